#include "firmware/slice/job_directory.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

namespace plumbline::firmware {
namespace {

constexpr const char* kLayers = "layers";
/// In the order of JobPicture.
constexpr std::array kPictures = {"preview.png", "coverage.png", "issues.png", "comparison.png"};
constexpr const char* kManifest = "manifest.json";
constexpr const char* kNewManifest = "manifest.json.part";

/// The start of every manifest of plumbline. Other programs also write files named manifest.json.
constexpr std::string_view kManifestStart = "{\n  \"plumbline\":";

bool is_picture(std::string_view name) {
  return std::find(kPictures.begin(), kPictures.end(), name) != kPictures.end();
}

/// The number in "00042.png".
std::optional<std::uint32_t> layer_number(std::string_view name) {
  constexpr std::size_t kDigits = 5;
  if (name.size() != kDigits + 4 || name.substr(kDigits) != ".png") return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : name.substr(0, kDigits)) {
    if (c < '0' || c > '9') return std::nullopt;
    number = number * 10 + static_cast<std::uint32_t>(c - '0');
  }
  return number;
}

bool is_our_manifest(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return false;
  std::array<char, kManifestStart.size()> start = {};
  const ssize_t got = ::read(file, start.data(), start.size());
  ::close(file);
  return got == static_cast<ssize_t>(start.size()) && std::string_view(start.data(), start.size()) == kManifestStart;
}

std::uint64_t bytes_on_disk(const char* path) {
  struct stat status = {};
  constexpr std::uint64_t kBlock = 512;  // of st_blocks
  return ::lstat(path, &status) == 0 ? kBlock * static_cast<std::uint64_t>(status.st_blocks) : 0;
}

struct CloseDirectory {
  void operator()(DIR* directory) const { ::closedir(directory); }
};

/// Calls `visit(name)` for each entry but "." and "..", until it returns an error.
template <class Visit>
Status for_each_entry(const char* path, Visit visit) {
  const std::unique_ptr<DIR, CloseDirectory> directory(::opendir(path));
  if (!directory) return fail(ErrorCode::kCannotOpen, "%s: cannot be listed: %s", path, std::strerror(errno));
  while (const dirent* entry = ::readdir(directory.get())) {
    const std::string_view name = entry->d_name;
    if (name == "." || name == "..") continue;
    PLUMBLINE_TRY(visit(entry->d_name));
  }
  return {};
}

/// @returns whether the folder was missing and is there now
Expected<bool> make_folder(const char* path) {
  constexpr mode_t kMode = 0777;  // less the user's umask
  if (::mkdir(path, kMode) == 0) return true;
  const int reason = errno;
  struct stat status = {};
  if (::stat(path, &status) == 0) {
    if (S_ISDIR(status.st_mode)) return false;
    return fail(ErrorCode::kCannotOpen, "%s: is a file, not a folder.\tChoose another output folder", path);
  }
  return fail(ErrorCode::kCannotOpen, "%s: the folder cannot be created: %s.\tChoose another output folder", path,
              std::strerror(reason));
}

}  // namespace

