#pragma once
/// Hashes of layer masks, the same on every machine.

#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::firmware {

/// 64-bit hash of a mask. It detects errors; it does not resist forgery.
///
/// A row is read as its bytes in the PNG (first pixel in the high bit), padded with zeros to whole groups of
/// eight; word(r, w) is group w of row r read as a big-endian number, and s(r, w) = r * groups a row + w + 1.
///
///   mix(z): z = (z ^ z >> 30) * BF58476D1CE4E5B9; z = (z ^ z >> 27) * 94D049BB133111EB; z ^ z >> 31   (SplitMix64)
///   hash  = mix( mix(columns * 2^32 + rows) + sum over words that are not 0 of mix(word + s * 9E3779B97F4A7C15) )
///
/// all modulo 2^64. The sum does not depend on the order of the words, so black words are skipped and the processor
/// works on several at a time.
///
/// Bits of grey pixels are as set_bits() sets them. A mask with grey pixels adds, for each of the longest runs of one level in a row, to the inner sum
///
///   mix(mix(first pixel * 2^32 + count * 2^16 + level))
std::uint64_t mask_hash(ConstBitImage mask, std::span<const GreyRun> greys = {});

/// Hash of a job, from the hashes of its layers in order.
///
///   h = mix(number of layers);   for each layer:  h = mix(h + 9E3779B97F4A7C15 + hash of the layer)
std::uint64_t job_hash(std::span<const std::uint64_t> layers);

/// Both definitions in words, for the manifest.
extern const char* const kMaskHashDefinition;

}  // namespace plumbline::firmware
