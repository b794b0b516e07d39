#pragma once
/// Buttons pressed by command, for printers without buttons and for people who are not at the printer: a datagram socket in the state folder.
///
///   STATE/buttons   takes "start", "pause" and "cancel"; the folder's owner and group may press

#include <optional>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "hal/events.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class ButtonSocket {
 public:
  /// @param folder  the JobStore's, which is locked: nobody else listens there
  /// @retval ErrorCode::kCannotOpen  the folder, the reason
  [[nodiscard]] static Expected<ButtonSocket> open(const std::string& folder);

  /// The next button, without waiting. Takes nothing from the heap.
  std::optional<EventKind> next();

 private:
  ButtonSocket() = default;

  Descriptor socket_;
};

/// The button of a word; none: there is no such button.
std::optional<EventKind> button_of(std::string_view word);

/// Presses a button of the daemon that uses a state folder.
/// @param word  "start", "pause" or "cancel"
/// @retval ErrorCode::kCannotOpen  no daemon runs with that folder
/// @retval ErrorCode::kCannotWrite
[[nodiscard]] Status press_button(const std::string& folder, std::string_view word);

}  // namespace plumbline
