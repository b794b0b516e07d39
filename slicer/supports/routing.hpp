#pragma once
/// Leads every tip's load to the plate.

#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/supports/obstacles.hpp"
#include "slicer/supports/strut_list.hpp"
#include "slicer/supports/support_settings.hpp"
#include "slicer/supports/tips.hpp"

namespace plumbline {

/// Tips by where their load goes, and by its size.
struct RouteCounts {
  std::uint32_t on_plate = 0;     ///< have a pillar of their own on the plate
  std::uint32_t on_supports = 0;  ///< hang on another tip's pillar
  std::uint32_t on_object = 0;    ///< stand on the object, since no way leads past it
  std::uint32_t close = 0;        ///< of these, nearer to the object than base_safety_distance
  std::uint32_t light = 0, medium = 0, heavy = 0;
};

/// A tip's head goes along the surface's normal, tilted by 45 degrees at most. From where it ends, the load goes, in this order,
///   - over a short bridge to a pillar that stands already,
///   - straight down to the plate,
///   - over a bridge of up to max_bridge_length to a pillar, or to where the plate is free,
///   - by the same ways with a smaller base, then nearer to the object than base_safety_distance,
///   - straight down from the tip to whatever is there.
class Routing {
 public:
  /// @param raft_mm  thickness of the raft; 0: none
  Routing(const SupportSettings& settings, double raft_mm, const Obstacles& obstacles, StrutList& list);

  /// @param tips  highest first
  [[nodiscard]] Status route(const Tip& tip);

  const RouteCounts& counts() const { return counts_; }

  /// Radius from which pillars keep away from the object, mm.
  static double clearance(const SupportSettings& settings) {
    return settings.pillar_diameter / 2 + settings.base_safety_distance;
  }

 private:
  struct Head {
    Place tip, joint;  ///< joint: where the head ends
    double tip_radius = 0, radius = 0;
  };

  /// What a way must keep free.
  struct Room {
    double clear;  ///< mm round pillars and bridges
    double base;   ///< mm round a pillar's axis on the plate
  };

  bool find_joint(const Tip& tip, double share, Head& head) const;
  bool is_way_clear(const Place& from, const Place& to, double radius, double clear) const;
  bool stands_free(double x, double y, double z, double radius, const Room& room) const;
  bool is_on_panel(double x, double y, double radius) const;
  bool can_stand_below(const Place& joint, double radius, const Room& room) const;

  Expected<bool> lead_to_plate(const Head& head, const Room& room);
  Expected<bool> join_pillar(const Head& head, double clear, double farthest);
  Expected<bool> lead_aside(const Head& head, const Room& room);
  Status straight_down(const Tip& tip, const Head& head);

  Status add_head(const Head& head, std::uint32_t layer);
  Status add_bridge(const Head& head, const Place& end);
  Status stand_on_plate(double x, double y, double top, double radius);

  SupportSettings settings_;
  double raft_;
  double slope_;  ///< tangent of critical_angle
  double low_;    ///< mm; joints are above it
  double px_, py_, lh_;
  const Obstacles& obstacles_;
  StrutList& list_;
  RouteCounts counts_;
};

}  // namespace plumbline
