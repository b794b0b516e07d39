#pragma once
/// TOML files with a fixed set of keys: printers (board/*.toml), profiles (board/profiles/*.toml), jobs (job.toml).

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "slicer/core/error.hpp"

namespace plumbline {

/// One of a few words. `store` gets the index of the word that was found.
struct ChoiceSetting {
  std::span<const std::string_view> words;
  std::function<void(std::size_t)> store;
};

/// One of a few numbers.
struct NumberChoiceSetting {
  std::span<const std::uint32_t> numbers;
  std::uint32_t* value = nullptr;
};

/// The file must have the key; may have it; must have it if it has any key of this kind.
enum class Presence : std::uint8_t { kRequired, kOptional, kAllOrNone };

/// Characters of text: names go into file names and messages, paths are taken as they are.
enum class TextKind : std::uint8_t { kName, kPath };

struct TextSetting {
  std::string* value = nullptr;
  TextKind kind = TextKind::kName;
};

/// One key that a file has: where it stands, what it allows, where its value goes.
struct SettingRule {
  std::string_view table;
  std::string_view key;
  std::variant<TextSetting, std::uint32_t*, double*, bool*, ChoiceSetting, NumberChoiceSetting> value;
  double low = 0;         ///< of the number, or of the characters in the text; nothing of a choice
  double high = 0;        ///< included, as low is
  const char* unit = "";  ///< with a space before it
  Presence presence = Presence::kRequired;
};

/// An enumeration whose values 0, 1, ... are called `words`.
template <class Enum>
ChoiceSetting choice(std::span<const std::string_view> words, Enum& value) {
  return {words, [&value](std::size_t index) { value = static_cast<Enum>(index); }};
}

struct SettingsSchema {
  const char* kind = "";  ///< "a board file": what the message about a file that is none says
  /// The order is that of messages: the first rule that is broken is the one reported. Rules of a table stand together.
  std::span<const SettingRule> rules;
  /// Set to whether the file has the keys of Presence::kAllOrNone; may be null where no rule is so.
  bool* has_all_or_none = nullptr;
  /// What is wrong with a key in view of the others, "allowed is less than lamp_max_c"; empty: nothing. Asked for each key of
  /// the file when all values are stored; may be null.
  std::function<std::string(const SettingRule& rule)> check = nullptr;
};

/// Largest file that is read, bytes. A real one has some thousand; a file of another kind is noticed before it is parsed.
inline constexpr std::size_t kMaxSettingsFileBytes = std::size_t{64} * 1024;

/// Reads a file and stores every value. Nothing but the rules' keys is known. After an error some values may be stored.
/// @param path  as it is to appear in messages
/// @retval ErrorCode::kCannotOpen, kCannotRead
/// @retval ErrorCode::kMalformed   not TOML, or too large: the file and the line
/// @retval ErrorCode::kBadSetting  a key is unknown, missing, of a wrong type or out of range: file and line, the key,
///         what was found, what is allowed; for an unknown key the nearest known one
[[nodiscard]] Status read_settings_file(const std::string& path, const SettingsSchema& schema);

/// The same from text in memory.
/// @param path  for messages only
[[nodiscard]] Status parse_settings(std::string_view text, std::string_view path, const SettingsSchema& schema);

/// A file's text, whole.
/// @retval ErrorCode::kCannotOpen, kCannotRead
/// @retval ErrorCode::kMalformed  larger than kMaxSettingsFileBytes
[[nodiscard]] Expected<std::string> read_settings_text(const std::string& path, const char* kind);

}  // namespace plumbline
