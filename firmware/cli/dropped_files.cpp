#include "firmware/cli/dropped_files.hpp"

#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

namespace plumbline::firmware {
namespace fs = std::filesystem;

DroppedFiles::DroppedFiles(std::string folder, std::string link) : folder_(std::move(folder)), link_(std::move(link)) {
  pull();
}

std::optional<std::uint64_t> DroppedFiles::signature() const {
  std::uint64_t sum = 0;
  bool any = false;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unknown;
    const auto size = static_cast<std::uint64_t>(entry->file_size(unknown));
    const auto time = static_cast<std::uint64_t>(entry->last_write_time(unknown).time_since_epoch().count());
    const std::uint64_t name = std::hash<std::string>()(entry->path().filename().string());
    // A sum does not depend on the order of the folder.
    sum += (name * 31 + size) * 31 + time;
    any = true;
  }
  return any ? std::optional(sum) : std::nullopt;
}

void DroppedFiles::plug() {
  std::error_code ignored;
  fs::create_directory_symlink(folder_, link_, ignored);
}

void DroppedFiles::pull() {
  std::error_code ignored;
  if (fs::is_symlink(link_, ignored)) fs::remove(link_, ignored);
  plugged_.reset();
}

void DroppedFiles::look(bool reading) {
  const auto now = signature();
  const bool settled = now == std::exchange(seen_, now);
  if (!settled || reading || now == plugged_) return;
  if (plugged_) return pull();  // the next look plugs it in, when the printer has noticed
  plug();
  plugged_ = now;
}

}  // namespace plumbline::firmware
