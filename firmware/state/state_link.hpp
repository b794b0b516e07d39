#pragma once
/// The other end of the state socket: for `plumbline status` and `plumbline ctl`.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline state {

class StateLink {
 public:
  /// More than a living daemon takes to answer.
  static constexpr std::chrono::seconds kPatience{10};

  /// @param path      the state socket's
  /// @param commands  connect to the socket for commands that is beside it
  /// @retval ErrorCode::kCannotOpen  no daemon serves there, or this user may not command
  [[nodiscard]] static Expected<StateLink> open(const std::string& path, bool commands);

  /// The next line, without its end.
  /// @param patience  none: for ever
  /// @returns none: the daemon has ended
  /// @retval ErrorCode::kDeviceTimeout  nothing came
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] Expected<std::optional<std::string>> next_line(std::optional<std::chrono::milliseconds> patience);
  /// The next line of a type: "state", "reply".
  /// @retval the errors of next_line()
  /// @retval ErrorCode::kCannotRead  the daemon has ended
  [[nodiscard]] Expected<std::string> next_of_type(std::string_view type,
                                                   std::chrono::milliseconds patience = kPatience);
  /// @param file  a descriptor that goes with it; below 0: none
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status send(const std::string& line, int file = -1);

 private:
  StateLink() = default;

  std::string path_;
  Descriptor socket_;
  std::string received_;
};

}  // namespace plumbline::firmware::inline state
