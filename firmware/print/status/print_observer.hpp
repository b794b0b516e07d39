#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/print/status/print_report.hpp"
#include "firmware/print/status/print_state.hpp"
#include "hal/clock.hpp"
#include "hal/units.hpp"
#include "slicer/core/bit_image.hpp"

namespace plumbline::firmware {

/// What a print has heard or waits for, beside its state.
enum class PrintNote : std::uint8_t {
  kNone,
  kPauseTaken,  ///< it pauses after the layer at hand
  kCoverFirst,  ///< the plate moves when the cover is closed
};

/// A sentence, and the same as a code.
struct Spoken {
  FixedText<160> text;
  Told told;
};

/// How far a print is.
struct PrintStatus {
  PrintState state = PrintState::kIdle;
  PrintNote note = PrintNote::kNone;
  std::uint32_t layer = 0;  ///< the next one to cure, from 0; equals `layers` when all are cured
  std::uint32_t layers = 0;
  ZPosition height;  ///< of that layer
  TimePoint now;
  nanoseconds elapsed{};
  nanoseconds remaining{};
  std::optional<nanoseconds> slack;  ///< of the last mask
  double resin_ml = 0;               ///< used so far
  std::string_view question;         ///< why the print waits, and for what; empty: the state says it
  Told question_told;                ///< the same as a code
};

/// Follows a print.
class PrintObserver {
 public:
  virtual ~PrintObserver() = default;
  /// Called after each layer, on each change of state, and several times a second while the print waits.
  /// @returns false: cancel the print
  virtual bool update(const PrintStatus& status) = 0;
  /// Called when the next mask is ready and there is time to look at it, before it is shown. Not called for each layer.
  /// @param mask  valid during the call
  virtual void mask_made(std::uint32_t /*layer*/, ConstBitImage /*mask*/) {}
  /// Called after each check.
  virtual void checked(Check check, const CheckResult& result) = 0;
};

}  // namespace plumbline::firmware
