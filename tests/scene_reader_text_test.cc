// The text of a scene: mistakes of YAML, of keys and of plain values; and every line deleted, cut
// and mangled.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene_reader_util.h"

namespace darboux {
namespace {

std::vector<Mistake> Mistakes() {
  return {
      {"EmptyFile",
       "",
       "1: scene: found an empty file; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"OnlyComment",
       "# nothing\n",
       "1: scene: found an empty file; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"NotAMap",
       "- a\n"
       "- b\n",
       "1: scene: found a list of 2; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"TextOnly",
       "hello\n",
       "1: scene: found 'hello'; allowed a map with the keys name, surface, shell, ..."},
      {"LeadingComma",  // yaml-cpp's LoadAll never ends here
       ", lu",
       "1: scene: found a YAML mistake (text that is part of nothing); allowed valid YAML"},
      {"TwoDocuments",
       Edit("shell:\n",
            "---\n"
            "shell:\n"),
       "11: scene: found a second YAML document; allowed one document"},
      {"Tab",
       Edit("  thickness: 3", "\tthickness: 3"),
       "11: scene: found a tab in the indentation; allowed spaces"},
      {"Unclosed",
       Edit("[16, 8]", "[16, 8"),
       "8: scene: found a YAML mistake (*); allowed valid YAML"},
      {"UnclosedQuote",
       Edit("p. 217\"", "p. 217"),
       "45: scene: found a YAML mistake (*); allowed valid YAML"},
      {"BadIndent",
       Edit("  radius: 300", "   radius: 300"),
       "4: scene: found a YAML mistake (*); allowed valid YAML"},
      {"ControlCharacter",
       Edit("name: roof", "name: ro\004of"),
       "1: scene: found a control character (code 4); allowed UTF-8 text"},
      {"NotUtf8",
       Edit("name: roof", "name: ro\377of"),
       "1: scene: found a byte that is not UTF-8 text; allowed UTF-8 text"},
      {"Directive",
       Edit("name: roof",
            "%YAML 1.1\n"
            "---\n"
            "name: roof"),
       "1: scene: found a YAML directive (%); allowed one document without directives"},
      {"UndefinedAlias",
       Edit("radius: 300", "radius: *r"),
       "4: scene: found a YAML mistake (*); allowed valid YAML"},
      {"MergeKey",
       Edit("  radius: 300", "  <<: {radius: 300}"),
       "4: surface.<<: found a YAML merge key; allowed keys written out"},
      {"Tag",
       Edit("radius: 300", "radius: !!float 300"),
       "4: surface.radius: found the tag 'tag:yaml.org,2002:float'; allowed values "
       "without YAML tags"},
      {"ListAsKey",
       Edit("steps: 4", "[steps]: 4"),
       "36: scene: found a list of 1 as a key; allowed names as keys"},
      {"UnknownRootKey",
       Edit("steps: 4", "step: 4"),
       std::string("36: step: found an unknown key; allowed ") + kRootKeys +
           "; did you mean 'steps'?"},
      {"UnknownRootKeyFar",
       Edit("steps: 4", "iterations_of_newton: 4"),
       std::string("36: iterations_of_newton: found an unknown key; allowed ") + kRootKeys},
      {"DuplicateRootKey",
       Edit("steps: 4",
            "steps: 4\n"
            "steps: 5"),
       "37: steps: found the key a second time (first in line 36); allowed every key "
       "once"},
      {"DuplicateKey",
       Edit("  thickness: 3\n",
            "  thickness: 3\n"
            "  thickness: 3\n"),
       "12: shell.thickness: found the key a second time (first in line 11); allowed "
       "every key once"},
      {"NoName",
       Edit("name: roof\n", ""),
       "1: name: found no such key, which is required; allowed a text of one line"},
      {"EmptyName",
       Edit("name: roof", "name:"),
       "1: name: found nothing; allowed a text of one line"},
      {"NameOfTwoLines",
       Edit("name: roof", "name: \"a\\nb\""),
       "1: name: found \"a?b\"; allowed a text of one line"},
      {"NoSurface",
       "name: a\n"
       "shell: {thickness: 1}\n",
       "1: surface: found no such key, which is required; allowed a map with the key "
       "kind"},
      {"NoShell",
       Edit("shell:\n"
            "  thickness: 3\n"
            "  young_modulus: 3.0e6\n"
            "  poisson_ratio: 0.3\n"
            "  density: 0.1\n",
            ""),
       "1: shell: found no such key, which is required; allowed a map with thickness, "
       "young_modulus, poisson_ratio"},
      {"FingerWithoutShape",
       Edit("steps: 4", "fingers: [{name: left}]"),
       "36: fingers[0].shape: found no such key, which is required; allowed a map with the key "
       "kind"},
      {"FingerShapeMisspelt",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: spere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[0].shape.kind: found 'spere'; allowed pin | sphere | capsule | box | plane | "
       "mesh | link; did you mean 'sphere'?"},
      {"FingerRadius",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 0}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[0].shape.radius: found 0; allowed a number > 0"},
      {"FingerDirection",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, 0], motion: {travel: 1}}]"),
       "36: fingers[0].direction: found a vector of length zero; allowed a list of three numbers, "
       "[x, y, z]"},
      {"FingerForce",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {force: -1}}]"),
       "36: fingers[0].motion.force: found -1; allowed a number > 0"},
      {"FingerForceAndTravel",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {force: 1, travel: 1}}]"),
       "36: fingers[0].motion.force: found a force beside a travel; allowed exactly one of travel "
       "and force"},
      {"FingerTwice",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}, {name: left, shape: {kind: sphere, "
            "radius: 2}, position: [0, 0, 400], direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[1].name: found 'left' a second time; allowed a different name for each finger"},
      {"FingerFriction",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}, friction: -1}]"),
       "36: fingers[0].friction: found -1; allowed a number >= 0"},
      {"ModelList",
       Edit("\n"
            "  minimizer: ceres\n"
            "  theory: linear\n"
            "  strains: seed\n"
            "  quadrature: 6\n"
            "  boundary_rule: seed_ghosts\n"
            "  accuracy: 0.05\n",
            "\n"
            "  - 3\n"),
       "15: model: found a list of 1; allowed a map"},
      {"ThicknessZero",
       Edit("thickness: 3", "thickness: 0"),
       "11: shell.thickness: found 0; allowed a number > 0"},
      {"YoungNegative",
       Edit("young_modulus: 3.0e6", "young_modulus: -3.0e6"),
       "12: shell.young_modulus: found -3.0e6; allowed a number > 0"},
      {"PoissonLarge",
       Edit("poisson_ratio: 0.3", "poisson_ratio: 0.51"),
       "13: shell.poisson_ratio: found 0.51; allowed a number in (-1, 0.5]"},
      {"PoissonMinusOne",
       Edit("poisson_ratio: 0.3", "poisson_ratio: -1"),
       "13: shell.poisson_ratio: found -1; allowed a number in (-1, 0.5]"},
      {"DensityNegative",
       Edit("density: 0.1", "density: -0.1"),
       "14: shell.density: found -0.1; allowed a number >= 0"},
      {"NoThickness",
       Edit("  thickness: 3\n", ""),
       "10: shell.thickness: found no such key, which is required; allowed a number > "
       "0"},
      {"ShellKey",
       Edit("thickness: 3", "thicknes: 3"),
       "11: shell.thicknes: found an unknown key; allowed thickness | young_modulus | "
       "poisson_ratio | density; did you mean 'thickness'?"},
      {"ModelKey",
       Edit("theory: linear", "teory: linear"),
       "17: model.teory: found an unknown key; allowed minimizer | theory | strains | "
       "quadrature | contact_spacing | boundary_rule | unstable | accuracy; did you mean "
       "'theory'?"},
      {"ContactSpacing",
       Edit("theory: linear", "contact_spacing: 0.01"),
       "17: model.contact_spacing: found 0.01; allowed a number from 0.02 to 1"},
      {"MinimizerTypo",
       Edit("minimizer: ceres", "minimizer: cere"),
       "16: model.minimizer: found 'cere'; allowed auto | mip | ceres | cg; did you mean 'ceres'?"},
      {"Theory",
       Edit("theory: linear", "theory: non_linear"),
       "17: model.theory: found 'non_linear'; allowed auto | linear | nonlinear; did "
       "you mean 'nonlinear'?"},
      {"TheoryMap",
       Edit("theory: linear", "theory: {a: b}"),
       "17: model.theory: found a map; allowed auto | linear | nonlinear"},
      {"Strains",
       Edit("strains: seed", "strains: donnell"),
       "18: model.strains: found 'donnell'; allowed koiter | seed"},
      {"BoundaryRule",
       Edit("boundary_rule: seed_ghosts", "boundary_rule: seed_ghost"),
       "20: model.boundary_rule: found 'seed_ghost'; allowed independent | "
       "seed_ghosts; did you mean 'seed_ghosts'?"},
      {"Quadrature",
       Edit("quadrature: 6", "quadrature: 4"),
       "19: model.quadrature: found 4; allowed 1, 3, 6 or 12 points per triangle"},
      {"QuadratureText",
       Edit("quadrature: 6", "quadrature: \"6\""),
       "19: model.quadrature: found \"6\"; allowed 1, 3, 6 or 12 points per triangle"},
      {"Accuracy",
       Edit("accuracy: 0.05", "accuracy: 1"),
       "21: model.accuracy: found 1; allowed a number in (0, 1)"},
  };
}

class SceneReaderMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneReaderMistakeTest, IsReportedWithPlaceAndRemedy) { ExpectMessage(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Text, SceneReaderMistakeTest, ::testing::ValuesIn(Mistakes()), NameOf);

TEST(SceneReaderTest, LongOrUnprintableWordsAreQuotedInOneShortLine) {
  const std::string error = ErrorOf(Edit("steps: 4", "\"a\\n" + std::string(500, 'b') + "\": 4"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
  EXPECT_LT(error.size(), 300u);
  EXPECT_EQ(error.find("roof.yaml:36: a?bbb"), 0u) << error;
}

TEST(SceneReaderTest, DeepNestingIsAnErrorNotACrash) {
  for (const char* piece : {"[", "{", "- ", "? ", "[a: ", "{a: "}) {
    std::string text;
    while (text.size() < 200000) text += piece;
    EXPECT_EQ(ErrorOf(text).find("roof.yaml:1: scene: found a YAML mistake"), 0u) << piece;
  }
  EXPECT_EQ(ErrorOf("&a [*a]\n"),
            "roof.yaml:1: scene: found a list of 1; allowed a map with the keys name, surface, "
            "shell, ...");
  EXPECT_EQ(ErrorOf(Edit("radius: 300", "radius: " + std::string(100000, '('))).find('\n'),
            std::string::npos);
}

// ---- Every line deleted, cut and mangled -----------------------------------------------------

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin);
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Whether the text is accepted; if not, checks the form of the message.
bool IsAcceptedOrExplained(const std::string& text) {
  Scene scene;
  std::string error;
  if (ParseScene(text, kFile, &scene, &error)) return true;
  const std::string prefix = std::string(kFile) + ":";
  EXPECT_EQ(error.compare(0, prefix.size(), prefix), 0) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  EXPECT_NE(error.find("; allowed "), std::string::npos) << error;
  const int line = std::atoi(error.c_str() + prefix.size());
  EXPECT_GE(line, 1) << error;
  EXPECT_LE(line, std::count(text.begin(), text.end(), '\n') + 1) << error;
  return false;
}

TEST(SceneReaderTest, DamagedLinesAreAcceptedOrExplained) {
  std::mt19937 generator(38401);
  const auto below = [&generator](size_t n) {
    return std::uniform_int_distribution<size_t>(0, n - 1)(generator);
  };
  const std::string alphabet = "[]{}:,-#&*!|>'\"%@` \t\n\r\x01\x04\xC3\xFF~?0a.e";
  const std::vector<std::string> lines = Lines(FullScene());
  int accepted = 0, refused = 0;
  const auto check = [&](const std::vector<std::string>& damaged) {
    ++(IsAcceptedOrExplained(JoinLines(damaged)) ? accepted : refused);
  };
  for (size_t i = 0; i < lines.size(); ++i) {
    std::vector<std::string> damaged = lines;
    damaged.erase(damaged.begin() + i);
    check(damaged);
    damaged = lines;
    damaged.insert(damaged.begin() + i, lines[i]);  // Doubled.
    check(damaged);
    for (size_t length = 0; length < lines[i].size(); length += 3) {
      damaged = lines;
      damaged[i].resize(length);
      check(damaged);
    }
    for (int k = 0; k < 15; ++k) {
      damaged = lines;
      for (size_t n = 0; n <= below(3) && !damaged[i].empty(); ++n) {
        const size_t at = below(damaged[i].size());
        switch (below(4)) {
          case 0:
            damaged[i][at] = alphabet[below(alphabet.size())];
            break;
          case 1:
            damaged[i].insert(at, 1, alphabet[below(alphabet.size())]);
            break;
          case 2:
            damaged[i].erase(at, 1);
            break;
          default:
            std::swap(damaged[i][at], damaged[i][below(damaged[i].size())]);
        }
      }
      check(damaged);
    }
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 500);
}

TEST(SceneReaderTest, FilesCutShortAreAcceptedOrExplained) {
  const std::string text = FullScene();
  for (size_t length = 0; length < text.size(); ++length) {
    IsAcceptedOrExplained(text.substr(0, length));
  }
}

}  // namespace
}  // namespace darboux
