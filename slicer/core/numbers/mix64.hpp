#pragma once
/// A mixer of 64-bit words, for hashes and random numbers.

#include <cstdint>

namespace plumbline::inline slicer {

/// 2^64 divided by the golden ratio, made odd. Multiples of it, modulo 2^64, spread evenly over all words.
inline constexpr std::uint64_t kGoldenStep64 = 0x9E3779B97F4A7C15U;

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection in which every bit of z affects every bit of the
/// result. Recorded mask hashes and the sample's points depend on it.
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

}  // namespace plumbline::inline slicer
