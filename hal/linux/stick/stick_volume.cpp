#include "hal/linux/stick/stick_volume.hpp"

#include <sys/mount.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

namespace plumbline {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& path) {
  std::string text;
  std::ifstream file(path);
  std::getline(file, text);
  return text;
}

std::uint16_t hexadecimal(const std::string& text) {
  std::uint16_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return number;
}

template <std::size_t Size>
void copy_text(const std::string& text, std::array<char, Size>& to) {
  *std::copy_n(text.data(), std::min(text.size(), Size - 1), to.begin()) = '\0';
}

/// Finds the block devices below a USB device: .../host0/target0:0:0/0:0:0:0/block/sda.
void find_media(const fs::path& folder, int depth, std::vector<fs::path>& media) {
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(folder, problem)) {
    if (!entry.is_directory(problem) || entry.is_symlink(problem)) continue;
    if (folder.filename() == "block") {
      media.push_back(entry.path());
    } else if (depth > 0) {
      find_media(entry.path(), depth - 1, media);
    }
  }
}

bool has_size(const fs::path& block) {
  const std::string sectors = first_line(block / "size");
  return !sectors.empty() && sectors != "0";
}

/// Whether the kernel has looked for partitions. It announces a medium to udev afterwards, and udev records it. Without udev, assume
/// that it has.
bool was_scanned(const fs::path& block, const fs::path& known) {
  const std::string number = first_line(block / "dev");
  std::error_code problem;
  return number.empty() || !fs::exists(known, problem) || fs::exists(known / ("b" + number), problem);
}

/// "/dev/sda1", the kernel's own name.
std::string node_of(const fs::path& block) { return "/dev/" + block.filename().string(); }

}  // namespace

std::string usb_place(unsigned bus, const std::uint8_t* ports, int count) {
  std::string place = std::to_string(bus);
  for (int i = 0; i < count; ++i) {
    place += i == 0 ? '-' : '.';
    place += std::to_string(ports[i]);
  }
  return place;
}

StickIdentity read_identity(const std::string& device) {
  const fs::path folder(device);
  StickIdentity identity;
  identity.vendor_id = hexadecimal(first_line(folder / "idVendor"));
  identity.product_id = hexadecimal(first_line(folder / "idProduct"));
  copy_text(first_line(folder / "manufacturer"), identity.maker);
  copy_text(first_line(folder / "product"), identity.product);
  copy_text(first_line(folder / "serial"), identity.serial);
  return identity;
}

std::vector<std::string> block_devices(const std::string& device, const std::string& udev) {
  constexpr int kDepth =
      6;  // folders between the device and "sda": interface, host, target, LUN, "block", and one to spare
  std::vector<fs::path> media;
  find_media(device, kDepth, media);
  std::sort(media.begin(), media.end());
  std::vector<std::string> nodes;
  for (const auto& medium : media) {
    if (!has_size(medium) || !was_scanned(medium, udev)) continue;
    std::vector<std::pair<int, std::string>> partitions;
    std::error_code problem;
    for (const auto& entry : fs::directory_iterator(medium, problem)) {
      const std::string number = first_line(entry.path() / "partition");
      if (!number.empty() && has_size(entry.path())) partitions.emplace_back(std::stoi(number), node_of(entry.path()));
    }
    std::sort(partitions.begin(), partitions.end());
    for (auto& partition : partitions) nodes.push_back(std::move(partition.second));
    nodes.push_back(node_of(medium));
  }
  return nodes;
}

void unmount_all(const std::string& folder) {
  // Detached, because open files of a pulled stick must not block the next one. Repeated, because mounts can lie on top of each
  // other; one is usual.
  for (int times = 0; times < 8 && ::umount2(folder.c_str(), MNT_DETACH | UMOUNT_NOFOLLOW) == 0; ++times) {
  }
}

Expected<StickVolume> StickVolume::mount(const std::vector<std::string>& nodes, const std::string& folder) {
  struct Kind {
    const char* name;
    const char* options;
  };
  // Everybody may read, nobody may write or execute; names are UTF-8. errors=continue: a read-only mount has nothing to lose.
  constexpr std::array kKinds = {Kind{"vfat", "utf8,fmask=0333,dmask=0222,errors=continue"},
                                 Kind{"exfat", "iocharset=utf8,fmask=0333,dmask=0222,errors=continue"}};
  constexpr unsigned long kFlags = MS_RDONLY | MS_NOSUID | MS_NODEV | MS_NOEXEC;
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) return fail(ErrorCode::kMountFailed, "%s: %s", folder.c_str(), problem.message().c_str());
  unmount_all(folder);
  int reason = 0;
  for (const auto& node : nodes) {
    for (const auto& kind : kKinds) {
      if (::mount(node.c_str(), folder.c_str(), kind.name, kFlags, kind.options) == 0) return StickVolume(folder);
      // EINVAL means another file system, ENODEV an unknown one. Any other error says more.
      if (reason == 0 || (errno != EINVAL && errno != ENODEV)) reason = errno;
    }
  }
  if (nodes.empty()) {
    return fail(ErrorCode::kMountFailed, "the board finds no storage on the stick:\ttry another stick");
  }
  if (reason == EPERM || reason == EACCES) {
    return fail(ErrorCode::kMountFailed, "%s: no permission to mount: run plumblined as a service, see board/README.md",
                nodes.front().c_str());
  }
  return fail(ErrorCode::kMountFailed, "the stick's file system can't be read (%s: %s):\tformat it as FAT32 or exFAT",
              nodes.front().c_str(), std::strerror(reason));
}

StickVolume::StickVolume(StickVolume&& other) noexcept : folder_(std::exchange(other.folder_, std::string())) {}

StickVolume::~StickVolume() {
  if (!folder_.empty()) unmount_all(folder_);
}

}  // namespace plumbline
