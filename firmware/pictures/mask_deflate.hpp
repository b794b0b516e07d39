#pragma once
/// The zlib stream of a mask's PNG file, made of the mask's words.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// How a PNG holds a pixel that is white: as a bit, or as a byte of 255, the only one that PrusaSlicer's reader of archives takes.
enum class MaskDepth : std::uint8_t { kBit = 1, kByte = 8 };

constexpr std::size_t line_bytes(std::uint32_t columns, MaskDepth depth) {
  return depth == MaskDepth::kByte ? columns : (columns + std::size_t{7}) / 8;
}

/// Bytes that deflate_mask() writes at most: 14 bits for each byte of the lines, and what is around them.
constexpr std::size_t deflated_mask_bound(std::uint32_t columns, std::uint32_t rows, MaskDepth depth) {
  return (1 + line_bytes(columns, depth)) * rows * 7 / 4 + 128;
}

/// Compresses the lines of a mask's PNG by deflate (RFC 1951) in a zlib stream (RFC 1950).
///
/// Each byte of a line is its difference from the one above ("up"); a blank line has no filter. So nearly all bytes are 0, and all that is
/// written is literals and runs of zeros, with one fixed Huffman code. Only words that differ from those above take time: a 2K mask of a
/// part of 15 mm takes 0.3 M instructions and 1.1 kB, where libdeflate at level 5 takes 13 M and 0.96 kB (slicer/EXPERIMENTS.md).
///
/// @param mask  1 x 1 or more. Bits past the last column are ignored
/// @param out   deflated_mask_bound() bytes
/// @returns the bytes written
std::size_t deflate_mask(ConstBitImage mask, MaskDepth depth, std::span<std::uint8_t> out);

}  // namespace plumbline
