#include "slicer/checks/region_tracker.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "checks";

/// The layer height is a float, so heights may be off by this share.
constexpr double kRounding = 1e-6;

/// Columns of solid that nothing holds, or of enclosed air, that a layer may have.
constexpr std::uint32_t kMostColumns = 4096;

/// Lattices have a wall every millimetre or so; wide panels have more of them in a row.
LayerRegions::Settings region_settings(const PrintGrid& grid) {
  return {.runs_per_row = std::max(64U, grid.columns / 32), .join_white_corners = false, .stage = kStage};
}

/// Calls visit(run, region) for each white run of `parts` and the region of `whole` that it is part of.
template <class Visit>
void for_each_run_within(const LayerRegions& parts, const LayerRegions& whole, Visit visit) {
  for (std::uint32_t r = 0; r < parts.rows(); ++r) {
    std::uint32_t j = whole.row_begin(r) + 1;
    for (std::uint32_t i = parts.row_begin(r) + 1; i < parts.row_begin(r + 1); i += 2) {
      while (whole.run(j).last < parts.run(i).first) j += 2;
      visit(i, whole.region(j));
    }
  }
}

}  // namespace

Expected<RegionTracker> RegionTracker::create(const PrintGrid& grid, const CheckLimits& limits, Arena& arena) {
  const auto islands = IslandRule::create(grid, limits, arena);
  PLUMBLINE_TRY(islands);
  RegionTracker tracker(grid, limits, *islands);
  const auto settings = region_settings(grid);
  const std::size_t runs = LayerRegions::most_runs(grid.rows, settings);
  for (Layer& layer : tracker.layers_) {
    auto regions = LayerRegions::create(grid.columns, grid.rows, arena, settings);
    PLUMBLINE_TRY(regions);
    layer.regions = *regions;
    const auto column = arena.take_top<std::uint32_t>(runs, kStage);
    PLUMBLINE_TRY(column);
    layer.column = *column;
    layer.column[LayerRegions::kOutside] = 0;
  }
  for (auto* list : {&tracker.roots_, &tracker.shared_, &tracker.widest_}) {
    const auto taken = arena.take_top<std::uint32_t>(runs, kStage);
    PLUMBLINE_TRY(taken);
    *list = *taken;
  }
  auto touches = RegionContacts::create(runs, arena);
  PLUMBLINE_TRY(touches);
  tracker.touches_ = *touches;
  const auto contacts = arena.take_top<Contact>(RegionContacts::room(runs), kStage);
  PLUMBLINE_TRY(contacts);
  tracker.contacts_ = *contacts;
  for (RegionColumns* columns : {&tracker.solid_, &tracker.air_}) {
    auto created = RegionColumns::create(kMostColumns, arena);
    PLUMBLINE_TRY(created);
    *columns = *created;
  }
  auto film = Film::create(grid, arena);
  PLUMBLINE_TRY(film);
  tracker.film_ = *film;
  auto tears = TearFinder::create(grid, limits.peel, runs, arena);
  PLUMBLINE_TRY(tears);
  tracker.tears_ = *tears;
  return tracker;
}

std::size_t RegionTracker::bytes_needed(const PrintGrid& grid) {
  const auto settings = region_settings(grid);
  const std::size_t runs = LayerRegions::most_runs(grid.rows, settings);
  return 3 * LayerRegions::bytes_needed(grid.rows, settings) + 6 * Arena::rounded(runs * sizeof(std::uint32_t)) +
         RegionContacts::bytes_needed(runs) + Arena::rounded(RegionContacts::room(runs) * sizeof(Contact)) +
         2 * RegionColumns::bytes_needed(kMostColumns) + Film::bytes_needed(grid) +
         TearFinder::bytes_needed(grid, runs) + IslandRule::bytes_needed(grid);
}

void RegionTracker::next(ConstBitImage mask, ConstBitImage eroded, BitImage scratch, StackFindings& findings) {
  now_ = another(below_, stayed_below_);
  below_is_known_ = track(mask, eroded, scratch, findings);
  if (!below_is_known_) {
    ++findings.unchecked_layers;
    if (!film_.clean()) film_.keep(mask);
    solid_.clear();
    air_.clear();
  }
  below_ = now_;
  stayed_below_ = stayed_now_;
  ++layer_;
}

