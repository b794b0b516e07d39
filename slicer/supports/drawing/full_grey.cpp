#include "slicer/supports/drawing/full_grey.hpp"

#include <algorithm>
#include <bit>

#include "slicer/rrep/mask_extent.hpp"
#include "slicer/supports/drawing/vertical_grey.hpp"

namespace plumbline::inline slicer {
namespace {

/// Pixels of a word that have both white and black ones in the 3 x 3 around them.
std::uint64_t edges_of(ConstBitImage mask, std::uint32_t row, std::uint32_t word) {
  std::uint64_t any = 0, all = ~std::uint64_t{0};
  for (std::uint32_t r = row == 0 ? 0 : row - 1; r <= row + 1; ++r) {
    if (r >= mask.rows()) {
      all = 0;
      continue;
    }
    const auto words = mask.row(r);
    const std::uint64_t here = words[word];
    const std::uint64_t left = here << 1U | (word > 0 ? words[word - 1] >> 63U : 0);
    const std::uint64_t right = here >> 1U | (word + 1 < words.size() ? words[word + 1] << 63U : 0);
    any |= left | here | right;
    all &= left & here & right;
  }
  if (row == 0) all = 0;
  return any & ~all;
}

}  // namespace

/// What is known of a layer while it is looked through.
struct FullGrey::Layer {
  bool is_grey = false;
  bool is_last = false;
  std::array<ConstBitImage, kRaysPerPixel> masks;
  std::array<std::optional<ChangingRays>, kRaysPerPixel> rays;  ///< not in bottom layers
  std::uint32_t next = ChangingRays::kNone;                     ///< the least pixel of these
  BitImage image;
  GreyRuns* greys = nullptr;
};

FullGrey::FullGrey(const RRep& rrep, const CureModel& model, double layer_height_mm, const SupportCover& supports)
    : rrep_(&rrep),
      first_(model.bottom_layers + model.faded_layers),
      levels_(model, layer_height_mm),
      supports_(supports) {
  MaskExtent all = extent_of(rrep);
  for (const RRep& other : rrep.other_rays()) {
    const MaskExtent extent = extent_of(other);
    all = {std::min(all.left, extent.left), std::max(all.right, extent.right), std::min(all.top, extent.top),
           std::max(all.bottom, extent.bottom)};
  }
  top_ = all.top;
  bottom_ = all.bottom;
  left_ = all.left / 64;
  right_ = (all.right + 63) / 64;
}

Expected<FullGrey> FullGrey::create(const RRep& rrep, const Supports& supports, const CureModel& model,
                                    double layer_height_mm, Arena& arena) {
  const auto cover = SupportCover::create(rrep.grid, supports, arena);
  PLUMBLINE_TRY(cover);
  FullGrey grey(rrep, model, layer_height_mm, *cover);
  for (std::size_t i = 0; i < grey.others_.size(); ++i) {
    const auto stream = LayerStream::create(rrep.others[i], arena);
    PLUMBLINE_TRY(stream);
    grey.others_[i] = *stream;
  }
  return grey;
}

/// @param mixed  pixels that not all rays' masks agree on
void FullGrey::find_in_word(Layer& layer, std::uint32_t row, std::uint32_t word, std::uint64_t mixed) {
  const std::uint32_t columns = rrep_->grid.columns;
  const std::uint32_t begin = row * columns + word * 64, end = begin + std::min(64U, columns - word * 64);
  std::array<std::array<std::uint8_t, 64>, kRaysPerPixel> levels;
  std::array<std::uint64_t, kRaysPerPixel> between = {}, ends = {};
  std::uint64_t touched = mixed, entered = 0;
  layer.next = ChangingRays::kNone;
  for (std::size_t i = 0; layer.is_grey && i < kRaysPerPixel; ++i) {
    ChangingRays& rays = *layer.rays[i];
    for (; rays.pixel() < end; rays.next()) {
      const std::uint32_t bit = rays.pixel() - begin;
      if (rays.ends()) {
        ends[i] |= std::uint64_t{1} << bit;
        continue;
      }
      if (i == 0) entered |= std::uint64_t{1} << bit;
      // Opening, closing and supports have changed the pixel, or its level is that of its bit.
      if (layer.masks[i].at(word * 64 + bit, row) != rays.is_lit() || !plumbline::is_grey(rays.level())) continue;
      between[i] |= std::uint64_t{1} << bit;
      levels[i][bit] = rays.level();
    }
    touched |= between[i];
    layer.next = std::min(layer.next, rays.pixel());
  }
  touched &= entered | edges_of(layer.masks[0], row, word);
  touched &= ~supports_.word(row, word);
  std::uint64_t white = 0, black = 0;
  for (; touched != 0; touched &= touched - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(touched));
    const std::uint32_t column = word * 64 + bit;
    std::uint32_t sum = 0, lit = 0, ending = 0;
    for (std::size_t i = 0; i < kRaysPerPixel; ++i) {
      const bool is_lit = layer.masks[i].at(column, row);
      lit += is_lit ? 1 : 0;
      ending += is_lit && (ends[i] >> bit & 1U) != 0 ? 1 : 0;
      const bool is_between = (between[i] >> bit & 1U) != 0;
      sum += is_between ? levels[i][bit] : is_lit ? kFullLevel : 0U;
    }
    std::uint32_t level = (sum + kRaysPerPixel / 2) / kRaysPerPixel;
    const bool is_top = 2 * ending > lit || (layer.is_last && lit > 0);
    if (!layer.is_grey || (is_top && lit < kRaysPerPixel))
      level = 2 * sum >= kRaysPerPixel * kFullLevel ? kFullLevel : 0U;
    const bool is_lit = layer.masks[0].at(column, row);
    if (!is_lit && level > levels_.most_alone && !has_white_beside(layer.masks[0], column, row)) {
      level = levels_.most_alone;
    }
    (level >= kLeastCuringLevel ? white : black) |= std::uint64_t{1} << bit;
    if (plumbline::is_grey(level)) layer.greys->add(begin + bit, static_cast<std::uint8_t>(level));
  }
  std::uint64_t& bits = layer.image.row(row)[word];
  bits = (bits & ~black) | white;
}

