#include "firmware/page/page_log.hpp"

#include <cstdio>
#include <utility>

namespace plumbline::firmware::inline page {

void PageLog::say(const PrintableText& text, HostClock::time_point now) {
  if (!lines_.takes_line(now)) return;
  if (const unsigned left_out = lines_.take_left_out(); left_out > 0) {
    std::fprintf(stderr, "plumbline-page: %u lines are left out\n", left_out);
  }
  std::fprintf(stderr, "plumbline-page: %s\n", text.c_str());
}

void PageLog::count(HostClock::time_point now) {
  const bool is_due = counted_at_ == HostClock::time_point() || now - counted_at_ >= kBetweenCounts;
  if (!is_due || refused_ + turned_away_ == 0) return;
  counted_at_ = now;
  FixedText<160> text;
  text.add("too many requests: refused %u, and %u connections", refused_, turned_away_);
  if (refused_ > 0) text.add("; the last request was from %s", text_of(last_).c_str());
  refused_ = turned_away_ = 0;
  say(text.view(), now);
}

}  // namespace plumbline::firmware::inline page
