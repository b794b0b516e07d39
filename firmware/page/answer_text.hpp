#pragma once
/// Short answers that the page writes itself, as JSON.

#include <string_view>

#include "firmware/io/text/json_writer.hpp"
#include "firmware/page/http_server.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

class AnswerText {
 public:
  /// {"ok": false, "error": ..., "advice": ..., "told": ...}
  HttpAnswer refuse(unsigned status, std::string_view error, std::string_view advice = {}, const Told& told = {});
  HttpAnswer refuse(unsigned status, const Error& error) {
    return refuse(status, error.finding(), error.advice(), error.told());
  }
  HttpAnswer no_daemon() { return refuse(503, "the printer's daemon does not answer", "Start plumblined"); }
  /// An object with the members that `write` writes.
  template <class Write>
  HttpAnswer object(const Write& write) {
    text_.clear();
    JsonWriter json(text_);
    json.begin_object(JsonWriter::Layout::kOneLine);
    write(json);
    json.end_object();
    static_cast<void>(json.finish());
    return {.body = text_.view()};
  }
  /// @param write  writes all of it
  template <class Write>
  HttpAnswer text(const Write& write) {
    text_.clear();
    if (!write(text_)) return refuse(500, "the answer is too long");
    return {.body = text_.view()};
  }

 private:
  TextBuffer<4096> text_;  ///< of the last answer: it is copied before the next one
};

}  // namespace plumbline::firmware::inline page
