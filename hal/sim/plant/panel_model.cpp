#include "hal/sim/plant/panel_model.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace plumbline::inline hal::inline sim {

PanelModel::PanelModel(Timeline& timeline, const Build& build) : timeline_(timeline), build_(build) {
  for (auto& buffer : buffers_) buffer.resize(BitImage::words_needed(build.columns, build.rows), 0);
  if (!build.grey.has_levels()) return;
  shares_ = LampShares(build.lamp, build.columns, build.rows);
  light_ = build.grey.values();
  for (auto& of_level : light_) {
    for (auto& value : of_level) value = static_cast<std::uint8_t>(std::lround(255 * build.grey.light(value)));
  }
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    runs_[i].resize(GreyRuns::runs_needed(build.columns, build.rows));
    greys_[i] = GreyRuns(runs_[i], build.columns);
  }
}

void PanelModel::flip(bool black, std::function<void()> on_settled) {
  timeline_.cancel(due_);
  if (never_flips) return;
  const auto since_start = timeline_.now().time_since_epoch();
  const TimePoint frame((since_start / build_.frame + 1) * build_.frame);
  due_ = timeline_.at(frame, [this, black, on_settled = std::move(on_settled)] {
    if (on_change) on_change();
    changing_ = true;
    was_black_ = black_;
    matches_mask_ = !stale && !torn;
    if (!stale) {
      black_ = black;
      if (!black) shown_ = 1 - shown_;
    }
    due_ = timeline_.at(timeline_.now() + build_.frame + build_.settling + extra, [this, on_settled] {
      changing_ = false;
      on_settled();
    });
  });
}

void PanelModel::cut() {
  timeline_.cancel(due_);
  changing_ = false;
  black_ = true;
  matches_mask_ = true;
}

ConstBitImage PanelModel::visible() {
  if (!shows_two()) return image(shown_);
  torn_.resize(buffers_[0].size());
  const auto half = static_cast<std::ptrdiff_t>(torn_.size() / build_.rows * (build_.rows / 2));
  const auto& upper = buffers_[shown_];
  const auto& lower = buffers_[black_ ? shown_ : 1 - shown_];
  std::fill(torn_.begin(), torn_.end(), 0);
  if (!black_) std::copy(upper.begin(), upper.begin() + half, torn_.begin());
  if (!was_black_) std::copy(lower.begin() + half, lower.end(), torn_.begin() + half);
  return {torn_, build_.columns, build_.rows};
}

/// Adds what the panel makes of a run.
/// @param row  of the shares of an uneven lamp, at the run; null: all is let through
void PanelModel::add_visible(const GreyRun& run, LampShares::Row* row) {
  const std::uint32_t column = run.pixel % build_.columns;
  const std::uint32_t pattern = 4 * (run.pixel / build_.columns % 4);
  for (std::uint32_t i = 0; i < run.count; ++i) {
    const std::uint8_t level = row != nullptr ? LampShares::scaled(run.level, row->next()) : run.level;
    const std::uint8_t light = light_[level][pattern + (column + i) % 4];
    if (level == kFullLevel) continue;  // white
    if (i > 0 && !visible_greys_.empty() && visible_greys_.back().end() == run.pixel + i &&
        visible_greys_.back().level == light) {
      ++visible_greys_.back().count;
    } else {
      visible_greys_.push_back({run.pixel + i, 1, light});
    }
  }
}

std::span<const GreyRun> PanelModel::visible_greys() {
  const std::uint32_t pixels = build_.columns * build_.rows, half = build_.columns * (build_.rows / 2);
  visible_greys_.clear();
  sent_.clear();
  const auto send = [&](std::size_t which, std::uint32_t begin, std::uint32_t end) {
    std::ranges::copy_if(greys_[which].runs(), std::back_inserter(sent_),
                         [&](const GreyRun& run) { return run.pixel >= begin && run.pixel < end; });
  };
  if (!shows_two()) {
    if (black_) return {};
    send(shown_, 0, pixels);
  } else {
    if (!black_) send(shown_, 0, half);
    if (!was_black_) send(black_ ? shown_ : 1 - shown_, half, pixels);
  }
  if (shares_.known()) {
    for_each_lit_run(visible(), sent_, shares_,
                     [this](const GreyRun& run, LampShares::Row& row) { add_visible(run, &row); });
  } else {
    for (const GreyRun& run : sent_) add_visible(run, nullptr);
  }
  return visible_greys_;
}

}  // namespace plumbline::inline hal::inline sim
