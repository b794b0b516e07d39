#include "slicer/dose/adaptive_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "slicer/core/bit_image.hpp"
#include "slicer/dose/floating_edges.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "adaptive layers";

/// mm2 of flat surface that count: less is noise, or too little to see.
constexpr double kLeastArea = 0.1;
/// Share of the surface between two heights that is flat from which on layers there are thin.
constexpr double kFlatShare = 0.25;

/// In a list of the greatest heights of layers: a layer begins here.
constexpr std::uint8_t kBegins = 0x80;

/// Squares of four pixels that are all set.
std::uint64_t squares(ConstBitImage image, std::uint32_t top, std::uint32_t bottom) {
  std::uint64_t sum = 0;
  for (std::uint32_t r = top; r + 1 < bottom; ++r) {
    const auto above = image.row(r), below = image.row(r + 1);
    for (std::uint32_t w = 0; w < image.stride(); ++w) {
      const std::uint64_t both = above[w] & below[w];
      if (both == 0) continue;
      const std::uint64_t next = w + 1 < image.stride() ? above[w + 1] & below[w + 1] : 0;
      sum += count_ones(both & (both >> 1 | next << 63));
    }
  }
  return sum;
}

/// Sides of white pixels that border on black ones.
std::uint64_t outline(ConstBitImage image) {
  std::uint64_t sum = 0;
  for (std::uint32_t r = 0; r + 1 < image.rows(); ++r) {
    const auto row = image.row(r), below = image.row(r + 1);
    for (std::uint32_t w = 0; w < image.stride(); ++w) {
      const std::uint64_t next = w + 1 < image.stride() ? row[w + 1] : 0;
      sum += count_ones(row[w] ^ below[w]) + count_ones(row[w] ^ (row[w] >> 1 | next << 63));
    }
  }
  return sum;
}

/// Finds where an R-Rep has surface that is too flat for layers of a height.
class FlatSurfaces {
 public:
  /// @param section, band  images of the grid
  FlatSurfaces(const RRep& rrep, BitImage section, BitImage band)
      : rrep_(rrep), section_(section), band_(band), packing_(rrep.grid) {
    band_.clear();
  }

  /// Calls flat(first, end) for stretches of at most `height` layers with such surface.
  /// @param enters  look at undersides, not at tops
  /// @param share   of the surface there that is flat, at least
  template <class Flat>
  void find(std::uint32_t height, bool enters, double share, Flat flat) {
    enters_ = enters;
    section_.clear();
    for (std::uint32_t k = 0; k < rrep_.grid.layers; k += height) {
      const std::uint32_t end = std::min(k + height, rrep_.grid.layers);
      top_ = UINT32_MAX;
      bottom_ = 0;
      for (std::uint32_t i = rrep_.first[k]; i < rrep_.first[end]; ++i) cross(packing_.pixel(rrep_.packed[i]));
      if (bottom_ == 0) continue;
      const double area = pixel_mm2_ * static_cast<double>(squares(band_, top_, bottom_));
      if (area >= kLeastArea && (share <= 0 || area >= share * (area + wall_mm2(end - k)))) flat(k, end);
      for (std::uint32_t r = top_; r < bottom_; ++r) std::ranges::fill(band_.row(r), 0);
    }
  }

 private:
  /// Area of the section's outline up to so many layers.
  double wall_mm2(std::uint32_t layers) const {
    const auto sides = static_cast<double>(outline(section_));
    return sides * std::sqrt(pixel_mm2_) * static_cast<double>(rrep_.grid.layer_height_mm) * layers;
  }
  void cross(std::uint32_t pixel) {
    const std::uint32_t row = pixel / rrep_.grid.columns, column = pixel % rrep_.grid.columns;
    std::uint64_t& word = section_.row(row)[column / 64];
    const std::uint64_t bit = std::uint64_t{1} << (column % 64);
    const bool exits = (word & bit) != 0;
    word ^= bit;
    if (exits == enters_) return;
    band_.set(column, row);
    top_ = std::min(top_, row);
    bottom_ = std::max(bottom_, row + 1);
  }

  const RRep& rrep_;
  bool enters_ = false;
  BitImage section_, band_;
  CrossingPacking packing_;
  double pixel_mm2_ = static_cast<double>(rrep_.grid.pitch_x_mm) * static_cast<double>(rrep_.grid.pitch_y_mm);
  std::uint32_t top_ = 0, bottom_ = 0;  ///< rows of band_ that have pixels
};

