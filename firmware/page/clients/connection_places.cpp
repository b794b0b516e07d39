#include "firmware/page/clients/connection_places.hpp"

#include <algorithm>

namespace plumbline::firmware::inline page {
namespace {

template <class Counts>
std::size_t count(std::span<const HeldPlace> held, Counts counts) {
  return static_cast<std::size_t>(std::count_if(
      held.begin(), held.end(), [&](const HeldPlace& one) { return one.is_taken && !one.ends && counts(one); }));
}

}  // namespace

PlaceChoice choose_place(std::span<const HeldPlace> held, const ClientAddress& address, bool is_paired,
                         const PlaceLimits& limits) {
  const auto of = [&](const ClientAddress& whose) {
    return count(held, [&](const HeldPlace& one) { return one.address == whose; });
  };
  const std::size_t own = of(address);
  const bool is_full = own >= (is_paired ? limits.of_paired : limits.of_unpaired);
  const std::size_t all = count(held, [](const HeldPlace&) { return true; });
  const std::size_t unpaired = count(held, [](const HeldPlace& one) { return !one.is_paired; });
  if (!is_full && all < limits.all && (is_paired || unpaired < limits.unpaired)) return {.is_let_in = true, .ends = {}};
  std::optional<std::size_t> worst;
  std::size_t most = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const HeldPlace& one = held[i];
    if (!one.is_taken || one.ends || !one.may_end) continue;
    if (is_full ? one.address != address : one.is_paired) continue;
    const std::size_t theirs = of(one.address);
    if (!is_full && !is_paired && theirs < own + 2) continue;
    if (worst && (theirs < most || (theirs == most && one.since >= held[*worst].since))) continue;
    worst = i;
    most = theirs;
  }
  return {.is_let_in = worst.has_value(), .ends = worst};
}

}  // namespace plumbline::firmware::inline page
