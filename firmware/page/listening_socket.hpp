#pragma once

#include <cstdint>
#include <string>

#include "firmware/io/descriptor.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// A TCP socket that listens and does not block.
/// @param address  numeric; empty: all of this machine, IPv4 and IPv6
/// @param port     0: any
/// @retval ErrorCode::kBadSetting  not an address
/// @retval ErrorCode::kCannotOpen  the port and the reason
[[nodiscard]] Expected<Descriptor> listen_at(const std::string& address, std::uint16_t port);

}  // namespace plumbline::firmware::inline page
