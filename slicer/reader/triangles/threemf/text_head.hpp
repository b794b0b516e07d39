#pragma once
/// The beginning of a text that comes in pieces.

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace plumbline::inline slicer {

/// Its first `Size` bytes.
template <std::size_t Size>
class TextHead {
 public:
  void append(std::string_view piece) {
    const std::size_t count = std::min(piece.size(), Size - size_);
    std::copy_n(piece.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += count;
  }
  std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, Size> text_{};
  std::size_t size_ = 0;
};

}  // namespace plumbline::inline slicer
