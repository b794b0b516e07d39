#include "firmware/state/socket_place.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace plumbline::firmware::inline state {

Expected<SocketPlace> SocketPlace::at(const std::string& path) {
  const std::filesystem::path file(path);
  SocketPlace place;
  place.path_ = path;
  place.name_ = file.filename();
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  place.folder_ = Descriptor(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  constexpr std::size_t kLongestName = 64;  // beside /proc/self/fd/N/
  if (place.folder_.is_open() && !place.name_.empty() && place.name_.size() <= kLongestName) return place;
  const int reason = place.folder_.is_open() ? ENAMETOOLONG : errno;
  return fail(ErrorCode::kCannotOpen, "%s: %s.\tName another socket: 'state_socket' in the board file, or --socket",
              path.c_str(), std::strerror(reason));
}

sockaddr_un SocketPlace::address() const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/%s", folder_.get(), name_.c_str());
  return address;
}

Descriptor SocketPlace::connect() const {
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_un to = address();
  if (!socket.is_open()) return socket;
  // Without it a daemon that hangs, and lets nobody in, would hold up everybody.
  const timeval bound{.tv_sec = 2, .tv_usec = 0};
  static_cast<void>(::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &bound, sizeof bound));
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return socket;
  const int reason = errno;
  socket = Descriptor();  // closed before errno is set
  errno = reason;
  return socket;
}

}  // namespace plumbline::firmware::inline state
