#pragma once
/// Options that several subcommands have.

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "firmware/settings/check_policy.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/support_choice.hpp"

namespace plumbline::firmware {

/// Headings of `--help`.
inline constexpr const char* kPrinterGroup = "Printer and layers";
inline constexpr const char* kObjectGroup = "Object";
inline constexpr const char* kSupportsGroup = "Supports";
inline constexpr const char* kChecksGroup = "Checks";
inline constexpr const char* kProgramGroup = "Program";

/// The scan, the printer, and the object's size and place.
/// @returns the scan, which is required unless the caller changes that
CLI::Option* add_job_options(CLI::App& app, JobOptions& job);

/// Options for the memory and threads that the program may use, and for what it prints.
void add_program_options(CLI::App& app, JobOptions& job);

/// `--supports` and an option for each setting.
/// @param default_kind  what applies without the option, as the help says it: "[none]"
void add_support_options(CLI::App& app, SupportChoice& choice, const char* default_kind);

/// `--absolute-correction`.
void add_correction_option(CLI::App& app, JobOptions& job);

/// `--check KIND=ACTION` and `--accept`.
void add_check_options(CLI::App& app, CheckChoice& choice);

/// All that slices without a profile: the options of the job, of supports, of checks and of the program.
/// @returns the scan
CLI::Option* add_slicing_options(CLI::App& app, JobOptions& job, SupportChoice& supports, CheckChoice& checks);

/// All that looks at a scan: a picture, the options of the job and of the program.
/// @param picture  file for the picture; stays empty if none is wanted
/// @param drawn    what the picture shows, as the help says it
void add_look_options(CLI::App& app, JobOptions& job, std::string& picture, const char* drawn);

/// "--support-head-width" for support_head_width.
std::string option_name(std::string_view key);

}  // namespace plumbline::firmware
