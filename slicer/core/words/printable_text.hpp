#pragma once
/// Text from outside, made safe to show: names of files, values of a stick's job.toml, labels, messages about them.

#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>

namespace plumbline::inline slicer {

/// One line of valid UTF-8 that can't steer a terminal, forge a second line of a log, or look like another text. Whatever becomes a
/// PrintableText is made safe, so a sink that takes this type can't be given a raw string.
///
///   control characters (C0, DEL, C1), bytes that are not UTF-8          \x1b, \x0a, \xff
///   line separators, bidirectional controls, characters without width   \u{202e}
///   more than the capacity                                              cut between two characters, with "..." at the end
///
/// Everything else stays as it is. Applied twice it changes nothing more. Never allocates.
class PrintableText {
 public:
  static constexpr std::size_t kCapacity = 1024;  ///< bytes, terminator included

  /// @param longest  bytes of the result, "..." included; at most kCapacity - 1
  explicit PrintableText(std::string_view raw, std::size_t longest);
  /// Implicit, because it makes the text safe.
  template <std::convertible_to<std::string_view> Text>
  // NOLINTNEXTLINE(google-explicit-constructor)
  PrintableText(const Text& raw) : PrintableText(std::string_view(raw), kCapacity - 1) {}

  const char* c_str() const { return text_.data(); }
  std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, kCapacity> text_;  // set up to the terminator
  std::size_t size_ = 0;
};

}  // namespace plumbline::inline slicer