bool RegionTracker::track(ConstBitImage mask, ConstBitImage eroded, BitImage scratch, StackFindings& findings) {
  if (!now().regions.label(mask)) return false;
  root_count_ = 0;
  for_each_region(now().regions, widest_, [&](std::uint32_t region, bool white) {
    roots_[root_count_++] = white ? region | kWhite : region;
    // All regions of the first layer are held, by the plate. So are those above a layer that was not looked at.
    now().column[region] = below_is_known_ || (layer_ == 0 && !white) ? kNone : 0;
    shared_[region] = 0;
  });
  solid_.begin_layer();
  air_.begin_layer();
  if (below_is_known_ && !find_contacts()) return false;
  if (below_is_known_) find_islands(eroded, scratch, findings);
  bool any_falls = false;
  const bool shaded = !film_.clean();
  if (shaded && !find_what_stays(mask, scratch, any_falls, findings)) return false;
  if (below_is_known_) join_solid();
  if (!start_columns()) return false;
  if (!shaded) {
    const auto falls = [&](std::uint32_t region) { return now().column[region] != 0; };
    any_falls = std::any_of(roots_.begin(), roots_.begin() + root_count_,
                            [&](std::uint32_t root) { return (root & kWhite) != 0 && falls(root & ~kWhite); });
    if (any_falls) film_.lay_down(now().regions, falls);
  }
  if (below_is_known_) join_air(findings);
  count_regions();
  stayed_now_ = film_.clean() ? now_ : another(now_, stayed_below_);
  LayerRegions& stayed = layers_[stayed_now_].regions;
  if (any_falls && !stayed.label(film_.stayed())) return false;
  // While the film is clean, the regions that stayed are those of the masks.
  const bool all_stayed = stayed_now_ == now_ && stayed_below_ == below_;
  if (below_is_known_ && !all_stayed && !touches_.find(layers_[stayed_below_].regions, stayed)) return false;
  if (!find_tears(stayed, shaded)) return false;
  end_layer(findings);
  return true;
}

/// Lists what regions touch of the layer below, except for solid that is held and air that is open there.
/// @returns false if there is no room for the list
bool RegionTracker::find_contacts() {
  Layer& above = now();
  std::size_t front = 0;
  std::size_t back = contacts_.size();
  if (!touches_.find(below().regions, above.regions)) return false;
  for (const RegionContact& touch : touches_.list()) {
    const std::uint32_t column = below().column[touch.below];
    if (touch.white) {
      shared_[touch.above] += touch.pixels;
      if (column == 0) {
        above.column[touch.above] = 0;
      } else {
        contacts_[front++] = {touch.above, column, touch.pixels};
      }
    } else if (column != 0 || touch.above != LayerRegions::kOutside) {
      contacts_[--back] = {touch.above, column, touch.pixels};
    }
  }
  solid_contacts_ = front;
  air_contacts_ = back;
  return true;
}

/// Makes a column for each region that is not held or not the outside.
bool RegionTracker::start_columns() {
  for (std::uint32_t i = 0; i < root_count_; ++i) {
    const std::uint32_t region = roots_[i] & ~kWhite;
    std::uint32_t& column = now().column[region];
    if (column != kNone) continue;
    const bool drains = now().regions.area(region) >= limits_.drain_pixels;
    column = ((roots_[i] & kWhite) != 0 ? solid_ : air_).start(drains, layer_ == 0);
    if (column == kNone) return false;
  }
  return true;
}

void RegionTracker::find_islands(ConstBitImage eroded, BitImage scratch, StackFindings& findings) {
  IslandRule::Layers layers{now().regions, below().regions, eroded, scratch};
  for (std::uint32_t i = 0; i < root_count_; ++i) {
    const std::uint32_t region = roots_[i] & ~kWhite;
    if ((roots_[i] & kWhite) == 0 || !islands_.is_island(region, shared_[region], layers)) continue;
    findings.of(IssueKind::kIsland).add(issue_at(IssueKind::kIsland, layer_, now().regions, widest_[region]));
  }
}

