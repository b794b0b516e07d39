#pragma once
/// The printer's state for people, from a line of the state socket.

#include <string>
#include <string_view>

namespace plumbline::firmware {

/// A text of an object's member; empty if it is null, no text, or not there.
std::string json_text(std::string_view object, std::string_view key);

/// Several lines: what the printer does, its job, the scans on the stick, findings, the fault and what to do.
std::string status_page(std::string_view state);

/// The prints whose reports are kept, a line each, newest first.
std::string prints_page(std::string_view state);

/// One line: "printing layer 12 of 1184, 2 h 10 min left", or a fault and what to do.
std::string status_line(std::string_view state);

}  // namespace plumbline::firmware
