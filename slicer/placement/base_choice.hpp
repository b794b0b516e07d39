#pragma once
/// What becomes of an underside that the scan has not seen.

#include <cstdint>

namespace plumbline {

enum class BaseChoice : std::uint8_t {
  kAuto,  ///< closed flat at the base plane where the surface is open there
  kNone,  ///< no base plane: what is open is closed as any other hole, by the winding number
  kFlat,  ///< stands on the base plane whether the surface looks open there or not; nothing is printed below it
};

/// "auto", "none", "flat".
const char* to_string(BaseChoice choice);

}  // namespace plumbline
