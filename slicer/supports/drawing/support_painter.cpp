#include "slicer/supports/drawing/support_painter.hpp"

#include <algorithm>
#include <bit>

#include "slicer/layers/morphology.hpp"

namespace plumbline {

Expected<SupportPainter> SupportPainter::create(const Supports& supports, Arena& arena) {
  auto active = arena.take_bottom<std::uint32_t>(supports.list.size(), "layer stream");
  PLUMBLINE_TRY(active);
  SupportPainter painter;
  painter.supports_ = &supports;
  painter.active_ = *active;
  return painter;
}

void SupportPainter::go_to(std::uint32_t layer) {
  const auto list = supports_->list;
  if (at_ + 1 != layer) {
    active_count_ = 0;
    next_ = 0;
  }
  const auto active = active_.first(active_count_);
  const auto ended =
      std::remove_if(active.begin(), active.end(), [&](std::uint32_t i) { return list[i].end <= layer; });
  active_count_ = static_cast<std::size_t>(ended - active.begin());
  for (; next_ < list.size() && list[next_].first <= layer; ++next_) {
    if (list[next_].is_in(layer)) active_[active_count_++] = static_cast<std::uint32_t>(next_);
  }
  at_ = layer;
}

std::uint64_t SupportPainter::draw(std::uint32_t layer, BitImage image, BitImage touched) {
  if (at_ != layer) go_to(layer);
  std::uint64_t drawn = 0;
  for (const std::uint32_t i : active_.first(active_count_)) {
    for_each_strut_span(supports_->pitch, supports_->list[i], layer, image.columns(), image.rows(),
                        [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                          const auto line = image.row(row);
                          for_each_word(begin, end, [&](std::uint32_t word, std::uint64_t bits) {
                            drawn += static_cast<std::uint64_t>(std::popcount(bits & ~line[word]));
                            line[word] |= bits;
                          });
                          for (std::uint32_t s = begin / kStripColumns; s * kStripColumns < end; ++s)
                            touched.set(row, s);
                        });
  }
  return drawn;
}

}  // namespace plumbline
