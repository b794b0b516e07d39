#pragma once
/// What other machines of the network reach this one by.

#include "firmware/io/text/fixed_text.hpp"

struct ifaddrs;

namespace plumbline::firmware {

using HostText = FixedText<80>;

/// The first IPv4 address of an interface that is up and has a link: "192.168.1.20". Where such interfaces have none, the machine's name
/// with ".local"; empty: there is no network. Left out are loopback, tunnels, and addresses that a machine gives itself (169.254.0.0/16,
/// RFC 3927).
/// @param interfaces  as getifaddrs() lists them
/// @param name        the machine's
HostText reachable_host(const ifaddrs* interfaces, const char* name);

/// The same, of this machine at this moment. Takes some kilobytes from the heap and gives them back.
HostText reachable_host();

}  // namespace plumbline::firmware
