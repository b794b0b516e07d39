#pragma once
/// What the plant objects to: anything that would ruin a print or hurt someone.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/clock.hpp"
#include "hal/sim/part/loss.hpp"
#include "hal/units.hpp"

namespace plumbline::inline hal::inline sim {

enum class ObjectionKind : std::uint8_t {
  kMaskChangedUnderLight,  ///< a flip or a blank began while there was light
  kMaskTornUnderLight,     ///< light through a panel that does not show all rows of the presented mask
  kMotionUnderLight,       ///< the stage moved while there was light, or light began while it moved
  kLightWithCoverOpen,     ///< light that begins with the cover open, or lasts until 10 ms after it opened
  kExposureWithoutMask,    ///< light through a blank panel
  kTravelPastEnd,          ///< the plate or part was pressed into the film, or the carriage into its upper end
  kLiftSkipped,            ///< a layer was exposed while the last one still stuck to the film
  kDoseOff,                ///< a layer's dose was more than 1 % off
  kNotBonded,              ///< a layer cured less deep than the gap to the layer above it
  kDropped,                ///< a region of a layer touches nothing held: it drops on the film
  kTorn,                   ///< the peel asked for more than the part or the plate holds: a piece stays on the film
  kShadowed,               ///< what lies on the film kept light from the part
};
inline constexpr std::size_t kObjectionKindCount = 12;

/// The objection to a loss.
ObjectionKind kind_of(LossKind kind);

/// "mask changed under light", ...
std::string_view to_string(ObjectionKind kind);

struct Objection {
  ObjectionKind kind = ObjectionKind::kDoseOff;
  TimePoint at;
  ZPosition z;              ///< true height of the plate
  std::uint32_t layer = 0;  ///< in progress, 0-based
  std::string detail;
  std::optional<Loss> loss;  ///< of kDropped, kTorn, kShadowed; up to date until the print ends
};

/// "12.345 s, layer 40, 2.050 mm: dose off: ..."
std::string to_string(const Objection& objection);

}  // namespace plumbline::inline hal::inline sim
