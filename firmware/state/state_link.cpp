#include "firmware/state/state_link.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>

#include "firmware/io/text/json_cursor.hpp"
#include "firmware/state/socket_place.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline::firmware::inline state {

Expected<StateLink> StateLink::open(const std::string& path, bool commands) {
  StateLink link;
  link.path_ = commands ? command_socket(path) : path;
  const auto place = SocketPlace::at(link.path_);
  if (!place && place.error().code() != ErrorCode::kCannotOpen) return tl::unexpected<Error>(place.error());
  if (place) link.socket_ = place->connect();
  if (link.socket_.is_open()) return link;
  const int reason = place ? errno : ENOENT;
  if (reason == EACCES || reason == EPERM) {
    return fail(ErrorCode::kCannotOpen,
                "%s: this user may not command the printer.\tAdd it to the group that 'ls -l' shows",
                link.path_.c_str());
  }
  if (reason == ENOENT || reason == ECONNREFUSED) {
    return fail(ErrorCode::kCannotOpen, "no plumblined serves its state at %s.\tStart it, or name its --socket",
                path.c_str());
  }
  return fail(ErrorCode::kCannotOpen, "%s: %s", link.path_.c_str(), std::strerror(reason));
}

Expected<std::optional<std::string>> StateLink::next_line(std::optional<std::chrono::milliseconds> patience) {
  for (;;) {
    if (const auto end = received_.find('\n'); end != std::string::npos) {
      std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      return line;
    }
    pollfd readable{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    const int ready = ::poll(&readable, 1, patience ? static_cast<int>(patience->count()) : -1);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) {
      return fail(ErrorCode::kDeviceTimeout, "%s: plumblined does not answer.\tLook at its log", path_.c_str());
    }
    std::array<char, 4096> bytes;
    const ssize_t got = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno != ECONNRESET) {
      return fail(ErrorCode::kCannotRead, "%s: %s", path_.c_str(), std::strerror(errno));
    }
    if (got <= 0) return std::nullopt;
    received_.append(bytes.data(), static_cast<std::size_t>(got));
  }
}

Expected<std::string> StateLink::next_of_type(std::string_view type, std::chrono::milliseconds patience) {
  for (;;) {
    auto line = next_line(patience);
    PLUMBLINE_TRY(line);
    if (!*line) return fail(ErrorCode::kCannotRead, "%s: plumblined has ended", path_.c_str());
    const auto found = json_member(**line, "type");
    if (found && found->size() == type.size() + 2 && found->substr(1, type.size()) == type) return std::move(**line);
    // Before a state or an answer, a refused connection gets a reply without a number.
    if (type == "state" && found == "\"reply\"") {
      const auto reason = json_member(**line, "error").value_or("");
      return fail(ErrorCode::kCannotOpen, "%s: %.*s", path_.c_str(), static_cast<int>(reason.size()), reason.data());
    }
  }
}

Status StateLink::send(const std::string& line, int file) {
  if (send_message(socket_.get(), std::as_bytes(std::span(line)), std::span(&file, file >= 0 ? 1 : 0))) return {};
  return fail(ErrorCode::kCannotWrite, "%s: %s", path_.c_str(), std::strerror(errno));
}

}  // namespace plumbline::firmware::inline state
