#include "slicer/core/regions/region_contacts.hpp"

#include <algorithm>

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "checks";
constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Most runs continue a region, so contacts are few beside runs; on a small panel there is room for one a run.
constexpr std::size_t kRunsPerContact = 8;
constexpr std::size_t kAlwaysRoom = 8192;

}  // namespace

std::size_t RegionContacts::room(std::size_t most_runs) {
  return std::max(most_runs / kRunsPerContact, std::min(most_runs, kAlwaysRoom));
}

Expected<RegionContacts> RegionContacts::create(std::size_t most_runs, Arena& arena) {
  RegionContacts contacts;
  const auto list = arena.take_top<RegionContact>(room(most_runs), kStage);
  PLUMBLINE_TRY(list);
  contacts.list_ = *list;
  const auto newest = arena.take_top<std::uint32_t>(most_runs, kStage);
  PLUMBLINE_TRY(newest);
  contacts.newest_ = *newest;
  return contacts;
}

std::size_t RegionContacts::bytes_needed(std::size_t most_runs) {
  return Arena::rounded(room(most_runs) * sizeof(RegionContact)) + Arena::rounded(most_runs * sizeof(std::uint32_t));
}

bool RegionContacts::find(const LayerRegions& below, const LayerRegions& above) {
  count_ = 0;
  std::fill_n(newest_.begin(), below.run_count(), kNone);
  bool room = true;
  const auto add = [&](const RegionContact& contact) {
    std::uint32_t& newest = newest_[contact.below];
    if (newest != kNone && list_[newest].above == contact.above) {
      list_[newest].pixels += contact.pixels;
    } else if (count_ < list_.size()) {
      newest = static_cast<std::uint32_t>(count_);
      list_[count_++] = contact;
    } else {
      room = false;
    }
  };
  const std::uint32_t first_enclosed = std::min(below.first_enclosed_row(), above.first_enclosed_row());
  for (std::uint32_t r = 0; r < below.rows() && room; ++r) {
    for_each_contact_in_row(below, above, r, true, add);
    if (r < first_enclosed) continue;
    for_each_contact_in_row(below, above, r, false, [&](const RegionContact& contact) {
      // Pixels of the outside, in both layers.
      if (contact.below == LayerRegions::kOutside && contact.above == LayerRegions::kOutside) return;
      add(contact);
    });
  }
  return room;
}

}  // namespace plumbline::inline slicer
