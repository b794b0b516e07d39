#pragma once
/// The record of a print: checks, exposures, times, fault.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/status/print_state.hpp"
#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline::firmware {

enum class Check : std::uint8_t {
  kMemory,        ///< the print's share of the arena
  kObject,        ///< stands on the plate, within the travel
  kMasks,         ///< islands, resin traps and the like
  kLight,         ///< cures through a layer
  kLampDark,      ///<
  kPanel,         ///< has the board file's size and takes a mask
  kCover,         ///< closed
  kTemperatures,  ///<
  kResin,         ///< needed, against a full tank
  kJournal,       ///< kept, so that a power cut is survived
  kStage,         ///< finds its end stop
};
inline constexpr std::size_t kCheckCount = 11;

/// In this order.
inline constexpr std::array<std::string_view, kCheckCount> kCheckWords = {
    "memory", "object", "masks", "light", "lamp dark", "panel", "cover", "temperatures", "resin", "journal", "stage"};
static_assert(!kCheckWords.back().empty());
constexpr std::string_view to_string(Check check) { return kCheckWords[static_cast<std::size_t>(check)]; }

enum class CheckOutcome : std::uint8_t { kNotReached, kPassed, kWarned, kFailed };
/// In reports and on the state socket, in this order.
inline constexpr std::array<std::string_view, 4> kOutcomeWords = {"not reached", "passed", "noted", "failed"};
constexpr std::string_view to_string(CheckOutcome outcome) { return kOutcomeWords[static_cast<std::size_t>(outcome)]; }

struct CheckResult {
  CheckOutcome outcome = CheckOutcome::kNotReached;
  Sentence detail;  ///< "28.0 degrees, 18 to 40 allowed"
  Told told;        ///< the same as a code
};

/// One exposure, and the next mask, which was rendered meanwhile.
struct ExposureLine {
  std::uint32_t layer = 0;
  std::uint32_t exposure = 0;  ///< of the layer's, from 0; one that was interrupted has several lines
  ExposureEnd end = ExposureEnd::kTimeUp;
  DoseSource source = DoseSource::kComputed;
  nanoseconds asked{};
  nanoseconds lit{};
  Dose expected;  ///< of `lit`, at the board file's irradiance
  Dose dose;
  std::uint64_t mask_hash = 0;
  bool next_made = false;  ///< a next mask was rendered; otherwise the rest is 0
  nanoseconds slack{};     ///< left of the exposure when the next mask was ready; below 0: it was late
  nanoseconds making{};    ///< of the next mask, by the processor's clock
  nanoseconds copying{};
};

struct PrintReport {
  PrintState state = PrintState::kIdle;  ///< at the end
  FaultCode fault = FaultCode::kNone;
  FixedText<448> fault_message;
  Told fault_told;  ///< what the message says, if it has a code
  std::array<CheckResult, kCheckCount> checks;

  bool begun = false;  ///< the checks have passed; before that nothing lights or moves
  std::uint32_t layers = 0;
  std::uint32_t first_layer = 0;  ///< above 0: resumed
  std::uint32_t next_layer = 0;   ///< all before it are cured
  std::uint64_t cured_pixels = 0;
  double resin_ml = 0;
  nanoseconds elapsed{};    ///< of this run, checks included
  nanoseconds estimated{};  ///< before it began
  std::uint32_t slowest_layer = 0;
  nanoseconds slowest{};
  std::uint32_t late_masks = 0;
  std::uint32_t pauses = 0;                   ///< by the user, the cover, a hot lamp or low resin
  std::uint32_t doses_off = 0;                ///< exposures whose measured dose was over 1 % off
  Distance steps_lost;                        ///< by the homing at the end
  std::optional<std::uint32_t> marked_layer;  ///< may show that the print was interrupted

  std::span<ExposureLine> room;          ///< for exposures
  std::span<ExposureLine> exposures;     ///< in order, at the start of `room`
  std::uint32_t exposures_left_out = 0;  ///< beyond the room for them

  /// Appends an exposure, or only counts it where there is no room.
  void add(const ExposureLine& exposure);
};

/// Figures of the masks that were rendered during exposures.
struct MaskFigures {
  std::uint32_t masks = 0;
  nanoseconds smallest_slack{};
  std::uint32_t smallest_slack_layer = 0;  ///< the layer exposed meanwhile
  nanoseconds median_making{};
  nanoseconds worst_making{};
  nanoseconds median_copying{};
  /// Median time to render a mask over median time to copy its bytes; 0 without a mask.
  double ratio() const {
    return median_copying.count() > 0
               ? static_cast<double>(median_making.count()) / static_cast<double>(median_copying.count())
               : 0;
  }
};

/// @param scratch  as large as `exposures`
MaskFigures mask_figures(std::span<const ExposureLine> exposures, std::span<nanoseconds> scratch);

/// Passes each sentence that the user should read to `tell`.
void for_each_warning(const PrintReport& report, const std::function<void(const Told&, std::string_view)>& tell);

}  // namespace plumbline::firmware
