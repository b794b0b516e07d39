#pragma once
/// The lamp of a board, driven by the keeper. It has no monitor: "lit" is the line's state, and a dose is computed.

#include "hal/linux/lamp/lamp_watch.hpp"
#include "hal/uv_lamp.hpp"

namespace plumbline::inline hal::inline linux_board {

class LinuxUvLamp final : public UvLamp {
 public:
  /// @param watch  must outlive it
  LinuxUvLamp(const Limits& limits, LampWatch& watch, Interlock& interlock, Clock& clock)
      : UvLamp(limits, interlock, clock), watch_(watch) {}

 private:
  Expected<TimePoint> do_begin(nanoseconds cure) override;
  bool do_over() const override;
  void do_turn_off() noexcept override;
  bool do_lit() const override;
  Expected<ExposureReport> do_report() override;

  LampWatch& watch_;
  nanoseconds began_at_{};
  nanoseconds asked_{};
};

}  // namespace plumbline::inline hal::inline linux_board
