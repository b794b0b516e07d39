#pragma once
/// Reads the wiring tables of a board file into the HAL's Wiring.

#include <string>
#include <string_view>
#include <vector>

#include "firmware/settings/settings_file.hpp"
#include "hal/wiring.hpp"

namespace plumbline::firmware::inline settings {

/// Adds the rules of [display], [lamp_line], ..., [stick]. Every key is optional.
void add_wiring_rules(std::vector<SettingRule>& rules, Wiring& wiring);

/// What is wrong with a key given the other keys of its table; empty: nothing.
std::string check_wiring(const SettingRule& rule, const Wiring& wiring);

/// Names of the tables that every printer needs and that the file lacks.
std::vector<std::string_view> missing_tables(const Wiring& wiring);

}  // namespace plumbline::firmware::inline settings
