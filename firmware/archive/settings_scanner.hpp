#pragma once
/// Finds the settings in a slicer's text, whatever writes it: lines, JSON, XML; UTF-8 or UTF-16.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware::inline archive {

enum class SettingsForm : std::uint8_t {
  kIni,    ///< key = value, or key: value; '#' and ';' begin comments
  kGcode,  ///< the same in comments, perhaps in brackets; a command with its words, KEY=value among them; <Delay> value in comments
  kJson,   ///< a member's key is its path: "Properties.Size.Layers", "Layers[].Z"
  kXml,    ///< <key>value</key>, whatever is round it
};

/// Takes a text as it comes, in 8 kB whatever its length. Keys and values that are longer than kLongest are passed over.
class SettingsScanner {
 public:
  using Visit = FunctionRef<Status(std::string_view key, std::string_view value)>;
  static constexpr std::size_t kLongest = 1023;  ///< bytes: printer_notes

  /// @param visit  called for each key with its value, without white space and quotes round them; must outlive the scanner
  SettingsScanner(SettingsForm form, Visit visit) : form_(form), visit_(visit) {}

  /// @retval ErrorCode::kMalformed  JSON that closes what it has not opened, or is nested too deeply; and any error of `visit`
  [[nodiscard]] Status feed(std::span<const std::byte> bytes);
  /// After the last byte.
  /// @retval ErrorCode::kMalformed  JSON that is cut off; and any error of `visit`
  [[nodiscard]] Status finish();

 private:
  /// The vsnprintf() of FixedText would take seconds on megabytes of G-code.
  struct Text {
    std::array<char, kLongest> bytes{};
    std::size_t size = 0;
    bool cut = false;

    void add(char c) {
      cut = cut || size == kLongest;
      if (!cut) bytes[size++] = c;
    }
    void add(std::string_view text) {
      for (const char c : text) add(c);
    }
    void keep(std::size_t count) {
      size = count;
      cut = false;
    }
    std::string_view view() const { return {bytes.data(), size}; }
  };
  static constexpr std::size_t kMostLevels = 16;

  [[nodiscard]] Status take_byte(unsigned char byte);
  [[nodiscard]] Status take(char c);
  [[nodiscard]] Status take_of_lines(char c);
  [[nodiscard]] Status take_of_json(char c);
  [[nodiscard]] Status take_of_xml(char c);
  [[nodiscard]] Status end_line();
  [[nodiscard]] Status tell(std::string_view key, std::string_view value);

  SettingsForm form_;
  Visit visit_;
  std::array<unsigned char, 2> unit_{};  ///< the first two bytes, then those of a UTF-16 character
  std::size_t bytes_ = 0;
  bool wide_ = false, high_first_ = false;

  Text key_, value_;
  bool inside_ = false;                              ///< a string of JSON, a tag of XML
  bool escaped_ = false;                             ///< the last character of a string was a backslash
  std::array<std::size_t, kMostLevels + 1> path_{};  ///< bytes of key_ that name what holds the member
  std::size_t level_ = 0;
};

}  // namespace plumbline::firmware::inline archive
