#include <vector>

#include "slicer/reader/formats/e57/e57_pages.hpp"
#include "tests/fuzz/fuzz_scan.hpp"

/// The input is the pages' payload, since hardly any change of a byte would leave a checksum right.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using plumbline::E57Pages;
  std::vector<std::uint8_t> file;
  for (std::size_t at = 0; at < size; at += E57Pages::kPayload) {
    std::vector<char> page(bytes + at, bytes + std::min(size, at + E57Pages::kPayload));
    page.resize(E57Pages::kPayload);
    const std::uint32_t sum = plumbline::crc32c(page);
    file.insert(file.end(), page.begin(), page.end());
    for (int shift = 24; shift >= 0; shift -= 8) file.push_back(static_cast<std::uint8_t>(sum >> shift));
  }
  return plumbline::firmware::fuzz::check_scan("scan.e57", file.data(), file.size(), 8);
}
