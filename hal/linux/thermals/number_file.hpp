#pragma once
/// A file of sysfs that holds a number.

#include <cstdint>
#include <optional>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {

/// Stays open, so that asking takes nothing from the heap. Move-only.
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

  /// @returns nothing: it can't be read, or holds no number; errno has the reason or is 0
  std::optional<std::int64_t> read() const noexcept;
  /// @returns false: it can't be written; errno has the reason
  [[nodiscard]] bool write(std::int64_t number) noexcept;

 private:
  explicit NumberFile(int file) : file_(file) {}
  int file_ = -1;
};

}  // namespace plumbline
