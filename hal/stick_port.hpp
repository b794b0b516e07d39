#pragma once
/// The port that USB sticks are plugged into. Arrival and departure are events (hal/events.hpp).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/interlock.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class StickPort;

/// Who a stick says it is. Texts are cut to their arrays and end with 0.
struct StickIdentity {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::array<char, 64> maker{};
  std::array<char, 64> product{};
  std::array<char, 64> serial{};
};

/// A file on a stick, read once from start to end. Move-only.
class StickFile final : public ByteSource {
 public:
  StickFile(StickFile&& other) noexcept;
  StickFile& operator=(StickFile&&) = delete;
  StickFile(const StickFile&) = delete;
  StickFile& operator=(const StickFile&) = delete;
  ~StickFile() override;

  /// @retval ErrorCode::kStickGone   the stick was pulled
  /// @retval ErrorCode::kCannotRead  bad sectors, a damaged file system
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  /// The name it was opened with.
  std::string_view name() const override { return {name_.data(), name_size_}; }
  std::optional<std::uint64_t> size() const override { return size_; }

 private:
  friend class StickMount;
  StickFile(StickPort& port, int file, std::string_view name, std::uint64_t size);

  StickPort* port_;
  int file_ = -1;
  std::array<char, 256> name_{};
  std::size_t name_size_ = 0;
  std::uint64_t size_ = 0;
};

/// A stick that is mounted: read-only, and nothing on it is run or believed. Unmounts when it ends; its files end before it.
class StickMount {
 public:
  static constexpr std::size_t kMaxPath = 1024;  ///< bytes of a mount point, terminator included

  StickMount(StickMount&& other) noexcept;
  StickMount& operator=(StickMount&&) = delete;
  StickMount(const StickMount&) = delete;
  StickMount& operator=(const StickMount&) = delete;
  ~StickMount();

  /// Where it is mounted, for messages.
  std::string_view path() const { return path_.data(); }

  /// @param name  below the mount point; neither absolute, nor with "..", nor through a symbolic link
  /// @retval ErrorCode::kCannotOpen  no such file, not a plain one, or a name as above
  /// @retval ErrorCode::kStickGone, kPowerLost
  [[nodiscard]] Expected<StickFile> open(std::string_view name) const;

  /// Hears of the plain files in the stick's top folder, hidden ones left out, in no order.
  class FileVisitor {
   public:
    virtual ~FileVisitor() = default;
    virtual void file(std::string_view name, std::uint64_t bytes) = 0;
  };
  /// @retval ErrorCode::kCannotRead, kStickGone, kPowerLost
  [[nodiscard]] Status for_each_file(FileVisitor& visitor) const;

 private:
  friend class StickPort;
  StickMount(StickPort& port, int folder, std::string_view path);

  StickPort* port_;
  int folder_ = -1;
  std::array<char, kMaxPath> path_{};
};

/// The port. One stick at a time; a second one is not seen before the first is gone.
class StickPort {
 public:
  StickPort(const StickPort&) = delete;
  StickPort& operator=(const StickPort&) = delete;
  virtual ~StickPort() = default;

  /// A stick that was there before the firmware came counts, and is no event.
  bool present() const { return do_present(); }

  /// @retval ErrorCode::kNoStick, kPowerLost
  [[nodiscard]] Expected<StickIdentity> identity() const;

  /// @retval ErrorCode::kNoStick
  /// @retval ErrorCode::kMountFailed  no partition, a file system that is not known or damaged
  /// @retval ErrorCode::kBusy         it is mounted already
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<StickMount> mount();

 protected:
  explicit StickPort(Interlock& interlock) : interlock_(interlock) {}

 private:
  friend class StickFile;
  friend class StickMount;

  Status check_mounted() const;

  virtual bool do_present() const = 0;
  virtual Expected<StickIdentity> do_identity() const = 0;
  /// Mounts and writes the mount point, ended by 0, to `path`.
  virtual Status do_mount(std::span<char> path) = 0;
  virtual void do_unmount() = 0;
  /// Reads as read(2) does and says what went wrong as StickFile::read() does.
  virtual Expected<std::size_t> do_read(int file, std::span<std::byte> buffer) = 0;
  /// Is the stick that was mounted still there?
  virtual Status do_check_mounted() const = 0;

  Interlock& interlock_;
  bool mounted_ = false;
};

}  // namespace plumbline
