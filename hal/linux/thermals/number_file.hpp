#pragma once
/// A sysfs file that holds a number.

#include <cstdint>
#include <optional>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Stays open, so that reading and writing never allocate. Move-only.
class NumberFile {
 public:
  enum class Access : std::uint8_t { kRead, kReadWrite };

  /// @retval ErrorCode::kCannotOpen
  [[nodiscard]] static Expected<NumberFile> open(const std::string& path, Access access);
  NumberFile(NumberFile&& other) noexcept;
  NumberFile& operator=(NumberFile&&) = delete;
  NumberFile(const NumberFile&) = delete;
  NumberFile& operator=(const NumberFile&) = delete;
  ~NumberFile();

  /// @returns nothing if it can't be read (errno is set) or holds no number (errno is 0)
  std::optional<std::int64_t> read() const noexcept;
  /// @returns false with errno set if it can't be written
  [[nodiscard]] bool write(std::int64_t number) noexcept;

 private:
  explicit NumberFile(int file) : file_(file) {}
  int file_ = -1;
};

}  // namespace plumbline::inline hal::inline linux_board
