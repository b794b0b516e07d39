#pragma once

#include <sys/un.h>

#include <string>

#include "firmware/io/descriptor.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline state {

/// Where the daemon serves the printer's state, unless the board file or the command line names another place.
inline constexpr const char* kStateSocket = "/run/plumbline/state";
/// The socket for commands is beside it.
inline std::string command_socket(const std::string& state_socket) { return state_socket + ".command"; }

/// The file of a Unix socket. Reached through a descriptor of its folder: an address has room for 107 characters, a path may have more.
class SocketPlace {
 public:
  /// @param path  its folder exists; the file need not
  /// @retval ErrorCode::kCannotOpen  the folder, the reason
  [[nodiscard]] static Expected<SocketPlace> at(const std::string& path);

  sockaddr_un address() const;
  /// A socket that is connected to it, SOCK_STREAM; not open: errno has the reason, EAGAIN if nobody was let in for 2 s.
  Descriptor connect() const;

  const std::string& path() const { return path_; }
  int folder() const { return folder_.get(); }
  const std::string& name() const { return name_; }  ///< in the folder

 private:
  SocketPlace() = default;

  std::string path_;
  std::string name_;
  Descriptor folder_;
};

}  // namespace plumbline::firmware::inline state
