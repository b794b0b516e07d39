#pragma once
/// Foretells what the peel tears off: the force that pulls at each region, and what it hangs from.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/regions/hold_network.hpp"
#include "slicer/core/regions/layer_regions.hpp"
#include "slicer/core/regions/region_contacts.hpp"
#include "slicer/core/regions/region_shapes.hpp"
#include "slicer/core/resin/peel_force.hpp"

namespace plumbline::inline slicer {

/// Takes the regions that stay of each layer: those that have not fallen. The rules are those of PeelSettings.
class TearFinder {
 public:
  /// @param most_runs  of a layer
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<TearFinder> create(const PrintGrid& grid, const PeelSettings& peel,
                                                   std::size_t most_runs, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t most_runs);

  /// @param stays  called with a region of the newest layer
  using OnTear = FunctionRef<void(const HoldNetwork::Tear& tear, std::uint64_t pixels)>;
  /// Takes a layer. With more regions than HoldNetwork has room for it is held as if by the plate, and so is the next.
  /// @param touches  contacts of the regions that stayed of the layer below, those that tore off included; nullptr: not known
  /// @param on_tear  called with each piece that tears off, and the pixels of its regions in this layer; in_piece() tells which
  void next(std::uint32_t layer, const LayerRegions& stayed, const RegionContacts* touches, OnTear on_tear);
  /// While on_tear() is called: whether a white region of the newest layer belongs to the piece.
  bool in_piece(std::uint32_t region) const { return is_torn_[number_[layer_ % 2][region]]; }
  /// Whether a white region of the newest layer tore off.
  bool torn(std::uint32_t region) const { return hangs_ && number_[layer_ % 2][region] == kTorn; }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint16_t kTorn = 0xffff;

  /// A white region of the newest layer.
  struct Held {
    RegionShape shape;
    double sealed_mm2 = 0;  ///< mouths of cavities that it carries
    std::uint32_t first_contact = kNone;
  };
  struct Contact {
    std::uint32_t below = 0;  ///< an end of the layer below
    std::uint32_t pixels = 0;
    std::uint32_t next = kNone;  ///< of the same region
  };
  /// Enclosed air: 0 is the outside, then those of the layer below that are still closed, then the regions of the newest layer.
  struct Hollow {
    std::uint32_t parent = 0;
    std::uint32_t region = 0;        ///< of the newest layer
    std::uint32_t renamed = 0;       ///< its number when the next layer comes; 0: none yet
    std::uint64_t plate_pixels = 0;  ///< of its ceiling
    std::uint64_t mouth_pixels = 0;  ///< in the newest layer
  };

  bool take(const LayerRegions& stayed, const RegionContacts* touches);
  bool number_regions(const LayerRegions& stayed);
  bool find_contacts(const RegionContacts& touches);
  void carry_suction(const LayerRegions& stayed);
  bool hang_up(const LayerRegions& stayed, double plate_n_mm2);

  PeelSettings peel_;
  double pitch_x_mm_ = 0, pitch_y_mm_ = 0, pixel_mm2_ = 0;
  std::uint32_t layer_ = 0;
  bool hangs_ = false;                              ///< the layer below is in the network
  std::array<std::span<std::uint16_t>, 2> number_;  ///< by region: of its Held; of its Hollow, 0 if it is open
  std::span<Held> held_;
  std::span<bool> is_torn_;  ///< of a Held
  std::span<double> newtons_;
  std::span<Contact> contacts_;
  std::span<std::uint32_t> below_pixels_;  ///< of an end of the layer below: sum of its contacts
  std::span<HoldNetwork::Link> links_;     ///< of one region
  std::span<Hollow> hollows_, next_hollows_;
  std::uint32_t held_count_ = 0, contact_count_ = 0;
  std::uint32_t hollow_count_ = 1;  ///< of hollows_
  std::uint32_t old_hollows_ = 1;   ///< those of the layer below, 0 included
  HoldNetwork network_;
};

}  // namespace plumbline::inline slicer
