#pragma once
/// What every subcommand that works on a scan needs besides the scan.

#include <cstddef>
#include <span>
#include <string_view>

#include "firmware/io/job_progress.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/settings/job_options.hpp"
#include "slicer/core/arena.hpp"

namespace plumbline::firmware {

/// A job that runs on a terminal: the memory that it may use, its progress, and its warnings. Ctrl-C cancels it.
class TerminalJob {
 public:
  /// @param setup        of the same options
  /// @param arena_block  the program's static memory, at least setup.arena_bytes
  /// @param whole        what the bar is about; of the subcommand
  TerminalJob(const JobOptions& options, const JobSetup& setup, std::span<std::byte> arena_block,
              const WholeProgress& whole = WholeProgress());

  Arena& arena() { return arena_; }
  JobProgress& progress() { return progress_; }
  bool silent() const { return silent_; }  ///< shows neither progress nor warnings
  void warn(std::string_view sentence);

 private:
  Arena arena_;
  bool silent_;
  ProgressLines lines_;
  JobProgress progress_;
};

}  // namespace plumbline::firmware
