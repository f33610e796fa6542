// libFuzzer target: the scene reader on any bytes. Needs clang and DARBOUX_BUILD_FUZZERS.
//
// Sample run: tests/scene_fuzzer -max_total_time=600 -rss_limit_mb=4096 new_inputs
// tests/corpus/scene
#include <cstddef>
#include <cstdint>

#include "tests/fuzz_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  darboux::FuzzScene({reinterpret_cast<const char*>(data), size});
  return 0;
}
