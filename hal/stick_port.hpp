#pragma once
/// The port for USB sticks. Arrivals and departures are events (hal/events.hpp).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/interlock.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

class StickPort;

/// A stick's own description. Texts are truncated to their arrays and end with 0.
struct StickIdentity {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::array<char, 64> maker{};
  std::array<char, 64> product{};
  std::array<char, 64> serial{};
};

/// A report that goes onto a stick: a part of a file of the printer's.
struct StickReport {
  std::string_view name;              ///< on the stick; is_report_name()
  int file = -1;                      ///< descriptor
  std::uint64_t from = 0, bytes = 0;  ///< of that file
};

/// The file systems on a stick that can be read, mounted.
struct StickParts {
  static constexpr std::size_t kMost = 8;
  std::array<int, kMost> folders{};  ///< descriptors of their top folders
  std::size_t count = 0;
  std::size_t unread = 0;  ///< partitions that can't be read, or for which there was no room

  void close();
};

/// What a listing tells of a file.
struct StickFileFacts {
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  ///< s since 1970
  std::size_t partition =
      0;  ///< 0: its path is enough; else a file of an earlier partition has that path, and path_on_stick() tells them apart
};

/// A name for StickMount::open(): "bust.ply", "scans/bust.ply", or "2:bust.ply" if the first partition has a bust.ply, too. No file on FAT or
/// exFAT has a colon in its name.
/// @param folder  as the name of open(), empty: the top folder
std::string path_on_stick(std::string_view folder, std::string_view name, std::size_t partition);

/// The error of a report that does not get onto a stick.
/// @param reason  errno
tl::unexpected<Error> not_stored(int reason);

/// A file on a stick, read once from start to end. Move-only.
/// Read it here and not through its path: a back end can tell a pulled stick from a bad sector.
class StickFile final : public ByteSource {
 public:
  StickFile(StickFile&& other) noexcept;
  StickFile& operator=(StickFile&&) = delete;
  StickFile(const StickFile&) = delete;
  StickFile& operator=(const StickFile&) = delete;
  ~StickFile() override;

  /// @retval ErrorCode::kStickGone   the stick was pulled
  /// @retval ErrorCode::kCannotRead  bad sectors or a damaged file system
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  /// The name passed to StickMount::open().
  std::string_view name() const override { return {name_.data(), name_size_}; }
  std::optional<std::uint64_t> size() const override { return size_; }

  /// A descriptor for another process that reads the file instead of read(). If that process can't read, StickMount::check() says
  /// whether the stick was pulled. Nothing: this back end's files can be read here only.
  std::optional<int> descriptor() const;

 private:
  friend class StickMount;
  StickFile(StickPort& port, int file, std::string_view name, std::uint64_t size);

  StickPort* port_;
  int file_ = -1;
  std::array<char, 256> name_{};
  std::size_t name_size_ = 0;
  std::uint64_t size_ = 0;
};

/// A mounted stick: read-only, nothing on it is executed. Its partitions are seen as one: a path leads to the first of them that has it. The
/// destructor unmounts it; close its files first.
class StickMount {
 public:
  StickMount(StickMount&& other) noexcept;
  StickMount& operator=(StickMount&&) = delete;
  StickMount(const StickMount&) = delete;
  StickMount& operator=(const StickMount&) = delete;
  ~StickMount();

  /// @param name  relative to the stick's top folder, without ".." and symbolic links; of path_on_stick() if partitions share it
  /// @retval ErrorCode::kCannotOpen  no such file, not a regular file, or a forbidden name
  /// @retval ErrorCode::kStickGone, kPowerLost
  [[nodiscard]] Expected<StickFile> open(std::string_view name) const;

  /// Whether the stick is still there.
  /// @retval ErrorCode::kStickGone, kPowerLost
  [[nodiscard]] Status check() const;

  /// Partitions that can't be read: they have another file system, are damaged, or are more than StickParts::kMost.
  std::size_t unread_partitions() const { return parts_.unread; }

