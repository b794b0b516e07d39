#include "firmware/cli/scan_upload.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include "firmware/cli/reports/status_text.hpp"
#include "firmware/daemon/upload/upload_name.hpp"
#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_link.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {
namespace {

/// Slow storage has to be written before the printer says that a scan is kept.
constexpr std::chrono::minutes kKeepPatience{2};

std::uint64_t number_of(std::string_view object, std::string_view key) {
  std::uint64_t number = 0;
  const auto text = json_member(object, key).value_or("");
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Sends a file until it ends, as it was announced, or the printer takes no more: that says why.
/// @retval ErrorCode::kCannotRead
Status send_bytes(const Descriptor& from, std::uint64_t bytes, const Descriptor& into) {
  std::vector<std::byte> part(std::size_t{64} * 1024);
  while (bytes > 0) {
    const auto now = std::span(part).first(static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), bytes)));
    if (!from.read_all(now)) {
      return fail(ErrorCode::kCannotRead, "%s", errno == 0 ? "the file has become shorter" : std::strerror(errno));
    }
    for (auto rest = now; !rest.empty();) {
      const ssize_t put = ::send(into.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return {};
      rest = rest.subspan(static_cast<std::size_t>(put));
    }
    bytes -= now.size();
  }
  return {};
}

/// Waits until the printer says what became of an upload.
Status wait_until_kept(StateLink& link, std::uint64_t number) {
  for (;;) {
    const auto state = link.next_of_type("state", kKeepPatience);
    PLUMBLINE_TRY(state);
    const std::string_view upload = json_member(*state, "upload").value_or("");
    const std::uint64_t newest = number_of(upload, "number");
    const std::string stage = json_text(upload, "stage");
    if (newest < number || (newest == number && stage == "coming")) continue;
    if (newest == number && stage == "kept") return {};
    return fail(ErrorCode::kCannotWrite, "%s",
                newest == number ? json_text(upload, "problem").c_str() : "another scan is uploaded already");
  }
}

}  // namespace

Expected<std::string> upload_scan(const std::string& socket, const std::string& file) {
  const PrintableText path(file, 200);
  const Descriptor scan(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat facts {};
  if (!scan.is_open() || ::fstat(scan.get(), &facts) != 0) {
    return fail(ErrorCode::kCannotOpen, "%s: %s", path.c_str(), std::strerror(errno));
  }
  if (!S_ISREG(facts.st_mode))
    return fail(ErrorCode::kCannotOpen, "%s: is not a file.\tName a scan or a mesh", path.c_str());
  const auto bytes = static_cast<std::uint64_t>(facts.st_size);
  ClientRequest request;
  request.command = Command::kUpload;
  request.name = upload_name_of(std::filesystem::path(file).filename().string());
  request.bytes = bytes;
  TextBuffer<kLongestRequest + 1> line;
  PLUMBLINE_TRY(write_request(line, request, 1));
  auto link = StateLink::open(socket, true);
  PLUMBLINE_TRY(link);
  std::array<int, 2> ends{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return fail(ErrorCode::kCannotOpen, "no socket for the scan: %s", std::strerror(errno));
  }
  Descriptor ours(ends[0]);
  {
    const Descriptor theirs(ends[1]);
    PLUMBLINE_TRY(link->send(std::string(line.view()), theirs.get()));
  }
  const auto reply = link->next_of_type("reply");
  PLUMBLINE_TRY(reply);
  if (json_member(*reply, "ok") != "true") {
    return fail(ErrorCode::kBadSetting, "%s.\t%s", json_text(*reply, "error").c_str(),
                json_text(*reply, "advice").c_str());
  }
  // Beside it this thread reads what the printer says meanwhile.
  Status sent;
  std::thread sender([&] {
    sent = send_bytes(scan, bytes, ours);
    ::shutdown(ours.get(), SHUT_WR);  // all of it, or the printer sees that not all came
  });
  const auto kept = wait_until_kept(*link, number_of(*reply, "upload"));
  if (!kept) ::shutdown(ours.get(), SHUT_RDWR);
  sender.join();
  if (!sent) return fail(sent.error().code(), "%s: %s", path.c_str(), sent.error().message());
  PLUMBLINE_TRY(kept);
  return std::string(request.name.view());
}

}  // namespace plumbline::firmware
