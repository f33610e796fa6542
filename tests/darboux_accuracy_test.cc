// The tool as its users meet it: command line in, exit status and files out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "tests/temporary_folder.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;

class DarbouxAccuracyTest : public FolderTest {
 protected:
  // `before`: of the command line, e.g. "timeout 5".
  CommandOutcome Run(const std::string& arguments, const std::string& before = "") const {
    return RunCommand(folder_, before + " " + DARBOUX_ACCURACY + " " + arguments + " --threads=1");
  }
  static std::string Data(const std::string& name) {
    return std::string(DARBOUX_DATA_DIR) + "/" + name;
  }
};

TEST_F(DarbouxAccuracyTest, NamesTheCheapestSettingsOfThePinchedCylinder) {
  const CommandOutcome outcome =
      Run(Data("pinched_cylinder.yaml") + " --levels=4 --target=0.02 --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, IsEmpty());  // No progress: stderr is no terminal.
  const Json json = Json::parse(Read("cost/accuracy.json"));
  EXPECT_TRUE(json["established"].get<bool>());
  EXPECT_EQ(json["reference"]["kind"], "expect");
  ASSERT_EQ(json["cheapest"].size(), 4u);
  double before = 1.0;
  for (const Json& entry : json["cheapest"]) {
    EXPECT_LT(entry["target"].get<double>(), before);
    before = entry["target"].get<double>();
    ASSERT_FALSE(entry["run"].is_null()) << entry["text"];
    const Json& run = json["runs"][entry["run"].get<int>()];
    EXPECT_LE(run["error"].get<double>(), before);
    char target[32];
    std::snprintf(target, sizeof(target), "%.2g", 100.0 * before);
    EXPECT_THAT(outcome.out,
                HasSubstr(std::string("cheapest for ") + target +
                          " %: " + entry["text"].get<std::string>()));
  }
  // The scene's own line, against README.md's table.
  bool found = false;
  for (const Json& run : json["runs"]) {
    EXPECT_NE(run["status"], "crashed") << run.dump();
    if (run["label"] != "divisions 16 x 16, grading 0.85, 3 points, koiter, linear") continue;
    found = true;
    EXPECT_NEAR(run["error"].get<double>(), 1.83e-3, 0.01e-3);
    EXPECT_EQ(run["dof"], 1077);
    EXPECT_GT(run["memory_mb"].get<double>(), 1.0);
    EXPECT_GT(run["time_s"]["cpu"].get<double>(), 0.0);
  }
  EXPECT_TRUE(found);
  EXPECT_THAT(Read("cost/accuracy.csv"), HasSubstr("\"divisions 16 x 16, grading 0.5"));
  EXPECT_THAT(Read("cost/accuracy.svg"), HasSubstr("</svg>"));
  EXPECT_FALSE(fs::exists(Path("cost/accuracy.csv.part")));
}

TEST_F(DarbouxAccuracyTest, ExtrapolatesWhereNothingIsExpectedAndSaysHowSurely) {
  std::string text = ReadFile(Data("pinched_cylinder.yaml"));
  text = text.substr(0, text.find("expect:"));
  const std::string scene = Write("scene.yaml", text);
  const CommandOutcome outcome =
      Run(scene + " --levels=4 --sweep=resolution,grading --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(Read("cost/accuracy.json"));
  EXPECT_EQ(json["reference"]["kind"], "richardson");
  bool found = false;
  for (const Json& quantity : json["reference"]["quantities"]) {
    if (quantity["quantity"] != "probes.under_load.displacement.z") continue;
    found = true;
    const double exact = -1.828195199e-5;
    const double error = std::abs(quantity["value"].get<double>() / exact - 1.0);
    EXPECT_LE(error, quantity["uncertainty"].get<double>());
    EXPECT_LT(quantity["uncertainty"].get<double>(), 1e-2);
  }
  EXPECT_TRUE(found);
  EXPECT_THAT(outcome.out, HasSubstr("Richardson"));
}

TEST_F(DarbouxAccuracyTest, RefinesMeshes) {
  const std::string scene = Write(
      "ball.yaml",
      "name: ball\nsurface: {kind: icosphere, radius: 1, frequency: 4}\n"
      "shell: {thickness: 0.05, young_modulus: 1, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
      "loads: [{kind: normal_traction, value: 1.5*z^2-0.5}]\n"
      "probes: [{name: pole, at: {nearest: [0, 0, 1]}}]\n");
  const CommandOutcome outcome =
      Run(scene + " --levels=4 --sweep=resolution,quadrature --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(Read("cost/accuracy.json"));
  EXPECT_EQ(json["reference"]["kind"], "richardson");
  int levels = 0;
  double before = 1e9;
  for (const Json& run : json["runs"]) {
    if (run["family"] != 0) continue;
    ++levels;
    EXPECT_LT(run["error"].get<double>(), before);
    before = run["error"].get<double>();
  }
  EXPECT_EQ(levels, 4);
}

TEST_F(DarbouxAccuracyTest, QuietPrintsNothing) {
  const CommandOutcome outcome = Run(
      Data("clamped_plate.yaml") + " --levels=2 --sweep=resolution --quiet --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out + outcome.err, IsEmpty());
  EXPECT_TRUE(fs::exists(Path("cost/accuracy.svg")));
}

TEST_F(DarbouxAccuracyTest, TargetsOutOfReachAreSaidToBe) {
  const CommandOutcome outcome =
      Run(Data("pinched_cylinder.yaml") +
          " --levels=2 --sweep=resolution --target=1e-5 --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, HasSubstr("cheapest for 0.001 %: not reached; most accurate divisions"));
}

TEST_F(DarbouxAccuracyTest, WithoutAReferenceTheStatusIsOneAndTheFilesAreThere) {
  const std::string scene = Write(
      "scene.yaml",
      "name: plate\nsurface: {kind: plane, u: [0, 1], v: [0, 1], divisions: [4, 4]}\n"
      "shell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
      "supports: [{on: rim, clamped: true}]\nloads: [{kind: normal_traction, value: 1}]\n");
  const CommandOutcome outcome =
      Run(scene + " --levels=2 --sweep=resolution --out=" + Path("cost"));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no errors: reference none"));
  EXPECT_TRUE(fs::exists(Path("cost/accuracy.json")));
}

TEST_F(DarbouxAccuracyTest, AnInterruptWritesWhatThereIs) {
  // Its finest levels would take minutes. In the foreground, as otherwise timeout signals twice,
  // and the second signal ends any tool at once.
  const CommandOutcome outcome =
      Run(Data("pinched_cylinder.yaml") +
              " --divisions=128,128 --max_dof=1e9 --levels=6 --sweep=resolution --quiet --out=" +
              Path("cost"),
          "timeout --foreground --preserve-status -s INT 2");
  EXPECT_EQ(outcome.status, 1);
  ASSERT_TRUE(fs::exists(Path("cost/accuracy.json")));
  EXPECT_EQ(outcome.err, "darboux_accuracy: interrupted\n");
  EXPECT_TRUE(Json::parse(Read("cost/accuracy.json"))["stopped"].get<bool>());
}

TEST_F(DarbouxAccuracyTest, BadInputIsOneLineAndStatusTwo) {
  const std::string plate = Data("clamped_plate.yaml");
  const std::string loose = Write(
      "loose.yaml",
      "name: plate\nsurface: {kind: plane, u: [0, 1], v: [0, 1], divisions: [4, 4]}\n"
      "shell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
      "loads: [{kind: normal_traction, value: 1}]\n");
  const struct {
    std::string arguments, message;
  } cases[] = {{plate + " --sweep=resolution,quadratur", "did you mean 'quadrature'?"},
               {plate + " --levels=13", "--levels: found '13'; allowed an integer from 1 to 12"},
               {plate + " --repeats=0", "--repeats: found '0'"},
               {plate + " --target=1", "--target: found '1'"},
               {plate + " --max_dof=0", "--max_dof: found '0'"},
               {plate + " --clock=sun", "--clock: found 'sun'; allowed wall | cpu"},
               {plate + " --reference=none", "--reference: found 'none'"},
               {plate + " --quadrature=2", "--quadrature: found 2"},
               {Path("missing.yaml"), "missing.yaml:0: scene"},
               {loose, "loose.yaml"},
               {"", "found no argument"}};
  for (const auto& [arguments, message] : cases) {
    const CommandOutcome outcome = Run(arguments + " --out=" + Path("none"));
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(message)) << arguments;
    EXPECT_FALSE(fs::exists(Path("none"))) << arguments;
  }
}

}  // namespace
}  // namespace darboux
