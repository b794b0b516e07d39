#include "firmware/io/text/base64.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::optional<std::size_t> write_base64(std::span<const std::byte> bytes, std::span<char> out) {
  const std::size_t size = (bytes.size() + 2) / 3 * 4;
  if (size > out.size()) return std::nullopt;
  const auto byte = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<unsigned>(bytes[i]) : 0U; };
  for (std::size_t i = 0, at = 0; i < bytes.size(); i += 3, at += 4) {
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (std::size_t k = 0; k < 4; ++k) out[at + k] = kDigits[three >> (18 - 6 * k) & 63U];
    if (i + 1 >= bytes.size()) out[at + 2] = '=';
    if (i + 2 >= bytes.size()) out[at + 3] = '=';
  }
  return size;
}

std::optional<std::size_t> read_base64(std::string_view text, std::span<std::byte> out) {
  if (text.size() % 4 != 0) return std::nullopt;
  std::size_t padding = 0;
  while (padding < 2 && !text.empty() && text.back() == '=') {
    text.remove_suffix(1);
    ++padding;
  }
  const std::size_t size = (text.size() + padding) / 4 * 3 - padding;
  if (size > out.size()) return std::nullopt;
  unsigned bits = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t digit = kDigits.find(text[i]);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6 | static_cast<unsigned>(digit);
    // The digits so far have 6 (i + 1) bits; a byte is complete whenever 8 more are there.
    if (i % 4 != 0) out[at++] = static_cast<std::byte>(bits >> (6 - 2 * (i % 4)) & 0xFFU);
  }
  return at;
}

}  // namespace plumbline::firmware