/// Where something lies on the film: of each region, the pixels that get light and hang from what stayed below, itself or through others.
/// A region without any falls. Overwrites the regions of the layer below, which are not needed any more.
/// @returns false if the layer has too many regions
bool RegionTracker::find_what_stays(ConstBitImage mask, BitImage lit, bool& any_falls, StackFindings& findings) {
  film_.shade(mask, lit);
  auto& [pieces, held] = layers_[another(now_, stayed_below_)];
  if (!pieces.label(lit)) return false;
  std::fill_n(held.begin(), pieces.run_count(), below_is_known_ ? 0 : 1);
  pieces.for_each_white_run([&, &pieces = pieces, &held = held](std::uint32_t row, std::uint32_t i) {
    std::uint32_t& is_held = held[pieces.region(i)];
    if (is_held == 0 && film_.touches_part(row, pieces.run(i))) is_held = 1;
  });
  const LayerRegions& regions = now().regions;
  for (std::uint32_t i = 0; i < root_count_; ++i) shared_[roots_[i] & ~kWhite] = 0;
  for_each_run_within(pieces, regions, [&, &pieces = pieces, &held = held](std::uint32_t i, std::uint32_t home) {
    if (held[pieces.region(i)] != 0) shared_[home] += pieces.run(i).last + 1U - pieces.run(i).first;
  });
  for (std::uint32_t i = 0; i < root_count_; ++i) {
    if ((roots_[i] & kWhite) == 0) continue;
    const std::uint32_t region = roots_[i] & ~kWhite;
    now().column[region] = shared_[region] > 0 ? 0 : kNone;
    if (shared_[region] > 0) findings.shadowed_voxels += regions.area(region) - shared_[region];
  }
  film_.lay_down(pieces, [&, &held = held](std::uint32_t piece) {
    any_falls = any_falls || held[piece] == 0;
    return held[piece] == 0;
  });
  return true;
}

/// What touches only pieces that are lost is lost with them. Pieces that fall become one where they meet; what meets one that tore off
/// belongs to the older of the two.
void RegionTracker::join_solid() {
  for (const Contact& contact : contacts_.first(solid_contacts_)) {
    std::uint32_t& above = now().column[contact.above];
    if (above == 0) continue;
    const std::uint32_t below = solid_.root(contact.below);
    above = above == kNone ? below : solid_.root(above);
    if (above == below) continue;
    if (solid_.column(above).torn || solid_.column(below).torn) {
      above = std::min(above, below);
    } else {
      solid_.unite(above, below);
    }
  }
}

/// Takes off what the peel tears off: it lies on the film, too.
/// @param shaded  shared_ has the pixels of each region that stayed; else all of them did, or none
/// @returns false if there is no room
bool RegionTracker::find_tears(const LayerRegions& stayed, bool shaded) {
  bool any_tear = false;
  bool room = true;
  const LayerRegions& regions = now().regions;
  const auto is_lost = [&](std::uint32_t root) {
    return (root & kWhite) != 0 && now().column[root & ~kWhite] == 0 && shared_[root & ~kWhite] == 0;
  };
  tears_.next(layer_, stayed, below_is_known_ ? &touches_ : nullptr,
              [&](const HoldNetwork::Tear& tear, std::uint64_t pixels) {
                if (!std::exchange(any_tear, true) && !shaded) {
                  for (std::uint32_t i = 0; i < root_count_; ++i) {
                    shared_[roots_[i] & ~kWhite] = regions.area(roots_[i] & ~kWhite);
                  }
                }
                const std::uint32_t node = room ? solid_.start(false, false) : kNone;
                room = node != kNone;
                if (!room) return;
                RegionColumn& column = solid_.column(node);
                column.torn = true;
                column.first_layer = column.largest_layer = tear.place.layer;
                column.last_layer = layer_;
                column.voxels = tear.voxels;
                column.largest = static_cast<std::uint32_t>(pixels);
                column.column = tear.place.column;
                column.row = tear.place.row;
                column.asked_n = static_cast<float>(tear.asked_n);
                column.held_n = static_cast<float>(tear.held_n);
                // A region of the mask is lost with the last of its pixels that stayed.
                for_each_run_within(stayed, regions, [&](std::uint32_t i, std::uint32_t home) {
                  if (tears_.in_piece(stayed.region(i))) shared_[home] -= stayed.run(i).last + 1U - stayed.run(i).first;
                });
                for (std::uint32_t i = 0; i < root_count_; ++i) {
                  if (!is_lost(roots_[i])) continue;
                  now().column[roots_[i] & ~kWhite] = node;
                  column.alive = true;
                }
              });
  if (any_tear) film_.lay_down(stayed, [&](std::uint32_t region) { return tears_.torn(region); });
  return room;
}

