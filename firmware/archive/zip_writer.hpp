#pragma once
/// Writes a zip archive entry by entry. Only its directory is kept in memory: some 80 bytes an entry, on the heap.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline archive {

struct ZipHandle;

class ZipWriter {
 public:
  enum class Packing : std::uint8_t { kStore, kDeflate };

  /// Writes beside the path, under a temporary name that finish() replaces.
  /// @retval ErrorCode::kCannotOpen  the path and the reason
  [[nodiscard]] static Expected<ZipWriter> create(const std::string& path);
  ZipWriter(ZipWriter&& other) noexcept;
  ZipWriter& operator=(ZipWriter&&) = delete;
  /// Removes what was written, unless finish() was called.
  ~ZipWriter();

  /// Every entry has the same date, so that the same entries make the same archive.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status add(const char* name, std::span<const std::byte> bytes, Packing packing);
  /// Writes the directory and gives the file its name. An older file of that name is replaced.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status finish();

  const char* path() const { return path_.c_str(); }

 private:
  ZipWriter() = default;
  tl::unexpected<Error> cannot_write() const;
  FixedPath new_path() const;

  FixedPath path_;
  Descriptor file_;
  std::unique_ptr<ZipHandle> handle_;  ///< minizip keeps its address
  void* zip_ = nullptr;                ///< null: closed
  bool named_ = false;                 ///< finish() has renamed it, or it was moved from
};

}  // namespace plumbline::firmware::inline archive
