#pragma once
/// A scan file.

#include <string>

#include "slicer/core/byte_source.hpp"

namespace plumbline::firmware {

/// Reads a file with system calls: it has no buffer, and takes nothing from the heap after open().
class FileSource final : public ByteSource {
 public:
  /// @param path  a file, or a pipe
  /// @retval ErrorCode::kCannotOpen  missing, a folder or not readable: the path, the reason, what to do
  [[nodiscard]] static Expected<FileSource> open(const std::string& path);
  FileSource(FileSource&& other) noexcept;
  FileSource& operator=(FileSource&&) = delete;
  ~FileSource() override;

  /// @retval ErrorCode::kCannotRead  the name, the byte at which it failed and the system's reason
  [[nodiscard]] Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return name_; }  ///< without its folders
  std::optional<std::uint64_t> size() const override { return size_; }
  [[nodiscard]] Status rewind() override;

 private:
  FileSource() = default;

  int file_ = -1;
  std::string name_;
  std::optional<std::uint64_t> size_;
  std::uint64_t offset_ = 0;  ///< bytes read so far
};

}  // namespace plumbline::firmware
