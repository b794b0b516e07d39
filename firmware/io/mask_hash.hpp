#pragma once
/// Fingerprints of layer masks, the same on every machine.

#include <cstdint>
#include <span>

#include "slicer/core/bit_image.hpp"

namespace plumbline {

/// 64-bit hash of a mask. It finds errors, it does not resist forgery.
///
/// A row is taken as its bytes stand in the PNG (first pixel in the high bit), filled up with zeros to whole groups of
/// eight; word(r, w) is group w of row r read as a big-endian number, and s(r, w) = r * groups a row + w + 1.
///
///   mix(z): z = (z ^ z >> 30) * BF58476D1CE4E5B9; z = (z ^ z >> 27) * 94D049BB133111EB; z ^ z >> 31   (SplitMix64)
///   hash  = mix( mix(columns * 2^32 + rows) + sum over words that are not 0 of mix(word + s * 9E3779B97F4A7C15) )
///
/// all modulo 2^64. Words add up independently of one another, so black costs next to nothing and the processor works on
/// several words at a time.
std::uint64_t mask_hash(ConstBitImage mask);

/// Hash of a job: of its layers' hashes in order, each weighing in on all that follow.
///
///   h = mix(number of layers);   for each layer:  h = mix(h + 9E3779B97F4A7C15 + hash of the layer)
std::uint64_t job_hash(std::span<const std::uint64_t> layers);

/// The two definitions above, for the manifest.
extern const char* const kMaskHashDefinition;

}  // namespace plumbline
