#include "slicer/checks/tear_finder.hpp"

#include <algorithm>
#include <utility>

#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/disjoint_sets.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "checks";

/// Regions of a layer, white or enclosed, that there is room for: 1800 on a 2K panel.
std::uint32_t most_regions(const PrintGrid& grid) {
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::uint64_t{grid.columns} * grid.rows / 2048, 128, 8192));
}

}  // namespace

Expected<TearFinder> TearFinder::create(const PrintGrid& grid, const PeelSettings& peel, std::size_t most_runs,
                                        Arena& arena) {
  TearFinder finder;
  const std::uint32_t most = most_regions(grid);
  const IssueScale scale(grid);
  finder.peel_ = peel;
  finder.pitch_x_mm_ = scale.pitch_x_mm;
  finder.pitch_y_mm_ = scale.pitch_y_mm;
  finder.pixel_mm2_ = scale.pixel_mm2;
  const auto take = [&arena]<class T>(std::span<T>& to, std::size_t count) -> Status {
    const auto taken = arena.take_top<T>(count, kStage);
    PLUMBLINE_TRY(taken);
    to = *taken;
    return {};
  };
  for (auto& number : finder.number_) PLUMBLINE_TRY(take(number, most_runs));
  PLUMBLINE_TRY(take(finder.held_, most));
  PLUMBLINE_TRY(take(finder.is_torn_, most));
  PLUMBLINE_TRY(take(finder.newtons_, most));
  PLUMBLINE_TRY(take(finder.below_pixels_, most));
  PLUMBLINE_TRY(take(finder.contacts_, std::size_t{2} * most));
  PLUMBLINE_TRY(take(finder.links_, std::size_t{2} * most));
  for (auto* hollows : {&finder.hollows_, &finder.next_hollows_}) {
    PLUMBLINE_TRY(take(*hollows, std::size_t{2} * most));
    (*hollows)[0] = {};
  }
  auto network = HoldNetwork::create(most, arena);
  PLUMBLINE_TRY(network);
  finder.network_ = *network;
  return finder;
}

std::size_t TearFinder::bytes_needed(const PrintGrid& grid, std::size_t most_runs) {
  const std::size_t most = most_regions(grid);
  return 2 * Arena::rounded(most_runs * sizeof(std::uint16_t)) + Arena::rounded(most * sizeof(Held)) +
         Arena::rounded(most * sizeof(bool)) + Arena::rounded(most * sizeof(double)) +
         Arena::rounded(most * sizeof(std::uint32_t)) + Arena::rounded(2 * most * sizeof(Contact)) +
         Arena::rounded(2 * most * sizeof(HoldNetwork::Link)) + 2 * Arena::rounded(2 * most * sizeof(Hollow)) +
         HoldNetwork::bytes_needed(most_regions(grid));
}

void TearFinder::next(std::uint32_t layer, const LayerRegions& stayed, const RegionContacts* touches, OnTear on_tear) {
  layer_ = layer;
  hangs_ = hangs_ && touches != nullptr;
  hangs_ = take(stayed, hangs_ ? touches : nullptr);
  if (!hangs_) return;
  const auto& number = number_[layer_ % 2];
  network_.pull(newtons_.first(held_count_), [&](const HoldNetwork::Tear& tear, std::span<const std::uint32_t> ends) {
    std::uint64_t pixels = 0;
    std::fill_n(is_torn_.begin(), held_count_, false);
    for (const std::uint32_t end : ends) {
      pixels += stayed.area(held_[end].shape.region);
      is_torn_[end] = true;
    }
    on_tear(tear, pixels);
  });
  for (std::uint32_t end = 0; end < held_count_; ++end) {
    if (network_.torn(end)) number[held_[end].shape.region] = kTorn;
  }
}

/// @returns whether there is room for the layer
bool TearFinder::take(const LayerRegions& stayed, const RegionContacts* touches) {
  if (touches == nullptr) {
    network_.clear();
    old_hollows_ = 1;
  }
  held_count_ = contact_count_ = 0;
  if (!number_regions(stayed)) return false;
  if (touches != nullptr && !find_contacts(*touches)) return false;
  carry_suction(stayed);
  // Above a layer of which nothing is known everything is held.
  return hang_up(stayed, layer_ == 0 ? peel_.plate_n(1) : HoldNetwork::kUnbreakable);
}

