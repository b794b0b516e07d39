#pragma once
/// Quotients by a divisor that many numbers share.

#include <cstdint>

namespace plumbline::inline slicer {

/// Divides by a number that is known late, in two multiplications (Robison 2005, rounding down).
class Quotient {
 public:
  Quotient() = default;
  /// @param divisor  not 0
  explicit Quotient(std::uint32_t divisor) : inverse_(~std::uint64_t{0} / divisor) {}
  std::uint32_t operator()(std::uint32_t number) const {
    // The upper half of a product of 64 and 33 bits.
    const std::uint64_t next = std::uint64_t{number} + 1;
    return static_cast<std::uint32_t>(((inverse_ >> 32) * next + (((inverse_ & 0xFFFFFFFFU) * next) >> 32)) >> 32);
  }

 private:
  std::uint64_t inverse_ = 0;  ///< 2^64 / divisor, rounded to a smaller number
};

}  // namespace plumbline::inline slicer
