#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// Takes text piece by piece.
class TextSink {
 public:
  virtual ~TextSink() = default;
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] virtual Status write(std::string_view text) = 0;

 protected:
  TextSink() = default;
  TextSink(const TextSink&) = default;
  TextSink& operator=(const TextSink&) = default;
};

/// Keeps the text, in memory of its own.
template <std::size_t Capacity>
class TextBuffer final : public TextSink {
 public:
  /// @retval ErrorCode::kCannotWrite  it has more than Capacity bytes; none of this piece is kept
  [[nodiscard]] Status write(std::string_view text) override {
    if (text.size() > Capacity - size_)
      return fail(ErrorCode::kCannotWrite, "a text has more than %zu bytes", Capacity);
    text.copy(bytes_.data() + size_, text.size());
    size_ += text.size();
    return {};
  }
  void clear() { size_ = 0; }
  std::string_view view() const { return {bytes_.data(), size_}; }

 private:
  std::array<char, Capacity> bytes_;  // set up to size_
  std::size_t size_ = 0;
};

}  // namespace plumbline::firmware
