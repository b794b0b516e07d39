/// What the peel tears off small random parts, against all cuts. Shares no code with what it tests but PeelSettings' numbers.

#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "hal/sim/part/hanging_part.hpp"

namespace plumbline {
namespace {

constexpr int kSide = 6;
constexpr int kLayers = 6;
constexpr std::size_t kMostRegions = 12;

using Pixels = std::bitset<kSide * kSide>;

bool is_at_edge(int pixel) {
  const int x = pixel % kSide;
  const int y = pixel / kSide;
  return x == 0 || y == 0 || x == kSide - 1 || y == kSide - 1;
}

/// The pixels that can be reached from `start` along sides, within `all`.
Pixels flood(const Pixels& all, const Pixels& start) {
  Pixels left_edge, right_edge;
  for (int y = 0; y < kSide; ++y) {
    left_edge.set(static_cast<std::size_t>(kSide * y));
    right_edge.set(static_cast<std::size_t>(kSide * y + kSide - 1));
  }
  Pixels found = start & all;
  for (Pixels before; before != found;) {
    before = found;
    found |= (found & ~right_edge) << 1 | (found & ~left_edge) >> 1 | found << kSide | found >> kSide;
    found &= all;
  }
  return found;
}

std::vector<Pixels> regions_of(Pixels image) {
  std::vector<Pixels> regions;
  while (image.any()) {
    regions.push_back(flood(image, Pixels{}.set(image._Find_first())));
    image &= ~regions.back();
  }
  return regions;
}

/// A part of regions, each with what it holds of those above it. What tears is tried out.
struct BrutePart {
  struct Region {
    std::size_t layer;
    Pixels pixels;
    double load = 0;  ///< N
  };
  PeelSettings peel;
  std::vector<Region> hanging;
  std::vector<Pixels> solid;  ///< of a layer, when it was peeled
  Pixels film;

