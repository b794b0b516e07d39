#include "hal/stick_port.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline {
namespace {

/// Whether a name is relative and can't leave its folder.
bool stays_inside(std::string_view name) {
  if (name.empty() || name.front() == '/' || name.find('\0') != std::string_view::npos) return false;
  while (!name.empty()) {
    const auto part = name.substr(0, name.find('/'));
    if (part == "..") return false;
    name.remove_prefix(std::min(name.size(), part.size() + 1));
  }
  return true;
}

/// What stands in a folder instead of a file.
const char* kind_of(mode_t mode) {
  switch (mode & S_IFMT) {
    case S_IFDIR: return "a folder";
    case S_IFLNK: return "a symbolic link";
    case S_IFIFO: return "a pipe";
    case S_IFSOCK: return "a socket";
    case S_IFBLK:
    case S_IFCHR: return "a device";
    default: return "not a file";
  }
}

/// Opens folder by folder, to refuse a symbolic link anywhere in the path: O_NOFOLLOW checks only the last part.
/// @returns the descriptor, or -1 with errno set
int open_below(int folder, std::string_view name) {
  std::array<char, 256> part{};
  int at = ::dup(folder);
  while (at >= 0) {
    const auto length = std::min(name.find('/'), name.size());
    const bool last = length == name.size();
    if (length >= part.size()) {
      ::close(at);
      errno = ENAMETOOLONG;
      return -1;
    }
    std::copy_n(name.data(), length, part.begin());
    part[length] = '\0';
    name.remove_prefix(last ? length : length + 1);
    // O_NONBLOCK: otherwise opening a FIFO would wait for its writer.
    const int flags = O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | (last ? 0 : O_DIRECTORY);
    const int next = ::openat(at, length == 0 ? "." : part.data(), flags);
    const int reason = errno;
    ::close(at);
    errno = reason;
    if (last || next < 0) return next;
    at = next;
  }
  return -1;
}

}  // namespace

StickFile::StickFile(StickPort& port, int file, std::string_view name, std::uint64_t size)
    : port_(&port), file_(file), name_size_(std::min(name.size(), name_.size())), size_(size) {
  std::copy_n(name.data(), name_size_, name_.begin());
}

StickFile::StickFile(StickFile&& other) noexcept
    : port_(other.port_),
      file_(std::exchange(other.file_, -1)),
      name_(other.name_),
      name_size_(other.name_size_),
      size_(other.size_) {}

StickFile::~StickFile() {
  if (file_ >= 0) ::close(file_);
}

Expected<std::size_t> StickFile::read(std::span<std::byte> buffer) {
  PLUMBLINE_TRY(port_->interlock_.check_power());
  auto got = port_->do_read(file_, buffer);
  if (!got) return tl::unexpected<Error>(got.error().with_prefix(name()));
  return got;
}

std::optional<int> StickFile::descriptor() const {
  return port_->do_has_real_files() ? std::optional(file_) : std::nullopt;
}

StickMount::StickMount(StickMount&& other) noexcept
    : port_(std::exchange(other.port_, nullptr)), folder_(std::exchange(other.folder_, -1)) {}

StickMount::~StickMount() {
  if (folder_ >= 0) ::close(folder_);
  if (port_ != nullptr) port_->mounted_ = false;
}

Expected<StickFile> StickMount::open(std::string_view name) const {
  PLUMBLINE_TRY(port_->check_mounted());
  const int shown = static_cast<int>(std::min<std::size_t>(name.size(), 200));
  if (!stays_inside(name)) {
    return fail(ErrorCode::kCannotOpen, "%.*s:\tname a file on the stick, without a leading / and without ..", shown,
                name.data());
  }
  const int file = open_below(folder_, name);
  struct stat facts {};
  if (file < 0 || ::fstat(file, &facts) != 0) {
    const int reason = errno;
    if (file >= 0) ::close(file);
    PLUMBLINE_TRY(port_->check_mounted());
    // The errors of O_NOFOLLOW, of a socket, or of a device without a driver would mean nothing to a user.
    const char* const why = reason == ELOOP   ? "a symbolic link, which could lead off the stick"
                            : reason == ENXIO ? "a device or a socket, not a file"
                                              : std::strerror(reason);
    return fail(ErrorCode::kCannotOpen, "%.*s: %s", shown, name.data(), why);
  }
  if (!S_ISREG(facts.st_mode)) {
    ::close(file);
    return fail(ErrorCode::kCannotOpen, "%.*s: %s, not a file", shown, name.data(), kind_of(facts.st_mode));
  }
  return StickFile(*port_, file, name, static_cast<std::uint64_t>(facts.st_size));
}

