#include "hal/linux/stick/stick_volume.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <utility>

#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline::inline hal::inline linux_board {
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

/// Whether it has room for a file system. An extended partition, which only holds others, has two sectors.
bool has_size(const fs::path& block) {
  const std::string sectors = first_line(block / "size");
  return !sectors.empty() && sectors != "0" && sectors != "1" && sectors != "2";
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

struct Reply {
  int folder = -1;        ///< a descriptor
  bool answered = false;  ///< whether `reason` is the kernel's for not mounting
  int reason = 0;         ///< errno
};

/// @param descriptors  for plumbline-mount
Reply ask_to_mount(std::span<const std::byte> request, std::span<const int> descriptors, const std::string& socket) {
  const int connection = connect_to_mount(socket);
  if (connection < 0) return {.reason = errno};
  Reply reply;
  std::optional<ReceivedMessage> received;
  int result = 0;
  if (send_message(connection, request, descriptors)) {
    received = receive_message(connection, std::as_writable_bytes(std::span(&result, 1)));
  }
  if (received && received->bytes == sizeof result) {
    const auto folder = received->descriptors();
    reply = {folder.empty() ? -1 : folder[0], true, result};
  } else {
    reply.reason = received ? ECONNRESET : errno;
  }
  ::close(connection);
  return reply;
}

/// "sda1" of "/dev/sda1".
std::string_view device_of(std::string_view node) { return node.substr(node.rfind('/') + 1); }

/// Whether one node is a partition of another one, a medium: "/dev/sda1" and "/dev/sda".
bool is_part_of(std::string_view node, std::string_view medium) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return node.size() > medium.size() && node.starts_with(medium) && is_digit(node[medium.size()]) &&
         !is_digit(medium.back());
}

/// EINVAL means another file system, ENODEV an unknown one. Any other error says more.
bool says_more(int reason) { return reason != EINVAL && reason != ENODEV; }

tl::unexpected<Error> no_storage() {
  return fail(ErrorCode::kMountFailed, "the board finds no storage on the stick:\ttry another stick");
}
tl::unexpected<Error> no_answer(int reason) {
  return fail(ErrorCode::kMountFailed, "plumbline-mount does not answer (%s):\tstart plumbline-mount.service",
              std::strerror(reason));
}

}  // namespace

int connect_to_mount(const std::string& socket) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  if (socket.size() >= sizeof to.sun_path) {
    errno = ENAMETOOLONG;
    return -1;
  }
  std::copy(socket.begin(), socket.end(), to.sun_path);
  const int connection = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  // The kernel gives a stick that does not answer 30 s, perhaps twice.
  timeval patience{};
  patience.tv_sec = 70;
  if (connection < 0 || ::setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      ::connect(connection, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    const int reason = errno;
    if (connection >= 0) ::close(connection);
    errno = reason;
    return -1;
  }
  return connection;
}

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

Expected<StickParts> mount_stick(const std::vector<std::string>& nodes, const std::string& socket) {
  if (nodes.empty()) return no_storage();
  StickParts parts;
  std::array<std::string_view, StickParts::kMost> mounted;
  int reason = 0;
  for (const std::string& node : nodes) {
    const auto is_part = [&node](std::string_view other) { return is_part_of(other, node); };
    const auto count = static_cast<std::size_t>(std::count_if(nodes.begin(), nodes.end(), is_part));
    if (std::any_of(mounted.begin(), mounted.begin() + parts.count, is_part))
      continue;  // a medium is in its partitions
    if (parts.count == StickParts::kMost) {
      ++parts.unread;
      continue;
    }
    const Reply reply = ask_to_mount(std::as_bytes(std::span(device_of(node))), {}, socket);
    if (!reply.answered) {
      parts.close();
      return no_answer(reply.reason);
    }
    if (reply.folder >= 0) {
      mounted[parts.count] = node;
      parts.folders[parts.count++] = reply.folder;
      parts.unread -= count;  // what seemed to be its partitions was the file system's own
      continue;
    }
    parts.unread += count == 0 ? 1 : 0;
    if (reason == 0 || says_more(reply.reason)) reason = reply.reason;
  }
  if (parts.count > 0) return parts;
  return fail(ErrorCode::kMountFailed, "the stick's file system can't be read (%s: %s):\tformat it as FAT32 or exFAT",
              nodes.front().c_str(), std::strerror(reason));
}

Expected<bool> store_on_stick(const std::vector<std::string>& nodes, const StickReport& report,
                              const std::string& socket) {
  if (nodes.empty()) return no_storage();
  ReportRequest request;
  request.from = report.from;
  request.bytes = report.bytes;
  report.name.copy(request.name.data(), request.name.size() - 1);
  int reason = 0;
  for (const auto& node : nodes) {
    request.device.fill('\0');
    device_of(node).copy(request.device.data(), request.device.size() - 1);
    const Reply reply = ask_to_mount(std::as_bytes(std::span(&request, 1)), {&report.file, 1}, socket);
    if (!reply.answered) return no_answer(reply.reason);
    if (reply.reason == 0) return true;
    if (reply.reason == EEXIST) return false;
    // A partition without the folder says nothing of one that has it and is full.
    const bool lacks_folder = reply.reason == ENOENT && says_more(reason);
    if (reason == 0 || (says_more(reply.reason) && !lacks_folder)) reason = reply.reason;
  }
  return not_stored(reason);
}

}  // namespace plumbline::inline hal::inline linux_board
