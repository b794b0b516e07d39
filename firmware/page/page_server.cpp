#include "firmware/page/page_server.hpp"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <utility>

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/base64.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/io/wall_clock.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/page/clients/access.hpp"
#include "firmware/page/octoprint.hpp"
#include "firmware/page/page_files.hpp"
#include "firmware/page/printer_texts.hpp"
#include "firmware/state/socket_place.hpp"

namespace plumbline::firmware::inline page {
namespace {

constexpr std::size_t kMostPng = kLongestLine / 4 * 3;
constexpr std::string_view kPicturePath = "/picture/";
constexpr std::string_view kPrintPicturePath = "/print.png";
constexpr std::string_view kPartPath = "/part";
constexpr std::string_view kProposalPath = "/proposal";
constexpr std::string_view kScanPath = "/scan.png";
constexpr std::string_view kBodyPath = "/upload/body";

using Kind = PrinterQuestion::Kind;

/// A printer that has not answered for so long hangs. It answers between two waits for its stage, lamp or stick.
constexpr std::chrono::seconds kSilence{5}, kBetweenSigns{2};

constexpr std::string_view kTooManyRequests =
    R"({"ok": false, "error": "too many requests come from this device", "advice": "Wait a moment, then try again", )"
    R"("told": {"code": "requests_too_many", "values": {}}})";

/// Commands that a browser may give: those that a state may list, and what somebody says of the tank.
bool is_command(Command command) {
  return static_cast<std::size_t>(command) < kCommandCount || command == Command::kFilled;
}

}  // namespace

PageServer::PageServer(const std::string& socket, PageChoice page, std::string page_host, PairedBrowsers browsers)
    : page_(page),
      page_host_(std::move(page_host)),
      browsers_(std::move(browsers)),
      link_(command_socket(socket)),
      commands_(command_socket(socket)),
      mask_(kMostPng) {
  for (Picture& picture : pictures_) picture.png.resize(kMostPng);
}

bool PageServer::is_paired(const ClientAddress& address) {
  return page_ == PageChoice::kLocal || limits_.is_paired(address, HostClock::now());
}

bool PageServer::is_flooding(const ClientAddress& address) {
  return page_ != PageChoice::kLocal && limits_.is_flooding(address, HostClock::now());
}

/// Whoever is paired is served; what others ask is counted.
std::optional<HttpAnswer> PageServer::refuse_early(const HttpRequest& request) {
  const auto now = HostClock::now();
  if (const auto browser = browsers_.find(request.token)) {
    limits_.showed_token(request.address, *browser, now);
    browsers_.seen(*browser, std::time(nullptr));
    return std::nullopt;
  }
  if (page_ == PageChoice::kLocal) return std::nullopt;
  const bool is_pairing = request.path == "/pair" && request.method == "POST";
  if (limits_.takes_request(request.address, now) && (!is_pairing || limits_.takes_code(request.address, now))) {
    return std::nullopt;
  }
  log_.refused(request.address);
  return HttpAnswer{.status = 429, .body = kTooManyRequests, .is_fixed = true, .closes = true};
}

HttpReply PageServer::answer(const HttpRequest& request, const HttpTicket& ticket) {
  if (!is_known_host(request.host, page_, page_host_)) {
    return text_.refuse(
        421, "this machine is not known by that name",
        page_ == PageChoice::kLocal ? "Open http://localhost" : "Use its address, or set [printer] page_host");
  }
  if (request.method == "GET" || request.method == "HEAD") return get(request, ticket);
  if (request.method == "POST") return post(request, ticket);
  HttpAnswer answer = text_.refuse(405, "only GET and POST are served");
  answer.allow = "GET, HEAD, POST";
  return answer;
}

HttpReply PageServer::get(const HttpRequest& request, const HttpTicket& ticket) {
  for (const PageFile& file : page_files()) {
    if (request.path != file.path) continue;
    return HttpAnswer{.type = file.type,
                      .body = request.takes_gzip ? file.packed : file.text,
                      .is_fixed = true,
                      .is_gzip = request.takes_gzip};
  }
  if (request.path == "/events") return HttpStream{};
  if (request.path == "/access") return access(request);
  if (request.path == "/browsers") return browsers(request);
  if (request.path == "/api/version") return text_.text([](TextSink& out) { return write_octoprint_version(out); });
  if (request.path == "/api/job") {
    return text_.text([this](TextSink& out) { return write_octoprint_job(out, state_.view()); });
  }
  if (request.path == "/api/printer") {
    return text_.text([this](TextSink& out) { return write_octoprint_printer(out, state_.view()); });
  }
  const bool is_picture = request.path.starts_with(kPicturePath);
  const bool is_mask = request.path == "/mask", is_report = request.path == "/report.json";
  const bool is_print = request.path == kPrintPicturePath, is_part = request.path == kPartPath;
  const bool is_proposal = request.path == kProposalPath, is_scan = request.path == kScanPath;
  if (!is_picture && !is_mask && !is_report && !is_print && !is_part && !is_proposal && !is_scan &&
      request.path != "/state")
    return text_.refuse(404, "there is no such page");
  if (state_.view().empty()) return text_.no_daemon();
  if (request.path == "/state") return HttpAnswer{.body = state_.view()};
  // What belongs to a job is that of the job that the browser shows, or else nothing. A script that names none gets the state's.
  const auto named = id_of(request.job);
  if (!request.job.empty() && !named)
    return text_.refuse(400, "which job?", "Ask with job=, the id of the state's job");
  const std::uint64_t job = named.value_or(job_of(state_.view()));
  if (is_part && job == 0) return text_.refuse(404, "there is no job now");
  if (is_picture) {
    const std::string_view name = request.path.substr(kPicturePath.size());
    const auto* const word = std::find(kPictureWords.begin(), kPictureWords.end(), name);
    if (word == kPictureWords.end()) return text_.refuse(404, "there is no such picture");
    return picture(static_cast<PictureName>(word - kPictureWords.begin()), job, ticket);
  }
  // The preview of a print that is kept is one picture in one reply, as a mask is, and so is a proposal.
  const PrinterQuestion question{.kind = is_report || is_part ? Kind::kFileBegin : Kind::kMask,
                                 .ticket = ticket,
                                 .job = is_part ? job : 0,
                                 .print = is_report ? request.n.value_or(0) : 0};
  FixedText<140> what;
  if (is_print) {
    if (request.n.value_or(0) == 0) return text_.refuse(400, "which print?", "Ask for /print.png?n=1");
    what.add(R"("do": "picture", "picture": "preview", "print": %u)", *request.n);
  } else if (is_proposal) {
    if (request.n.value_or(kProposalCount) >= kProposalCount)
      return text_.refuse(400, "which proposal?", "Ask for /proposal?n=1");
    what.add(R"("do": "picture", "picture": "proposal", "proposal": %u%s)", *request.n, job_member(job).c_str());
  } else if (is_scan) {
    const std::uint32_t scan = request.n.value_or(0);
    if (scan == 0 || scan > kMostListedScans) return text_.refuse(400, "which scan?", "Ask for /scan.png?n=1");
    what.add(R"("do": "picture", "picture": "scan", "scan": %u)", scan);
  } else if (is_mask) {
    if (!request.n) return text_.refuse(400, "which layer?", "Ask for /mask?n=0");
    const auto& [x, y, step] = request.window;
    what.add(R"("do": "mask", "layer": %u, "x": %u, "y": %u, "step": %u%s)", *request.n, x, y, step,
             job_member(job).c_str());
  } else {
    what.add("%s", file_question(question.print, question.job, 0).c_str());
  }
  if (!questions_.ask(question, what.c_str())) return text_.refuse(503, "the printer is busy");
  return HttpLater{};
}

/// What this browser may do.
HttpAnswer PageServer::access(const HttpRequest& request) {
  return text_.object([&](JsonWriter& json) {
    json.member("page", page_ == PageChoice::kLocal ? "local" : "network");
    json.member("paired", browsers_.find(request.token).has_value());
  });
}

/// Those that are paired, for those that are.
HttpAnswer PageServer::browsers(const HttpRequest& request) {
  const auto own = browsers_.find(request.token);
  if (!own) return not_paired();
  return text_.object([&](JsonWriter& json) {
    json.begin_array("browsers", kOneLine);
    for (const PairedBrowsers::Browser& one : browsers_.list()) {
      if (one.number == 0) continue;
      json.begin_object(kOneLine);
      json.member("number", one.number);
      json.member("name", std::string_view(one.name));
      json.member("paired_at", utc_text(known_time(one.paired_at)));
      json.member("seen_at", utc_text(known_time(one.seen_at)));
      json.member("this", one.number == *own);
      json.end_object();
    }
    json.end_array();
  });
}

/// {"browser": 3}: that one may command no more.
HttpAnswer PageServer::forget(const HttpRequest& request) {
  const auto number = whole_number(json_member(request.body, "browser")).value_or(0);
  if (number > UINT32_MAX || !browsers_.forget(static_cast<std::uint32_t>(number))) {
    return text_.refuse(409, "there is no such browser", "Look at the list again");
  }
  limits_.forget(static_cast<std::uint32_t>(number));
  FixedText<80> text;
  text.add("forgot browser %u", static_cast<unsigned>(number));
  log_.say(text.view(), HostClock::now());
  return text_.object([](JsonWriter& json) { json.member("ok", true); });
}

HttpReply PageServer::picture(PictureName name, std::uint64_t job, const HttpTicket& ticket) {
  const Picture& kept = pictures_[static_cast<std::size_t>(name)];
  const std::string_view word = kPictureWords[static_cast<std::size_t>(name)];
  const auto pictures = json_member(state_.view(), "pictures");
  const auto number = pictures ? whole_number(json_member(*pictures, word)) : std::nullopt;
  const bool is_at_hand = job == job_of(state_.view());
  if (is_at_hand && !number) return text_.refuse(404, "there is no such picture now");
  if (is_at_hand && kept.number == *number) {
    return HttpAnswer{.type = "image/png", .body = {reinterpret_cast<const char*>(kept.png.data()), kept.size}};
  }
  PrinterQuestion question{.kind = Kind::kPicture, .ticket = ticket, .picture = name, .job = job};
  if (const auto id = questions_.in_flight(name, job)) {
    question.id = *id;
    return questions_.ask(question, std::string_view()) ? HttpReply(HttpLater{})
                                                        : text_.refuse(503, "the printer is busy");
  }
  FixedText<100> what;
  what.add(R"("do": "picture", "picture": "%.*s"%s)", static_cast<int>(word.size()), word.data(),
           job_member(job).c_str());
  if (!questions_.ask(question, what.c_str())) return text_.refuse(503, "the printer is busy");
  return HttpLater{};
}

HttpReply PageServer::post(const HttpRequest& request, const HttpTicket& ticket) {
  if (request.path == kBodyPath) return uploads_.whole(ticket);
  if (request.path != "/command" && request.path != "/pair" && request.path != "/upload" && request.path != "/forget") {
    HttpAnswer answer = text_.refuse(405, "nothing can be sent there");
    answer.allow = "GET, HEAD";
    return answer;
  }
  if (const auto refusal = distrust(request, "application/json")) return *refusal;
  if (request.path == "/pair") return pair(request);
  if (!browsers_.find(request.token)) return not_paired();
  if (request.path == "/forget") return forget(request);
  return request.path == "/upload" ? uploads_.ask(request.body, ticket) : command(request, ticket);
}

/// Refuses what the page's own script would not send.
std::optional<HttpAnswer> PageServer::distrust(const HttpRequest& request, std::string_view type) {
  if (!is_same_origin(request.host, request.origin))
    return text_.refuse(403, "only the printer's own page may do that");
  if (request.content_type.starts_with(type)) return std::nullopt;
  FixedText<80> text;
  text.add("what is sent must be %.*s", static_cast<int>(type.size()), type.data());
  return text_.refuse(415, text.c_str());
}

/// {}: show a code on the screen, or pair at once if only this machine can ask. {"code": "482913"}: the person has read it.
/// {"stop": true}: the browser wants none any more. "ask" is what the browser calls itself meanwhile, "name" what it is called in the list.
HttpReply PageServer::pair(const HttpRequest& request) {
  if (page_ == PageChoice::kLocal) return paired_at_once();
  const auto now = HostClock::now();
  const Asker asker{plain_text(json_member(request.body, "ask")), request.address};
  if (asker.name.size() > PairingCodes::kLongestName) return text_.refuse(400, "\"ask\" has more than 64 characters");
  const std::string_view code = plain_text(json_member(request.body, "code"));
  std::optional<PageToken> token;
  std::optional<Error> problem;
  if (json_member(request.body, "stop") == "true") {
    codes_.give_up(asker);
  } else if (code.empty()) {
    if (!commands_.is_open()) return text_.no_daemon();
    if (const auto asked = codes_.ask(asker, now); !asked) problem = asked.error();
  } else if (const auto used = codes_.use(code, asker, now); !used) {
    problem = used.error();
  } else {
    const std::string_view name = plain_text(json_member(request.body, "name"));
    token = browsers_.add(name, std::time(nullptr));
    const auto number = browsers_.find(token->view()).value_or(0);
    limits_.showed_token(request.address, number, now);
    FixedText<160> text;
    text.add("paired browser %u at %s: %.*s", number, text_of(request.address).c_str(), static_cast<int>(name.size()),
             name.data());
    log_.say(text.view(), now);
  }
  show_code(now);
  if (problem) return text_.refuse(problem->code() == ErrorCode::kBusy ? 429 : 403, *problem);
  return text_.object([&](JsonWriter& json) {
    json.member("ok", true);
    if (token) json.member("token", token->view());
  });
}

/// Whoever uses this machine may command the printer, so all its browsers have one token.
HttpAnswer PageServer::paired_at_once() {
  if (!browsers_.find(local_token_.view())) local_token_ = browsers_.add("this machine", std::time(nullptr));
  return text_.object([&](JsonWriter& json) {
    json.member("ok", true);
    json.member("token", local_token_.view());
  });
}

/// Has the printer show the code there is, if that has changed.
void PageServer::show_code(HostClock::time_point now) {
  const std::string_view code = codes_.shown(now);
  if (code == shown_.view()) return;
  FixedText<60> what;
  what.add(R"("do": "code", "code": "%.*s")", static_cast<int>(code.size()), code.data());
  static_cast<void>(commands_.send(question_line(what.c_str(), orders_.next_id()).view()));
  shown_.clear();
  shown_.add("%.*s", static_cast<int>(code.size()), code.data());
  if (code.empty()) return;
  // For a printer without a screen: whoever may read the log of the machine may command it.
  std::fprintf(stderr, "plumbline-page: the code for a browser is %s\n", shown_.c_str());
}

HttpReply PageServer::command(const HttpRequest& request, const HttpTicket& ticket) {
  std::optional<std::uint64_t> id;
  const auto asked = parse_request(request.body, id);
  if (!asked) return text_.refuse(400, asked.error());
  if (!is_command(asked->command)) return text_.refuse(400, "a browser can't command that");
  const PrinterQuestion question{.kind = Kind::kCommand, .id = orders_.next_id(), .ticket = ticket};
  TextBuffer<1024> line;
  if (!write_request(line, *asked, question.id)) return text_.refuse(400, "the command is too long");
  if (!orders_.ask(question, line.view())) return text_.no_daemon();
  return HttpLater{};
}

HttpAnswer PageServer::not_paired() { return text_.refuse(401, "this browser is not paired with the printer"); }

bool PageServer::streams_body(std::string_view path) { return path == kBodyPath; }

std::optional<HttpAnswer> PageServer::begin_body(const HttpRequest& request, std::uint64_t bytes,
                                                 const HttpTicket& ticket) {
  if (!is_known_host(request.host, page_, page_host_))
    return text_.refuse(421, "this machine is not known by that name");
  if (request.method != "POST") {
    HttpAnswer answer = text_.refuse(405, "a scan is sent by POST");
    answer.allow = "POST";
    return answer;
  }
  if (const auto refusal = distrust(request, "application/octet-stream")) return refusal;
  if (!browsers_.find(request.token)) return not_paired();
  return uploads_.begin_body(request.n.value_or(0), bytes, ticket);
}

std::optional<std::size_t> PageServer::take_body(const HttpTicket& ticket, std::span<const char> bytes) {
  return uploads_.take_body(ticket, bytes);
}

void PageServer::ended(const HttpTicket& ticket) { uploads_.ended(ticket); }

void PageServer::answer_question(HttpServer& server, const PrinterQuestion& asked, std::string_view line) {
  if (asked.kind == Kind::kAlive) {
    if (!std::exchange(lives_, true)) streams_.tell();
    return;
  }
  const bool is_done = json_member(line, "ok") == "true";
  const bool for_stream = asked.kind == Kind::kFilePart;
  const bool is_command = asked.kind == Kind::kCommand || asked.kind == Kind::kUpload;
  if (asked.kind == Kind::kUpload) uploads_.answered(is_done ? line : std::string_view());
  if (!is_done && !for_stream) {
    const auto told = json_member(line, "told");
    const bool is_stale =
        told && plain_text(json_member(*told, "code")) == to_string(Told(PrinterCode::kJobStale).code);
    return server.finish(asked.ticket, {.status = is_command ? 409U : is_stale ? 410U : 404U, .body = line});
  }
  switch (asked.kind) {
    case Kind::kNone:
    case Kind::kAlive: return;
    case Kind::kUpload:
    case Kind::kCommand: return server.finish(asked.ticket, {.body = line});
    case Kind::kMask: {
      const auto size = read_base64(plain_text(json_member(line, "png")), mask_);
      return server.finish(asked.ticket, {.status = size ? 200U : 502U,
                                          .type = "image/png",
                                          .body = {reinterpret_cast<const char*>(mask_.data()), size.value_or(0)}});
    }
    case Kind::kPicture: {
      Picture& picture = pictures_[static_cast<std::size_t>(asked.picture)];
      const auto size = read_base64(plain_text(json_member(line, "png")), picture.png);
      picture.size = size.value_or(0);
      picture.number = static_cast<std::uint32_t>(size ? whole_number(json_member(line, "number")).value_or(0) : 0);
      return server.finish(asked.ticket, {.status = size ? 200U : 502U,
                                          .type = "image/png",
                                          .body = {reinterpret_cast<const char*>(picture.png.data()), picture.size}});
    }
    case Kind::kFileBegin: {
      // The answer only says how long it is: a stream asks for it again, from its start.
      return server.begin_stream(asked.ticket,
                                 {.kind = HttpStream::Kind::kParts,
                                  .size = whole_number(json_member(line, "size")).value_or(0),
                                  .n = asked.print,
                                  .job = asked.job,
                                  .type = asked.job == 0 ? "application/json" : "application/octet-stream",
                                  .save_as = asked.job == 0 ? "report.json" : nullptr});
    }
    case Kind::kFilePart: {
      const auto data = is_done ? plain_text(json_member(line, "data")) : std::string_view();
      // A report that has become shorter, or can't be read any more, ends the download.
      if (!streams_.put_report(asked.stream, data)) return server.fail(asked.stream);
      return server.wake(asked.stream);
    }
  }
}

/// Ends those that wait too long, and all of a connection that is gone.
void PageServer::end_questions(HttpServer& server, PrinterLink& link, PrinterQuestions& questions,
                               HostClock::time_point now) {
  while (const auto asked = questions.take_late(now, !link.is_open())) {
    // The printer must not do later what a browser has given up: it carries out no command of a connection that has ended.
    if (&link == &commands_) link.end();
    if (asked->kind == Kind::kUpload) uploads_.answered({});
    if (asked->kind == Kind::kAlive) continue;
    if (asked->kind == Kind::kFilePart) {
      server.fail(asked->stream);
    } else if (&link == &commands_) {
      server.finish(asked->ticket,
                    text_.refuse(504, "the printer has not answered, so the command was withdrawn",
                                 "Look at what it does, then try again", PrinterCode::kCommandWithdrawn));
    } else {
      server.finish(asked->ticket,
                    text_.refuse(504, "the printer has not answered", "Look at what it does, then try again"));
    }
  }
}

void PageServer::receive_replies(HttpServer& server, PrinterLink& link, PrinterQuestions& questions) {
  link.receive();
  while (const auto line = link.take_line()) {
    const auto type = json_member(*line, "type");
    if (type == "\"reply\"") {
      const auto id = whole_number(json_member(*line, "id"));
      while (const auto asked = questions.take(id)) answer_question(server, *asked, *line);
    } else if (type == "\"state\"" && &link == &link_) {
      state_.clear();
      if (!state_.write(*line)) state_.clear();
      uploads_.look_at(*line);
      streams_.tell();
    }
  }
}

/// Asks now and then for something that costs nothing. A process that is stopped keeps its connection.
void PageServer::look_for_life(HostClock::time_point now) {
  if (!link_.is_open()) {
    lives_ = true;  // that it is gone is said by itself
    return;
  }
  const bool waits = questions_.is_asked(Kind::kAlive);
  if (waits && now - asked_for_life_ > kSilence && std::exchange(lives_, false)) streams_.tell();
  if (waits || now - asked_for_life_ < kBetweenSigns) return;
  if (questions_.ask({.kind = Kind::kAlive}, R"("do": "picture", "picture": "part", "from": 9007199254740992)")) {
    if (lives_) asked_for_life_ = now;
  }
}

void PageServer::lose_printer() {
  state_.clear();
  streams_.tell();
  for (Picture& picture : pictures_) picture.number = 0;  // the next daemon counts from 1
}

std::optional<std::size_t> PageServer::fill(std::size_t stream, const HttpStream& what, bool begins, std::uint64_t sent,
                                            std::span<char> out) {
  if (begins) {
    // Nobody waits for what the previous stream of this place has asked.
    questions_.forget(stream);
    streams_.begin(stream);
  }
  if (what.kind == HttpStream::Kind::kEvents) return streams_.write_event(stream, state_.view(), lives_, out);
  if (const std::size_t written = streams_.write_report(stream, out); written > 0) return written;
  const PrinterQuestion question{.kind = Kind::kFilePart, .stream = stream};
  if (!questions_.ask(question, file_question(what.n, what.job, sent).c_str())) return std::nullopt;
  return 0;
}

void PageServer::run(HttpServer& server) {
  for (bool was_there = false;;) {
    const auto now = HostClock::now();
    receive_replies(server, link_, questions_);
    receive_replies(server, commands_, orders_);
    if (was_there && !link_.is_open()) lose_printer();
    end_questions(server, link_, questions_, now);
    end_questions(server, commands_, orders_, now);
    // The next daemon does not know the code.
    if (!commands_.is_open()) shown_.clear();
    link_.connect(now);
    commands_.connect(now);
    if (commands_.is_open()) show_code(now);
    was_there = link_.is_open();
    look_for_life(now);
    uploads_.serve(server, now, commands_.is_open());
    const bool hurries = streams_.hurries();
    if (streams_.wakes(now)) server.wake_all(HttpStream::Kind::kEvents);
    server.run();
    log_.turned_away(server.take_turned_away());
    log_.count(now);
    const auto until = std::min<std::chrono::milliseconds>(
        server.patience(), hurries ? std::chrono::milliseconds(PageStreams::kBetweenEvents) : std::chrono::seconds(1));
    std::array<pollfd, 4> files{};
    files[0] = {.fd = server.descriptor(), .events = POLLIN, .revents = 0};
    files[1] = {.fd = link_.is_open() ? link_.descriptor() : -1, .events = POLLIN, .revents = 0};
    files[2] = {.fd = uploads_.awaited(), .events = POLLOUT, .revents = 0};
    files[3] = {.fd = commands_.is_open() ? commands_.descriptor() : -1, .events = POLLIN, .revents = 0};
    static_cast<void>(::poll(files.data(), files.size(), static_cast<int>(until.count())));
    if (files[2].revents != 0) uploads_.has_room(server);
  }
}

}  // namespace plumbline::firmware::inline page
