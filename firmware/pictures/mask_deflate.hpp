#pragma once
/// The zlib stream of a mask's PNG file, made of the mask's words.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// Bytes that deflate_mask() writes at most: 14 bits for each byte of the lines, and what is around them.
constexpr std::size_t deflated_mask_bound(std::uint32_t columns, std::uint32_t rows) {
  return (1 + (columns + std::size_t{7}) / 8) * rows * 7 / 4 + 128;
}

/// Compresses the lines of a mask's PNG, 1 bit a pixel, by deflate (RFC 1951) in a zlib stream (RFC 1950).
///
/// Each byte of a line is its difference from the one above ("up"); a blank line has no filter. So nearly all bytes are 0, and all that is
/// written is literals and runs of zeros, with one fixed Huffman code. Only words that differ from those above take time: a 2K mask of a
/// part of 15 mm takes 0.3 M instructions and 1.1 kB, where libdeflate at level 5 takes 13 M and 0.96 kB (slicer/EXPERIMENTS.md).
///
/// @param mask  1 x 1 or more. Bits past the last column are ignored
/// @param out   deflated_mask_bound() bytes
/// @returns the bytes written
std::size_t deflate_mask(ConstBitImage mask, std::span<std::uint8_t> out);

}  // namespace plumbline
