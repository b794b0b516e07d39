#pragma once
/// How to close an underside that the scan did not see.

#include <cstdint>

namespace plumbline::inline slicer {

enum class BaseChoice : std::uint8_t {
  kAuto,  ///< flat, at the base plane, where the surface is open there
  kNone,  ///< no base plane: the winding number closes the underside like any other hole
  kFlat,  ///< flat, at the base plane, even where the surface looks closed; nothing is printed below it
};

/// "auto", "none", "flat".
constexpr const char* to_string(BaseChoice choice) {
  return choice == BaseChoice::kAuto ? "auto" : choice == BaseChoice::kNone ? "none" : "flat";
}

}  // namespace plumbline::inline slicer
