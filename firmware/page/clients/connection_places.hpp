#pragma once
/// Who gets one of the page's connections. Places are kept for paired browsers; among the others nobody can take those of everybody.

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>

#include "firmware/page/clients/client_address.hpp"

namespace plumbline::firmware::inline page {

/// A connection that is open.
struct HeldPlace {
  ClientAddress address;
  bool is_taken = false;
  bool is_paired = false;  ///< its address is that of a paired browser
  bool may_end =
      false;  ///< a request is awaited on it, or its answer is taken; false: it is a stream, or waits for the printer
  bool ends = false;                            ///< it is being ended, and counts no more
  std::chrono::steady_clock::time_point since;  ///< of may_end
};

struct PlaceLimits {
  std::size_t all = 32;         ///< connections
  std::size_t unpaired = 20;    ///< of them for addresses that are not paired
  std::size_t of_unpaired = 8;  ///< of one such address. A browser opens six
  std::size_t of_paired = 16;   ///< of one paired address. A reverse proxy is one
};

struct PlaceChoice {
  bool is_let_in = false;
  std::optional<std::size_t> ends;  ///< this one is ended for it
};

/// Chooses for a new connection. An address that has all it may have loses the connection that has waited longest. Where there is no place for
/// others, the address that has most of them loses that one, if it has at least two more than the new one.
/// @param is_paired  the new one's address is that of a paired browser
PlaceChoice choose_place(std::span<const HeldPlace> held, const ClientAddress& address, bool is_paired,
                         const PlaceLimits& limits = {});

}  // namespace plumbline::firmware::inline page
