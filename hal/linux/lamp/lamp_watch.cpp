#include "hal/linux/lamp/lamp_watch.hpp"

namespace plumbline {

LampWatch::LampWatch(LampKeeper keeper, EventQueue& events, bool has_cover, std::function<void()> hold_line_off)
    : keeper_(std::move(keeper)), events_(events), has_cover_(has_cover), hold_line_off_(std::move(hold_line_off)) {
  // The keeper reported the cover's state before it was ready.
  while (const auto notice = keeper_.next_notice()) open_ = notice->kind != LampKeeper::Notice::Kind::kCoverClosed;
}

void LampWatch::on_lit(Time at) {
  lit_ = true;
  cut_by_cover_ = false;
  dark_at_ = at;
}

void LampWatch::on_dark(Time at) {
  if (!lit_) return;
  lit_ = false;
  dark_at_ = at;
  events_.add(EventKind::kExposureEnded, at);
}

void LampWatch::drain(Time now) {
  if (gone_) return;
  while (const auto notice = keeper_.next_notice()) {
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
      case LampKeeper::Notice::Kind::kGone:
        gone_ = true;
        hold_line_off_();
        on_dark(now);
        if (has_cover_) open_ = true;
        return;
    }
  }
}

}  // namespace plumbline
