#include "firmware/machine/screen_folder.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "firmware/canvas/canvas.hpp"
#include "firmware/io/output_file.hpp"

namespace plumbline::firmware {

Expected<std::unique_ptr<ScreenFolder>> ScreenFolder::open(const std::string& folder, std::uint32_t columns,
                                                           std::uint32_t rows) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) {
    return fail(ErrorCode::kCannotOpen, "%s: the folder for the screen can't be made (%s).\tName another one",
                folder.c_str(), problem.message().c_str());
  }
  auto encoder = PictureEncoder::create(picture_bytes(columns, rows));
  PLUMBLINE_TRY(encoder);
  return std::unique_ptr<ScreenFolder>(new ScreenFolder(folder, std::move(*encoder)));
}

void ScreenFolder::write(std::uint32_t columns, std::uint32_t rows, std::span<const std::uint16_t> pixels) {
  rgb_.clear();
  for (const std::uint16_t pixel : pixels) {
    rgb_.insert(rgb_.end(), {red_of(pixel), green_of(pixel), blue_of(pixel)});
  }
  const auto file = encoder_.encode(rgb_, columns, rows);
  // Whoever watches screen.png never sees half of one.
  const std::string newest = folder_ + "/screen.png", part = newest + ".part";
  if (write_file(part.c_str(), file)) static_cast<void>(std::rename(part.c_str(), newest.c_str()));
  if (frames_ >= kMostFrames) return;
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "/%05u.png", ++frames_);
  static_cast<void>(write_file((folder_ + name.data()).c_str(), file));
}

}  // namespace plumbline::firmware
