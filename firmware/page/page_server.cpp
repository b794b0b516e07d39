#include "firmware/page/page_server.hpp"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

#include "firmware/io/base64.hpp"
#include "firmware/io/json_cursor.hpp"
#include "firmware/io/json_writer.hpp"
#include "firmware/page/access.hpp"
#include "firmware/page/octoprint.hpp"
#include "firmware/page/page_files.hpp"
#include "firmware/page/printer_texts.hpp"
#include "firmware/state/socket_place.hpp"

namespace plumbline {
namespace {

constexpr std::size_t kMostPng = kLongestLine / 4 * 3;
constexpr auto kOneLine = JsonWriter::Layout::kOneLine;
constexpr std::string_view kPicturePath = "/picture/";
constexpr std::string_view kPrintPicturePath = "/print.png";
constexpr std::string_view kSidePath = "/side";
constexpr std::string_view kBodyPath = "/upload/body";

/// Commands that a browser may give: those that a state may list.
bool is_command(Command command) { return static_cast<std::size_t>(command) < kCommandCount; }

}  // namespace

PageServer::PageServer(const std::string& socket, PageChoice page, std::string page_host, Pairing pairing)
    : page_(page),
      page_host_(std::move(page_host)),
      pairing_(std::move(pairing)),
      link_(command_socket(socket)),
      mask_(kMostPng) {
  static_cast<void>(write_german_faults(faults_));
  for (Picture& picture : pictures_) picture.png.resize(kMostPng);
  for (Stream& stream : streams_) stream.report.resize(kMostPng);
}

HttpAnswer PageServer::refuse(unsigned status, const char* error, std::string_view advice) {
  text_.clear();
  JsonWriter json(text_);
  json.begin_object(kOneLine);
  json.member("ok", false);
  json.member("error", error);
  if (!advice.empty()) json.member("advice", advice);
  json.end_object();
  static_cast<void>(json.finish());
  return {.status = status, .body = text_.view()};
}

HttpReply PageServer::answer(const HttpRequest& request, const HttpTicket& ticket) {
  if (!is_known_host(request.host, page_, page_host_)) {
    return refuse(
        421, "this machine is not known by that name",
        page_ == PageChoice::kLocal ? "Open http://localhost" : "Use its address, or set [printer] page_host");
  }
  if (request.method == "GET" || request.method == "HEAD") return get(request, ticket);
  if (request.method == "POST") return post(request, ticket);
  HttpAnswer answer = refuse(405, "only GET and POST are served");
  answer.allow = "GET, HEAD, POST";
  return answer;
}

HttpReply PageServer::get(const HttpRequest& request, const HttpTicket& ticket) {
  for (const PageFile& file : page_files()) {
    if (request.path == file.path) return HttpAnswer{.type = file.type, .body = file.text, .is_fixed = true};
  }
  if (request.path == "/faults.json") return HttpAnswer{.body = faults_.view(), .is_fixed = true};
  if (request.path == "/events") return HttpStream{};
  if (request.path == "/access") return access(request);
  if (request.path == "/api/version") {
    return octoprint([](TextSink& out, std::string_view) { return write_octoprint_version(out); });
  }
  if (request.path == "/api/job") return octoprint(write_octoprint_job);
  if (request.path == "/api/printer") return octoprint(write_octoprint_printer);
  const bool is_picture = request.path.starts_with(kPicturePath);
  const bool is_mask = request.path == "/mask", is_report = request.path == "/report.json";
  const bool is_print = request.path == kPrintPicturePath, is_side = request.path == kSidePath;
  if (!is_picture && !is_mask && !is_report && !is_print && !is_side && request.path != "/state")
    return refuse(404, "there is no such page");
  if (state_.view().empty()) return refuse(503, "the printer's daemon does not answer", "Start plumblined");
  if (request.path == "/state") return HttpAnswer{.body = state_.view()};
  if (is_picture) {
    const std::string_view name = request.path.substr(kPicturePath.size());
    const auto* const word = std::find(kPictureWords.begin(), kPictureWords.end(), name);
    if (word == kPictureWords.end()) return refuse(404, "there is no such picture");
    return picture(static_cast<PictureName>(word - kPictureWords.begin()), ticket);
  }
  // The preview of a print that is kept is one picture in one reply, as a mask is, and so is a side.
  Question question{.kind = is_report ? Question::Kind::kReportBegin : Question::Kind::kMask,
                    .ticket = ticket,
                    .print = is_report ? request.n.value_or(0) : 0};
  FixedText<100> what;
  if (is_print) {
    if (request.n.value_or(0) == 0) return refuse(400, "which print?", "Ask for /print.png?n=1");
    what.add(R"("do": "picture", "picture": "preview", "print": %u)", *request.n);
  } else if (is_side) {
    if (request.n.value_or(kSideCount) >= kSideCount) return refuse(400, "which side?", "Ask for /side?n=0");
    what.add(R"("do": "picture", "picture": "side", "side": %u)", *request.n);
  } else if (is_mask) {
    if (!request.n) return refuse(400, "which layer?", "Ask for /mask?n=0");
    what.add(R"("do": "mask", "layer": %u)", *request.n);
  } else {
    what = report_question(question.print, 0);
  }
  question.id = ++last_id_;
  if (!ask(question, question_line(what.c_str(), question.id).view())) return refuse(503, "the printer is busy");
  return HttpLater{};
}

HttpAnswer PageServer::octoprint(Status (*write)(TextSink&, std::string_view)) {
  text_.clear();
  if (!write(text_, state_.view())) return refuse(500, "the answer is too long");
  return {.body = text_.view()};
}

/// What this browser may do.
HttpAnswer PageServer::access(const HttpRequest& request) {
  text_.clear();
  JsonWriter json(text_);
  json.begin_object(kOneLine);
  json.member("page", page_ == PageChoice::kLocal ? "local" : "network");
  json.member("paired", pairing_.knows(request.token));
  json.end_object();
  static_cast<void>(json.finish());
  return {.body = text_.view()};
}

HttpReply PageServer::picture(PictureName name, const HttpTicket& ticket) {
  const Picture& kept = pictures_[static_cast<std::size_t>(name)];
  const std::string_view word = kPictureWords[static_cast<std::size_t>(name)];
  const auto pictures = json_member(state_.view(), "pictures");
  const auto number = pictures ? whole_number(json_member(*pictures, word)) : std::nullopt;
  if (!number) return refuse(404, "there is no such picture now");
  if (kept.number == *number) {
    return HttpAnswer{.type = "image/png", .body = {reinterpret_cast<const char*>(kept.png.data()), kept.size}};
  }
  Question question{.kind = Question::Kind::kPicture, .ticket = ticket, .picture = name};
  if (const auto id = in_flight(name)) {
    question.id = *id;
    return ask(question, {}) ? HttpReply(HttpLater{}) : refuse(503, "the printer is busy");
  }
  question.id = ++last_id_;
  FixedText<80> what;
  what.add(R"("do": "picture", "picture": "%.*s")", static_cast<int>(word.size()), word.data());
  if (!ask(question, question_line(what.c_str(), question.id).view())) return refuse(503, "the printer is busy");
  return HttpLater{};
}

HttpReply PageServer::post(const HttpRequest& request, const HttpTicket& ticket) {
  if (request.path == kBodyPath) return uploaded(ticket);
  if (request.path != "/command" && request.path != "/pair" && request.path != "/upload") {
    HttpAnswer answer = refuse(405, "nothing is sent there");
    answer.allow = "GET, HEAD";
    return answer;
  }
  if (const auto refusal = distrust(request, "application/json")) return *refusal;
  if (request.path == "/pair") return pair(request);
  return request.path == "/upload" ? upload(request, ticket) : command(request, ticket);
}

/// Refuses what the page's own script would not send.
std::optional<HttpAnswer> PageServer::distrust(const HttpRequest& request, std::string_view type) {
  if (!is_same_origin(request.host, request.origin)) return refuse(403, "only the printer's own page may do that");
  if (request.content_type.starts_with(type)) return std::nullopt;
  FixedText<80> text;
  text.add("what is sent must be %.*s", static_cast<int>(type.size()), type.data());
  return refuse(415, text.c_str());
}

/// {}: show a code on the screen, or pair at once if only this machine can ask. {"code": "482913"}: the person has read it.
HttpReply PageServer::pair(const HttpRequest& request) {
  const auto now = HostClock::now();
  const std::string_view code = plain_text(json_member(request.body, "code"));
  std::optional<PageToken> token;
  if (page_ == PageChoice::kLocal) {
    token = pairing_.add();
  } else if (code.empty()) {
    const auto made = pairing_.new_code(now);
    if (!made) return refuse(429, std::string(made.error().finding()).c_str(), made.error().advice());
    FixedText<60> what;
    what.add(R"("do": "code", "code": "%s")", made->c_str());
    if (!link_.send(question_line(what.c_str(), ++last_id_).view())) {
      return refuse(503, "the printer's daemon does not answer", "Start plumblined");
    }
    // For a printer without a screen: whoever may read the log of the machine may command it.
    std::fprintf(stderr, "plumbline-page: the code for a browser is %s\n", made->c_str());
  } else {
    const auto made = pairing_.pair(code, now);
    if (!made) return refuse(403, std::string(made.error().finding()).c_str(), made.error().advice());
    token = *made;
    static_cast<void>(link_.send(question_line(R"("do": "code", "code": "")", ++last_id_).view()));
  }
  text_.clear();
  JsonWriter json(text_);
  json.begin_object(kOneLine);
  json.member("ok", true);
  if (token) json.member("token", token->view());
  json.end_object();
  static_cast<void>(json.finish());
  return HttpAnswer{.body = text_.view()};
}

HttpReply PageServer::command(const HttpRequest& request, const HttpTicket& ticket) {
  if (!pairing_.knows(request.token)) return refuse(401, "this browser is not paired with the printer");
  std::optional<std::uint64_t> id;
  const auto asked = parse_request(request.body, id);
  if (!asked) return refuse(400, std::string(asked.error().finding()).c_str(), asked.error().advice());
  if (!is_command(asked->command)) return refuse(400, "a browser can't command that");
  const Question question{.kind = Question::Kind::kCommand, .id = ++last_id_, .ticket = ticket};
  TextBuffer<1024> line;
  if (!write_request(line, *asked, question.id)) return refuse(400, "the command is too long");
  if (!ask(question, line.view())) return refuse(503, "the printer's daemon does not answer", "Start plumblined");
  return HttpLater{};
}

/// Asks the printer whether it takes a scan. The scan itself comes in a second request: a browser that is refused while it sends a long
/// body may not see why.
HttpReply PageServer::upload(const HttpRequest& request, const HttpTicket& ticket) {
  if (!pairing_.knows(request.token)) return refuse(401, "this browser is not paired with the printer");
  std::optional<std::uint64_t> id;
  const auto asked = parse_request(request.body, id);
  if (!asked) return refuse(400, std::string(asked.error().finding()).c_str(), asked.error().advice());
  if (asked->command != Command::kUpload) return refuse(400, "only an upload may be asked for there");
  if (upload_.stage() != PageUpload::Stage::kFree) {
    return refuse(409, "another scan is being uploaded", "Try again when it has come");
  }
  const Question question{.kind = Question::Kind::kUpload, .id = ++last_id_, .ticket = ticket};
  TextBuffer<1024> line;
  if (!write_request(line, *asked, question.id)) return refuse(400, "the name is too long");
  const Descriptor for_printer = upload_.offer(asked->bytes);
  if (!for_printer.is_open()) return refuse(503, "the page has no room for an upload", "Try again");
  if (ask(question, line.view(), for_printer.get())) return HttpLater{};
  upload_.drop();
  return refuse(503, "the printer's daemon does not answer", "Start plumblined");
}

bool PageServer::streams_body(std::string_view path) { return path == kBodyPath; }

std::optional<HttpAnswer> PageServer::begin_body(const HttpRequest& request, std::uint64_t bytes,
                                                 const HttpTicket& ticket) {
  if (!is_known_host(request.host, page_, page_host_)) return refuse(421, "this machine is not known by that name");
  if (request.method != "POST") {
    HttpAnswer answer = refuse(405, "a scan is sent by POST");
    answer.allow = "POST";
    return answer;
  }
  if (const auto refusal = distrust(request, "application/octet-stream")) return refusal;
  if (!pairing_.knows(request.token)) return refuse(401, "this browser is not paired with the printer");
  if (upload_.begin(request.n.value_or(0), bytes, ticket)) return std::nullopt;
  return refuse(409, "the printer does not wait for this scan", "Ask by /upload first");
}

std::optional<std::size_t> PageServer::take_body(const HttpTicket& ticket, std::span<const char> bytes) {
  return upload_.is_of(ticket) ? upload_.take(bytes) : std::nullopt;
}

void PageServer::ended(const HttpTicket& ticket) {
  if (upload_.is_of(ticket)) upload_.drop();
}

/// All of the scan has come: the printer says whether it is kept.
HttpReply PageServer::uploaded(const HttpTicket& ticket) {
  if (!upload_.is_of(ticket)) return refuse(409, "the printer does not wait for this scan", "Ask by /upload first");
  upload_.whole();
  upload_until_ = HostClock::now() + kKeepPatience;
  return HttpLater{};
}

/// Tells the browser what became of its upload, once that is known.
void PageServer::look_at_upload(HttpServer& server, HostClock::time_point now) {
  const auto stage = upload_.stage();
  if (stage == PageUpload::Stage::kWaiting && (now > upload_until_ || !link_.is_open())) {
    server.finish(upload_.ticket(),
                  refuse(504, "the printer has not answered", "Look at what it does, then try again"));
    return upload_.drop();
  }
  if (!link_.is_open() && stage != PageUpload::Stage::kFree) {
    const HttpTicket ticket = upload_.ticket();
    upload_.drop();
    return server.go_on(ticket);
  }
  if (upload_.outcome().empty()) return;
  const HttpTicket ticket = upload_.ticket();
  if (stage == PageUpload::Stage::kWaiting) {
    server.finish(ticket, {.status = upload_.is_kept() ? 200U : 409U, .body = upload_.outcome()});
  }
  // Before its body has come whole, the connection ends when it sends more.
  upload_.drop();
  server.go_on(ticket);
}

std::optional<std::uint64_t> PageServer::in_flight(PictureName name) const {
  for (const Question& question : questions_) {
    if (question.kind == Question::Kind::kPicture && question.picture == name) return question.id;
  }
  return std::nullopt;
}

PageServer::Question* PageServer::free_question() {
  auto* const free = std::find_if(questions_.begin(), questions_.end(),
                                  [](const Question& one) { return one.kind == Question::Kind::kNone; });
  return free != questions_.end() ? free : nullptr;
}

/// @param line  empty: the printer was asked before
/// @returns whether an answer can be expected
bool PageServer::ask(const Question& question, std::string_view line, int file) {
  Question* const place = free_question();
  if (place == nullptr || (!line.empty() && !link_.send(line, file))) return false;
  *place = question;
  place->until = HostClock::now() + kPatience;
  return true;
}

void PageServer::answer_question(HttpServer& server, Question& question, std::string_view line) {
  const Question asked = std::exchange(question, Question());
  const bool is_done = json_member(line, "ok") == "true";
  const bool for_stream = asked.kind == Question::Kind::kReportPart;
  const bool is_command = asked.kind == Question::Kind::kCommand || asked.kind == Question::Kind::kUpload;
  if (!is_done && asked.kind == Question::Kind::kUpload) upload_.drop();
  if (!is_done && !for_stream) {
    return server.finish(asked.ticket, {.status = is_command ? 409U : 404U, .body = line});
  }
  switch (asked.kind) {
    case Question::Kind::kNone: return;
    case Question::Kind::kUpload:
      upload_.accepted(static_cast<std::uint32_t>(whole_number(json_member(line, "upload")).value_or(0)));
      return server.finish(asked.ticket, {.body = line});
    case Question::Kind::kCommand: return server.finish(asked.ticket, {.body = line});
    case Question::Kind::kMask: {
      const auto size = read_base64(plain_text(json_member(line, "png")), mask_);
      return server.finish(asked.ticket, {.status = size ? 200U : 502U,
                                          .type = "image/png",
                                          .body = {reinterpret_cast<const char*>(mask_.data()), size.value_or(0)}});
    }
    case Question::Kind::kPicture: {
      Picture& picture = pictures_[static_cast<std::size_t>(asked.picture)];
      const auto size = read_base64(plain_text(json_member(line, "png")), picture.png);
      picture.size = size.value_or(0);
      picture.number = static_cast<std::uint32_t>(size ? whole_number(json_member(line, "number")).value_or(0) : 0);
      return server.finish(asked.ticket, {.status = size ? 200U : 502U,
                                          .type = "image/png",
                                          .body = {reinterpret_cast<const char*>(picture.png.data()), picture.size}});
    }
    case Question::Kind::kReportBegin: {
      // The answer only says how long it is: a stream asks for it again, from its start.
      text_.clear();
      return server.begin_stream(asked.ticket, {.kind = HttpStream::Kind::kReport,
                                                .size = whole_number(json_member(line, "size")).value_or(0),
                                                .n = asked.print,
                                                .type = "application/json",
                                                .save_as = "report.json"});
    }
    case Question::Kind::kReportPart: {
      Stream& stream = streams_[asked.stream];
      const auto size = is_done ? read_base64(plain_text(json_member(line, "data")), stream.report) : std::nullopt;
      // A report that has become shorter, or can't be read any more, ends the download.
      if (size.value_or(0) == 0) return server.fail(asked.stream);
      stream.report_bytes = *size;
      return server.wake(asked.stream);
    }
  }
}

void PageServer::take_reply(HttpServer& server, std::string_view line) {
  const auto id = whole_number(json_member(line, "id"));
  for (Question& question : questions_) {
    if (question.kind != Question::Kind::kNone && question.id == id) answer_question(server, question, line);
  }
}

void PageServer::end_questions(HttpServer& server, HostClock::time_point now, bool all) {
  for (Question& question : questions_) {
    if (question.kind == Question::Kind::kNone || (!all && now < question.until)) continue;
    const Question asked = std::exchange(question, Question());
    if (asked.kind == Question::Kind::kUpload) upload_.drop();
    if (asked.kind == Question::Kind::kReportPart) {
      server.fail(asked.stream);
    } else {
      server.finish(asked.ticket, refuse(504, "the printer has not answered", "Look at what it does, then try again"));
    }
  }
}

void PageServer::receive(HttpServer& server) {
  const bool was_open = link_.is_open();
  link_.receive();
  while (const auto line = link_.take_line()) {
    const auto type = json_member(*line, "type");
    if (type == "\"reply\"") {
      take_reply(server, *line);
    } else if (type == "\"state\"") {
      state_.clear();
      if (!state_.write(*line)) state_.clear();
      upload_.look_at(*line);
      ++event_;
    }
  }
  if (!was_open || link_.is_open()) return;
  state_.clear();
  ++event_;
  for (Picture& picture : pictures_) picture.number = 0;  // the next daemon counts from 1
  end_questions(server, HostClock::now(), true);
}

std::size_t PageServer::write_event(Stream& stream, std::span<char> out) {
  const auto now = HostClock::now();
  std::string_view parts[] = {":", "", "\n\n"};  // a comment: a sign of life
  if (stream.told != event_) {
    if (now - stream.told_at < kBetweenEvents) {
      owes_event_ = true;
      return 0;
    }
    parts[0] = state_.view().empty() ? "event: lost\ndata: " : "data: ";
    parts[1] = state_.view();
  } else if (now - stream.told_at < kSignOfLife) {
    return 0;
  }
  std::size_t size = 0;
  for (const std::string_view part : parts) {
    part.copy(out.data() + size, part.size());
    size += part.size();
  }
  stream.told = event_;
  stream.told_at = now;
  return size;
}

std::optional<std::size_t> PageServer::write_report(std::size_t place, std::uint32_t print, std::uint64_t sent,
                                                    std::span<char> out) {
  Stream& stream = streams_[place];
  if (stream.report_bytes > 0) {
    const std::size_t size = std::min(out.size(), std::exchange(stream.report_bytes, 0));
    std::memcpy(out.data(), stream.report.data(), size);
    return size;
  }
  Question question{.kind = Question::Kind::kReportPart, .stream = place};
  question.id = ++last_id_;
  if (!ask(question, question_line(report_question(print, sent).c_str(), question.id).view())) return std::nullopt;
  return 0;
}

std::optional<std::size_t> PageServer::fill(std::size_t stream, const HttpStream& what, bool begins, std::uint64_t sent,
                                            std::span<char> out) {
  if (begins) {
    // Nobody waits for what the previous stream of this place has asked.
    for (Question& question : questions_) {
      if (question.kind == Question::Kind::kReportPart && question.stream == stream) question = {};
    }
    streams_[stream].told = 0;
    streams_[stream].told_at = {};
    streams_[stream].report_bytes = 0;
  }
  return what.kind == HttpStream::Kind::kEvents ? write_event(streams_[stream], out)
                                                : write_report(stream, what.n, sent, out);
}

void PageServer::run(HttpServer& server) {
  HostClock::time_point woken{};
  std::uint64_t woken_for = 0;
  for (;;) {
    const auto now = HostClock::now();
    link_.connect(now);
    receive(server);
    end_questions(server, now, false);
    look_at_upload(server, now);
    const bool is_new = event_ != woken_for || owes_event_;
    if (now - woken >= (is_new ? kBetweenEvents : HostClock::duration(kSignOfLife))) {
      woken = now;
      woken_for = event_;
      owes_event_ = false;
      server.wake_all(HttpStream::Kind::kEvents);
    }
    server.run();
    const auto until =
        is_new ? std::min<std::chrono::milliseconds>(server.patience(), kBetweenEvents) : server.patience();
    std::array<pollfd, 3> files{};
    files[0] = {.fd = server.descriptor(), .events = POLLIN, .revents = 0};
    files[1] = {.fd = link_.is_open() ? link_.descriptor() : -1, .events = POLLIN, .revents = 0};
    files[2] = {.fd = upload_.wants_room() ? upload_.descriptor() : -1, .events = POLLOUT, .revents = 0};
    static_cast<void>(::poll(files.data(), files.size(), static_cast<int>(until.count())));
    if (files[2].revents != 0) {
      upload_.has_room();
      server.go_on(upload_.ticket());
    }
  }
}

}  // namespace plumbline
