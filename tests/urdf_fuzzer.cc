// libFuzzer target: the reader of robot hands on any bytes. Needs clang and DARBOUX_BUILD_FUZZERS.
//
// Sample run: tests/urdf_fuzzer -max_total_time=600 new_inputs tests/corpus/urdf
#include <cstddef>
#include <cstdint>

#include "tests/fuzz_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  darboux::FuzzUrdf({reinterpret_cast<const char*>(data), size});
  return 0;
}
