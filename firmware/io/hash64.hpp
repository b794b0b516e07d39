#pragma once
/// Hash of a stream of bytes, the same on every machine. It detects errors; it does not resist forgery.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::firmware {

/// h = mix64(h + kGoldenStep64 + word) for each eight bytes, little-endian, the last ones padded with zeros; then the number of bytes
/// in the same way. The split of the bytes over calls does not matter.
class Hash64 {
 public:
  void add(std::span<const std::byte> bytes) {
    const std::size_t to_fill = filled_ == 0 ? 0 : sizeof(std::uint64_t) - filled_;
    const std::size_t head = to_fill < bytes.size() ? to_fill : bytes.size();
    for (const std::byte byte : bytes.first(head)) add_byte(byte);
    auto rest = bytes.subspan(head);
    while (rest.size() >= sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, rest.data(), sizeof word);
      add_word(word);
      size_ += sizeof word;
      rest = rest.subspan(sizeof word);
    }
    for (const std::byte byte : rest) add_byte(byte);
  }
  template <class T>
  void add_value(const T& value) {
    static_assert(std::has_unique_object_representations_v<T>, "padding has no value");
    add(std::as_bytes(std::span(&value, 1)));
  }
  void add_text(std::string_view text) {
    add(std::as_bytes(std::span(text)));
    add_value(std::uint64_t{text.size()});
  }

  std::uint64_t value() const {
    Hash64 last = *this;
    if (last.filled_ > 0) last.add_word(last.partial_);
    last.add_word(size_);
    return last.hash_;
  }

 private:
  static_assert(std::endian::native == std::endian::little, "words are taken as they lie in memory");

  void add_byte(std::byte byte) {
    partial_ |= std::uint64_t{std::to_integer<std::uint8_t>(byte)} << (8 * filled_);
    ++size_;
    if (++filled_ < sizeof(std::uint64_t)) return;
    add_word(partial_);
    partial_ = 0;
    filled_ = 0;
  }
  void add_word(std::uint64_t word) { hash_ = mix64(hash_ + kGoldenStep64 + word); }

  std::uint64_t hash_ = 0;
  std::uint64_t size_ = 0;
  std::uint64_t partial_ = 0;
  std::size_t filled_ = 0;
};

}  // namespace plumbline::firmware
