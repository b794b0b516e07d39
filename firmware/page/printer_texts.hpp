#pragma once
/// What the page says to the printer, and small parts of what the printer says.

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"

namespace plumbline::firmware::inline page {

/// A JSON number, if it is whole and fits.
std::optional<std::uint64_t> whole_number(std::optional<std::string_view> text);

/// What a JSON string without escapes holds, such as base64, the name of a state, or a code.
std::string_view plain_text(std::optional<std::string_view> value);

/// The id of the job in a state line; 0: there is none.
std::uint64_t job_of(std::string_view state);

/// The member "job" of a question, behind another one; empty for 0.
FixedText<40> job_member(std::uint64_t job);

/// @param what  members of the question, as JSON
FixedText<160> question_line(const char* what, std::uint64_t id);

/// What asks for a report, or for the model of a job, from its byte `from` on.
/// @param print  0: the last one
FixedText<100> file_question(std::uint32_t print, std::uint64_t job, std::uint64_t from);

}  // namespace plumbline::firmware::inline page
