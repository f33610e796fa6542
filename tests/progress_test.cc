// What the tools say while they work: --log=json, the live line of a terminal, --quiet.

#include <pty.h>

#include <cmath>

#include "tests/deform_util.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::Not;

// A strip that an edge moment winds to a circle: a dozen iterations.
constexpr char kStrip[] = R"(
name: strip
surface: {kind: plane, u: [0, 12], v: [0, 1], divisions: [24, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
steps: 2
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, moment: [0, -26.18, 0]}
probes:
  - {name: tip, at: {uv: [12, 0.5]}}
)";

class ProgressTest : public DeformTest {
 protected:
  // stderr, which must consist of JSON objects, one a line.
  std::vector<Json> Events() const {
    std::vector<Json> events;
    std::istringstream lines(Stderr());
    for (std::string line; std::getline(lines, line);) {
      events.push_back(Json::parse(line, nullptr, false));
      EXPECT_TRUE(events.back().is_object()) << line;
    }
    return events;
  }
  static std::vector<Json> Named(const std::vector<Json>& events, const std::string& name) {
    std::vector<Json> named;
    for (const Json& event : events) {
      if (event["event"] == name) named.push_back(event);
    }
    return named;
  }
};

TEST_F(ProgressTest, JsonTellsOfEveryStepAndIterationFromStartToDone) {
  EXPECT_EQ(Run({Write("strip.yaml", kStrip), OutFlag(), "--log=json"}), 0);
  const std::vector<Json> events = Events();
  ASSERT_GE(events.size(), 6u);
  EXPECT_EQ(events.front()["event"], "start");
  EXPECT_EQ(events.front()["tool"], "darboux_deform");
  EXPECT_EQ(events.back()["event"], "done");
  EXPECT_EQ(events.back()["exit_status"], 0);
  double t = 0.0;
  for (const Json& event : events) {
    EXPECT_GE(event["t"].get<double>(), t);
    t = event["t"];
  }
  const std::vector<Json> steps = Named(events, "step");
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[1]["load_factor"], 1.0);
  EXPECT_TRUE(steps[1]["converged"].get<bool>());
  const std::vector<Json> iterations = Named(events, "iteration");
  const int counted = steps[0]["iterations"].get<int>() + steps[1]["iterations"].get<int>();
  EXPECT_GE(static_cast<int>(iterations.size()), counted);
  for (const Json& iteration : iterations) {
    EXPECT_TRUE(iteration["energy"].is_number());
    EXPECT_TRUE(iteration["relative_gradient"].is_number());
  }
  EXPECT_EQ(iterations.back()["step"], 2);
  // What is for people is on stdout still.
  EXPECT_THAT(Stdout(), HasSubstr("converged"));
}

TEST_F(ProgressTest, MistakesAreEventsToo) {
  EXPECT_EQ(Run({Write("strip.yaml", kStrip), OutFlag(), "--log=json", "--theori=linear"}), 2);
  std::vector<Json> events = Events();
  ASSERT_EQ(Named(events, "error").size(), 1u);
  EXPECT_THAT(Named(events, "error")[0]["message"], HasSubstr("--theory"));

  std::string scene = kStrip;
  scene.replace(scene.find("poisson_ratio: 0"), 16, "poisson_ratio: 7");
  EXPECT_EQ(Run({Write("wrong.yaml", scene), OutFlag(), "--log", "json", "--quiet"}), 2);
  events = Events();
  ASSERT_EQ(Named(events, "error").size(), 1u);
  EXPECT_THAT(Named(events, "error")[0]["message"], HasSubstr("shell.poisson_ratio"));

  EXPECT_EQ(Run({Write("strip.yaml", kStrip), OutFlag(), "--log=xml"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--log: found 'xml'; allowed text | json"));
}

TEST_F(ProgressTest, WithoutATerminalThereAreNoEscapesAndQuietIsQuiet) {
  EXPECT_EQ(Run({Write("strip.yaml", kStrip), OutFlag()}), 0);
  EXPECT_THAT(Stderr(), HasSubstr("step 2/2"));
  EXPECT_THAT(Stderr(), Not(HasSubstr("\033")));
  EXPECT_EQ(Run({Write("strip.yaml", kStrip), OutFlag(), "--quiet"}), 0);
  EXPECT_EQ(Stderr(), "");
  EXPECT_EQ(Stdout(), "");
}

TEST_F(ProgressTest, ATerminalHasALiveLineThatLeavesNothingBehind) {
  const std::string scene = Write("strip.yaml", kStrip), out = OutFlag();
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    // Fine cells, so that it takes longer than the tenth of a second between two live lines.
    execl(DARBOUX_DEFORM,
          DARBOUX_DEFORM,
          scene.c_str(),
          out.c_str(),
          "--divisions=96,8",
          "--threads=1",
          static_cast<char*>(nullptr));
    _exit(127);
  }
  std::string text;
  char buffer[4096];
  for (ssize_t size; (size = read(terminal, buffer, sizeof(buffer))) > 0;) {
    text.append(buffer, static_cast<size_t>(size));
  }
  int status = -1;
  waitpid(child, &status, 0);
  close(terminal);
  EXPECT_EQ(WEXITSTATUS(status), 0) << text;
  EXPECT_THAT(text, HasSubstr("\r\033[Kstep 1/2  load 0.5  iteration "));
  EXPECT_THAT(text, HasSubstr("gradient "));
  // Every live line is wiped before the next for good.
  EXPECT_THAT(text, HasSubstr("\r\033[Kstep 1/2  load 0.5  "));
  const size_t last = text.rfind("\r\033[K");
  EXPECT_THAT(text.substr(last + 4), Not(HasSubstr("iteration 0")));
}

}  // namespace
}  // namespace darboux