/// The heights of layers from the plate up.
/// @param allowed  the greatest height of a layer that has a layer of the R-Rep
/// @returns false: more runs than there is room for
bool stack(std::span<const std::uint8_t> allowed, const AdaptiveLayers& asked, LayerSteps& steps) {
  steps = {};
  for (std::uint32_t i = 0; i < asked.first_layers; ++i) {
    if (!steps.add(asked.first)) return false;
  }
  for (std::size_t at = std::size_t{asked.first_layers} * asked.first; at < allowed.size();) {
    const auto left = static_cast<std::uint32_t>(std::min<std::size_t>(allowed.size() - at, asked.most));
    std::uint32_t step = left - (left % 2 == 0 ? 1 : 0);  // none reaches beyond the top
    for (std::uint32_t i = 0; i < step && at + i < allowed.size(); ++i) {
      // One that does not reach this far, of odd height, or one that is allowed here.
      const std::uint32_t shorter = i - (i % 2 == 0 ? std::min(i, 1U) : 0);
      const bool ends = i > 0 && (allowed[at + i] & kBegins) != 0;
      const std::uint32_t most = ends ? 0 : allowed[at + i] % kBegins;
      step = std::min(step, std::max({most, shorter, 1U}));
    }
    if (!steps.add(step)) return false;
    at += step;
  }
  return true;
}

/// Makes each the least of those up to `reach` away.
void spread(std::span<std::uint8_t> allowed, std::size_t reach) {
  // In place: from either side, the place of the last that was as low or lower wins.
  const auto sweep = [&](auto index) {
    std::array<std::size_t, LayerSteps::kMostStep + 1> left = {};
    for (std::size_t i = 0; i < allowed.size(); ++i) {
      std::uint8_t& one = allowed[index(i)];
      const std::uint8_t own = one % kBegins, begins = one & kBegins;
      std::uint8_t least = own;
      for (std::uint8_t step = 1; step < least; ++step) {
        if (left[step] > 0) least = step;
      }
      one = least | begins;
      for (std::size_t& l : left) l -= std::min<std::size_t>(l, 1);
      left[own] = reach;
    }
  };
  sweep([](std::size_t i) { return i; });
  sweep([&](std::size_t i) { return allowed.size() - 1 - i; });
}

}  // namespace

PrintLayers count_print_layers(RRep& rrep, const LayerSteps& steps, std::uint32_t lifted) {
  PrintLayers counted{steps.layer_at(lifted), rrep.grid.layers};
  if (steps.of(counted.first).sampled() < lifted) ++counted.first;
  const CrossingPacking packing(rrep.grid);
  const std::uint32_t layers = steps.layers(lifted + rrep.grid.layers) - counted.first;
  auto* const first = const_cast<std::uint32_t*>(rrep.first.data());
  auto* const packed = const_cast<std::uint32_t*>(rrep.packed.data());
  std::uint32_t written = 0, read = 0;
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    const LayerStep step = steps.of(counted.first + layer);
    const std::uint32_t own = step.step == 1 ? first[step.first - lifted] : UINT32_MAX;  // those stay where they are
    const std::uint32_t end = first[step.sampled() + 1 - lifted];
    for (std::uint32_t i = read; i < std::min(own, end); ++i) {
      const std::uint32_t mark = packed[i] & kMostLessThin;
      packed[i] = marked_less(packing.packed(packing.pixel(packed[i])), mark, kMostLessThin);
    }
    std::sort(packed + read, packed + end);
    first[layer] = written;  // not above `layer` layers of the R-Rep, all of which have been read
    for (; read < end; ++read) {
      // Two of a pixel: it changes and changes back.
      if (written > first[layer] && packing.pixel(packed[written - 1]) == packing.pixel(packed[read])) {
        --written;
      } else {
        packed[written++] = packed[read];
      }
    }
  }
  first[layers] = written;
  rrep.grid.layers = layers;
  rrep.first = rrep.first.first(std::size_t{layers} + 1);
  rrep.packed = rrep.packed.first(written);
  return counted;
}

