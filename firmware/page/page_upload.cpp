#include "firmware/page/page_upload.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <utility>

#include "firmware/io/text/json_cursor.hpp"

namespace plumbline::firmware::inline page {

Descriptor PageUpload::offer(std::uint64_t bytes) {
  std::array<int, 2> ends{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) return Descriptor();
  drop();
  into_ = Descriptor(ends[0]);
  stage_ = Stage::kAsked;
  bytes_ = bytes;
  return Descriptor(ends[1]);
}

void PageUpload::accepted(std::uint32_t number) {
  if (stage_ != Stage::kAsked) return;
  number_ = number;
  stage_ = Stage::kReady;
}

void PageUpload::drop() {
  const Descriptor gone = std::exchange(into_, Descriptor());
  stage_ = Stage::kFree;
  wants_room_ = is_kept_ = false;
  outcome_.clear();
}

bool PageUpload::begin(std::uint32_t number, std::uint64_t bytes, const HttpTicket& ticket) {
  if (stage_ != Stage::kReady || number != number_ || bytes != bytes_) return false;
  ticket_ = ticket;
  stage_ = Stage::kComing;
  return true;
}

std::optional<std::size_t> PageUpload::take(std::span<const char> bytes) {
  if (!into_.is_open() || !outcome().empty()) return std::nullopt;
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t put = ::send(into_.get(), bytes.data() + sent, bytes.size() - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return std::nullopt;
    if (put < 0) {
      wants_room_ = true;
      break;
    }
    sent += static_cast<std::size_t>(put);
  }
  return sent;
}

void PageUpload::whole() {
  // The printer has all of it only at the end of the stream.
  const Descriptor done = std::exchange(into_, Descriptor());
  stage_ = Stage::kWaiting;
}

bool PageUpload::is_of(const HttpTicket& ticket) const {
  const bool has_request = stage_ == Stage::kComing || stage_ == Stage::kWaiting;
  return has_request && ticket.place == ticket_.place && ticket.number == ticket_.number;
}

void PageUpload::look_at(std::string_view state) {
  if (stage_ == Stage::kFree || stage_ == Stage::kAsked || !outcome().empty()) return;
  const auto upload = json_member(state, "upload");
  const auto text = upload ? json_member(*upload, "number") : std::nullopt;
  std::uint32_t number = 0;
  if (!text || std::from_chars(text->data(), text->data() + text->size(), number).ec != std::errc()) return;
  if (number < number_) return;
  const auto stage = json_member(*upload, "stage");
  if (number == number_ && stage == "\"coming\"") return;
  if (number == number_ && stage == "\"kept\"") {
    is_kept_ = true;
    outcome_.add(R"({"ok": true})");
    return;
  }
  const auto problem = number == number_ ? json_member(*upload, "problem").value_or("null") : "null";
  const bool is_known = problem.size() + 40 < 512;  // a text as the printer wrote it
  outcome_.add(R"({"ok": false, "error": %.*s})", is_known ? static_cast<int>(problem.size()) : 4,
               is_known ? problem.data() : "null");
}

}  // namespace plumbline::firmware::inline page
