#pragma once
/// What a program returns to its shell.

#include <cstdint>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

enum class ExitCode : std::uint8_t {
  kDone = 0,
  kWorldError = 1,     ///< a file, a medium, an object: standard error has the sentence
  kUsageError = 2,     ///< the command line
  kInterrupted = 130,  ///< SIGINT or SIGTERM; the shells' 128 + SIGINT
};

/// Prints the error's message to standard error. @returns kInterrupted for kCancelled, else kWorldError
ExitCode report_error(const Error& error);

}  // namespace plumbline::firmware
