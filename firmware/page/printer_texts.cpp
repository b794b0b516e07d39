#include "firmware/page/printer_texts.hpp"

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware::inline page {
std::optional<std::uint64_t> whole_number(std::optional<std::string_view> text) {
  return text ? to_number<std::uint64_t>(*text) : std::nullopt;
}

std::string_view plain_text(std::optional<std::string_view> value) {
  if (!value || value->size() < 2 || value->front() != '"') return {};
  return value->substr(1, value->size() - 2);
}

std::uint64_t job_of(std::string_view state) {
  const auto job = json_member(state, "job");
  return id_of(plain_text(job ? json_member(*job, "id") : std::nullopt)).value_or(0);
}

FixedText<40> job_member(std::uint64_t job) {
  FixedText<40> text;
  if (job != 0) text.add(R"(, "job": "%s")", id_text(job).c_str());
  return text;
}

FixedText<160> question_line(const char* what, std::uint64_t id) {
  FixedText<160> line;
  line.add("{%s, \"id\": %llu}\n", what, static_cast<unsigned long long>(id));
  return line;
}

FixedText<100> file_question(std::uint32_t print, std::uint64_t job, std::uint64_t from) {
  FixedText<100> what;
  what.add(R"("do": %s, "from": %llu%s)", job == 0 ? R"("report")" : R"("picture", "picture": "part")",
           static_cast<unsigned long long>(from), job_member(job).c_str());
  if (print > 0) what.add(R"(, "print": %u)", print);
  return what;
}

}  // namespace plumbline::firmware::inline page
