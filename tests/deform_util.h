#ifndef DARBOUX_TESTS_DEFORM_UTIL_H_
#define DARBOUX_TESTS_DEFORM_UTIL_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>

#include "tests/file_util.h"
#include "tests/tool_util.h"

// darboux_deform as its users meet it, and the files that it writes.

namespace darboux {

class DeformTest : public ToolTest {
 protected:
  DeformTest() : ToolTest(DARBOUX_DEFORM) {}

  nlohmann::ordered_json Summary() const {
    return nlohmann::ordered_json::parse(ReadFile(Out() / "summary.json"), nullptr, false);
  }

  // Waits until the tool has reported a load step.
  void WaitForAStep() const {
    for (int i = 0; i < 6000 && Stderr().find("step 1/") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_THAT(Stderr(), ::testing::HasSubstr("step 1/"));
  }

  // All files of `steps` load steps are there, complete and finite.
  void ExpectCompleteResults(size_t steps) const {
    std::set<std::string> names = {
        "summary.json", "shell.vtu", "shell.pvd", "deformed.ply", "history.csv"};
    for (size_t i = 1; i <= steps; ++i) {
      const std::string number = std::to_string(i);
      names.insert("shell_" + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number +
                   ".vtu");
    }
    if (!Summary()["fingers"].empty()) names.insert("contact.csv");
    EXPECT_EQ(FilesIn(Out()), names);
    for (const std::string& name : names) {
      const std::string text = ReadFile(Out() / name);
      EXPECT_FALSE(text.empty()) << name;
      if (name.find(".vtu") != std::string::npos || name == "shell.pvd") {
        EXPECT_THAT(text.substr(text.size() - 11), "</VTKFile>\n") << name;
      }
      if (name == "history.csv" || name == "summary.json") {
        for (const char* number : {" nan", "-nan", ",nan", "NaN", "inf,", "Infinity"}) {
          EXPECT_EQ(text.find(number), std::string::npos) << name << ": " << number;
        }
      }
    }
    const nlohmann::ordered_json summary = Summary();
    ASSERT_TRUE(summary.is_object());
    EXPECT_EQ(summary["load_steps"].size(), steps);
  }
};

}  // namespace darboux

#endif  // DARBOUX_TESTS_DEFORM_UTIL_H_
