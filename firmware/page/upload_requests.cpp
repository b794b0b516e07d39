#include "firmware/page/upload_requests.hpp"

#include "firmware/io/text/json_cursor.hpp"
#include "firmware/page/printer_texts.hpp"

namespace plumbline::firmware::inline page {

HttpReply UploadRequests::ask(std::string_view body, const HttpTicket& ticket) {
  std::optional<std::uint64_t> id;
  const auto asked = parse_request(body, id);
  if (!asked) return text_.refuse(400, asked.error());
  if (asked->command != Command::kUpload) return text_.refuse(400, "only an upload may be asked for there");
  if (upload_.stage() != PageUpload::Stage::kFree) {
    return text_.refuse(409, "another scan is being uploaded", "Try again when it has come");
  }
  const PrinterQuestion question{.kind = PrinterQuestion::Kind::kUpload, .id = questions_.next_id(), .ticket = ticket};
  TextBuffer<1024> line;
  if (!write_request(line, *asked, question.id)) return text_.refuse(400, "the name is too long");
  const Descriptor for_printer = upload_.offer(asked->bytes);
  if (!for_printer.is_open()) return text_.refuse(503, "the page has no room for an upload", "Try again");
  if (questions_.ask(question, line.view(), for_printer.get())) return HttpLater{};
  upload_.drop();
  return text_.no_daemon();
}

void UploadRequests::answered(std::string_view reply) {
  if (reply.empty()) return upload_.drop();
  upload_.accepted(static_cast<std::uint32_t>(whole_number(json_member(reply, "upload")).value_or(0)));
}

std::optional<HttpAnswer> UploadRequests::begin_body(std::uint32_t number, std::uint64_t bytes,
                                                     const HttpTicket& ticket) {
  if (upload_.begin(number, bytes, ticket)) return std::nullopt;
  return text_.refuse(409, "the printer does not wait for this scan", "Ask by /upload first");
}

std::optional<std::size_t> UploadRequests::take_body(const HttpTicket& ticket, std::span<const char> bytes) {
  return upload_.is_of(ticket) ? upload_.take(bytes) : std::nullopt;
}

void UploadRequests::ended(const HttpTicket& ticket) {
  if (upload_.is_of(ticket)) upload_.drop();
}

HttpReply UploadRequests::whole(const HttpTicket& ticket) {
  if (!upload_.is_of(ticket)) {
    return text_.refuse(409, "the printer does not wait for this scan", "Ask by /upload first");
  }
  upload_.whole();
  until_ = HostClock::now() + kKeepPatience;
  return HttpLater{};
}

void UploadRequests::serve(HttpServer& server, HostClock::time_point now, bool is_there) {
  const auto stage = upload_.stage();
  if (stage == PageUpload::Stage::kWaiting && (now > until_ || !is_there)) {
    server.finish(upload_.ticket(),
                  text_.refuse(504, "the printer has not answered", "Look at what it does, then try again"));
    return upload_.drop();
  }
  if (!is_there && stage != PageUpload::Stage::kFree) {
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

void UploadRequests::has_room(HttpServer& server) {
  upload_.has_room();
  server.go_on(upload_.ticket());
}

}  // namespace plumbline::firmware::inline page