void count_rrep_layers(RRep& rrep, const PrintLayers& counted, const LayerSteps& steps, std::uint32_t lifted) {
  auto* const first = const_cast<std::uint32_t*>(rrep.first.data());
  // The crossings of a layer are at its first one of the R-Rep's. From the top, so that those below have their places yet.
  std::uint32_t layer = rrep.grid.layers;
  std::uint32_t begin = first[layer];
  for (std::uint32_t k = counted.rrep_layers + 1; k-- > 0;) {
    while (layer > 0 && std::max(steps.of(counted.first + layer - 1).first, lifted) >= lifted + k)
      begin = first[--layer];
    first[k] = begin;
  }
  rrep.grid.layers = counted.rrep_layers;
  rrep.first = {first, std::size_t{counted.rrep_layers} + 1};
}

std::size_t steps_bytes(const PrintGrid& grid, std::uint32_t lifted) {
  return 2 * Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(std::size_t{grid.layers} + lifted);
}

Expected<LayerSteps> choose_steps(const RRep& rrep, const AdaptiveLayers& asked, std::uint32_t lifted,
                                  const CureModel& cure, Arena& arena) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = rrep.grid;
  const auto take_image = [&]() -> Expected<BitImage> {
    const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
    PLUMBLINE_TRY(words);
    return BitImage(*words, grid.columns, grid.rows);
  };
  const auto section = take_image();
  PLUMBLINE_TRY(section);
  const auto band = take_image();
  PLUMBLINE_TRY(band);
  const auto allowed = arena.take_top<std::uint8_t>(std::size_t{grid.layers} + lifted, kStage);
  PLUMBLINE_TRY(allowed);
  std::ranges::fill(*allowed, static_cast<std::uint8_t>(asked.most));
  FlatSurfaces surfaces(rrep, *section, *band);
  // Light cures an underside down from where the lowest layer is lit, so that is where it must be thin.
  std::uint32_t least_up = 0, most_up = 0;
  if (cure.is_known()) {
    const auto up = [&](std::uint32_t step) {
      const double height = static_cast<double>(grid.layer_height_mm);
      CureModel model = cure;
      model.dose *= dose_factor(height * step - cure.layer_height_mm, cure.penetration_mm);
      model.bottom_layers = model.faded_layers = 0;
      const double mm = CureDepths(model, height * step).below_film_mm(0, CureDepths::kThick) - height * step;
      return std::max(0.0, mm / height);
    };
    least_up = static_cast<std::uint32_t>(up(asked.most));
    most_up = static_cast<std::uint32_t>(std::ceil(up(1)));
  }
  const double pitch = std::min(double{grid.pitch_x_mm}, double{grid.pitch_y_mm}) / double{grid.layer_height_mm};
  for (std::uint32_t step = asked.most; step >= 3; step -= 2) {
    const double tangent = std::sqrt(step * step - kMostCusp * kMostCusp) / kMostCusp;  // of the flattest tilt
    const auto height = static_cast<std::uint32_t>(std::ceil(2 * pitch * tangent));
    const auto limit = [&](std::uint32_t first, std::uint32_t end) {
      for (std::uint32_t k = first + lifted; k < std::min<std::size_t>(end + lifted, allowed->size()); ++k) {
        (*allowed)[k] = std::min((*allowed)[k], static_cast<std::uint8_t>(step - 2));
      }
    };
    const auto limit_above = [&](std::uint32_t first, std::uint32_t end) { limit(first + least_up, end + most_up); };
    surfaces.find(std::max(height, step), false, kFlatShare, limit);
    surfaces.find(std::max(height, step), true, kFlatShare, limit_above);
  }
  // A level top is where a layer begins, whatever is beside it; where its underside is to be is not known to a layer.
  surfaces.find(1, false, 0, [&](std::uint32_t k, std::uint32_t) { (*allowed)[k + lifted] |= kBegins; });
  surfaces.find(1, true, 0, [&](std::uint32_t k, std::uint32_t end) {
    for (std::uint32_t i = k + least_up + lifted; i < std::min<std::size_t>(end + most_up + lifted, allowed->size());
         ++i) {
      (*allowed)[i] = kBegins | 1;
    }
  });
  LayerSteps steps;
  for (std::size_t reach = 8; !stack(*allowed, asked, steps); reach *= 2) {
    if (reach > 2 * allowed->size()) {  // the R-Rep has more layers than a print can have
      return fail(ErrorCode::kDoesNotFit,
                  "the print has more layers than 65,535 of the least height.\tMake it lower, or its "
                  "least layers higher");
    }
    spread(*allowed, reach);
  }
  return steps;
}

}  // namespace plumbline::inline slicer
