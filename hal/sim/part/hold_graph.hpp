#pragma once
/// What every region of a part hangs from, and how much that holds.

#include <cstdint>
#include <span>
#include <vector>

#include "slicer/core/regions/max_flow.hpp"

namespace plumbline::inline hal::inline sim {

/// A graph of the part's regions from the plate down, with the strength of each joint between two layers.
///
/// The plate is vertex 0. A *limb* is a chain of regions, one a layer, each joined to one region above and one below. Only its
/// weakest joint, its neck, matters; so memory grows with the places where regions split or merge, not with layers.
///
/// Loads are carried if some way of sharing them keeps every joint within its strength: the lower bound theorem of limit analysis
/// for tough material. The largest load is then the largest flow from the loads to the plate, and what tears is the smallest cut.
class HoldGraph : private MaxFlow<HoldGraph> {
 public:
  static constexpr std::uint32_t kPlate = 0;  ///< a limb that every pull ends at
  static constexpr double kUnbreakable = 1e12;

  struct Place {
    std::uint32_t layer = 0, column = 0, row = 0;
  };
  struct Joint {
    std::uint32_t limb = 0;  ///< above
    double newtons = 0;      ///< strength
    double share = 1;        ///< of all joints below that limb's last region, by area; only speeds up pull()
  };
  struct Load {
    std::uint32_t limb = 0;  ///< whose last region is pulled
    double newtons = 0;
  };
  /// A piece that tore off.
  struct Tear {
    Place place;                       ///< of the strongest joint that tore
    double asked_n = 0;                ///< of it, by the loads on the piece
    double held_n = 0;                 ///< by all joints that tore; less than asked_n
    double mm3 = 0;                    ///< volume of the piece
    std::vector<std::uint32_t> loads;  ///< indices of the loads that hung from it, ascending
  };

  HoldGraph();

  /// Begins a limb below others.
  /// @param joints  to the limbs above
  /// @param place   of its first region
  /// @param mm3     of that region
  std::uint32_t begin_limb(std::span<const Joint> joints, const Place& place, double mm3);
  /// Adds a region below the last one of a limb.
  void extend(std::uint32_t limb, double newtons, const Place& place, double mm3);

  /// Pulls at the last regions of all limbs that are still growing. Pieces that ask for more than they are held by are torn off.
  std::vector<Tear> pull(std::span<const Load> loads);

  /// Whether the limb's region in `layer` has torn off.
  bool lost(std::uint32_t limb, std::uint32_t layer) const {
    return limbs_[limb].lost_from <= layer && layer < limbs_[limb].lost_to;
  }
  bool any_lost() const { return any_lost_; }

 private:
  friend MaxFlow;
  /// A limb has two vertices, 2 limb at its top and 2 limb + 1 at its bottom, with its neck between them.
  struct Limb {
    Place begin = {};
    Place neck = {};       ///< of the region below it
    double above_mm3 = 0;  ///< volume above the neck
    double below_mm3 = 0;
    double holds = 0;  ///< a load that it surely holds, while all others carry theirs
    std::uint32_t neck_arc = kNone;
    std::uint32_t lost_from = kNone, lost_to = kNone;  ///< layers
  };
  /// Half of an undirected edge; the other half has index ^ 1.
  struct Arc {
    std::uint32_t to = 0;
    std::uint32_t next = kNone;  ///< from the same vertex
    double newtons = 0;          ///< strength; 0: torn
    double flow = 0;             ///< the other half's is its negative
  };

  // For MaxFlow.
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(first_arc_.size()); }
  std::uint32_t first_arc(std::uint32_t vertex) const { return first_arc_[vertex]; }
  Arc& arc(std::uint32_t i) { return arcs_[i]; }
  double room(std::uint32_t arc) const { return arcs_[arc].newtons - arcs_[arc].flow; }

  void add_edge(std::uint32_t above, std::uint32_t below, double newtons);
  /// Sends each load's newtons times `factor` to the plate, as far as they can. @returns whether all arrived; else rest_ has what did not
  bool carry_all(std::span<const Load> loads, double factor);
  Tear tear_from(std::uint32_t vertex, std::span<const Load> loads);

  std::vector<Limb> limbs_;
  std::vector<std::uint32_t> first_arc_;  ///< of a vertex
  std::vector<Arc> arcs_;
  bool any_lost_ = false;
  std::vector<std::uint32_t> lists_[kListsOfVertices];  ///< of MaxFlow
  std::vector<double> rest_;
};

}  // namespace plumbline::inline hal::inline sim
