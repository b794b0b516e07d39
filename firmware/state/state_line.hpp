#pragma once
/// The lines that the state socket sends. README.md and state.schema.json describe them for clients.

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/json_writer.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/printer_record.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline state {

/// Rises when a client of before would misread what is sent now. New members don't raise it.
inline constexpr std::uint32_t kStateProtocol = 1;

/// Longer than any line: a test writes the longest one.
inline constexpr std::size_t kLongestLine = std::size_t{128} * 1024;
using StateLine = TextBuffer<kLongestLine>;

/// Writes what is told: {"code": "island", "values": {"count": 3, ...}, "name": ...}; null if it has no code.
void write_told(JsonWriter& json, const Told& told);

/// @param sequence  rises with each line that differs from the one before
/// @retval ErrorCode::kCannotWrite  `out` is full
[[nodiscard]] Status write_state_line(TextSink& out, const PrinterRecord& record, std::uint64_t sequence);

/// @param id     the request's; none: it had none
/// @param error   null: the request was carried out
/// @param upload  number of the state's `upload` that begins with it
[[nodiscard]] Status write_reply_line(TextSink& out, std::optional<std::uint64_t> id, const Error* error,
                                      std::optional<std::uint32_t> upload = std::nullopt);

/// The reply to a question, with what was asked for.
/// @param members  further ones, as JSON
/// @param name     of the member that has the bytes
/// @param base64   the bytes
/// @retval ErrorCode::kCannotWrite  `out` is full
[[nodiscard]] Status write_data_line(TextSink& out, std::optional<std::uint64_t> id, std::string_view members,
                                     std::string_view name, std::string_view base64);

}  // namespace plumbline::firmware::inline state
