#include "firmware/io/mask_hash.hpp"

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::firmware {
std::uint64_t mask_hash(ConstBitImage mask, std::span<const GreyRun> greys) {
  std::uint64_t sum = mix64((std::uint64_t{mask.columns()} << 32) + mask.rows());
  std::uint64_t place = 0;
  for (std::uint32_t r = 0; r < mask.rows(); ++r, place += mask.stride() * kGoldenStep64) {
    const auto row = mask.row(r);
    if (is_blank(row)) continue;
    std::uint64_t at = place;
    for (const std::uint64_t word : row) {
      at += kGoldenStep64;
      if (word != 0) sum += mix64(reversed_bits(word) + at);
    }
  }
  for (const GreyRun& run : greys) {
    sum += mix64(mix64((std::uint64_t{run.pixel} << 32) + (std::uint64_t{run.count} << 16) + run.level));
  }
  return mix64(sum);
}

std::uint64_t job_hash(std::span<const std::uint64_t> layers) {
  std::uint64_t hash = mix64(layers.size());
  for (const std::uint64_t layer : layers) hash = mix64(hash + kGoldenStep64 + layer);
  return hash;
}

const char* const kMaskHashDefinition =
    "modulo 2^64: mix(z) is SplitMix64's finaliser; a layer is mix(mix(columns * 2^32 + rows) + sum of mix(word + s * "
    "0x9E3779B97F4A7C15) over its non-zero words), where a word is 8 bytes of an image row as PNG has them, "
    "big-endian, the "
    "last one filled up with zeros, and s counts the words of the image from 1; a grey pixel's bit is 1 from level 128 "
    "of 255 on, and each of the longest runs of one level in a row adds mix(mix(pixel * 2^32 + count * 2^16 + level)) "
    "to the sum, where pixel = row * columns + column of its first one; a job starts as mix(number of layers) "
    "and "
    "takes in each layer as h = mix(h + 0x9E3779B97F4A7C15 + layer)";

}  // namespace plumbline::firmware
