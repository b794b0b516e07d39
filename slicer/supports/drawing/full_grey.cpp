#include "slicer/supports/drawing/full_grey.hpp"

#include <algorithm>
#include <bit>
#include <span>

#include "slicer/rrep/mask_extent.hpp"
#include "slicer/supports/drawing/vertical_grey.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;  ///< no pixel

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

/// The crossings of one ray of each pixel in a layer and in the next one, of those that have not been looked at.
struct FullGrey::Ray {
  ConstBitImage section, mask;
  std::span<const std::uint32_t> own, above;

  std::uint32_t next(const CrossingPacking& packing) const {
    return std::min(own.empty() ? kNone : packing.pixel(own.front()),
                    above.empty() ? kNone : packing.pixel(above.front()));
  }
};

/// What is known of a layer while it is looked through.
struct FullGrey::Layer {
  bool is_last = false;
  std::array<Ray, 1 + kRaysAround> rays;
  std::uint32_t next = kNone;  ///< the least pixel that is crossed
  BitImage image;
  GreyRuns* greys = nullptr;
};

/// Pixels of a word, as one of their rays sees them.
struct FullGrey::Word {
  std::uint64_t mask = 0;
  std::uint64_t ends = 0;     ///< lit, and not in the next layer
  std::uint64_t entered = 0;  ///< enter in the layer, or so little above it that the next one would be too high
  std::uint64_t between = 0;  ///< of these, grey
  std::array<std::uint8_t, 64> level;
};

FullGrey::FullGrey(const RRep& rrep, const CureModel& model, double layer_height_mm, const SupportCover& supports)
    : rrep_(&rrep),
      packing_(rrep.grid),
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

/// Takes the crossings of a ray that are before pixel `end`.
FullGrey::Word FullGrey::take_word(Ray& ray, std::uint32_t row, std::uint32_t word, std::uint32_t begin,
                                   std::uint32_t end) const {
  Word found;
  found.mask = ray.mask.row(row)[word];
  if (ray.next(packing_) >= end) return found;
  std::array<std::uint8_t, 64> own_part, above_part;
  const auto take = [&](std::span<const std::uint32_t>& crossings, std::array<std::uint8_t, 64>& parts) {
    std::uint64_t bits = 0;
    std::size_t i = 0;
    for (; i < crossings.size() && packing_.pixel(crossings[i]) < end; ++i) {
      const std::uint32_t bit = packing_.pixel(crossings[i]) - begin;
      bits |= std::uint64_t{1} << bit;
      parts[bit] = static_cast<std::uint8_t>(packing_.height(crossings[i], 0).part());
    }
    crossings = crossings.subspan(i);
    return bits;
  };
  const std::uint64_t own = take(ray.own, own_part), above = take(ray.above, above_part);
  const std::uint64_t lit = ray.section.row(row)[word];
  // A lit ray that changes in the next layer leaves there; if it has entered in this one, it is in no other, and stays white. A lit ray that changes here has
  // entered, and so will one in the next layer that is not lit. Others have left here.
  found.ends = lit & above;
  found.entered = (lit & own & ~above) | (~lit & above & ~own);
  // Opening, closing and supports may have changed the pixel.
  for (std::uint64_t bits = found.entered & ~(lit ^ found.mask); bits != 0; bits &= bits - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(bits));
    const bool is_lit = (lit >> bit & 1U) != 0;
    const std::uint32_t part = is_lit ? own_part[bit] : above_part[bit];
    if (is_lit != (part >= CrossingHeight::kUnderside)) continue;
    found.level[bit] = levels_.by_part[part];
    found.between |= plumbline::is_grey(found.level[bit]) ? std::uint64_t{1} << bit : 0;
  }
  return found;
}

void FullGrey::find_in_word(Layer& layer, std::uint32_t row, std::uint32_t word) {
  const std::uint32_t columns = rrep_->grid.columns;
  const std::uint32_t begin = row * columns + word * 64, end = begin + std::min(64U, columns - word * 64);
  std::array<Word, 1 + kRaysAround> words;
  std::uint64_t any = 0, all = ~std::uint64_t{0}, touched = 0;
  layer.next = kNone;
  for (std::size_t i = 0; i < 1 + kRaysAround; ++i) {
    words[i] = take_word(layer.rays[i], row, word, begin, end);
    any |= words[i].mask;
    all &= words[i].mask;
    touched |= i > 0 ? words[i].between : 0;
    layer.next = std::min(layer.next, layer.rays[i].next(packing_));
  }
  touched |= any & ~all;
  touched &= ~supports_.word(row, word);
  if (touched == 0) return;
  touched &= words[0].entered | edges_of(layer.rays[0].mask, row, word);
  std::uint64_t white = 0, black = 0;
  for (; touched != 0; touched &= touched - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(touched));
    std::uint32_t sum = 0, lit = 0, ending = 0;
    for (const Word& ray : std::span(words).subspan(1)) {
      const auto is_lit = static_cast<std::uint32_t>(ray.mask >> bit & 1U);
      lit += is_lit;
      ending += is_lit & static_cast<std::uint32_t>(ray.ends >> bit & 1U);
      sum += (ray.between >> bit & 1U) != 0 ? ray.level[bit] : is_lit * kFullLevel;
    }
    std::uint32_t level = (sum + kRaysAround / 2) / kRaysAround;
    const bool is_top = 2 * ending > lit || (layer.is_last && lit > 0);
    const bool is_checked = (words[0].mask >> bit & 1U) != 0;
    if (is_top && lit < kRaysAround) level = is_checked ? kFullLevel : 0U;
    // What the checks have seen cures, and what cures in addition is beside it: so all hangs together as they have found.
    if (is_checked) {
      level = std::max(level, levels_.least);
    } else if (level > levels_.most_alone && !has_white_beside(layer.rays[0].mask, word * 64 + bit, row)) {
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
  if (layer < first_) return;
  Layer all;
  all.is_last = layer + 1 == rrep_->grid.layers;
  all.image = image;
  all.greys = &greys;
  for (std::size_t i = 0; i < 1 + kRaysAround; ++i) {
    Ray& ray = all.rays[i];
    ray.mask = i == 0 ? mask : others_[i - 1]->mask(layer);
    ray.section = i == 0 ? section : others_[i - 1]->section();
    const RRep& rrep = i == 0 ? *rrep_ : rrep_->others[i - 1];
    const auto bucket = [&](std::uint32_t k) {
      return k < rrep.grid.layers ? rrep.packed.subspan(rrep.first[k], rrep.first[k + 1] - rrep.first[k])
                                  : std::span<const std::uint32_t>();
    };
    ray.own = bucket(layer);
    ray.above = bucket(layer + 1);
    all.next = std::min(all.next, ray.next(packing_));
  }
  supports_.draw(layer);
  for (std::uint32_t row = top_; row < bottom_; ++row) {
    std::array<std::span<const std::uint64_t>, 1 + kRaysAround> rows;
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = all.rays[i].mask.row(row);
    const std::uint32_t row_begin = row * rrep_->grid.columns;
    for (std::uint32_t word = left_; word < right_; ++word) {
      std::uint64_t any = 0, every = ~std::uint64_t{0};
      for (const auto& words : rows) {
        any |= words[word];
        every &= words[word];
      }
      const std::uint64_t mixed = any & ~every;
      if (mixed == 0 && all.next >= row_begin + word * 64 + 64) continue;
      find_in_word(all, row, word);
    }
  }
  supports_.clear();
}

}  // namespace plumbline::inline slicer
