#include "slicer/core/words/printable_text.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace plumbline::inline slicer {
namespace {

constexpr std::string_view kCut = "...";

struct Character {
  std::size_t bytes = 0;  ///< 0: not UTF-8
  std::uint32_t code = 0;
};

/// The character at the start of `text`, which is not empty.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {1, lead};
  if (lead >= 0xC2 && lead <= 0xDF && follows(1)) return {2, (lead & 0x1FU) << 6U | (byte(1) & 0x3FU)};
  if (lead >= 0xE0 && lead <= 0xEF && follows(1) && follows(2)) {
    const std::uint32_t code = (lead & 0xFU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU);
    // Neither overlong nor half of a UTF-16 pair.
    if (code >= 0x800 && (code < 0xD800 || code > 0xDFFF)) return {3, code};
  }
  if (lead >= 0xF0 && lead <= 0xF4 && follows(1) && follows(2) && follows(3)) {
    const std::uint32_t code =
        (lead & 7U) << 18U | (byte(1) & 0x3FU) << 12U | (byte(2) & 0x3FU) << 6U | (byte(3) & 0x3FU);
    if (code >= 0x10000 && code <= 0x10FFFF) return {4, code};
  }
  return {};
}

/// Whether a terminal would obey the character, or hide it, or let it reorder its neighbours.
bool is_harmful(std::uint32_t code) {
  struct Range {
    std::uint32_t first, last;
  };
  constexpr std::array kHarmful = {
      Range{0x00, 0x1F},     Range{0x7F, 0x9F},       // C0, DEL, C1
      Range{0xAD, 0xAD},     Range{0x61C, 0x61C},     // soft hyphen, Arabic letter mark
      Range{0x180E, 0x180E}, Range{0x200B, 0x200F},   // without width; left-to-right and right-to-left marks
      Range{0x2028, 0x202E},                          // line and paragraph separators, embeddings and overrides
      Range{0x2060, 0x206F},                          // word joiner, isolates, deprecated format characters
      Range{0xFDD0, 0xFDEF}, Range{0xFEFF, 0xFEFF},   // no characters; byte order mark
      Range{0xFFF9, 0xFFFB}, Range{0xE0000, 0xE0FFF}  // annotations; tags and variation selectors
  };
  return (code & 0xFFFEU) == 0xFFFEU || std::any_of(kHarmful.begin(), kHarmful.end(), [code](const Range& range) {
           return code >= range.first && code <= range.last;
         });
}

}  // namespace

PrintableText::PrintableText(std::string_view raw, std::size_t longest) {
  longest = std::min(longest, kCapacity - 1);
  std::size_t can_be_cut_at = 0;  // leaves room for kCut
  while (!raw.empty()) {
    const Character character = first_character(raw);
    std::array<char, 16> escaped{};
    std::string_view shown = raw.substr(0, character.bytes);
    if (character.bytes == 0 || character.code < 0x80) {
      if (character.bytes == 0 || is_harmful(character.code)) {
        std::snprintf(escaped.data(), escaped.size(), "\\x%02x",
                      static_cast<unsigned>(static_cast<unsigned char>(raw[0])));
        shown = escaped.data();
      }
    } else if (is_harmful(character.code)) {
      std::snprintf(escaped.data(), escaped.size(), "\\u{%x}", static_cast<unsigned>(character.code));
      shown = escaped.data();
    }
    if (size_ + shown.size() > longest) {
      size_ = can_be_cut_at;
      const auto dots = kCut.substr(0, std::min(kCut.size(), longest - size_));
      size_ += dots.copy(text_.data() + size_, dots.size());
      break;
    }
    size_ += shown.copy(text_.data() + size_, shown.size());
    if (size_ + kCut.size() <= longest) can_be_cut_at = size_;
    raw.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  text_[size_] = '\0';
}

}  // namespace plumbline::inline slicer
