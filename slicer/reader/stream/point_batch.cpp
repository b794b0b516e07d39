#include "slicer/reader/stream/point_batch.hpp"

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

std::size_t slot_of(std::string_view name) {
  static constexpr std::string_view kNames[][kSlots] = {
      {"x", "y", "z", "nx", "ny", "nz"},
      {"x", "y", "z", "normal_x", "normal_y", "normal_z"},
      {"x", "y", "z", "normalx", "normaly", "normalz"},
  };
  for (const auto& names : kNames) {
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      if (same_word(name, names[slot])) return slot;
    }
  }
  return kSlots;
}

std::size_t splat_slot_of(std::string_view name) {
  static constexpr std::string_view kNames[] = {"opacity", "scale_0", "scale_1", "scale_2",
                                                "rot_0",   "rot_1",   "rot_2",   "rot_3"};
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if (name == kNames[i]) return kSlots + i;
  }
  return kRowSlots;
}

Status PointBatch::flush() {
  if (count_ == 0) return {};
  const auto ready = room_.first(count_);
  count_ = 0;
  summary_.points += ready.size();
  return sink_.take(ready);
}

}  // namespace plumbline::inline slicer
