#pragma once
/// Keeps the scan that was uploaded last:
///
///   STATE/uploads/NAME       whole and durable; at most one
///   STATE/uploads/.incoming  what comes; it gets its name when it is whole and durable, and is removed when the daemon starts
///
/// What a file holds is not looked at: that is the slicing child's task, as with a stick's.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

class UploadStore {
 public:
  /// Bytes between two syncs. A slow card needs half a second for them, and buttons wait meanwhile.
  static constexpr std::uint64_t kDurableBytes = std::uint64_t{4} << 20U;

  /// Creates STATE/uploads if it is missing, and removes what a power cut has left there but the newest scan.
  /// @param state       the daemon's folder, which exists
  /// @param most_bytes  of a scan
  /// @retval ErrorCode::kCannotOpen, kCannotRead  the path, the reason
  [[nodiscard]] static Expected<UploadStore> open(const std::string& state, std::uint64_t most_bytes);

  std::uint64_t most_bytes() const { return most_bytes_; }
  /// Name of the scan that is kept; empty: there is none.
  std::string_view kept() const { return kept_.view(); }
  std::uint64_t kept_bytes() const { return kept_bytes_; }
  /// Rises when another scan is kept, and when it is removed.
  std::uint32_t kept_count() const { return kept_count_; }
  /// @returns a descriptor of STATE/uploads, below 0: errno has the reason
  int open_folder() const;

  /// Makes room for a scan. Drops what came before and was not kept. The others take nothing from the heap.
  /// @param name  check_upload_name() accepts it
  /// @retval ErrorCode::kBadSetting   it is empty or too large: the limit
  /// @retval ErrorCode::kCannotWrite  there is not enough room: how much is needed
  [[nodiscard]] Status begin(std::string_view name, std::uint64_t bytes);
  /// @retval ErrorCode::kCannotWrite  it is dropped
  /// @retval ErrorCode::kBadSetting   there are more bytes than begin() was told; it is dropped
  [[nodiscard]] Status write(std::span<const std::byte> bytes);
  bool is_whole() const { return file_.is_open() && written_ == bytes_; }
  /// Keeps it, in place of the one that was kept. Durable when this returns.
  /// @pre is_whole()
  /// @retval ErrorCode::kCannotWrite  it is dropped; the one that was kept still is
  [[nodiscard]] Status keep();
  void drop();
  /// Removes the scan that is kept, if there is one. Durable when this returns.
  /// @retval ErrorCode::kCannotWrite  it is still kept; or it may be there again after a power cut, and kept() is empty
  [[nodiscard]] Status remove();

 private:
  UploadStore() = default;
  [[nodiscard]] Status tidy();
  tl::unexpected<Error> cannot_write();

  FixedPath path_;
  Descriptor folder_;
  Descriptor file_;  ///< .incoming
  std::uint64_t most_bytes_ = 0;
  FixedText<80> name_;  ///< that the file gets
  std::uint64_t bytes_ = 0, written_ = 0, durable_ = 0;
  FixedText<256> kept_;
  std::uint64_t kept_bytes_ = 0;
  std::uint32_t kept_count_ = 0;
};

}  // namespace plumbline::firmware
