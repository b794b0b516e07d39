#pragma once
/// Braces between pillars, so that none stands alone.

#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"
#include "slicer/supports/obstacles.hpp"
#include "slicer/supports/strut_list.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

/// A height at which something beside a pillar holds it.
struct StrutContact {
  double z = 0;              ///< mm
  std::uint32_t next = ~0U;  ///< the pillar's next contact
};

struct BraceCounts {
  std::uint32_t braces = 0;
  std::uint32_t helpers = 0;   ///< pillars that carry nothing
  std::uint32_t unbraced = 0;  ///< pillars with a longer free height than kMostFree_mm
  double longest_free_mm = 0;  ///< of all pillars
};

/// Puts braces between neighbouring pillars until none has more than kWantedFree_mm without one, from its foot to its
/// head, or no neighbour within max_pillar_link_distance is left. A pillar that then has more gets props: braces to the middle of such a
/// stretch, from neighbours that may be lower, at the critical angle or steeper; and up to three legs: braces from the rim of its base, as
/// high as these reach. One that still has more than kMostFree_mm gets a helper: a second pillar beside it.
/// Where the list of struts ends there are fewer braces; no print is refused for them.
class Bracing {
 public:
  static constexpr double kMostFree_mm = 10;
  static constexpr double kWantedFree_mm = 8;

  /// @param contacts  room for most_contacts()
  Bracing(const SupportSettings& settings, double raft_mm, const Obstacles& obstacles, StrutList& list,
          std::span<StrutContact> contacts);

  [[nodiscard]] Status brace_all();

  const BraceCounts& counts() const { return counts_; }

 private:
  struct Gap {
    double low = 0, high = 0;
    double height() const { return high - low; }
  };

  Gap largest_gap(const Pillar& pillar) const;
  Gap gap_at(const Pillar& pillar, double z) const;
  void add_contact(Pillar& pillar, double z);
  bool is_clear(const Place& from, const Place& to) const;

  /// @returns whether any brace was added
  Expected<bool> join(Pillar& a, Pillar& b);
  Status brace(std::size_t index);
  Expected<bool> add_prop(Pillar& pillar, const Gap& gap);
  Expected<bool> add_leg(Pillar& pillar, const Gap& gap);
  Status add_brace(Pillar& lower, Pillar& upper, const Place& from, const Place& to);
  bool has_room() const;
  Expected<bool> add_helper(std::size_t index, const Gap& gap);

  double distance(const Pillar& a, const Pillar& b) const;
  bool stand_in_each_other(const Pillar& a, const Pillar& b) const;
  double foot(const Pillar& pillar) const { return pillar.bottom + (pillar.on_plate ? raft_ : 0); }

  SupportSettings settings_;
  double raft_, slope_, px_, py_, lh_, radius_;
  const Obstacles& obstacles_;
  StrutList& list_;
  std::span<StrutContact> contacts_;
  std::size_t contact_count_ = 0;
  BraceCounts counts_;
};

}  // namespace plumbline::inline slicer