  /// What has stayed of a layer.
  Pixels stayed(std::size_t layer) const {
    Pixels all;
    for (const Region& region : hanging) {
      if (region.layer == layer) all |= region.pixels;
    }
    return all;
  }
  /// The air in the layers so far that a mouth in the last one leads to.
  std::vector<Pixels> cavity(const Pixels& mouth) const {
    std::vector<Pixels> air(solid.size());
    air.back() = mouth;
    for (bool grows = true; grows;) {
      grows = false;
      for (std::size_t k = 0; k < air.size(); ++k) {
        Pixels start = air[k];
        if (k > 0) start |= air[k - 1];
        if (k + 1 < air.size()) start |= air[k + 1];
        const Pixels wider = flood(~solid[k], start);
        grows = grows || wider != air[k];
        air[k] = wider;
      }
    }
    return air;
  }
  double outline(const Pixels& pixels) const {
    int sides = 0;
    for (int p = 0; p < kSide * kSide; ++p) {
      if (!pixels[static_cast<std::size_t>(p)]) continue;
      const auto is_white = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < kSide && y < kSide && pixels[static_cast<std::size_t>(kSide * y + x)];
      };
      const int x = p % kSide;
      const int y = p / kSide;
      sides += !is_white(x - 1, y) + !is_white(x + 1, y) + !is_white(x, y - 1) + !is_white(x, y + 1);
    }
    return 0.7853981633974483 * sides;
  }
  /// What the loads on the regions of `cut` ask for, and what holds these to the plate and to the others that still hang.
  struct Forces {
    double asked_n = 0, held_n = 0;
    double excess() const { return asked_n - held_n; }
  };
  /// @param hung  that still hang, a bit for each of `hanging`; holds `cut`
  Forces forces(std::uint32_t cut, std::uint32_t hung) const {
    Forces sum;
    for (std::size_t i = 0; i < hanging.size(); ++i) {
      if ((hung >> i & 1U) == 0) continue;
      const bool in = (cut >> i & 1U) != 0;
      if (in) sum.asked_n += hanging[i].load;
      if (in && hanging[i].layer == 0) {
        sum.held_n += peel.plate_adhesion_mpa * static_cast<double>(hanging[i].pixels.count());
      }
      for (std::size_t j = 0; j < i; ++j) {
        if ((hung >> j & 1U) == 0 || in == ((cut >> j & 1U) != 0) || hanging[j].layer + 1 != hanging[i].layer) continue;
        sum.held_n += peel.green_strength_mpa * static_cast<double>((hanging[i].pixels & hanging[j].pixels).count());
      }
    }
    return sum;
  }
  /// The largest excess of any cut within `regions`.
  double worst_excess(std::uint32_t regions, std::uint32_t hung) const {
    double worst = 0;
    for (std::uint32_t cut = regions; cut != 0; cut = (cut - 1) & regions) {
      worst = std::max(worst, forces(cut, hung).excess());
    }
    return worst;
  }
  std::size_t voxels(std::uint32_t cut) const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < hanging.size(); ++i) sum += (cut >> i & 1U) != 0 ? hanging[i].pixels.count() : 0;
    return sum;
  }
  /// The cut within `torn` that a loss tells of; 0: there is none.
  std::uint32_t cut_of(const Loss& loss, std::uint32_t torn, std::uint32_t hung) const {
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    std::uint32_t cut = torn;
    for (; cut != 0; cut = (cut - 1) & torn) {
      const Forces asked = forces(cut, hung);
      if (near(asked.asked_n, loss.asked_n) && near(asked.held_n, loss.held_n) &&
          near(static_cast<double>(voxels(cut)), 1000 * loss.ml))
        break;
    }
    return cut;
  }

  /// Adds a layer and pulls at it. @returns false if there are too many regions to try all cuts
  bool add(const Pixels& asked) {
    const std::size_t layer = solid.size();
    for (const Pixels& region : regions_of(asked & ~film)) {
      if (layer > 0 && (region & stayed(layer - 1)).none()) {
        film |= region;
      } else {
        hanging.push_back({layer, region});
      }
    }
    if (hanging.size() > kMostRegions) return false;
    solid.push_back(stayed(layer));
    for (Region& region : hanging) {
      region.load = 0;
      if (region.layer != layer) continue;
      region.load = 1e-3 * peel.traction_kpa * static_cast<double>(region.pixels.count()) +
                    peel.line_force_n_mm * outline(region.pixels);
    }
    for (const Pixels& mouth : regions_of(~solid.back())) {
      const std::vector<Pixels> air = cavity(mouth);
      bool vented = false;
      for (int p = 0; p < kSide * kSide; ++p) {
        for (const Pixels& pixels : air) vented = vented || (is_at_edge(p) && pixels[static_cast<std::size_t>(p)]);
      }
      if (vented) continue;
      const auto mouths = static_cast<double>(air.back().count());
      const double on_part = 1 - std::min(1.0, static_cast<double>(air.front().count()) / mouths);
      const std::size_t beside = mouth._Find_first() - 1;
      for (Region& region : hanging) {
        if (region.layer != layer || !region.pixels[beside]) continue;
        region.load += 1e-3 * peel.suction_kpa * static_cast<double>(mouth.count()) * on_part;
      }
    }
    return true;
  }
  /// Takes off the regions of a cut, those of the last layer onto the film.
  void tear(std::uint32_t cut) {
    std::vector<Region> left;
    for (std::size_t i = 0; i < hanging.size(); ++i) {
      if ((cut >> i & 1U) == 0) {
        left.push_back(hanging[i]);
      } else if (hanging[i].layer + 1 == solid.size()) {
        film |= hanging[i].pixels;
      }
    }
    hanging = left;
  }
};

/// An image of the simulated printer.
struct Mask {
  std::vector<std::uint64_t> words = std::vector<std::uint64_t>(BitImage::words_needed(kSide, kSide), 0);
  BitImage image{words, kSide, kSide};

  explicit Mask(const Pixels& pixels) {
    for (std::uint32_t p = 0; p < kSide * kSide; ++p) {
      if (pixels[p]) image.set(p % kSide, p / kSide);
    }
  }
};

Pixels pixels_of(ConstBitImage image) {
  Pixels found;
  for (std::uint32_t p = 0; p < kSide * kSide; ++p) found[p] = image.at(p % kSide, p / kSide);
  return found;
}

