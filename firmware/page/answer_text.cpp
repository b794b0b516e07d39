#include "firmware/page/answer_text.hpp"

namespace plumbline {

HttpAnswer AnswerText::refuse(unsigned status, std::string_view error, std::string_view advice) {
  HttpAnswer answer = object([&](JsonWriter& json) {
    json.member("ok", false);
    json.member("error", error);
    if (!advice.empty()) json.member("advice", advice);
  });
  answer.status = status;
  return answer;
}

}  // namespace plumbline
