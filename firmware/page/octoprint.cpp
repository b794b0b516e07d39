#include "firmware/page/octoprint.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/io/version.hpp"
#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware::inline page {
namespace {

/// What OctoPrint calls a state, with the flags that are set beside.
struct Row {
  std::string_view state;  ///< as the socket names it
  const char* text;
  const char* flags;  ///< names of those that are true
};
constexpr std::array kRows{
    Row{"idle", "Operational", "operational ready"},
    Row{"offered", "Operational", "operational ready"},
    Row{"interrupted", "Operational", "operational"},
    Row{"plate in use", "Operational", "operational"},
    Row{"slicing", "Starting", "operational printing"},
    Row{"checks", "Starting", "operational printing"},
    Row{"homing", "Starting", "operational printing"},
    Row{"printing", "Printing", "operational printing"},
    Row{"pausing", "Pausing", "operational printing pausing"},
    Row{"paused", "Paused", "operational paused"},
    Row{"cover open", "Paused", "operational paused"},
    Row{"cooling down", "Paused", "operational paused"},
    Row{"feed me", "Paused", "operational paused"},
    Row{"cancelling", "Cancelling", "operational printing cancelling"},
    Row{"finishing", "Finishing", "operational printing finishing"},
    Row{"finished", "Operational", "operational"},
    Row{"cancelled", "Operational", "operational"},
    Row{"suspended", "Offline", "closedOrError"},
    Row{"fault", "Error", "error closedOrError"},
};
constexpr Row kOffline{"", "Offline", "closedOrError"};
constexpr std::array<std::string_view, 11> kFlags = {"operational", "printing",  "cancelling",    "pausing",
                                                     "resuming",    "finishing", "closedOrError", "error",
                                                     "paused",      "ready",     "sdReady"};

const Row& row_of(std::string_view state_line) {
  const std::string_view state = json_member(state_line, "state").value_or("");
  const auto* const row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& one) {
    return state.size() == one.state.size() + 2 && state.substr(1, one.state.size()) == one.state;
  });
  return row != kRows.end() ? *row : kOffline;
}

/// A member of a member, as it is written; "null" if there is none.
std::string_view member(std::string_view state_line, std::string_view of, std::string_view name) {
  const auto outer = json_member(state_line, of);
  return outer ? json_member(*outer, name).value_or("null") : "null";
}

/// Writes pieces of JSON one after another.
class Pieces {
 public:
  explicit Pieces(TextSink& out) : out_(out) {}
  Pieces& operator<<(std::string_view text) {
    if (status_) status_ = out_.write(text);
    return *this;
  }
  const Status& status() const { return status_; }

 private:
  TextSink& out_;
  Status status_;
};

}  // namespace

Status write_octoprint_version(TextSink& out) {
  // "server" is the version of OctoPrint whose answers these are.
  Pieces pieces(out);
  pieces << R"({"api": "0.1", "server": "1.9.0", "text": "plumbline )" << kVersion << "\"}";
  return pieces.status();
}

Status write_octoprint_job(TextSink& out, std::string_view state_line) {
  const std::string_view scan = member(state_line, "job", "scan");
  const auto done = to_number<double>(member(state_line, "progress", "layers_done"));
  const auto layers = to_number<double>(member(state_line, "progress", "layers"));
  FixedText<32> completion;
  if (done && layers && *layers > 0) {
    // Without printf's decimal point, which is the locale's.
    const auto hundredths = static_cast<unsigned>(10000 * *done / *layers);
    completion.add("%u.%02u", hundredths / 100, hundredths % 100);
  } else {
    completion.add("null");
  }
  Pieces pieces(out);
  pieces
      << R"({"job": {"file": {"name": )" << scan << R"(, "display": )" << scan << R"(, "path": )" << scan
      << R"(, "origin": "local", "size": null, "date": null}, "estimatedPrintTime": )"
      << member(state_line, "sliced", "time_s")
      << R"(, "averagePrintTime": null, "lastPrintTime": null, "filament": null, "user": null}, "progress": {"completion": )"
      << completion.view() << R"(, "filepos": null, "printTime": )" << member(state_line, "progress", "elapsed_s")
      << R"(, "printTimeLeft": )" << member(state_line, "progress", "left_s")
      << R"(, "printTimeLeftOrigin": "analysis"}, "state": ")" << row_of(state_line).text << "\"}";
  return pieces.status();
}

Status write_octoprint_printer(TextSink& out, std::string_view state_line) {
  const Row& row = row_of(state_line);
  const std::string_view set = row.flags;
  Pieces pieces(out);
  pieces << R"({"temperature": {}, "sd": {"ready": false}, "state": {"text": ")" << row.text << R"(", "flags": {)";
  for (const std::string_view flag : kFlags) {
    bool is_set = false;
    for (std::size_t at = 0; at < set.size(); at = std::min(set.find(' ', at), set.size() - 1) + 1) {
      const std::string_view word = set.substr(at, set.find(' ', at) - at);
      is_set |= word == flag;
    }
    pieces << (flag == kFlags.front() ? "\"" : ", \"") << flag << "\": " << (is_set ? "true" : "false");
  }
  pieces << "}, \"error\": \"\"}}";
  return pieces.status();
}

}  // namespace plumbline::firmware::inline page
