#include "hal/linux/lamp/lamp_watch.hpp"

namespace plumbline {

LampWatch::LampWatch(LampKeeper keeper, EventQueue& events, bool has_cover, std::function<void()> hold_dark)
    : keeper_(std::move(keeper)), events_(events), has_cover_(has_cover), hold_dark_(std::move(hold_dark)) {
  // It said how it found the cover before it said that it was ready.
  while (const auto news = keeper_.next_news()) open_ = news->kind != LampKeeper::News::Kind::kCoverClosed;
}

void LampWatch::began(Time at) {
  lit_ = true;
  cut_by_cover_ = false;
  dark_at_ = at;
}

void LampWatch::ended(Time at) {
  if (!lit_) return;
  lit_ = false;
  dark_at_ = at;
  events_.add(EventKind::kExposureEnded, at);
}

void LampWatch::drain(Time now) {
  if (gone_) return;
  while (const auto news = keeper_.next_news()) {
    switch (news->kind) {
      case LampKeeper::News::Kind::kDark: ended(news->at); break;
      case LampKeeper::News::Kind::kCoverOpened:
        if (!open_) events_.add(EventKind::kCoverOpened, news->at);
        open_ = true;
        cut_by_cover_ = cut_by_cover_ || lit_;
        break;
      case LampKeeper::News::Kind::kCoverClosed:
        if (open_) events_.add(EventKind::kCoverClosed, news->at);
        open_ = false;
        break;
      case LampKeeper::News::Kind::kGone:
        gone_ = true;
        hold_dark_();
        ended(now);
        if (has_cover_) open_ = true;
        return;
    }
  }
}

}  // namespace plumbline
