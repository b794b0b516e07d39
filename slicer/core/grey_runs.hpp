#pragma once
/// Pixels of a mask that let some of the light through, beside its BitImage.

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>

#include "slicer/core/bit_spans.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::inline slicer {

/// Which pixels of a mask may be grey: none, those where rays enter the object, so that undersides lie between the heights of layers, or also those
/// that walls pass through.
enum class Grey : std::uint8_t { kOff, kVertical, kFull };
/// Of each pixel.
constexpr std::uint32_t rays_for(Grey grey) { return grey == Grey::kFull ? 1 + kRaysAround : 1; }

/// A stretch of pixels of one row that let some of the light through.
struct GreyRun {
  std::uint32_t pixel = 0;  ///< first, row * columns + column
  std::uint16_t count = 0;  ///< 1 or more
  std::uint8_t level = 0;   ///< 1 to 254 of 255, share of the dose

  std::uint32_t end() const { return pixel + count; }
  bool operator==(const GreyRun&) const = default;
};
static_assert(sizeof(GreyRun) == 8);

/// The share of the light that all of it is.
inline constexpr std::uint8_t kFullLevel = 255;
/// The least level that is taken to cure: bits of an image under grey pixels are set from here on. In UVtools' test of greys, pixels below
/// some 170 to 190 often don't bond.
inline constexpr std::uint8_t kLeastCuringLevel = 128;

constexpr bool is_grey(std::uint32_t level) { return level > 0 && level < kFullLevel; }

/// Sets the bits of grey pixels by kLeastCuringLevel, as a decoder of their image does.
/// @param runs  of one row each
inline void set_bits(std::span<const GreyRun> runs, BitImage image) {
  for (const GreyRun& run : runs) {
    const std::uint32_t row = run.pixel / image.columns(), begin = run.pixel % image.columns();
    fill(image, row, begin, begin + run.count, run.level >= kLeastCuringLevel);
  }
}

/// The grey pixels of a mask, in memory of its owner. A pixel for which there is no room is as its bit in the image says.
class GreyRuns {
 public:
  /// One run for so many pixels is enough: the outlines of a plate full of parts.
  static constexpr std::size_t kPixelsPerRun = 16;
  static constexpr std::size_t runs_needed(std::uint32_t columns, std::uint32_t rows) {
    return (std::size_t{columns} * rows + kPixelsPerRun - 1) / kPixelsPerRun;
  }

  /// Without room: a panel that shows black and white only.
  GreyRuns() = default;
  /// @param room     must outlive this
  /// @param columns  of the image, 1 to 16384
  GreyRuns(std::span<GreyRun> room, std::uint32_t columns) : room_(room), columns_(columns) {}

  /// Adds a pixel, each at most once and in any order; the cost is least in ascending order. It lengthens the last run where it can.
  /// @param level  is_grey()
  void add(std::uint32_t pixel, std::uint8_t level) {
    assert(is_grey(level));
    if (count_ > 0 && continues(room_[count_ - 1], pixel, level)) {
      ++room_[count_ - 1].count;
      return;
    }
    add(GreyRun{pixel, 1, level});
  }
  /// Adds all pixels of a run.
  void add(const GreyRun& run) {
    if (count_ == room_.size() && !make_room()) {
      lost_ += run.count;
      return;
    }
    sorted_ = sorted_ && (count_ == 0 || run.pixel >= room_[count_ - 1].end());
    room_[count_++] = run;
  }
  /// Puts the runs in order and joins those that touch.
  void finish() {
    if (!sorted_) sort();
  }
  void clear() {
    count_ = 0;
    lost_ = 0;
    sorted_ = true;
    full_ = false;
  }

  /// Ascending, of one row each. @pre pixels were added in ascending order, or finish() was called
  std::span<const GreyRun> runs() const {
    assert(sorted_);
    return room_.first(count_);
  }
  bool empty() const { return count_ == 0; }
  std::size_t capacity() const { return room_.size(); }  ///< runs
  std::uint64_t lost() const { return lost_; }           ///< pixels that found no room

 private:
  bool continues(const GreyRun& run, std::uint32_t pixel, std::uint8_t level) const {
    return run.level == level && run.end() == pixel && pixel % columns_ != 0;
  }
  void sort() {
    const auto runs = room_.first(count_);
    std::sort(runs.begin(), runs.end(), [](const GreyRun& a, const GreyRun& b) { return a.pixel < b.pixel; });
    std::size_t kept = 0;
    for (const GreyRun& run : runs) {
      if (kept > 0 && continues(runs[kept - 1], run.pixel, run.level)) {
        runs[kept - 1].count = static_cast<std::uint16_t>(runs[kept - 1].count + run.count);
      } else {
        runs[kept++] = run;
      }
    }
    count_ = kept;
    sorted_ = true;
  }
  /// Joins runs that were added out of order, unless that freed few the last time.
  bool make_room() {
    if (sorted_ || full_) return false;
    sort();
    full_ = count_ > room_.size() - room_.size() / 8;
    return count_ < room_.size();
  }

  std::span<GreyRun> room_;
  std::uint32_t columns_ = 1;
  std::size_t count_ = 0;
  std::uint64_t lost_ = 0;
  bool sorted_ = true;
  bool full_ = false;
};

}  // namespace plumbline::inline slicer
