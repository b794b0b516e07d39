#include "tests/fuzz/fuzz_scan.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return plumbline::firmware::fuzz::check_scan("scan.xyz", bytes, size);
}
