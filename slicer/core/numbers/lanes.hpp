#pragma once
/// Eight numbers at a time, with the same result on every machine.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace plumbline::inline slicer {

/// Before a function: compiles it once more for machines with wide vectors, and chooses when the program starts. Sanitizers begin
/// too late for that choice.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PLUMBLINE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PLUMBLINE_WIDE
#endif
/// What such a function calls must become part of it.
#define PLUMBLINE_INLINE __attribute__((always_inline)) inline

inline constexpr std::uint32_t kLanes = 8;

// In one vector register, two, or eight scalars. Sums by lane have a fixed order, so their bits don't depend on which.
#if defined(__x86_64__)
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));  ///< a comparison of Lanes: -1 or 0 in each

/// @param from  kLanes numbers; need not be aligned
PLUMBLINE_INLINE void load(Lanes& lanes, const float* from) { std::memcpy(&lanes, from, sizeof lanes); }
PLUMBLINE_INLINE void load(IntLanes& lanes, const std::int32_t* from) { std::memcpy(&lanes, from, sizeof lanes); }
PLUMBLINE_INLINE void store(float* to, const Lanes& lanes) { std::memcpy(to, &lanes, sizeof lanes); }

/// Sets each lane to that of `a` where the comparison holds, else to that of `b`.
PLUMBLINE_INLINE void choose(Lanes& chosen, const IntLanes& holds, const Lanes& a, const Lanes& b) {
  chosen = holds ? a : b;
}

/// Through memory, where the compiler makes one instruction of the loop.
PLUMBLINE_INLINE void square_root(Lanes& root, const Lanes& x) {
  float lanes[kLanes];
  store(lanes, x);
  for (float& lane : lanes) lane = std::sqrt(lane);
  load(root, lanes);
}

/// Loads kLanes points from one array.
PLUMBLINE_INLINE void load_points(Lanes& x, Lanes& y, Lanes& z, const float* from) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    x[k] = from[3 * k];
    y[k] = from[3 * k + 1];
    z[k] = from[3 * k + 2];
  }
}

PLUMBLINE_INLINE float sum(const Lanes& v) { return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7])); }
PLUMBLINE_INLINE std::int32_t sum(const IntLanes& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}
#else
/// Two registers of four. A vector type of eight won't do: where registers hold four, gcc 12 compares its lanes one by one, and keeps its
/// sums in memory.
template <class Number>
struct LanePair {
  using Half __attribute__((vector_size(16))) = Number;
  using Compared = LanePair<std::int32_t>;

  Half low, high;

  LanePair() = default;
  PLUMBLINE_INLINE LanePair(Number all)
      : low{all, all, all, all}, high(low) {}  // NOLINT(google-explicit-constructor): as vectors
  PLUMBLINE_INLINE LanePair(const Half& of_low, const Half& of_high) : low(of_low), high(of_high) {}

  PLUMBLINE_INLINE LanePair operator-() const { return {-low, -high}; }
  PLUMBLINE_INLINE LanePair& operator+=(const LanePair& b) { return *this = *this + b; }
  PLUMBLINE_INLINE LanePair& operator-=(const LanePair& b) { return *this = *this - b; }
  PLUMBLINE_INLINE LanePair& operator*=(const LanePair& b) { return *this = *this * b; }

  PLUMBLINE_INLINE friend LanePair operator+(const LanePair& a, const LanePair& b) {
    return {a.low + b.low, a.high + b.high};
  }
  PLUMBLINE_INLINE friend LanePair operator-(const LanePair& a, const LanePair& b) {
    return {a.low - b.low, a.high - b.high};
  }
  PLUMBLINE_INLINE friend LanePair operator*(const LanePair& a, const LanePair& b) {
    return {a.low * b.low, a.high * b.high};
  }
  PLUMBLINE_INLINE friend LanePair operator/(const LanePair& a, const LanePair& b) {
    return {a.low / b.low, a.high / b.high};
  }
  PLUMBLINE_INLINE friend LanePair operator&(const LanePair& a, const LanePair& b) {
    return {a.low & b.low, a.high & b.high};
  }
  PLUMBLINE_INLINE friend LanePair operator|(const LanePair& a, const LanePair& b) {
    return {a.low | b.low, a.high | b.high};
  }
  PLUMBLINE_INLINE friend Compared operator<(const LanePair& a, const LanePair& b) {
    return {a.low < b.low, a.high < b.high};
  }
  PLUMBLINE_INLINE friend Compared operator>(const LanePair& a, const LanePair& b) {
    return {a.low > b.low, a.high > b.high};
  }
  PLUMBLINE_INLINE friend Compared operator<=(const LanePair& a, const LanePair& b) {
    return {a.low <= b.low, a.high <= b.high};
  }
  PLUMBLINE_INLINE friend Compared operator>=(const LanePair& a, const LanePair& b) {
    return {a.low >= b.low, a.high >= b.high};
  }
  PLUMBLINE_INLINE friend Compared operator==(const LanePair& a, const LanePair& b) {
    return {a.low == b.low, a.high == b.high};
  }
  PLUMBLINE_INLINE friend Compared operator!=(const LanePair& a, const LanePair& b) {
    return {a.low != b.low, a.high != b.high};
  }
};
using Lanes = LanePair<float>;
using IntLanes = LanePair<std::int32_t>;

