#include "hal/linux/lamp/lamp_watch.hpp"

#include <utility>

#include "hal/linux/events/clock.hpp"
#include "hal/linux/keeper/keeper_lines.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

/// For a keeper that was killed to leave the kernel, and for its line to be taken: milliseconds on any board that still works.
constexpr std::chrono::milliseconds kTakeTime{250};

}  // namespace

Expected<std::unique_ptr<LampWatch>> LampWatch::start(LampKeeper::Settings settings, EventQueue& events) {
  std::unique_ptr<LampWatch> watch(new LampWatch(std::move(settings), events));
  PLUMBLINE_TRY(watch->start_keeper());
  return watch;
}

Status LampWatch::start_keeper() {
  // Releases the line, dark. The keeper takes it dark.
  keeper_.reset();
  held_.reset();
  settings_.lit_before = light_.light_since(monotonic_now() - LightBudget::kMinute);
  auto started = LampKeeper::start(settings_);
  if (!started) {
    auto line = open_lamp_line(settings_.line);
    if (line) held_ = std::move(*line);
    return tl::unexpected<Error>(started.error());
  }
  keeper_ = std::make_unique<LampKeeper>(std::move(*started));
  gone_ = false;
  // The keeper reported the cover's state before it was ready.
  while (const auto notice = keeper_->next_notice()) open_ = notice->kind != LampKeeper::Notice::Kind::kCoverClosed;
  return {};
}

Expected<LampKeeper*> LampWatch::keeper() {
  // Not while it may be lit: the guard of the lost keeper still tries to take the line.
  if (gone_ && !lit_) PLUMBLINE_TRY(start_keeper());
  if (gone_) return fail(ErrorCode::kLampFailed, "the lamp's keeper is gone:\tswitch the printer off and on");
  return keeper_.get();
}

void LampWatch::on_lit(Time at) {
  lit_ = true;
  cut_by_cover_ = false;
  cut_by_loss_ = nullptr;
  lit_at_ = dark_at_ = at;
}

void LampWatch::on_dark(Time at) {
  if (!lit_) return;
  lit_ = false;
  dark_at_ = at;
  light_.add(lit_at_, at);
  events_.add(EventKind::kExposureEnded, at);
}

void LampWatch::on_gone(Time now) {
  gone_ = true;
  if (!settings_.cover.empty()) open_ = true;
  if (!keeper_->await_dark(kTakeTime)) {
    lit_ = true;  // for all that is known
    return;
  }
  if (lit_) cut_by_loss_ = keeper_->reason();
  on_dark(now);
  // At once, because the board's watchdog runs. The print ends with a fault all the same. If it fails, keeper() tries again.
  static_cast<void>(start_keeper());
}

void LampWatch::drain(Time now) {
  if (gone_) {
    if (lit_ && keeper_->await_dark({})) on_dark(now);
    return;
  }
  while (const auto notice = keeper_->next_notice()) {
    switch (notice->kind) {
      case LampKeeper::Notice::Kind::kDark: on_dark(notice->at); break;
      case LampKeeper::Notice::Kind::kCoverOpened:
        if (!open_) events_.add(EventKind::kCoverOpened, notice->at);
        open_ = true;
        cut_by_cover_ = cut_by_cover_ || lit_;
        break;
      case LampKeeper::Notice::Kind::kCoverClosed:
        if (open_) events_.add(EventKind::kCoverClosed, notice->at);
        open_ = false;
        break;
      case LampKeeper::Notice::Kind::kGone: return on_gone(now);
    }
  }
}

}  // namespace plumbline::inline hal::inline linux_board
