#pragma once
/// The subcommands of `plumbline`: their options, and what they do.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/machine/back_end.hpp"
#include "firmware/messages/exit_code.hpp"
#include "firmware/settings/check_policy.hpp"
#include "firmware/settings/exposure_test.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/settings/print_fields.hpp"
#include "firmware/settings/support_choice.hpp"
#include "firmware/state/socket_place.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11's name
class App;
}

namespace plumbline::firmware {

struct SliceOptions {
  JobOptions job;
  std::string output;
  std::string grey;  ///< of kGreyWords; empty: the profile's
  bool preview = true;
  SupportChoice supports;
  CheckChoice checks;
};

struct InspectOptions {
  JobOptions job;
  std::string picture;  ///< file for a picture of what the scan missed; empty: none
  std::string issues;   ///< file for a picture of what the checks found; empty: none
};

struct OrientOptions {
  JobOptions job;
  std::string picture;  ///< file for a picture of the best orientations; empty: none
};

struct CheckOptions {
  JobOptions job;
  std::string picture;  ///< file for a picture of what was found; empty: none
  SupportChoice supports;
  CheckChoice checks;
};

struct SampleOptions {
  std::string output;
  std::uint64_t points = 300'000;
  std::uint64_t seed = 1;
  bool quiet = false;
};

struct PrintOptions {
  JobOptions job;            ///< the printer is required, the scan unless resume
  std::string profile;       ///< name or path; empty: the board file's
  std::string state;         ///< folder of journal and job; empty: none is kept
  bool resume = false;       ///< the print in `state`
  bool plate_empty = false;  ///< the user says so
  std::string keep_part;     ///< folder for the part that a simulated printer made; empty: none
  std::string grey;          ///< of kGreyWords; empty: the profile's
  std::string truth;         ///< closed mesh that the part is measured against; empty: the R-Rep, if the part is kept
  std::string report;        ///< file for the report as JSON; empty: none
  std::string issues;        ///< file for a picture of what the checks found; empty: none
  SimulationOptions simulation;
  ExposureTest exposure_test;  ///< instead of the profile's exposure
  SupportChoice supports;      ///< overrides the profile's
  CheckChoice checks;          ///< overrides the profile's
  PrintValues set{};           ///< override the profile's and the archive's

  bool is_adaptive() const { return job.layer_height_mm && *job.layer_height_mm < 0; }
  PrintValues by_person() const {
    PrintValues all = set;
    if (job.layer_height_mm && *job.layer_height_mm > 0) all[index_of(PrintKey::kLayerHeight)] = job.layer_height_mm;
    if (exposure_test.strips > 0) all[index_of(PrintKey::kExposureTime)] = exposure_test.longest();
    return all;
  }
};

struct DoctorOptions {
  std::string printer;  ///< board file
  bool json = false;
};

struct StatusOptions {
  std::string socket = kStateSocket;  ///< the daemon's state socket
  bool follow = false;                ///< until the daemon ends
  bool json = false;
  std::string picture;        ///< kPictureWords; empty: none is asked for
  bool prints = false;        ///< list those that are kept
  std::uint32_t report = 0;   ///< of which print the report is asked for; 0: of none
  std::uint32_t preview = 0;  ///< the same for the preview
  std::string output;         ///< file for the picture or the report
};

struct ControlOptions {
  std::string socket = kStateSocket;  ///< the daemon's state socket; commands go to the one beside it
  std::string command;                ///< to_string(Command)
  std::uint32_t scan = 0;             ///< of choose
  std::uint32_t folder = 0;           ///< of open
  std::string key, value;             ///< of set
  std::string file;                   ///< of upload: its path
  std::string name;                   ///< of remove
  std::optional<double> ml;           ///< of filled
  std::string about;                  ///< id of the question or job that is meant; empty: not said
};

struct SimulateOptions {
  std::vector<std::string> scans;  ///< are copied onto the stick
  std::string printer = "sim2k";   ///< board file
  double speed = 60;               ///< simulated seconds per second
  std::uint16_t port = 8080;       ///< of the page
  std::string folder;              ///< empty: a new one, which is removed
};

struct SetupOptions {
  std::string output;               ///< board file to write
  std::string like;                 ///< board file whose values are offered; empty: rpi4_dxq608, or what is simulated
  std::string answers;              ///< file; empty: a person answers
  std::string simulated;            ///< board file as which a simulated printer is built; empty: this board
  double speedup = 0;               ///< of the simulated printer, as SimulationOptions
  std::string lamp_line;            ///< that the simulated lamp lights, as SimulationOptions
  std::vector<std::string> faults;  ///< of the simulated printer, as SimulationOptions
  bool list = false;                ///< only list what the board has
};

struct ProfileOptions {
  std::string program;  ///< "prusaslicer", "uvtools"
  std::string printer;  ///< board file
  std::string profile;  ///< name or path; empty: the board file's
  std::string output;   ///< empty: standard output
};

/// Each adds a subcommand whose options are parsed into `options`, which must outlive the parsing.
CLI::App* add_slice_command(CLI::App& app, SliceOptions& options);
CLI::App* add_inspect_command(CLI::App& app, InspectOptions& options);
CLI::App* add_orient_command(CLI::App& app, OrientOptions& options);
CLI::App* add_print_command(CLI::App& app, PrintOptions& options);
CLI::App* add_check_command(CLI::App& app, CheckOptions& options);
CLI::App* add_sample_command(CLI::App& app, SampleOptions& options);
CLI::App* add_doctor_command(CLI::App& app, DoctorOptions& options);
CLI::App* add_status_command(CLI::App& app, StatusOptions& options);
CLI::App* add_control_command(CLI::App& app, ControlOptions& options);
CLI::App* add_simulate_command(CLI::App& app, SimulateOptions& options);
CLI::App* add_setup_command(CLI::App& app, SetupOptions& options);
CLI::App* add_profile_command(CLI::App& app, ProfileOptions& options);

/// Each runs a subcommand. Results go to standard output; progress, warnings and errors to standard error.
/// @param arena_block  the program's static memory
ExitCode run_slice(const SliceOptions& options, std::span<std::byte> arena_block);
ExitCode run_inspect(const InspectOptions& options, std::span<std::byte> arena_block);
ExitCode run_orient(const OrientOptions& options, std::span<std::byte> arena_block);
ExitCode run_print(const PrintOptions& options, std::span<std::byte> arena_block);
ExitCode run_check(const CheckOptions& options, std::span<std::byte> arena_block);
ExitCode run_sample(const SampleOptions& options);
ExitCode run_doctor(const DoctorOptions& options);
ExitCode run_status(const StatusOptions& options);
ExitCode run_control(const ControlOptions& options);
ExitCode run_simulate(const SimulateOptions& options);
ExitCode run_setup(const SetupOptions& options);
ExitCode run_profile(const ProfileOptions& options);

}  // namespace plumbline::firmware
