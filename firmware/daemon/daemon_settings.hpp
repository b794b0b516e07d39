#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/daemon/stick/scan_slicing.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// What stays the same for all jobs of the daemon.
struct DaemonSettings {
  BoardFile board;
  MachineFile machine;
  std::string board_path;             ///< the profiles are in profiles/ beside it
  std::vector<std::string> profiles;  ///< names of those
  std::string report_path;            ///< of the last print's report
  std::uint32_t threads = 1;
  std::chrono::nanoseconds slicing_patience = kSlicingPatience;
  std::uint64_t id_seed = 0;  ///< of the ids of jobs and questions: see RandomIds

  /// Reads a profile.
  /// @param name  not a path: a stick must not reach the printer's files; empty: the printer's profile
  /// @retval ErrorCode::kBadSetting  any error of read_print_profile()
  [[nodiscard]] Expected<PrintProfile> profile(const std::string& name) const;
};

}  // namespace plumbline::firmware
