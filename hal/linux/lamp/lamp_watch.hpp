#pragma once
/// What the keeper says, as a state: lamp and cover of a board.

#include <functional>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"
#include "hal/linux/lamp/lamp_keeper.hpp"

namespace plumbline {

class LampWatch final : public EventSource {
 public:
  using Time = std::chrono::nanoseconds;

  /// @param has_cover  the keeper was started with a cover's line
  /// @param hold_dark  takes the lamp's line itself and turns it off: called once, should the keeper end
  LampWatch(LampKeeper keeper, EventQueue& events, bool has_cover, std::function<void()> hold_dark);

  LampKeeper& keeper() { return keeper_; }
  bool lit() const { return lit_; }
  /// Also where the keeper has gone, with a printer that has a switch: nobody looks at it any more.
  bool cover_open() const { return open_; }
  bool gone() const { return gone_; }
  /// When the last light ended; where it ended by the cover.
  Time dark_at() const { return dark_at_; }
  bool cut_by_cover() const { return cut_by_cover_; }

  void began(Time at);

  int descriptor() const override { return gone_ ? -1 : keeper_.descriptor(); }
  void drain(Time now) override;

 private:
  void ended(Time at);

  LampKeeper keeper_;
  EventQueue& events_;
  bool has_cover_;
  std::function<void()> hold_dark_;
  bool lit_ = false;
  bool open_ = false;
  bool gone_ = false;
  bool cut_by_cover_ = false;
  Time dark_at_{};
};

}  // namespace plumbline
