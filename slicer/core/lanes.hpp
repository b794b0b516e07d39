#pragma once
/// Eight numbers at a time, with the same result on every machine.

#include <cmath>
#include <cstdint>
#include <cstring>

namespace plumbline {

/// In one vector register, two, or eight scalars. Sums by lane have a fixed order, so their bits don't depend on which.
using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));  ///< a comparison of Lanes: -1 or 0 in each
inline constexpr std::uint32_t kLanes = 8;

/// Before a function: compiles it once more for machines with wide vectors, and chooses when the program starts. Sanitizers begin
/// too late for that choice.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PLUMBLINE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define PLUMBLINE_WIDE
#endif
/// What such a function calls must become part of it.
#define PLUMBLINE_INLINE __attribute__((always_inline)) inline

/// @param from  kLanes numbers; need not be aligned
PLUMBLINE_INLINE void load(Lanes& lanes, const float* from) { std::memcpy(&lanes, from, sizeof lanes); }
PLUMBLINE_INLINE void load(IntLanes& lanes, const std::int32_t* from) { std::memcpy(&lanes, from, sizeof lanes); }

PLUMBLINE_INLINE void store(float* to, const Lanes& lanes) { std::memcpy(to, &lanes, sizeof lanes); }

/// Rounds x to the nearest integers. |x| must be below 2^22.
PLUMBLINE_INLINE void round_lanes(Lanes& integers, const Lanes& x) {
  constexpr float kRound = 12582912;  // 1.5 * 2^23: a sum with it has no bits below 1
  integers = (x + kRound) - kRound;
}

/// Through memory, where the compiler makes one instruction of the loop.
PLUMBLINE_INLINE void square_root(Lanes& root, const Lanes& x) {
  float lanes[kLanes];
  store(lanes, x);
  for (float& lane : lanes) lane = std::sqrt(lane);
  load(root, lanes);
}

PLUMBLINE_INLINE float sum(const Lanes& v) { return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7])); }
PLUMBLINE_INLINE std::int32_t sum(const IntLanes& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

}  // namespace plumbline
