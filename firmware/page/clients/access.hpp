#pragma once
/// Which requests the page accepts, by their Host and Origin. Pure functions.

#include <string_view>

#include "firmware/settings/board_file.hpp"

namespace plumbline::firmware::inline page {

/// Whether a request's Host is a name of this machine. With DNS rebinding it is not: somebody else's name then leads to this machine.
///   local    localhost, 127.0.0.1, [::1]
///   network  those, any numeric address, a name without a dot, a name that ends in .local, and `page_host`
/// @param host       as in the header, with or without port
/// @param page_host  of the board file; empty: none
bool is_known_host(std::string_view host, PageChoice page, std::string_view page_host);

/// Whether an Origin is that of the page itself: http or https (a reverse proxy's), the same name and port as in Host.
/// @param origin  empty, "null" and anything that is no origin: false
bool is_same_origin(std::string_view host, std::string_view origin);

}  // namespace plumbline::firmware::inline page
