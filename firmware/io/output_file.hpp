#pragma once
/// Output files, by plain system calls: stdio and iostreams take their buffers from the heap.

#include <cstddef>
#include <span>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/text_sink.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware {

class OutputFile final : public TextSink {
 public:
  /// @param path  created, or emptied if it exists
  /// @retval ErrorCode::kCannotOpen  the path, the system's reason, what to do
  [[nodiscard]] static Expected<OutputFile> create(const char* path);
  /// Standard output, which is not closed.
  static OutputFile standard_output();

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile() override;

  /// Writes all of it.
  /// @retval ErrorCode::kCannotWrite  the path, the system's reason ("No space left on device"), what to do
  [[nodiscard]] Status write(std::span<const std::byte> bytes);
  [[nodiscard]] Status write(std::string_view text) override { return write(std::as_bytes(std::span(text))); }

  /// Must be the last call: some file systems report only here that the data was not written.
  /// @retval ErrorCode::kCannotWrite  as write()
  [[nodiscard]] Status close();

 private:
  OutputFile() = default;
  tl::unexpected<Error> cannot_write(int reason) const;

  int file_ = -1;
  bool owned_ = true;
  FixedPath path_;
};

/// Finds out whether OutputFile::create() can succeed, for a file that is written after minutes or hours of work. A file that
/// exists keeps its content; one that does not is created and removed again.
/// @retval ErrorCode::kCannotOpen  as create()
[[nodiscard]] Status check_can_create(const char* path);

/// Writes a file whole or not at all: where that fails there is none of that name, neither half of it nor the one before.
/// @param write  writes its content
/// @retval the errors of OutputFile and of write()
[[nodiscard]] Status write_whole_file(const char* path, FunctionRef<Status(TextSink&)> write);

/// OutputFile::create(), write() and close().
[[nodiscard]] Status write_file(const char* path, std::span<const std::byte> bytes);

}  // namespace plumbline::firmware