// Each half by itself: a copy of both goes through the stack.
template <class Number>
PLUMBLINE_INLINE void load(LanePair<Number>& lanes, const Number* from) {
  std::memcpy(&lanes.low, from, sizeof lanes.low);
  std::memcpy(&lanes.high, from + 4, sizeof lanes.high);
}
PLUMBLINE_INLINE void store(float* to, const Lanes& lanes) {
  std::memcpy(to, &lanes.low, sizeof lanes.low);
  std::memcpy(to + 4, &lanes.high, sizeof lanes.high);
}

PLUMBLINE_INLINE void choose(Lanes& chosen, const IntLanes& holds, const Lanes& a, const Lanes& b) {
  chosen = {holds.low ? a.low : b.low, holds.high ? a.high : b.high};
}

#if defined(__aarch64__)
PLUMBLINE_INLINE void square_root(Lanes& root, const Lanes& x) { root = {vsqrtq_f32(x.low), vsqrtq_f32(x.high)}; }

PLUMBLINE_INLINE void load_points(Lanes& x, Lanes& y, Lanes& z, const float* from) {
  const float32x4x3_t low = vld3q_f32(from);
  const float32x4x3_t high = vld3q_f32(from + 3 * std::size_t{4});
  x = {low.val[0], high.val[0]};
  y = {low.val[1], high.val[1]};
  z = {low.val[2], high.val[2]};
}

PLUMBLINE_INLINE float sum(const Lanes& v) { return vaddvq_f32(v.low + v.high); }  // of neighbours, then of both
#else
PLUMBLINE_INLINE void square_root(Lanes& root, const Lanes& x) {
  for (std::size_t k = 0; k < 4; ++k) {
    root.low[k] = std::sqrt(x.low[k]);
    root.high[k] = std::sqrt(x.high[k]);
  }
}

PLUMBLINE_INLINE void load_points(Lanes& x, Lanes& y, Lanes& z, const float* from) {
  for (std::size_t k = 0; k < 4; ++k) {
    x.low[k] = from[3 * k];
    y.low[k] = from[3 * k + 1];
    z.low[k] = from[3 * k + 2];
    x.high[k] = from[3 * k + 12];
    y.high[k] = from[3 * k + 13];
    z.high[k] = from[3 * k + 14];
  }
}

PLUMBLINE_INLINE float sum(const Lanes& v) {
  const auto both = v.low + v.high;
  return (both[0] + both[1]) + (both[2] + both[3]);
}
#endif
PLUMBLINE_INLINE std::int32_t sum(const IntLanes& v) {
  const auto both = v.low + v.high;
  return (both[0] + both[1]) + (both[2] + both[3]);
}
#endif

/// Whether a comparison holds in any lane.
PLUMBLINE_INLINE bool any(const IntLanes& holds) {
  std::uint64_t words[kLanes / 2];
  std::memcpy(words, &holds, sizeof words);
  return ((words[0] | words[1]) | (words[2] | words[3])) != 0;
}

/// Rounds x to the nearest integers. |x| must be below 2^22.
PLUMBLINE_INLINE void round_lanes(Lanes& integers, const Lanes& x) {
  constexpr float kRound = 12582912;  // 1.5 * 2^23: a sum with it has no bits below 1
  integers = (x + kRound) - kRound;
}

PLUMBLINE_INLINE float smallest(const Lanes& v) {
  float lanes[kLanes];
  store(lanes, v);
  float least = lanes[0];
  for (const float lane : lanes) least = lane < least ? lane : least;
  return least;
}

}  // namespace plumbline::inline slicer
