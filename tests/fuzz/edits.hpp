#pragma once
/// Damages bytes as an input says. Random bytes would hardly ever be a journal or a stored job; damaged ones get past the first check.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace plumbline::firmware::fuzz {

/// Takes numbers from the input; 0 when it is used up.
class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  template <class Number>
  Number take() {
    Number number = 0;
    const std::size_t count = std::min(sizeof number, bytes_.size());
    if (count > 0) std::memcpy(&number, bytes_.data(), count);
    bytes_ = bytes_.subspan(count);
    return number;
  }
  /// @param end  1 or more
  std::size_t below(std::size_t end) { return take<std::uint32_t>() % end; }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Applies one damage: a byte, a range, a block from elsewhere, or the end cut off. Takes at least a byte of the input.
inline void damage(std::vector<std::byte>& bytes, Input& input) {
  const auto how = input.take<std::uint8_t>() % 6;
  if (bytes.empty()) return;
  const std::size_t from = input.below(bytes.size());
  const std::size_t count = std::min(bytes.size() - from, std::size_t{input.take<std::uint16_t>()} + 1);
  const auto value = static_cast<std::byte>(input.take<std::uint8_t>());
  std::byte* const place = bytes.data() + from;
  switch (how) {
    case 0: *place = value; break;
    case 1: *place ^= value; break;
    case 2: std::fill_n(place, count, std::byte{0}); break;
    case 3: std::fill_n(place, count, value); break;
    case 4: std::memmove(place, bytes.data() + input.below(bytes.size() - count + 1), count); break;
    default: bytes.resize(from);
  }
}

}  // namespace plumbline::firmware::fuzz
