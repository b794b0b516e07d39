#pragma once
/// Struts and pillars while supports are built.

#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/supports/drawing/supports.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

/// A place in a print, mm from the centre of pixel (0, 0) and from the plate.
struct Place {
  double x = 0, y = 0, z = 0;
};

/// An upright strut from `bottom` to `top`, mm.
struct Pillar {
  double x = 0, y = 0;
  double bottom = 0, top = 0;
  double radius = 0;             ///< mm
  std::uint32_t bridges = 0;     ///< heads that hang on it besides its own
  std::uint32_t contacts = ~0U;  ///< index of its last contact; see Bracing
  bool on_plate = false;
};

/// Lists of fixed length, and the way from millimetres to pixels and layers.
class StrutList {
 public:
  /// @param struts, pillars  most_struts() and most_pillars() of them
  StrutList(const PrintGrid& grid, std::span<Strut> struts, std::span<Pillar> pillars)
      : grid_(grid), struts_(struts), pillars_(pillars) {}

  /// Adds a cone or rod between two places, lower one first. Where pixels are coarse it is thicker than asked.
  /// @param layers  of the whole strut: [first, end)
  /// @retval ErrorCode::kOutOfMemory  the list is full
  [[nodiscard]] Status add(StrutKind kind, const Place& from, const Place& to, std::uint32_t first, std::uint32_t end,
                           double radius_from, double radius_to, bool lies = false);
  [[nodiscard]] Status add_pillar(const Pillar& pillar);

  bool is_full() const { return spare() == 0; }
  std::size_t spare() const { return struts_.size() - strut_count_; }  ///< struts that there is room for
  std::uint32_t layer_at(double z) const;                              ///< the layer in which height z, mm, lies

  std::span<Strut> struts() const { return struts_.first(strut_count_); }
  std::span<Pillar> pillars() const { return pillars_.first(pillar_count_); }
  const PrintGrid& grid() const { return grid_; }

 private:
  PrintGrid grid_;
  std::span<Strut> struts_;
  std::span<Pillar> pillars_;
  std::size_t strut_count_ = 0, pillar_count_ = 0;
};

}  // namespace plumbline::inline slicer
