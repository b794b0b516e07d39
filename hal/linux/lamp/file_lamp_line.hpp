#pragma once
/// A lamp line played by a file, for simulation and tests.

#include <string>

#include "hal/linux/lamp/lamp_line.hpp"

namespace plumbline {

/// Appends a line of text for each change: "on 123456789" or "off 123456789", with CLOCK_MONOTONIC in ns.
class FileLampLine final : public LampLine {
 public:
  /// @param path  created if it is missing; ok() says whether it could be opened
  explicit FileLampLine(const std::string& path);
  ~FileLampLine() override;

  bool ok() const { return file_ >= 0; }
  bool set(bool lit) noexcept override;

 private:
  int file_ = -1;
  bool lit_ = false;
};

}  // namespace plumbline
