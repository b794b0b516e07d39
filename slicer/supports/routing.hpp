#pragma once
/// Leads every tip's load to the plate.

#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/supports/obstacles.hpp"
#include "slicer/supports/strut_list.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/tips.hpp"

namespace plumbline::inline slicer {

/// Tips by where their load goes, and by its size.
struct RouteCounts {
  std::uint32_t on_plate = 0;     ///< have a pillar of their own on the plate
  std::uint32_t on_supports = 0;  ///< hang on another tip's pillar
  std::uint32_t on_object = 0;    ///< stand on the object, since no way leads past it
  std::uint32_t light = 0, medium = 0, heavy = 0;
  UnreachedTips unreached_islands, unreached_overhangs;
};

/// A tip's head goes along the surface's normal, tilted by 45 degrees at most, or aside. From where it ends, the load goes, in this order,
///   - over a bridge to a pillar that stands already, if that is shorter than a pillar of its own,
///   - straight down to the plate,
///   - over a bridge of up to max_bridge_length to a pillar, or to where the plate is free,
///   - by the same ways with a smaller base,
///   - down to the object, as a pin with a head at both ends, or leaning on a wall of it, unless buildplate_only.
/// Everything but the ends of heads keeps base_safety_distance from the object. A tip that no such way leads from gets no support.
class Routing {
 public:
  /// @param raft_mm  thickness of the raft; 0: none
  Routing(const SupportSettings& settings, double raft_mm, const Obstacles& obstacles, StrutList& list);

  /// @param tip  the highest of those to come
  /// @returns whether it has a support
  [[nodiscard]] Expected<bool> route(const Tip& tip);

  const RouteCounts& counts() const { return counts_; }

  /// Radius from which pillars keep away from the object, mm.
  static double clearance(const SupportSettings& settings) {
    return settings.pillar_diameter / 2 + settings.base_safety_distance;
  }

 private:
  struct Head {
    Place tip, joint;  ///< joint: where the head ends
    double tip_radius = 0, radius = 0;
    double length = 0;
  };
  static constexpr double kFar = 1e6;
  /// Of a way to the object, mm.
  struct Ends {
    double from = kFar, to = kFar;
  };
  /// What a pillar must keep free.
  struct Room {
    double base;  ///< mm round its axis on the plate, besides base_safety_distance
    double gap;   ///< mm to other pillars
  };

  Expected<bool> find_way(const Tip& tip, Head& head);
  static Vec3d tilted(const Vec3d& normal, double share);
  bool find_joint(const Vec3d& direction, double low, Head& head) const;
  bool is_way_clear(const Place& from, const Place& to, double radius_from, double radius_to, const Ends& ends) const;
  bool stands_free(const Place& top, double radius, const Room& room) const;
  bool is_on_panel(double x, double y, double radius) const;

  Expected<bool> lead_away(const Head& head, const Room& room, bool aside);
  Expected<bool> lead_to_plate(const Head& head, const Room& room);
  Expected<bool> join_pillar(const Head& head, double farthest);
  Expected<bool> lead_aside(const Head& head, const Room& room);
  Expected<bool> stand_on_object(const Head& head);
  Expected<bool> stand_below(const Tip& tip, Head& head);
  Expected<bool> lean_on_object(Head& head);
  Expected<bool> stand_on_foot(const Place& foot, std::uint32_t floor, double cone, const Head& head);

  Status add_bridge(const Head& head, const Place& end);
  Status stand_on_plate(const Place& top, double radius);

  SupportSettings settings_;
  double raft_;
  double slope_;  ///< tangent of critical_angle
  double low_;    ///< mm; joints are above it
  double px_, py_, lh_;
  const Obstacles& obstacles_;
  StrutList& list_;
  RouteCounts counts_;
};

}  // namespace plumbline::inline slicer
