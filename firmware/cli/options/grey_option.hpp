#pragma once
/// `--grey` of the subcommands that make masks for a panel.

#include <CLI/CLI.hpp>
#include <string>

#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// @param grey  becomes one of kGreyWords; stays empty without the option
CLI::Option* add_grey_option(CLI::App& app, std::string& grey);

/// Takes the option into the profile, where it can be done.
/// @param grey  of add_grey_option(); if it is empty the profile stays as it is
/// @retval ErrorCode::kBadSetting  the panel shows no grey, or the profile does not say what light cures
[[nodiscard]] Status choose_grey(const std::string& grey, const BoardFile& board, const MachineFile& machine,
                                 PrintProfile& profile);

}  // namespace plumbline::firmware
