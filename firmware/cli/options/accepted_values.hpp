#pragma once
/// What an option accepts. CLI11's own validators name neither the value nor the unit in the same way, and its Range lets
/// NaN pass.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace plumbline::firmware {

/// Accepts finite numbers from `low` to `high`. The message tells a comma from a point, and asks for the number alone if a
/// unit was given.
/// @param unit  "mm", or "" if the number has none
CLI::Validator number_from(double low, double high, const char* unit = "");

/// Accepts a height of layers, kFinestMm to kCoarsestMm, or kAdaptiveWord, which becomes kAdaptiveHeight.
CLI::Validator layer_height();

/// Accepts whole numbers from `low` to `high`, in decimal digits.
CLI::Validator whole_number_from(unsigned long long low, unsigned long long high);

/// Accepts these words.
CLI::Validator one_of(const std::vector<std::string>& words);

}  // namespace plumbline::firmware
