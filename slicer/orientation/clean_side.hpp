#pragma once
/// A side of a figure that supports are to keep off.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "slicer/core/numbers/vec.hpp"

namespace plumbline::inline slicer {

/// Along the axes of the scan as it came, before any rotation.
enum class CleanSide : std::uint8_t { kNone, kPlusX, kMinusX, kPlusY, kMinusY, kPlusZ, kMinusZ };

/// Of each side, in the order of CleanSide: as in options and job files.
inline constexpr std::array<std::string_view, 7> kCleanSideWords = {"none", "+x", "-x", "+y", "-y", "+z", "-z"};
inline constexpr const char* kCleanSideForm = "none, +x, -x, +y, -y, +z or -z";

constexpr std::optional<CleanSide> clean_side_named(std::string_view word) {
  const auto* const found = std::find(kCleanSideWords.begin(), kCleanSideWords.end(), word);
  if (found == kCleanSideWords.end()) return std::nullopt;
  return static_cast<CleanSide>(found - kCleanSideWords.begin());
}

/// Cosine of the angle between a surface's normal and that side; 0 if it faces away, or for kNone.
inline float facing(CleanSide side, const Vec3f& normal) {
  if (side == CleanSide::kNone) return 0;
  const int i = static_cast<int>(side) - 1;
  return std::max(0.0F, i % 2 == 0 ? normal[i / 2] : -normal[i / 2]);
}

}  // namespace plumbline::inline slicer
