#pragma once
/// A board file in the making: starts as another printer's, takes one answer after another, each checked by the rules of board files.

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "firmware/settings/board_file.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

class BoardDraft {
 public:
  /// @param like  name or path of the board file to begin with
  /// @retval ErrorCode::kBadSetting  it describes no machine; and the errors of read_board_file()
  [[nodiscard]] static Expected<BoardDraft> like(const std::string& like);

  /// @param answer  as a person types it: a text or word without quotes, a number, true or yes
  /// @param source  where it comes from: the comment of its line; empty: from where it was
  /// @retval ErrorCode::kBadSetting  what was found and what is allowed
  [[nodiscard]] Status set(std::string_view table, std::string_view key, const std::string& answer,
                           std::string_view source);

  /// A line: "GPIO17", "GPIO17 low pull-up", "1c20800.pinctrl 71", or "none".
  [[nodiscard]] Status set_line(std::string_view table, const std::string& answer, std::string_view source);
  /// A sensor: "hwmon tmp102", "hwmon tmp102 1", "zone cpu-thermal", "file PATH".
  [[nodiscard]] Status set_sensor(std::string_view table, const std::string& answer, std::string_view source);
  /// A fan: "hwmon NAME 1", "pwm pwmchip0 0", or "none".
  [[nodiscard]] Status set_fan(std::string_view table, const std::string& answer, std::string_view source);

  /// A screen for people: "HDMI-A-1 800x480", "SPI-1 320x240 90 16-bit /dev/input/by-path/NAME-event", in any order, or "none".
  [[nodiscard]] Status set_screen(const std::string& answer, std::string_view source);

  /// The present value, as set() takes it; empty: an optional key that is not set.
  std::string value(std::string_view table, std::string_view key) const;
  /// The present values of a wiring table, as set_line() and the others take them; "none" if it is not given.
  std::string line(std::string_view table) const;
  std::string sensor(std::string_view table) const;
  std::string fan(std::string_view table) const;
  std::string screen() const;
  /// "an integer from 1 to 16384 pixels"
  std::string allowed_for(std::string_view table, std::string_view key) const;

  /// The file: every line with its unit and source in a comment.
  std::string text() const;
  /// The file, parsed by the rules of all board files.
  /// @retval ErrorCode::kBadSetting  two answers contradict each other
  [[nodiscard]] Expected<BoardFile> board() const;
  /// Name of the printer that the draft began with.
  const std::string& like_name() const { return like_; }
  /// The values without the checks of one against the others.
  const BoardFile& values() const { return board_; }

 private:
  explicit BoardDraft(BoardFile board);
  void note(std::string_view table, std::string_view key, std::string_view source);
  /// Sets a wiring table to what `keys` say, after a look at the table as a whole.
  Status set_table(std::string_view table, const std::map<std::string, std::string>& keys, std::string_view source);

  BoardFile board_;
  std::string like_;  ///< name of the printer to begin with
  std::map<std::pair<std::string, std::string>, std::string> sources_;
};

}  // namespace plumbline::firmware