Status StickMount::check() const { return port_->check_mounted(); }

bool StickMount::is_folder(std::string_view name) const {
  const int file = stays_inside(name) ? open_below(folder_, name) : -1;
  struct stat facts {};
  const bool folder = file >= 0 && ::fstat(file, &facts) == 0 && S_ISDIR(facts.st_mode);
  if (file >= 0) ::close(file);
  return folder;
}

Status StickMount::for_each_file(FileVisitor& visitor, std::string_view folder) const {
  PLUMBLINE_TRY(port_->check_mounted());
  const auto refused = [folder](int reason) {
    if (folder.empty()) {
      return fail(ErrorCode::kCannotRead, "the stick's files can't be listed: %s", std::strerror(reason));
    }
    const int shown = static_cast<int>(std::min<std::size_t>(folder.size(), 200));
    return fail(ErrorCode::kCannotRead, "%.*s: its files can't be listed: %s", shown, folder.data(),
                std::strerror(reason));
  };
  if (!folder.empty() && !stays_inside(folder)) return refused(EACCES);
  // A descriptor of its own: a directory stream moves its descriptor's position and closes it.
  const int again =
      folder.empty() ? ::openat(folder_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : open_below(folder_, folder);
  DIR* const listing = again < 0 ? nullptr : ::fdopendir(again);
  if (listing == nullptr) {
    const int reason = errno;
    if (again >= 0) ::close(again);
    PLUMBLINE_TRY(port_->check_mounted());
    return refused(reason);
  }
  errno = 0;
  while (const dirent* const entry = ::readdir(listing)) {
    struct stat facts {};
    if (entry->d_name[0] != '.') {
      if (::fstatat(again, entry->d_name, &facts, AT_SYMLINK_NOFOLLOW) != 0) {
        visitor.on_other(entry->d_name, "unreadable");
      } else if (S_ISREG(facts.st_mode)) {
        visitor.on_file(entry->d_name, static_cast<std::uint64_t>(facts.st_size));
      } else if (S_ISDIR(facts.st_mode)) {
        visitor.on_folder(entry->d_name);
      } else {
        visitor.on_other(entry->d_name, kind_of(facts.st_mode));
      }
    }
    errno = 0;
  }
  const int reason = errno;
  ::closedir(listing);
  PLUMBLINE_TRY(port_->check_mounted());
  if (reason != 0) return refused(reason);
  return {};
}

Expected<StickIdentity> StickPort::identity() const {
  PLUMBLINE_TRY(interlock_.check_power());
  return do_identity();
}

Status StickPort::check_mounted() const {
  PLUMBLINE_TRY(interlock_.check_power());
  return do_check_mounted();
}

Expected<StickMount> StickPort::mount() {
  PLUMBLINE_TRY(interlock_.check_power());
  if (mounted_) return fail(ErrorCode::kBusy, "the stick is already mounted");
  const auto folder = do_mount();
  PLUMBLINE_TRY(folder);
  mounted_ = true;
  return StickMount(*this, *folder);
}

Expected<bool> StickPort::store(const StickReport& report) {
  PLUMBLINE_TRY(interlock_.check_power());
  if (mounted_) return fail(ErrorCode::kBusy, "the stick is mounted");
  return do_store(report);
}

tl::unexpected<Error> not_stored(int reason) {
  const char* const why = reason == ENOSPC                      ? "it is full"
                          : reason == EROFS || reason == EACCES ? "it is write-protected"
                          : reason == ENOENT                    ? "it has no folder plumbline-reports"
                                                                : std::strerror(reason);
  return fail(ErrorCode::kCannotWrite,
              "the report can't be written to the stick: %s.\tUse another stick, or ask for the report "
              "on the printer's page",
              why);
}

}  // namespace plumbline
