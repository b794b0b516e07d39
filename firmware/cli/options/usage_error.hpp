#pragma once
/// Messages about a wrong command line.

#include <CLI/CLI.hpp>
#include <string>

namespace plumbline::firmware {

/// One sentence that names what was given and what is accepted, with the nearest known word if one is near, and where
/// to read more. An unknown word comes first, since it often causes the error that CLI11 found: `--outptu out` also lacks
/// the required `--output`.
/// @param app  as its parse() left it
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace plumbline::firmware
