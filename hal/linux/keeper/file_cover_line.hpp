#pragma once
/// A cover switch played by a FIFO, for simulation and tests.

#include <string>

#include "hal/linux/keeper/cover_line.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Closed at first. Each byte that arrives is a change: 'o' opens, 'c' closes.
class FileCoverLine final : public CoverLine {
 public:
  /// @param path  of an existing FIFO; ok() says whether it could be opened
  explicit FileCoverLine(const std::string& path);
  ~FileCoverLine() override;

  bool ok() const { return file_ >= 0; }
  bool open() const noexcept override { return open_; }
  std::optional<Edge> next_edge() noexcept override;
  int descriptor() const override { return file_; }

 private:
  int file_ = -1;
  bool open_ = false;
};

}  // namespace plumbline::inline hal::inline linux_board
