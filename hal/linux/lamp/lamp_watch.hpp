#pragma once
/// Tracks the state of lamp and cover from the keeper's notices, and replaces a keeper that is gone.

#include <memory>

#include "hal/linux/events/event_queue.hpp"
#include "hal/linux/events/event_source.hpp"
#include "hal/linux/lamp/lamp_keeper.hpp"

namespace plumbline::inline hal::inline linux_board {

class LampWatch final : public EventSource {
 public:
  using Time = std::chrono::nanoseconds;

  /// Starts the keeper. @retval as LampKeeper::start()
  [[nodiscard]] static Expected<std::unique_ptr<LampWatch>> start(LampKeeper::Settings settings, EventQueue& events);

  /// @retval ErrorCode::kLampFailed  there is no keeper, and none could be started
  [[nodiscard]] Expected<LampKeeper*> keeper();
  bool lit() const { return lit_; }
  /// Also true on a printer with a cover switch while there is no keeper, since nobody watches the switch.
  bool cover_open() const { return open_; }
  /// When the lamp last went off.
  Time dark_at() const { return dark_at_; }
  bool cut_by_cover() const { return cut_by_cover_; }
  /// Why the keeper ended, for messages, if that cut the last exposure short. Otherwise null.
  const char* cut_by_loss() const { return cut_by_loss_; }

  void on_lit(Time at);

  int descriptor() const override { return keeper_ && !gone_ ? keeper_->descriptor() : -1; }
  void drain(Time now) override;

 private:
  LampWatch(LampKeeper::Settings settings, EventQueue& events)
      : settings_(std::move(settings)), events_(events), light_(settings_.limits) {}
  Status start_keeper();
  void on_dark(Time at);
  /// The keeper is gone: its line is held by this process, or still lit.
  void on_gone(Time now);

  LampKeeper::Settings settings_;
  EventQueue& events_;
  LightBudget light_;                   // of all keepers, for the next one
  std::unique_ptr<LampKeeper> keeper_;  // a keeper that is gone stays here, since its guard holds the line
  std::unique_ptr<LampLine> held_;      // if no keeper could be started
  bool gone_ = true;
  bool lit_ = false;
  bool open_ = false;
  bool cut_by_cover_ = false;
  const char* cut_by_loss_ = nullptr;
  Time lit_at_{};
  Time dark_at_{};
};

}  // namespace plumbline::inline hal::inline linux_board
