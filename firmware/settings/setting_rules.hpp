#pragma once
/// Describes the rules of a settings file in words.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/settings/settings_file.hpp"

namespace plumbline::firmware::inline settings {

/// What a key accepts: "an integer from 1 to 16384 pixels".
std::string allowed(const SettingRule& rule);

/// The tables of the rules, each once, in their order.
std::vector<std::string_view> known_tables(std::span<const SettingRule> rules);

/// The keys of one table, in the order of the rules.
std::vector<std::string_view> known_keys(std::span<const SettingRule> rules, std::string_view table);

}  // namespace plumbline::firmware::inline settings
