#pragma once
/// What the plant objects to: anything that would ruin a print or hurt someone.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "hal/clock.hpp"
#include "hal/units.hpp"

namespace plumbline {

enum class ObjectionKind : std::uint8_t {
  kMaskChangedUnderLight,  ///< a flip or a blank began while there was light
  kMaskTornUnderLight,     ///< light through a panel whose rows are not all those of the mask that was presented
  kMotionUnderLight,       ///< the stage moved while there was light, or light began while it moved
  kLightWithCoverOpen,     ///< light more than 10 ms after the cover opened, or begun with it open
  kExposureWithoutMask,    ///< light through a blank panel
  kTravelPastEnd,          ///< the plate or the part was pressed into the film, or the carriage into its upper end
  kLiftSkipped,            ///< a layer was exposed while the last one stuck to the film
  kDoseOff,                ///< a layer got more than 1 % more or less than was asked for it
  kNotBonded,              ///< a layer cured less deep than the gap to what is above it
};
inline constexpr std::size_t kObjectionKindCount = 9;

/// "mask changed under light", ...
std::string_view to_string(ObjectionKind kind);

struct Objection {
  ObjectionKind kind = ObjectionKind::kDoseOff;
  TimePoint at;
  ZPosition z;              ///< of the plate, as it really was
  std::uint32_t layer = 0;  ///< the one being made, 0-based
  std::string detail;
};

/// "12.345 s, layer 40, 2.050 mm: dose off: ..."
std::string to_string(const Objection& objection);

}  // namespace plumbline