  class FileVisitor {
   public:
    virtual ~FileVisitor() = default;
    virtual void on_file(std::string_view name, const StickFileFacts& facts) = 0;
    /// @param what  "a folder", "a symbolic link", "a pipe", ...: it can't be read as a file
    virtual void on_other(std::string_view name, const char* what) = 0;
    /// Called for each partition that has such a folder.
    virtual void on_folder(std::string_view name) { on_other(name, "a folder"); }
    /// A partition whose folder can't be listed to its end, while that of another one can.
    virtual void on_unlisted() {}
    /// Whether on_file() needs the facts: on FAT, looking for a file takes as long as its folder is large.
    virtual bool wants_facts(std::string_view /*name*/) { return true; }
    /// Asked before each entry. @returns whether to go on; an error ends the visit, too
    virtual Expected<bool> goes_on() { return true; }
  };
  /// Visits what is in a folder of all partitions in no particular order, without hidden names. Opens no file.
  /// @param folder  as the name of open(); empty: the stick's top folder
  /// @retval ErrorCode::kCannotRead  also: it is no folder
  /// @retval ErrorCode::kStickGone, kPowerLost, and the errors of goes_on()
  [[nodiscard]] Status for_each_file(FileVisitor& visitor, std::string_view folder = {}) const;
  /// What a file calls `name`: the file or folder of that name on its own partition, if there is one.
  /// @returns a name for open()
  std::string name_beside(std::string_view file, std::string_view name) const;
  /// Whether a name of open() is a folder.
  [[nodiscard]] bool is_folder(std::string_view name) const;

 private:
  friend class StickPort;
  StickMount(StickPort& port, const StickParts& parts) : port_(&port), parts_(parts) {}
  struct Opened {
    int file = -1;
    std::size_t partition = 0;
  };
  Opened open_path(std::string_view name) const;

  StickPort* port_;
  StickParts parts_;
};

/// The port. It serves one stick at a time: a second one is ignored until the first is gone.
class StickPort {
 public:
  StickPort(const StickPort&) = delete;
  StickPort& operator=(const StickPort&) = delete;
  virtual ~StickPort() = default;

  /// Includes a stick that was plugged in before the firmware started, for which there is no event.
  bool has_stick() const { return do_has_stick(); }

  /// @retval ErrorCode::kNoStick, kPowerLost
  [[nodiscard]] Expected<StickIdentity> identity() const;

  /// @retval ErrorCode::kNoStick
  /// @retval ErrorCode::kMountFailed  no partition, or its file system is unknown or damaged
  /// @retval ErrorCode::kBusy         it is already mounted
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<StickMount> mount();

  /// Copies a report into the stick's folder kReportFolder. The stick is writable only for that moment; afterwards it may be pulled.
  /// Overwrites nothing.
  /// @returns false if a file of that name is there already
  /// @retval ErrorCode::kNoStick, kMountFailed, kPowerLost
  /// @retval ErrorCode::kBusy         it is mounted
  /// @retval ErrorCode::kCannotWrite  it has no such folder, is full or write-protected, was pulled, or its file system is damaged
  [[nodiscard]] Expected<bool> store(const StickReport& report);

 protected:
  explicit StickPort(Interlock& interlock) : interlock_(interlock) {}

 private:
  friend class StickFile;
  friend class StickMount;

  Status check_mounted() const;

  virtual bool do_has_stick() const = 0;
  virtual Expected<StickIdentity> do_identity() const = 0;
  /// Mounts the stick's partitions, at least one. Closing the last file of each unmounts it
  virtual Expected<StickParts> do_mount() = 0;
  virtual Expected<bool> do_store(const StickReport& report) = 0;
  /// Reads like read(2), with the errors of StickFile::read().
  virtual Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) = 0;
  /// @retval ErrorCode::kStickGone  the mounted stick was pulled, even if another one was plugged in since
  virtual Status do_check_mounted() const = 0;
  /// Whether a stick's files are files of the operating system, which any process can read.
  virtual bool do_has_real_files() const = 0;

  Interlock& interlock_;
  bool mounted_ = false;
};

}  // namespace plumbline::inline hal
