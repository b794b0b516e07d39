#pragma once
/// Reads a zip archive through its directory, in about 100 kB of heap whatever sizes the archive claims.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware::inline archive {

struct ZipHandle;

/// Where an entry's record is in the directory. It is stored with a print, so a damaged one may be asked for.
struct ZipPlace {
  std::uint64_t at = 0;
  std::uint64_t entry = 0;
};

class ZipReader {
 public:
  static constexpr std::uint64_t kMostEntries = 100'000;

  /// @param file  a descriptor that can be sought; a copy of it is read, at the file's own place
  /// @param name  for messages
  /// @retval ErrorCode::kMalformed    no zip archive, or one that is cut off
  /// @retval ErrorCode::kUnsupported  more than kMostEntries
  /// @retval ErrorCode::kCannotRead, kOutOfMemory
  [[nodiscard]] static Expected<ZipReader> open(int file, std::string_view name);
  /// The same for a file in memory, which must outlive the reader.
  [[nodiscard]] static Expected<ZipReader> open(std::span<const std::byte> file, std::string_view name);
  ZipReader(ZipReader&& other) noexcept;
  ZipReader& operator=(ZipReader&&) = delete;
  ~ZipReader();

  /// Calls visit(name, place) for each entry, folders included, in the directory's order. Cuts names to 255 bytes.
  /// @retval ErrorCode::kUnsupported  more than kMostEntries, though fewer were claimed
  /// @retval ErrorCode::kMalformed    the directory goes on behind the entries that were claimed
  /// @retval ErrorCode::kCannotRead, and any error of `visit`
  [[nodiscard]] Status for_each(FunctionRef<Status(std::string_view, const ZipPlace&)> visit);

  /// Opens an entry for read(), and closes the one before it.
  /// @retval ErrorCode::kMalformed    there is none at that place, or it is damaged
  /// @retval ErrorCode::kUnsupported  encrypted, or packed by something else than deflate
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] Status open_entry(const ZipPlace& place);
  /// @returns 0 at the end of the entry, whose checksum was right
  /// @retval ErrorCode::kMalformed, kCannotRead
  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer);

  const std::string& name() const { return name_; }

 private:
  ZipReader() = default;
  [[nodiscard]] static Expected<ZipReader> open(const ZipHandle& handle, std::string_view name);
  tl::unexpected<Error> broken(int code) const;
  tl::unexpected<Error> too_many() const;

  std::string name_;
  std::unique_ptr<ZipHandle> handle_;  ///< minizip keeps its address
  void* zip_ = nullptr;
};

}  // namespace plumbline::firmware::inline archive
