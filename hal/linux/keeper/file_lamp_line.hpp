#pragma once
/// A lamp line played by a file, for simulation and tests.

#include <string>

#include "hal/linux/keeper/lamp_line.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Appends a line of text for each change: "on 123456789" or "off 123456789", with CLOCK_MONOTONIC in ns.
///
/// As on a GPIO chip, one process holds it at a time, and a line that was released lit stays lit until somebody takes it.
class FileLampLine final : public LampLine {
 public:
  /// @param path  created if it is missing; ok() says whether it could be opened and nobody else holds it
  explicit FileLampLine(const std::string& path);
  ~FileLampLine() override;

  bool ok() const { return file_ >= 0; }
  bool set(bool lit) noexcept override;

 private:
  /// Whether the last change in the file is "on".
  bool was_left_lit() const;

  int file_ = -1;
  bool lit_ = false;
};

}  // namespace plumbline::inline hal::inline linux_board