Expected<JobDirectory> JobDirectory::open(const std::string& path) {
  JobDirectory directory;
  directory.path_.add("%s", path.c_str());
  constexpr std::size_t kLongestName = 32;
  if (path.empty() || path.size() + kLongestName > kMaxPath) {
    return fail(ErrorCode::kCannotOpen, "the output folder's path has %zu characters; 1 to %zu are allowed",
                path.size(), kMaxPath - kLongestName);
  }
  PLUMBLINE_TRY(directory.create_folders());
  directory.lock_ = ::open(directory.path(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory.lock_ < 0) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be opened: %s", directory.path(), std::strerror(errno));
  }
  // A file system without locks is accepted: the lock only guards against accidents.
  if (::flock(directory.lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return fail(ErrorCode::kCannotWrite,
                "%s: another plumbline is writing there.\tWait for it, or choose another folder", directory.path());
  }
  PLUMBLINE_TRY(directory.inspect());
  const auto layers = make_folder(directory.file_path(kLayers).c_str());
  PLUMBLINE_TRY(layers);
  directory.created_layers_ = *layers;
  for (const char* folder : {directory.path(), directory.file_path(kLayers).c_str()}) {
    if (::access(folder, W_OK | X_OK) != 0) {
      return fail(ErrorCode::kCannotOpen, "%s: cannot be written to: %s.\tChoose another output folder", folder,
                  std::strerror(errno));
    }
  }
  return directory;
}

JobDirectory::JobDirectory(JobDirectory&& other) noexcept
    : path_(other.path_),
      lock_(std::exchange(other.lock_, -1)),
      created_(std::exchange(other.created_, false)),
      created_layers_(std::exchange(other.created_layers_, false)),
      begun_(other.begun_),
      older_end_(other.older_end_),
      older_bytes_(other.older_bytes_),
      written_end_(other.written_end_) {}

JobDirectory::~JobDirectory() {
  if (!begun_) {
    if (created_layers_) ::rmdir(file_path(kLayers).c_str());
    if (created_) ::rmdir(path());
  }
  if (lock_ >= 0) ::close(lock_);
}

Status JobDirectory::create_folders() {
  const std::string_view whole = path_.view();
  for (std::size_t end = 1; end <= whole.size(); ++end) {
    if (end < whole.size() && whole[end] != '/') continue;
    FixedPath part;
    part.add("%.*s", static_cast<int>(end), whole.data());
    const auto made = make_folder(part.c_str());
    PLUMBLINE_TRY(made);
    created_ = *made;
  }
  return {};
}

Status JobDirectory::inspect() {
  const bool has_manifest = is_our_manifest(file_path(kManifest).c_str());
  PLUMBLINE_TRY(for_each_entry(path(), [&](const char* name) -> Status {
    const std::string_view entry = name;
    if (is_picture(entry)) older_bytes_ += bytes_on_disk(file_path(name).c_str());
    if (has_manifest || entry == kLayers || entry == kNewManifest || is_picture(entry)) return {};
    return fail(
        ErrorCode::kCannotWrite,
        "%s: holds '%s', which plumbline did not write; nothing was changed. Choose a new or an empty output folder",
        path(), name);
  }));
  return inspect_layers();
}

Status JobDirectory::inspect_layers() {
  const FixedPath layers = file_path(kLayers);
  struct stat status = {};
  if (::lstat(layers.c_str(), &status) != 0) {
    if (errno == ENOENT) return {};
    return fail(ErrorCode::kCannotOpen, "%s: %s", layers.c_str(), std::strerror(errno));
  }
  if (!S_ISDIR(status.st_mode)) {
    return fail(ErrorCode::kCannotWrite,
                "%s: is not a folder; nothing was changed.\tChoose a new or an empty output folder", layers.c_str());
  }
  return for_each_entry(layers.c_str(), [&](const char* name) -> Status {
    if (const auto layer = layer_number(name)) {
      older_end_ = std::max(older_end_, *layer + 1);
      older_bytes_ += bytes_on_disk(layer_path(*layer).c_str());
      return {};
    }
    return fail(ErrorCode::kCannotWrite,
                "%s: holds '%s', which is not a layer; nothing was changed.\tChoose a new or an empty output folder",
                layers.c_str(), name);
  });
}

Status JobDirectory::check_room(const char* what, std::uint64_t bytes) const {
  struct statvfs room = {};
  if (::fstatvfs(lock_, &room) != 0) return {};  // a file system that does not say is found full when it is
  const std::uint64_t free = std::uint64_t{room.f_bavail} * room.f_frsize + older_bytes_;
  if (bytes <= free) return {};
  constexpr double kMb = 1e6;
  return fail(ErrorCode::kCannotWrite,
              "%s: %s needs some %.1f MB, %.1f MB are free.\tMake room there, or choose another folder", path(), what,
              static_cast<double>(bytes) / kMb, static_cast<double>(free) / kMb);
}

Status JobDirectory::begin() {
  begun_ = true;
  PLUMBLINE_TRY(remove_file(kManifest));
  for (const char* picture : kPictures) PLUMBLINE_TRY(remove_file(picture));
  return {};
}

Status JobDirectory::write_layer(std::uint32_t layer, std::span<const std::byte> png) {
  written_end_ = std::max(written_end_, layer + 1);
  return write_file(layer_path(layer).c_str(), png);
}

const char* JobDirectory::name(JobPicture picture) { return kPictures[static_cast<std::size_t>(picture)]; }

Status JobDirectory::write_picture(JobPicture picture, std::span<const std::byte> png) {
  return write_file(file_path(name(picture)).c_str(), png);
}

Expected<OutputFile> JobDirectory::create_manifest() { return OutputFile::create(file_path(kNewManifest).c_str()); }

Status JobDirectory::finish(OutputFile& manifest) {
  PLUMBLINE_TRY(manifest.close());
  PLUMBLINE_TRY(remove_layers(written_end_));
  const FixedPath name = file_path(kManifest);
  if (::rename(file_path(kNewManifest).c_str(), name.c_str()) != 0) {
    return fail(ErrorCode::kCannotWrite, "%s: cannot be written: %s", name.c_str(), std::strerror(errno));
  }
  return {};
}

void JobDirectory::discard() {
  if (!begun_) return;
  // Runs after an error, which is the one to report. What can't be removed stays.
  for (const char* name : {kManifest, kNewManifest}) static_cast<void>(remove_file(name));
  for (const char* name : kPictures) static_cast<void>(remove_file(name));
  static_cast<void>(remove_layers(0));
  if (created_layers_) ::rmdir(file_path(kLayers).c_str());
  if (created_) ::rmdir(path());
}

Status JobDirectory::remove_file(const char* name) {
  const FixedPath file = file_path(name);
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) {
    return fail(ErrorCode::kCannotWrite, "%s: cannot be removed: %s", file.c_str(), std::strerror(errno));
  }
  return {};
}

/// Removes by number: listing the folder would take memory from the heap.
Status JobDirectory::remove_layers(std::uint32_t from) {
  const std::uint32_t end = std::max(older_end_, written_end_);
  for (std::uint32_t layer = from; layer < end; ++layer) {
    const FixedPath file = layer_path(layer);
    if (::unlink(file.c_str()) != 0 && errno != ENOENT) {
      return fail(ErrorCode::kCannotWrite, "%s: cannot be removed: %s", file.c_str(), std::strerror(errno));
    }
  }
  return {};
}

FixedPath JobDirectory::file_path(const char* name) const {
  FixedPath file;
  file.add("%s/%s", path(), name);
  return file;
}

FixedPath JobDirectory::layer_path(std::uint32_t layer) const {
  FixedPath file;
  file.add("%s/%s/%05u.png", path(), kLayers, layer);
  return file;
}

}  // namespace plumbline::firmware
