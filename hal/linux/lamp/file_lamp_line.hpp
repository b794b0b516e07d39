#pragma once
/// A lamp's line that is a file: for simulation and tests.

#include <string>

#include "hal/linux/lamp/lamp_line.hpp"

namespace plumbline {

/// Appends a line of text for each change: "on 123456789" or "off 123456789", CLOCK_MONOTONIC in ns.
class FileLampLine final : public LampLine {
 public:
  /// @param path  created where it is missing; ok() tells whether it could be
  explicit FileLampLine(const std::string& path);
  ~FileLampLine() override;

  bool ok() const { return file_ >= 0; }
  bool set(bool lit) noexcept override;

 private:
  int file_ = -1;
  bool lit_ = false;
};

}  // namespace plumbline
