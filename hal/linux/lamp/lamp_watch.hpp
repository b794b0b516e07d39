#pragma once
/// Tracks the state of lamp and cover from the keeper's notices.

#include <functional>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"
#include "hal/linux/lamp/lamp_keeper.hpp"

namespace plumbline {

class LampWatch final : public EventSource {
 public:
  using Time = std::chrono::nanoseconds;

  /// @param has_cover  whether the keeper watches a cover switch
  /// @param hold_line_off  takes the lamp's line itself and turns it off: called once, should the keeper end
  LampWatch(LampKeeper keeper, EventQueue& events, bool has_cover, std::function<void()> hold_line_off);

  LampKeeper& keeper() { return keeper_; }
  bool lit() const { return lit_; }
  /// Also true on a printer with a cover switch once the keeper is gone, since nobody watches the switch.
  bool cover_open() const { return open_; }
  bool gone() const { return gone_; }
  /// When the lamp last went off.
  Time dark_at() const { return dark_at_; }
  bool cut_by_cover() const { return cut_by_cover_; }

  void on_lit(Time at);

  int descriptor() const override { return gone_ ? -1 : keeper_.descriptor(); }
  void drain(Time now) override;

 private:
  void on_dark(Time at);

  LampKeeper keeper_;
  EventQueue& events_;
  bool has_cover_;
  std::function<void()> hold_line_off_;
  bool lit_ = false;
  bool open_ = false;
  bool gone_ = false;
  bool cut_by_cover_ = false;
  Time dark_at_{};
};

}  // namespace plumbline
