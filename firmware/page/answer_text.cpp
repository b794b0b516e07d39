#include "firmware/page/answer_text.hpp"

#include "firmware/state/state_line.hpp"

namespace plumbline::firmware::inline page {

HttpAnswer AnswerText::refuse(unsigned status, std::string_view error, std::string_view advice, const Told& told) {
  HttpAnswer answer = object([&](JsonWriter& json) {
    json.member("ok", false);
    json.member("error", error);
    if (!advice.empty()) json.member("advice", advice);
    if (told.empty()) return;
    json.key("told");
    write_told(json, told);
  });
  answer.status = status;
  return answer;
}

}  // namespace plumbline::firmware::inline page
