#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/pictures/png.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Writes what a simulated screen shows into a folder: screen.png is the newest frame, and 00001.png, 00002.png, ... the first kMostFrames.
class ScreenFolder {
 public:
  static constexpr std::uint32_t kMostFrames = 2000;

  /// Makes the folder if it is missing.
  /// @retval ErrorCode::kCannotOpen  it can't be made: the reason
  [[nodiscard]] static Expected<std::unique_ptr<ScreenFolder>> open(const std::string& folder, std::uint32_t columns,
                                                                    std::uint32_t rows);

  /// @param pixels  RGB565, columns * rows. A frame that can't be written is left out: nothing depends on it
  void write(std::uint32_t columns, std::uint32_t rows, std::span<const std::uint16_t> pixels);

 private:
  ScreenFolder(std::string folder, PictureEncoder encoder) : folder_(std::move(folder)), encoder_(std::move(encoder)) {}

  std::string folder_;
  PictureEncoder encoder_;
  std::vector<std::uint8_t> rgb_;
  std::uint32_t frames_ = 0;
};

}  // namespace plumbline::firmware