void RegionTracker::join_air(StackFindings& findings) {
  const auto list = contacts_.subspan(air_contacts_);
  for (Contact& contact : list) contact.above = now().column[contact.above];
  std::sort(list.begin(), list.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.above, a.below, a.pixels) < std::tie(b.above, b.below, b.pixels);
  });
  std::size_t pairs = 0;
  for (const Contact& contact : list) {
    if (pairs > 0 && list[pairs - 1].above == contact.above && list[pairs - 1].below == contact.below) {
      list[pairs - 1].pixels += contact.pixels;
    } else {
      list[pairs++] = contact;
    }
  }
  for (const Contact& contact : list.first(pairs)) {
    if (contact.pixels >= limits_.drain_pixels) air_.unite(contact.above, contact.below);
  }
  // An opening below the limit drains nothing, but the narrow end of a hollow belongs to it.
  for (const Contact& contact : list.first(pairs)) {
    if (contact.pixels >= limits_.drain_pixels) continue;
    if (air_.column(contact.above).drains && air_.column(contact.below).drains) continue;
    air_.unite(contact.above, contact.below);
  }
  for (std::uint32_t i = 1; i < air_.below_count(); ++i) {
    if (air_.is_first(i)) add_cup(air_.below(i), findings);
  }
}

/// Adds the layer's regions to their columns.
void RegionTracker::count_regions() {
  const LayerRegions& regions = now().regions;
  for (std::uint32_t i = 0; i < root_count_; ++i) {
    const std::uint32_t region = roots_[i] & ~kWhite;
    RegionColumns& columns = (roots_[i] & kWhite) != 0 ? solid_ : air_;
    const std::uint32_t node = now().column[region];
    if (columns.is_first(node)) continue;
    const Issue place = issue_at(IssueKind::kFreePiece, layer_, regions, widest_[region]);
    RegionColumn part;
    part.first_layer = part.last_layer = part.largest_layer = layer_;
    part.voxels = part.largest = regions.area(region);
    part.column = place.column;
    part.row = place.row;
    if (part.largest >= limits_.suction_pixels) part.broad_first = part.broad_last = layer_;
    part.alive = true;
    columns.column(node).add(part);
  }
}

void RegionTracker::end_layer(StackFindings& findings) {
  solid_.end_layer([&](const RegionColumn& column) {
    add_column(column.torn ? IssueKind::kTear : IssueKind::kFreePiece, column, findings);
  });
  air_.end_layer([&](const RegionColumn& column) {
    // The plate closes what is open below, until the part is taken off it.
    if (column.on_plate) {
      const bool is_cup = add_cup(column, findings);
      if (!is_cup && column.largest >= limits_.trap_pixels) add_column(IssueKind::kPlateTrap, column, findings);
    } else if (column.largest >= limits_.trap_pixels &&
               scale_.z_mm(column.last_layer - column.first_layer + 1) > limits_.cured_gap_mm) {
      add_column(IssueKind::kResinTrap, column, findings);
    }
  });
  for (std::uint32_t i = 0; i < root_count_; ++i) {
    const std::uint32_t region = roots_[i] & ~kWhite;
    const RegionColumns& columns = (roots_[i] & kWhite) != 0 ? solid_ : air_;
    now().column[region] = columns.next_number(now().column[region]);
  }
}

void RegionTracker::add_column(IssueKind kind, const RegionColumn& column, StackFindings& findings) {
  findings.of(kind).add({kind, column.largest_layer, column.first_layer, column.last_layer, column.column, column.row,
                         column.largest, column.voxels, column.asked_n, column.held_n});
}

bool RegionTracker::add_cup(const RegionColumn& column, StackFindings& findings) {
  if (column.largest < limits_.suction_pixels) return false;
  if (column.on_plate && scale_.mm2(column.largest) < limits_.plate_suction_mm2) return false;
  const std::uint32_t layers = column.broad_last - column.broad_first + 1;
  if (scale_.z_mm(layers) < limits_.suction_height_mm * (1 - kRounding)) return false;
  add_column(IssueKind::kSuctionCup, column, findings);
  return true;
}

void RegionTracker::finish(StackFindings& findings) {
  // What is enclosed in the last layer is open above it.
  solid_.begin_layer();
  air_.begin_layer();
  solid_.end_layer([&](const RegionColumn& column) {
    add_column(column.torn ? IssueKind::kTear : IssueKind::kFreePiece, column, findings);
  });
  air_.end_layer([&](const RegionColumn& column) { add_cup(column, findings); });
}

}  // namespace plumbline::inline slicer
