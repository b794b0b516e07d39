#pragma once
/// Devices that are open for one measurement, and what ends it.

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "firmware/io/interrupt.hpp"
#include "firmware/setup/setup.hpp"

namespace plumbline::firmware {

/// The source of a measured value, in its line's comment.
inline constexpr const char* kMeasured = "measured by plumbline setup";

/// A number that a person types, with a point or a comma.
/// @retval ErrorCode::kBadSetting  no number, or outside least to most
[[nodiscard]] Expected<double> number_in(std::string text, double least, double most, const char* unit);

/// Stop, pause or the system's wish to end.
/// @retval ErrorCode::kCancelled
[[nodiscard]] Status ended_by(const Event& event);

/// Waits for a motion or an exposure. Ends it, and returns why, when somebody wants to stop.
template <class Action>
Status wait_for(Action& action, Machine& machine) {
  constexpr std::chrono::milliseconds kLook{10};  // Ctrl-C is no event
  constexpr std::chrono::seconds kGrace{2};
  while (!action.over()) {
    if (interrupted()) {
      return fail(ErrorCode::kCancelled, "interrupted: the lamp is dark, the plate stands, and nothing was written");
    }
    if (machine.clock.now() > action.ends_by() + kGrace) {
      return fail(ErrorCode::kDeviceTimeout, "a motion or an exposure did not end in time:\tswitch the printer off");
    }
    const auto event = machine.events.next_event(machine.clock.now() + kLook);
    PLUMBLINE_TRY(event);
    if (*event) PLUMBLINE_TRY(ended_by(**event));
  }
  return {};
}

/// While one is open, the dialogue heeds the printer's buttons. At its end the lamp is dark, the panel black and the stage still.
class Bench {
 public:
  [[nodiscard]] static Expected<std::unique_ptr<Bench>> open(Dialogue& dialogue, const BoardFile& board,
                                                             const OpenMachine& open);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  ~Bench();

  Machine& machine() { return back_end_->machine(); }
  Witness* witness() { return back_end_->witness(); }

  /// Asks whether the lamp may be lit, and lights it for at most `time`.
  /// @param name  of the question
  /// @param what  for: " on the meter"
  /// @returns whether it was lit to the end
  [[nodiscard]] Expected<bool> flash(nanoseconds time, const std::string& name, const std::string& what);

  [[nodiscard]] Status show(const std::function<void(BitImage)>& draw);

 private:
  Bench(Dialogue& dialogue, std::unique_ptr<BackEnd> back_end);

  Dialogue& dialogue_;
  std::unique_ptr<BackEnd> back_end_;
};

}  // namespace plumbline::firmware
