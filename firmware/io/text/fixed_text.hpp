#pragma once
/// Text of a fixed capacity: for lines and paths that are written where the heap must not be used.

#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string_view>

namespace plumbline::firmware {

/// At most Capacity - 1 characters and a terminator. Longer text is cut, and cut() returns true.
template <std::size_t Capacity>
class FixedText {
 public:
  FixedText() = default;

  /// Appends, printf-style. Does not allocate for integers, strings, and numbers of fewer than 32 digits.
  [[gnu::format(printf, 2, 3)]] void add(const char* pattern, ...) {
    va_list args;
    va_start(args, pattern);
    const int wanted = std::vsnprintf(text_ + size_, Capacity - size_, pattern, args);
    va_end(args);
    if (wanted < 0) return;
    const std::size_t room = Capacity - 1 - size_;
    cut_ = cut_ || static_cast<std::size_t>(wanted) > room;
    size_ += cut_ ? room : static_cast<std::size_t>(wanted);
  }
  void clear() {
    size_ = 0;
    text_[0] = '\0';
    cut_ = false;
  }

  const char* c_str() const { return text_; }
  std::string_view view() const { return {text_, size_}; }
  bool cut() const { return cut_; }

 private:
  char text_[Capacity] = {};
  std::size_t size_ = 0;
  bool cut_ = false;
};

/// A finding and what to do about it: the longest that is said, with the largest values, fits. Where it goes on to, there is as much room.
inline constexpr std::size_t kLongestSentence = 448;
using Sentence = FixedText<kLongestSentence>;

/// For "%llu", since std::uint64_t is another type on other architectures.
constexpr unsigned long long big(std::uint64_t number) { return number; }

/// The longest path that Linux takes, terminator included.
inline constexpr std::size_t kMaxPath = 4096;
using FixedPath = FixedText<kMaxPath>;

/// For a person: three significant digits, and no fraction from 100 on.
inline FixedText<24> three_digits(double value) {
  FixedText<24> text;
  text.add(value >= 100 ? "%.0f" : "%.3g", value);
  return text;
}

}  // namespace plumbline::firmware
