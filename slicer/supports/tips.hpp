#pragma once
/// Finds where supports are needed, from the masks alone (thesis I).

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/window.hpp"

namespace plumbline::inline slicer {

/// A place of the object that a support holds.
struct Tip {
  std::uint16_t column = 0, row = 0;
  std::uint16_t floor = 0;  ///< layer in which a foot straight below it stands; 0: on the plate
  std::uint16_t layer = 0;  ///< first layer of the object above it
  std::uint16_t end = 0;    ///< layer after the last that its head may reach into
  bool island = false;      ///< else an overhang
  bool dense = false;       ///< carries less, as it holds an island with no or few other tips
  std::uint32_t load = 0;   ///< pixels of overhang that it carries
  std::uint32_t close = 0;  ///< those of them that are nearer than points_minimal_distance
};

/// Tips that get no support: each would touch the object or end at its walls.
struct UnreachedTips {
  std::uint32_t count = 0;
  Tip largest;  ///< of them, by its load; of equal ones the first

  void add(const Tip& tip) {
    if (count == 0 || tip.load > largest.load) largest = tip;
    ++count;
  }
};

/// A pixel of a speck: of an island that its own tip would cover, so the print does without it.
struct SpeckPixel {
  std::uint32_t pixel = 0;  ///< row * columns + column
  std::uint16_t layer = 0;
  std::uint16_t depth = 1;  ///< layers of the speck so far
  bool in_section = true;   ///< else the mask's closing has added it
};

struct FoundTips {
  std::span<Tip> tips;            ///< by layer
  std::span<SpeckPixel> specks;   ///< by layer; those that the R-Rep has
  std::uint32_t speck_count = 0;  ///< of specks, not of their pixels
  std::uint32_t missed = 0;       ///< bit i: there is no surface at settings.added.list[i]
};

/// Sweeps the object's masks once, from the plate up, and puts tips
///   - below every island: a region of a mask that has no pixel above the layer below or above the head of a support;
///   - below overhangs: new pixels of a layer farther than overhang_span / 2 from all *held* pixels;
///   - where the overhang nearest to one tip becomes larger than area_per_tip.
/// Held are layer 0, the discs of tips, pixels within layer_height / tan(overhang_angle) of held pixels a layer below, and
/// pixels that have been there for as many layers as that growth would have needed (HeldArea). So a slope steeper than the
/// overhang angle needs no support, a flatter one gets them where it has fallen behind, and bridges up to overhang_span are free.
/// Each place of settings.added gets a tip, too (PlacedTips), and no other tip is put into a ball of settings.blocked, whatever falls without it.
///
/// The load of a tip is the area of new pixels that nothing held when they were cured and to which no other tip is nearer, of
/// those at most a few millimetres below.
///
/// An island that is a *speck* gets no tip, but is to be left out of the print: it has at most the area of a light tip and, with such
/// islands below it, a height of 0.2 mm. What a scan's last noise leaves at the lower end of a surface
/// is that small, and vanishes in the region that grows over it. A tip would be larger, and so would its scar.
/// @param settings  accepted by check_support_settings()
/// @param rrep      not lifted yet
/// @param lifted    empty layers that will be put below it; the tips' layers count them
/// @param list      most_tips() of them, overwritten
/// @param specks    overwritten; islands that there is no more room for here get tips
/// @param progress  may be null
/// @returns those of both lists that were found
/// @retval ErrorCode::kOutOfMemory  the arena is full, or the list
/// @retval ErrorCode::kCancelled    `progress` asked to stop
[[nodiscard]] Expected<FoundTips> find_tips(const RRep& rrep, std::uint32_t lifted, const SupportSettings& settings,
                                            std::span<Tip> list, std::span<SpeckPixel> specks, Arena& arena,
                                            ProgressSink* progress);

/// Bytes from the bottom and top of the arena while find_tips() runs, for any settings.
/// @param window  of the object
std::size_t find_tips_bytes(const PrintGrid& grid, const Window& window);

/// Largest number of tips on a panel. It follows the panel's area, so coarse pixels leave no object without its supports.
std::uint32_t most_tips(const PrintGrid& grid);

}  // namespace plumbline::inline slicer
