#pragma once
/// Random numbers without state: the n-th number of a stream is a function of n, so it does not depend on how many were
/// drawn before.

#include <cstdint>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/core/numbers/vec.hpp"

namespace plumbline::firmware {

class CounterRng {
 public:
  /// @param stream  what the numbers are for; streams of one seed are unrelated
  CounterRng(std::uint64_t seed, std::uint64_t stream) : key_(mix64(mix64(seed + kGoldenStep64) ^ (stream * kOdd))) {}

  /// 64 bits, all equally likely.
  std::uint64_t bits(std::uint64_t counter) const { return mix64(key_ + counter * kGoldenStep64); }

  /// 0 to just below 1, in steps of 2^-53.
  double uniform(std::uint64_t counter) const {
    return static_cast<double>(bits(counter) >> 11) * (1.0 / 9007199254740992.0);
  }

  /// Mean 0, variance 1, never beyond 6: the sum of twelve uniforms of 16 bits, which needs no logarithm. (The sum of 12
  /// has variance 1 - 2^-32.) Uses the three counters 3 n to 3 n + 2.
  double normal(std::uint64_t n) const {
    std::uint64_t sum = 0;
    for (std::uint64_t i = 0; i < 3; ++i) {
      const std::uint64_t word = bits(3 * n + i);
      for (unsigned part = 0; part < 4; ++part) sum += (word >> (16 * part)) & 0xFFFFU;
    }
    return (static_cast<double>(sum) + 6.0) / 65536.0 - 6.0;
  }

  /// Three independent normal deviates. Uses the nine counters from 9 n.
  Vec3d normal3(std::uint64_t n) const { return {normal(3 * n), normal(3 * n + 1), normal(3 * n + 2)}; }

 private:
  static constexpr std::uint64_t kOdd = 0xD1B54A32D192ED03U;

  std::uint64_t key_;
};

}  // namespace plumbline::firmware
