#pragma once
/// Compresses by zlib.

#include <zlib.h>

#include <string>
#include <string_view>

namespace plumbline::testing {

/// @param window_bits  as of deflateInit2(): 31 for gzip, -15 for a part of a zip archive
inline std::string deflated(std::string_view bytes, int window_bits) {
  z_stream zlib = {};
  deflateInit2(&zlib, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&zlib, bytes.size()), '\0');
  zlib.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  zlib.avail_in = static_cast<uInt>(bytes.size());
  zlib.next_out = reinterpret_cast<Bytef*>(out.data());
  zlib.avail_out = static_cast<uInt>(out.size());
  deflate(&zlib, Z_FINISH);
  out.resize(zlib.total_out);
  deflateEnd(&zlib);
  return out;
}

}  // namespace plumbline::testing