void FullGrey::find(std::uint32_t layer, ConstBitImage section, ConstBitImage mask, BitImage image, GreyRuns& greys) {
  greys.clear();
  Layer all;
  all.is_grey = layer >= first_;
  all.is_last = layer + 1 == rrep_->grid.layers;
  all.image = image;
  all.greys = &greys;
  all.masks[0] = mask;
  for (std::size_t i = 0; i < others_.size(); ++i) all.masks[i + 1] = others_[i]->mask(layer);
  for (std::size_t i = 0; all.is_grey && i < kRaysPerPixel; ++i) {
    all.rays[i].emplace(i == 0 ? *rrep_ : rrep_->others[i - 1], layer, i == 0 ? section : others_[i - 1]->section(),
                        levels_);
    all.rays[i]->next();
    all.next = std::min(all.next, all.rays[i]->pixel());
  }
  supports_.draw(layer);
  for (std::uint32_t row = top_; row < bottom_; ++row) {
    const auto a = all.masks[0].row(row), b = all.masks[1].row(row), c = all.masks[2].row(row),
               d = all.masks[3].row(row);
    const std::uint32_t row_begin = row * rrep_->grid.columns;
    for (std::uint32_t word = left_; word < right_; ++word) {
      const std::uint64_t mixed = (a[word] | b[word] | c[word] | d[word]) & ~(a[word] & b[word] & c[word] & d[word]);
      if (mixed == 0 && all.next >= row_begin + word * 64 + 64) continue;
      find_in_word(all, row, word, mixed);
    }
  }
  supports_.clear();
}

}  // namespace plumbline::inline slicer
