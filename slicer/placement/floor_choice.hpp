#pragma once
/// What to do with a floor that was scanned with the object.

#include <cstdint>

namespace plumbline::inline slicer {

struct FloorChoice {
  enum class Kind : std::uint8_t {
    kAuto,    ///< a plane that the object stands on is found and cut off
    kKeep,    ///< it is printed
    kHeight,  ///< everything below `height` is cut off
  };
  Kind kind = Kind::kAuto;
  double height = 0;  ///< z of the rotated scan, scan units
  bool operator==(const FloorChoice&) const = default;
};

inline constexpr double kLargestFloorHeight = 1e9;  ///< scan units, up and down

}  // namespace plumbline::inline slicer
