#include "hal/stick_port.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace plumbline::inline hal {
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

/// Whether something by that name is in a folder, whatever it is.
bool is_in(int folder, const char* name) {
  struct stat facts {};
  return ::fstatat(folder, name, &facts, AT_SYMLINK_NOFOLLOW) == 0;
}

/// The kind of an entry, as S_IFMT has it; 0: the file system does not say.
mode_t kind_in(const dirent& entry) {
  return entry.d_type == DT_UNKNOWN ? mode_t{0} : static_cast<mode_t>(DTTOIF(entry.d_type));
}

/// Visits a folder of one partition.
/// @param earlier  the same folder of the partitions before it; -1: one has none
/// @returns whether to go on
Expected<bool> visit(DIR* listing, std::span<const int> earlier, StickMount::FileVisitor& visitor, int& reason) {
  const int folder = ::dirfd(listing);
  errno = 0;
  while (const dirent* const entry = ::readdir(listing)) {
    if (entry->d_name[0] == '.') continue;
    const auto wanted = visitor.goes_on();
    PLUMBLINE_TRY(wanted);
    if (!*wanted) return false;
    struct stat facts {};
    facts.st_mode = kind_in(*entry);
    const bool looks = facts.st_mode == 0 || (S_ISREG(facts.st_mode) && visitor.wants_facts(entry->d_name));
    if (looks && ::fstatat(folder, entry->d_name, &facts, AT_SYMLINK_NOFOLLOW) != 0) {
      visitor.on_other(entry->d_name, "unreadable");
    } else if (S_ISREG(facts.st_mode)) {
      const bool hidden = looks && std::any_of(earlier.begin(), earlier.end(),
                                               [&](int other) { return other >= 0 && is_in(other, entry->d_name); });
      visitor.on_file(entry->d_name,
                      {static_cast<std::uint64_t>(facts.st_size), facts.st_mtim.tv_sec, hidden ? earlier.size() : 0});
    } else if (S_ISDIR(facts.st_mode)) {
      visitor.on_folder(entry->d_name);
    } else {
      visitor.on_other(entry->d_name, kind_of(facts.st_mode));
    }
    errno = 0;
  }
  reason = errno;
  return true;
}

/// The partition that a name of path_on_stick() begins with, which is taken off; none: it has none, or one that is not there.
std::optional<std::size_t> take_partition(std::string_view& name, std::size_t count) {
  if (name.size() < 3 || name[1] != ':' || name[0] < '2' || name[0] > '9') return std::nullopt;
  const auto partition = static_cast<std::size_t>(name[0] - '1');
  if (partition >= count) return std::nullopt;
  name.remove_prefix(2);
  return partition;
}

}  // namespace

std::string path_on_stick(std::string_view folder, std::string_view name, std::size_t partition) {
  static_assert(StickParts::kMost < 10, "a digit names a partition");
  std::string path = partition > 0 ? std::to_string(partition + 1) + ":" : std::string();
  if (!folder.empty()) path.append(folder).append("/");
  return path.append(name);
}

void StickParts::close() {
  for (std::size_t i = 0; i < count; ++i) ::close(folders[i]);
  count = 0;
}

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
    : port_(std::exchange(other.port_, nullptr)), parts_(std::exchange(other.parts_, {})) {}

StickMount::~StickMount() {
  parts_.close();
  if (port_ != nullptr) port_->mounted_ = false;
}

/// @returns a descriptor, or -1 with errno set
StickMount::Opened StickMount::open_path(std::string_view name) const {
  const auto only = take_partition(name, parts_.count);
  errno = EACCES;
  if (!stays_inside(name)) return {};
  for (std::size_t p = only.value_or(0);; ++p) {
    const int file = open_below(parts_.folders[p], name);
    const bool missing = file < 0 && (errno == ENOENT || errno == ENOTDIR);
    if (!missing || only || p + 1 == parts_.count) return {file, p};
  }
}

std::string StickMount::name_beside(std::string_view file, std::string_view name) const {
  const Opened there = open_path(file);
  if (there.file >= 0) ::close(there.file);
  if (there.file < 0 || there.partition == 0) return std::string(name);
  const std::string own = path_on_stick({}, name, there.partition);
  const Opened first = open_path(name), beside = open_path(own);
  if (first.file >= 0) ::close(first.file);
  if (beside.file >= 0) ::close(beside.file);
  return beside.file >= 0 && first.partition != there.partition ? own : std::string(name);
}

Expected<StickFile> StickMount::open(std::string_view name) const {
  PLUMBLINE_TRY(port_->check_mounted());
  const int shown = static_cast<int>(std::min<std::size_t>(name.size(), 200));
  std::string_view path = name;
  static_cast<void>(take_partition(path, parts_.count));
  if (!stays_inside(path)) {
    return fail(ErrorCode::kCannotOpen, "%.*s:\tname a file on the stick, without a leading / and without ..", shown,
                name.data());
  }
  const int file = open_path(name).file;
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
  const int file = open_path(name).file;
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
  std::string_view path = folder;
  const auto only = take_partition(path, parts_.count);
  if (!folder.empty() && !stays_inside(path)) return refused(EACCES);
  std::array<int, StickParts::kMost> opened{};
  opened.fill(-1);
  std::size_t listed = 0, unlisted = 0;
  int problem = ENOENT;
  Expected<bool> goes_on = true;
  for (std::size_t p = 0; p < parts_.count && goes_on && *goes_on; ++p) {
    if (only && *only != p) continue;
    // A descriptor of its own: a directory stream moves its descriptor's position and closes it.
    const int again = path.empty() ? ::openat(parts_.folders[p], ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)
                                   : open_below(parts_.folders[p], path);
    int reason = errno;
    opened[p] = again < 0 ? -1 : ::fcntl(again, F_DUPFD_CLOEXEC, 0);
    DIR* const listing = again < 0 ? nullptr : ::fdopendir(again);
    if (listing == nullptr) {
      if (again >= 0) {
        reason = errno;
        ::close(again);
      }
    } else {
      reason = 0;
      goes_on = visit(listing, std::span(opened).first(p), visitor, reason);
      ::closedir(listing);
    }
    if (reason == 0) ++listed;
    if (reason != 0 && reason != ENOENT && reason != ENOTDIR) ++unlisted;
    if (reason != 0 && (problem == ENOENT || problem == ENOTDIR)) problem = reason;
  }
  for (const int file : opened) {
    if (file >= 0) ::close(file);
  }
  PLUMBLINE_TRY(goes_on);
  PLUMBLINE_TRY(port_->check_mounted());
  if (listed == 0) return refused(problem);
  for (std::size_t i = 0; i < unlisted; ++i) visitor.on_unlisted();
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
  const auto parts = do_mount();
  PLUMBLINE_TRY(parts);
  mounted_ = true;
  return StickMount(*this, *parts);
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

}  // namespace plumbline::inline hal
