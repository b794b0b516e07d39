#pragma once
/// What the regions of the newest layer hang from, and how much that holds.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/arena.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"
#include "slicer/core/regions/max_flow.hpp"

namespace plumbline::inline slicer {

/// A network of what has been printed: *bodies* of regions, and the *joints* between them, each with its strength. Body 0 is the plate.
/// An *end* is a body with a region in the newest layer, at which the film pulls.
///
/// Only what can decide a tear is kept. A body without an end is merged into the one it hangs from if it has one joint, and into the
/// one with the stronger joint if it has two. So a part without loops needs no more bodies than twice its ends, however high it is.
///
/// Loads are carried if some way of sharing them keeps every joint within its strength (lower bound theorem of limit analysis). What tears
/// is the smallest cut of the largest flow from the loads to the plate.
class HoldNetwork : private MaxFlow<HoldNetwork> {
 public:
  static constexpr double kUnbreakable = 1e12;

  struct Place {
    std::uint32_t layer = 0, column = 0, row = 0;
  };
  struct Link {
    std::uint32_t end = 0;  ///< of the layer below
    double newtons = 0;     ///< that the joint holds
    double share = 1;       ///< of all joints above that end, by area; only speeds up pull()
  };
  struct Tear {
    Place place;  ///< of the strongest joint that tears: in the region above it
    double asked_n = 0, held_n = 0;
    std::uint64_t voxels = 0;
  };

  /// @param most_ends  regions of a layer; there is room for four times as many bodies, which braces and lattices need
  /// @retval ErrorCode::kOutOfMemory  bytes_needed() from the top of the arena
  [[nodiscard]] static Expected<HoldNetwork> create(std::uint32_t most_ends, Arena& arena);
  static std::size_t bytes_needed(std::uint32_t most_ends);

  /// Begins a layer; the ends so far are those of the layer below.
  void begin_layer();
  /// Before the layer's ends are added: an end of the layer below has one link more.
  void announce_link(std::uint32_t end) { ++below_[end].links; }
  /// Adds the newest layer's ends, from 0 on. If there is no room for one, clear() has to follow.
  /// @param links  none: it is on the plate
  /// @param newtons  that the plate holds of it; used without links only
  /// @returns false if there is no room
  [[nodiscard]] bool add_end(std::span<const Link> links, double newtons, const Place& place, std::uint64_t voxels);
  /// After the last end of a layer.
  void end_layer();
  std::uint32_t ends() const { return end_count_; }
  /// Whether an end tore off, and is no end any more.
  bool torn(std::uint32_t end) const { return ends_[end].body == kNone; }

  /// Pulls at the ends.
  /// @param newtons  of each end, torn ones excluded
  /// @param on_tear  called with each piece that is asked for more than holds it, and with its ends
  void pull(std::span<const double> newtons, FunctionRef<void(const Tear&, std::span<const std::uint32_t>)> on_tear);

  /// Forgets all that was printed.
  void clear();

 private:
  friend MaxFlow;
  static std::size_t most_bodies(std::uint32_t most_ends) { return std::size_t{4} * most_ends; }
  static std::size_t most_joints(std::uint32_t most_ends) { return std::size_t{6} * most_ends; }

  struct Body {
    std::uint32_t first_arc = kNone;  ///< of a body that is not in use: the next such one
    std::uint32_t arcs = 0;
    std::uint64_t voxels = 0;
    bool is_end = false;
    bool is_listed = false;  ///< in todo_
  };
  /// Half of a joint, which is the arcs 2 j and 2 j + 1.
  struct Arc {
    std::uint32_t to = 0;
    std::uint32_t next = kNone,
                  before = kNone;  ///< from the same body; of a joint that is not in use: the next such one
    double flow = 0;               ///< the other half's is its negative
  };
  struct Joint {
    double newtons = 0;
    Place place;
    bool yields = false;  ///< to a joint above that holds as little: that one is nearer to the film
  };
  struct End {
    std::uint32_t body = kNone;
    std::uint32_t links = 0;  ///< from the layer above
    double holds = 0;         ///< a load that it surely holds, while all others carry theirs
  };

  std::uint32_t new_body(std::uint64_t voxels);
  bool new_joint(std::uint32_t a, std::uint32_t b, const Joint& joint);
  void link_arc(std::uint32_t body, std::uint32_t arc);
  void unlink_arc(std::uint32_t body, std::uint32_t arc);
  void remove_joint(std::uint32_t joint);
  void remove_body(std::uint32_t body);
  void list(std::uint32_t body);
  void reduce_listed();
  void reduce(std::uint32_t body);
  void join_parallel(std::uint32_t a, std::uint32_t b, std::uint32_t joint);
  void extend(End& end, const Link& link, const Place& place, std::uint64_t voxels);

  // For MaxFlow.
  std::uint32_t vertices() const { return body_count_; }
  std::uint32_t first_arc(std::uint32_t body) const { return bodies_[body].first_arc; }
  Arc& arc(std::uint32_t i) const { return arcs_[i]; }
  double room(std::uint32_t arc) const { return joints_[arc / 2].newtons - arcs_[arc].flow; }

  bool carry_rest();
  Tear tear_from(std::uint32_t body, std::uint32_t& torn_count);

  std::span<Body> bodies_;
  std::span<Arc> arcs_;
  std::span<Joint> joints_;
  std::uint32_t body_count_ = 1, joint_count_ = 0;        ///< ever used since clear()
  std::uint32_t free_body_ = kNone, free_joint_ = kNone;  ///< the first that is not in use any more
  std::span<End> ends_, below_;
  std::uint32_t end_count_ = 0, below_count_ = 0;
  std::span<std::uint32_t> todo_;  ///< bodies that may be merged into others
  std::uint32_t todo_count_ = 0;
  std::span<double> load_, rest_;  ///< of an end
  std::span<std::uint32_t> torn_;  ///< ends
};

}  // namespace plumbline::inline slicer
