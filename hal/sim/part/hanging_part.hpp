#pragma once
/// The part that hangs from the plate: what of each layer stays on it, and what is left on the film.

#include <cstdint>
#include <span>
#include <vector>

#include "hal/sim/part/cavities.hpp"
#include "hal/sim/part/hold_graph.hpp"
#include "hal/sim/part/loss.hpp"
#include "hal/sim/part/part_regions.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/resin/peel_force.hpp"

namespace plumbline::inline hal::inline sim {

/// Judges the layers one after another, when each has all its light.
///
/// A region of a layer is held if it has a pixel below a held one of the layer above; pixels are joined at sides. The plate holds
/// the whole first layer. What is not held drops on the film and shadows those pixels in all later layers, until somebody cleans the
/// film. Then the layer is peeled off the film (PeelSettings), and what is pulled at harder than it is held tears (HoldGraph): it
/// stays on the film, too.
class HangingPart {
 public:
  struct Build {
    std::uint32_t columns = 0, rows = 0;
    double pitch_x_mm = 1, pitch_y_mm = 1;
    PeelSettings peel;
    bool remember = false;  ///< needed for remove_lost()
  };

  explicit HangingPart(const Build& build);

  /// The next layer is the first. @param on_part  it hangs from a part of which nothing is known, so it is all held
  void begin(bool on_part);
  /// Judges the next layer. Clears the pixels of `lit` that don't stay.
  /// @param layer    for losses
  /// @param lit      pixels that got light: `asked` without those on which something lies
  /// @param asked    pixels of the masks
  /// @param deep_mm  cured depth
  void add_layer(std::uint32_t layer, double height_mm, double deep_mm, BitImage lit, ConstBitImage asked);
  /// A layer in which nothing was cured. The part stays as it is.
  void skip_layer(std::uint32_t layer);

  bool film_is_clean() const { return clean_; }
  ConstBitImage film() const { return {film_, build_.columns, build_.rows}; }  ///< pixels on which something lies
  void clean_film();

  std::span<const Loss> losses() const { return losses_; }
  /// Indices of the losses that the last add_layer() made or changed.
  std::span<const std::uint32_t> changed() const { return changed_; }
  const Cavities& cavities() const { return cavities_; }
  double peel_n() const { return peel_n_; }                            ///< force of the last peel
  double largest_peel_n() const { return largest_peel_n_; }            ///< of all
  double suction_mm2() const { return suction_mm2_; }                  ///< mouths of suction cups in the last layer
  double largest_suction_mm2() const { return largest_suction_mm2_; }  ///< in any
  /// Volume below down-facing surfaces that light beyond a layer has cured, as if there were nothing close below them.
  double bleed_mm3() const { return bleed_mm3_; }

  /// Clears the regions of an earlier layer that have torn off since.
  /// @param nth  layer, counted from the first add_layer() or skip_layer()
  void remove_lost(std::size_t nth, BitImage stayed) const;
  bool any_torn() const { return graph_.any_lost(); }

 private:
  static constexpr std::uint32_t kNone = LayerRegions::kNone;
  struct Contact {
    std::uint32_t above = 0;  ///< region of the layer above
    std::uint32_t pixels = 0;
    std::uint32_t next = kNone;  ///< of the same region
  };

  struct Below {
    std::uint32_t pixels = 0;  ///< sum of its contacts
    std::uint32_t joints = 0;  ///< and their number
  };

  bool find_contacts();
  void drop_what_is_loose(double height_mm, BitImage lit, ConstBitImage asked);
  void hang_up(double height_mm, double bleed_mm);
  void peel(BitImage lit, ConstBitImage asked);
  void tear_off(const HoldGraph::Tear& tear, BitImage lit, ConstBitImage asked);
  template <class Which>
  void lay_on_film(BitImage lit, Which which);
  std::uint32_t joined(std::uint32_t loss) const;
  std::uint32_t join(std::uint32_t a, std::uint32_t b);
  std::uint32_t new_loss(LossKind kind, std::uint32_t column, std::uint32_t row, std::uint64_t pixels);
  void take(std::uint32_t loss, double ml);
  void remember();
  std::uint32_t nth() const { return static_cast<std::uint32_t>(layers_.size() - 1); }
  double ml(std::uint32_t pixels, double height_mm) const { return pixels * pixel_mm2_ * height_mm / 1000; }

  Build build_;
  double pixel_mm2_;
  bool first_ = true;
  bool on_part_ = false;

  // The last layer and the one above it.
  PartRegions here_, above_;                      ///< regions that are held, or were until they tore
  std::vector<std::uint32_t> limb_, limb_above_;  ///< of a region; kNone: it is not held
  PartRegions asked_, asked_above_;               ///< regions of the masks; used only where something did not stay
  std::vector<std::uint32_t> loss_, loss_above_;  ///< of a region of the masks; kNone: it stayed. Empty: all stayed
  std::vector<Contact> contacts_;
  std::vector<std::uint32_t> first_contact_;  ///< of a region
  std::vector<Below> below_;                  ///< of a region above
  std::vector<double> sealed_mm2_;            ///< of a region: mouths of suction cups in it that it carries
  std::vector<HoldGraph::Load> loads_;        ///< of the regions

  HoldGraph graph_;
  Cavities cavities_;
  bool clean_ = true;
  std::vector<std::uint64_t> film_;
  std::uint32_t shadow_ = kNone;  ///< loss since the film was cleaned last
  std::vector<Loss> losses_;
  std::vector<std::uint32_t> changed_;
  double peel_n_ = 0, largest_peel_n_ = 0, suction_mm2_ = 0, largest_suction_mm2_ = 0, bleed_mm3_ = 0;
  std::vector<std::uint32_t> layers_;       ///< their numbers for losses; the graph counts from 0
  std::vector<std::uint32_t> remembered_;   ///< limbs of the regions that stayed, layer after layer
  std::vector<std::size_t> remembered_at_;  ///< of a layer
};

}  // namespace plumbline::inline hal::inline sim