bool TearFinder::number_regions(const LayerRegions& stayed) {
  const auto& number = number_[layer_ % 2];
  number[LayerRegions::kOutside] = 0;
  hollow_count_ = old_hollows_;
  const auto begin = [&](std::uint32_t region, bool white) {
    if (white) {
      if (held_count_ == held_.size()) return false;
      held_[held_count_] = {.shape = {.region = region}};
      number[region] = static_cast<std::uint16_t>(held_count_++);
      return true;
    }
    if (hollow_count_ == hollows_.size()) return false;
    const std::uint64_t pixels = stayed.area(region);
    hollows_[hollow_count_] = {
        .parent = hollow_count_, .region = region, .plate_pixels = layer_ == 0 ? pixels : 0, .mouth_pixels = pixels};
    // Above a layer of which nothing is known all air is open.
    if (layer_ > 0 && !hangs_) hollows_[hollow_count_].parent = 0;
    number[region] = static_cast<std::uint16_t>(hollow_count_++);
    return true;
  };
  return measure_regions(
      stayed, begin, [&](std::uint32_t region) -> auto& { return held_[number[region]].shape; });
}

bool TearFinder::find_contacts(const RegionContacts& touches) {
  const auto& number = number_[layer_ % 2];
  const auto& number_below = number_[(layer_ + 1) % 2];
  std::fill_n(below_pixels_.begin(), network_.ends(), 0);
  DisjointSets<Hollow, &Hollow::parent> hollows(hollows_);
  for (const RegionContact& touch : touches.list()) {
    const std::uint32_t under = number_below[touch.below];
    const std::uint32_t over = number[touch.above];
    if (!touch.white) {
      hollows.unite(under, over);
      continue;
    }
    if (under == kTorn) continue;
    below_pixels_[under] += touch.pixels;
    std::uint32_t& first = held_[over].first_contact;
    std::uint32_t at = first;
    while (at != kNone && contacts_[at].below != under) at = contacts_[at].next;
    if (at != kNone) {
      contacts_[at].pixels += touch.pixels;
    } else if (contact_count_ < contacts_.size()) {
      contacts_[contact_count_] = {under, touch.pixels, first};
      first = contact_count_++;
    } else {
      return false;
    }
  }
  return true;
}

/// Gives the suction of each closed hollow to the regions round its mouths, and its number to the next layer.
void TearFinder::carry_suction(const LayerRegions& stayed) {
  const auto& number = number_[layer_ % 2];
  const DisjointSets<Hollow, &Hollow::parent> hollows(hollows_);
  for (std::uint32_t i = 1; i < hollow_count_; ++i) {
    const std::uint32_t root = hollows.root(i);
    if (root == i || root == 0) continue;
    hollows_[root].plate_pixels += hollows_[i].plate_pixels;
    hollows_[root].mouth_pixels += hollows_[i].mouth_pixels;
  }
  std::uint32_t kept = 1;
  for (std::uint32_t i = old_hollows_; i < hollow_count_; ++i) {
    const std::uint32_t root = hollows.root(i);
    const std::uint32_t region = hollows_[i].region;
    number[region] = 0;
    if (root == 0) continue;
    Hollow& whole = hollows_[root];
    if (whole.renamed == 0) {
      whole.renamed = kept;
      next_hollows_[kept] = {.parent = kept, .plate_pixels = whole.plate_pixels};
      ++kept;
    }
    number[region] = static_cast<std::uint16_t>(whole.renamed);
    // The white run to the left of its first run belongs to the region around it.
    held_[number[stayed.region(region - 1)]].sealed_mm2 +=
        stayed.area(region) * pixel_mm2_ * PeelSettings::share_of_part(whole.plate_pixels, whole.mouth_pixels);
  }
  std::swap(hollows_, next_hollows_);
  old_hollows_ = kept;
}

/// @param plate_n_mm2  what holds of a region without a contact
bool TearFinder::hang_up(const LayerRegions& stayed, double plate_n_mm2) {
  network_.begin_layer();
  for (const Contact& contact : contacts_.first(contact_count_)) network_.announce_link(contact.below);
  for (std::uint32_t i = 0; i < held_count_; ++i) {
    const Held& held = held_[i];
    const std::uint32_t pixels = stayed.area(held.shape.region);
    std::uint32_t count = 0;
    for (std::uint32_t at = held.first_contact; at != kNone; at = contacts_[at].next) {
      const Contact& contact = contacts_[at];
      links_[count++] = {contact.below, peel_.joint_n(contact.pixels * pixel_mm2_),
                         static_cast<double>(contact.pixels) / below_pixels_[contact.below]};
    }
    const double mm2 = pixels * pixel_mm2_;
    if (!network_.add_end(links_.first(count), plate_n_mm2 * mm2, {layer_, held.shape.column, held.shape.row}, pixels))
      return false;
    newtons_[i] =
        peel_.force(mm2, PeelSettings::outline_mm(held.shape.sides_x * pitch_x_mm_, held.shape.sides_y * pitch_y_mm_),
                    held.sealed_mm2);
  }
  network_.end_layer();
  return true;
}

}  // namespace plumbline::inline slicer