/// Some rectangles, with what the layer above has or without.
/// @param legs  narrow ones, so that wider ones hang from several of them
Pixels random_layer(std::mt19937& random, const Pixels& above, bool legs) {
  const auto upto = [&](int most) { return static_cast<int>(random() % static_cast<std::uint32_t>(most)); };
  Pixels pixels = upto(3) > 0 ? above : Pixels{};
  for (int i = legs ? 5 : upto(3); i >= 0; --i) {
    const bool white = upto(3) > 0;
    const int left = upto(kSide);
    const int top = upto(kSide);
    const int right = std::min(kSide, left + 1 + upto(legs ? 2 : 5));
    const int bottom = std::min(kSide, top + 1 + upto(legs ? 2 : 5));
    const bool is_ring = white && upto(3) == 0;
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const bool within = x > left && y > top && x + 1 < right && y + 1 < bottom;
        pixels[static_cast<std::size_t>(kSide * y + x)] = white && !(is_ring && within);
      }
    }
  }
  return pixels;
}

TEST(Tears, AreCutsThatAreAskedForMoreThanTheyHoldAndTheRestHolds) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(0, 1);
  std::map<std::string, int> seen;
  for (int run = 0; run < 10000; ++run) {
    BrutePart brute;
    brute.peel = {.traction_kpa = 1000 * unit(random),
                  .line_force_n_mm = 0.3 * unit(random),
                  .suction_kpa = 4000 * unit(random),
                  .green_strength_mpa = 0.5 + 4 * unit(random),
                  .plate_adhesion_mpa = 0.5 + 2 * unit(random)};
    HangingPart part({.columns = kSide, .rows = kSide, .peel = brute.peel, .remember = true});
    part.begin(false);
    std::vector<Pixels> stayed;
    Pixels asked;
    for (std::uint32_t k = 0; k < kLayers; ++k) {
      SCOPED_TRACE("part " + std::to_string(run) + ", layer " + std::to_string(k));
      asked = random_layer(random, asked, k % 2 == 0 && run % 2 == 0);
      if (!brute.add(asked)) break;
      const Mask mask(asked);
      const Mask lit(asked & ~pixels_of(part.film()));
      const std::size_t losses = part.losses().size();
      part.add_layer(k, 1, 1, lit.image, mask.image);
      stayed.push_back(pixels_of(lit.image));

      std::uint32_t hung = (1U << brute.hanging.size()) - 1;
      std::uint32_t torn = 0;
      for (std::uint32_t i = 0; i < brute.hanging.size(); ++i) {
        const BrutePart::Region& region = brute.hanging[i];
        const Mask left(stayed[region.layer]);
        part.remove_lost(region.layer, left.image);
        const Pixels remains = pixels_of(left.image) & region.pixels;
        ASSERT_TRUE(remains.none() || remains == region.pixels);
        if (remains.any()) continue;
        torn |= 1U << i;
        if (region.layer < k) ++seen["torn from an earlier layer"];
      }
      // One piece after the other: what is left is pulled at less.
      std::uint32_t rest = torn;
      int pieces = 0;
      for (const Loss& loss : part.losses().subspan(losses)) {
        if (loss.kind != LossKind::kTorn) continue;
        const std::uint32_t piece = brute.cut_of(loss, rest, hung);
        ASSERT_NE(piece, 0U) << to_string(loss);
        const double excess = brute.forces(piece, hung).excess();
        EXPECT_GT(excess, 0);
        EXPECT_LT(brute.worst_excess(piece, hung), excess + 1e-9) << "part of it would tear first";
        rest &= ~piece;
        hung &= ~piece;
        ++pieces;
      }
      ASSERT_EQ(rest, 0U) << "it is gone, but no loss tells of it";
      ASSERT_LT(brute.worst_excess(hung, hung), 1e-9) << "it should have torn, too";
      ++seen[pieces == 0 ? "whole" : pieces == 1 ? "one piece" : "several pieces"];
      if (part.suction_mm2() > 0) ++seen["suction"];
      brute.tear(torn);
      ASSERT_EQ(pixels_of(part.film()), brute.film);
    }
  }
  for (const char* what : {"torn from an earlier layer", "whole", "one piece", "suction"})
    EXPECT_GT(seen[what], 300) << what;
  EXPECT_GT(seen["several pieces"], 30);
}

}  // namespace
}  // namespace plumbline
