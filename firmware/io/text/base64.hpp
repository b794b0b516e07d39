#pragma once
/// Bytes as text: base64 (RFC 4648), with padding. Takes nothing from the heap.

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace plumbline::firmware {

/// @returns characters written; none: they are more than `out` holds
std::optional<std::size_t> write_base64(std::span<const std::byte> bytes, std::span<char> out);

/// @returns bytes written; none: the text is not base64, or `out` is too small
std::optional<std::size_t> read_base64(std::string_view text, std::span<std::byte> out);

}  // namespace plumbline::firmware
