// Every input that fuzzing has kept, once more: what broke a reader stays mended.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz_targets.h"

namespace darboux {
namespace {

std::vector<std::string> Inputs(const std::string& folder) {
  std::vector<std::string> inputs;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

TEST(FuzzReplayTest, ScenesOfTheCorpusGiveAResultOrOneLine) {
  const std::vector<std::string> inputs = Inputs(DARBOUX_SOURCE_DIR "/tests/corpus/scene");
  EXPECT_GE(inputs.size(), 20u);
  for (const std::string& input : inputs) FuzzScene(input);
}

TEST(FuzzReplayTest, MeshesOfTheCorpusGiveAResultOrOneLine) {
  const std::vector<std::string> inputs = Inputs(DARBOUX_SOURCE_DIR "/tests/corpus/mesh");
  EXPECT_GE(inputs.size(), 20u);
  for (const std::string& input : inputs) FuzzMesh(input);
}

TEST(FuzzReplayTest, HandsOfTheCorpusGiveAResultOrOneLine) {
  const std::vector<std::string> inputs = Inputs(DARBOUX_SOURCE_DIR "/tests/corpus/urdf");
  EXPECT_GE(inputs.size(), 8u);
  for (const std::string& input : inputs) FuzzUrdf(input);
}

}  // namespace
}  // namespace darboux
