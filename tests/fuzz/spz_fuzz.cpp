#include <zlib.h>

#include <vector>

#include "tests/fuzz/fuzz_scan.hpp"

/// The first byte decides whether the rest is the file, or what the file decompresses to.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using plumbline::firmware::fuzz::check_scan;
  constexpr std::uint64_t kPointsAByte = 64;  // 1032 bytes from one, at least 16 a splat
  if (size == 0) return 0;
  if (bytes[0] % 4 == 0) return check_scan("scan.spz", bytes + 1, size - 1, kPointsAByte);
  z_stream zlib = {};
  deflateInit2(&zlib, 1, Z_DEFLATED, 16 + 15, 8, Z_DEFAULT_STRATEGY);
  std::vector<std::uint8_t> file(deflateBound(&zlib, size));
  zlib.next_in = const_cast<std::uint8_t*>(bytes + 1);
  zlib.avail_in = static_cast<uInt>(size - 1);
  zlib.next_out = file.data();
  zlib.avail_out = static_cast<uInt>(file.size());
  deflate(&zlib, Z_FINISH);
  file.resize(zlib.total_out);
  deflateEnd(&zlib);
  return check_scan("scan.spz", file.data(), file.size(), kPointsAByte);
}
