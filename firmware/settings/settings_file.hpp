#pragma once
/// TOML files with a fixed set of keys: printers (board/*.toml), profiles (board/profiles/*.toml), jobs (job.toml).

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hal/lamp_map.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline::firmware::inline settings {

/// Whether a text has only what TextKind::kName allows: letters, digits, spaces, and . _ -
bool is_setting_name(std::string_view text);

/// One of a few words. `store` is called with the index of the word found, `load` gives that of the present value; it
/// may be null in a file that nothing writes.
struct ChoiceSetting {
  std::span<const std::string_view> words;
  std::function<void(std::size_t)> store;
  std::function<std::size_t()> load = nullptr;
};

/// One of a few numbers.
struct NumberChoiceSetting {
  std::span<const std::uint32_t> numbers;
  std::uint32_t* value = nullptr;
};
/// A number, or a word that becomes one.
struct NumberOrWord {
  double* value = nullptr;
  std::string_view word;
  double number = 0;
};
/// Degrees that a display can be turned by.
inline constexpr std::array<std::uint32_t, 4> kRotations = {0, 90, 180, 270};

/// kRequired: the file must have the key. kOptional: it may. kAllOrNone: it has all keys of this kind or none.
enum class Presence : std::uint8_t { kRequired, kOptional, kAllOrNone };

/// Names go into file names and messages, so only some characters are allowed; paths may have any.
enum class TextKind : std::uint8_t { kName, kPath };

struct TextSetting {
  std::string* value = nullptr;
  TextKind kind = TextKind::kName;
};

/// One path or an array of paths.
struct PathListSetting {
  std::vector<std::string>* values = nullptr;
  std::size_t most = 0;  ///< paths
};

/// A key of a list of places for supports.
struct PlaceField {
  std::string_view key;
  SupportPlaces SupportSettings::*member;
  const char* allowed;  ///< "places x, y, z; ..."
  bool has_radius() const { return member == &SupportSettings::blocked; }
};
/// An array of places, each an array of numbers, mm.
struct PlaceListSetting {
  SupportPlaces* places = nullptr;
  const PlaceField* field = nullptr;
};
/// Adds a place to a list.
/// @param numbers  x, y, z and, of a ball, its radius, which may be left out
/// @returns false: a number is out of range, there are too many or too few, or there is no room
bool add_place(std::span<const double> numbers, const PlaceField& field, SupportPlaces& places);

/// One key of a file: its table, what it accepts, and where its value goes.
struct SettingRule {
  std::string_view table;
  std::string_view key;
  std::variant<TextSetting, PathListSetting, std::uint32_t*, double*, bool*, ChoiceSetting, NumberChoiceSetting,
               std::optional<double>*, std::optional<bool>*, PlaceListSetting, NumberOrWord, LampMap*>
      value;
  double low = 0;         ///< least number, or fewest characters of each text; unused for a choice
  double high = 0;        ///< greatest; both are allowed
  const char* unit = "";  ///< for messages, with a leading space
  Presence presence = Presence::kRequired;
};

/// An enumeration whose values 0, 1, ... have the names `words`.
template <class Enum>
ChoiceSetting choice(std::span<const std::string_view> words, Enum& value) {
  return {words, [&value](std::size_t index) { value = static_cast<Enum>(index); },
          [&value] { return static_cast<std::size_t>(value); }};
}

struct SettingsSchema {
  const char* kind = "";  ///< "a board file", for messages about files that are none
  /// The first broken rule is the one reported. Rules of a table stand together.
  std::span<const SettingRule> rules;
  /// Set to whether the file has the keys of Presence::kAllOrNone; may be null if there are none.
  bool* has_all_or_none = nullptr;
  /// Checks a key against the others once all values are stored: returns what is wrong, "allowed is less than lamp_max_c", or
  /// nothing. May be null.
  std::function<std::string(const SettingRule& rule)> check = nullptr;
};

/// Largest file that is read, bytes. Real ones have a few thousand, so a scan given by mistake is refused before parsing.
inline constexpr std::size_t kMaxSettingsFileBytes = std::size_t{64} * 1024;

/// Reads a file and stores every value. Keys without a rule are errors. After an error some values may be stored.
/// @param path  as messages show it
/// @retval ErrorCode::kCannotOpen, kCannotRead
/// @retval ErrorCode::kMalformed   not TOML, or too large: the file and the line
/// @retval ErrorCode::kBadSetting  a key is unknown, missing, of a wrong type or out of range: file and line, the key,
///         what was found, what is allowed; for an unknown key the nearest known one
[[nodiscard]] Status read_settings_file(const std::string& path, const SettingsSchema& schema);

/// The same from text in memory.
/// @param path  for messages only
[[nodiscard]] Status parse_settings(std::string_view text, std::string_view path, const SettingsSchema& schema);

/// The whole text of a file.
/// @retval ErrorCode::kCannotOpen, kCannotRead
/// @retval ErrorCode::kMalformed  larger than kMaxSettingsFileBytes
[[nodiscard]] Expected<std::string> read_settings_text(const std::string& path, const char* kind);

}  // namespace plumbline::firmware::inline settings
