#pragma once
/// Words of a line, and how they are shown in a message.

#include <array>
#include <cstddef>
#include <string_view>

namespace plumbline {

/// The bytes that separate words; a table, because rows are looked at byte by byte, a hundred million times a scan.
class Separators {
 public:
  constexpr explicit Separators(std::string_view bytes) {
    for (const char byte : bytes) is_[static_cast<unsigned char>(byte)] = true;
  }
  constexpr bool operator()(char byte) const { return is_[static_cast<unsigned char>(byte)]; }

 private:
  std::array<bool, 256> is_{};
};
inline constexpr Separators kBlanks{" \t\v\f"};
inline constexpr Separators kBlanksAndCommas{" \t\v\f,;"};

inline const char* skip_separators(const char* first, const char* last, const Separators& separators) {
  while (first != last && separators(*first)) ++first;
  return first;
}
inline const char* skip_word(const char* first, const char* last, const Separators& separators) {
  while (first != last && !separators(*first)) ++first;
  return first;
}

/// Takes a line apart, from the left.
class Words {
 public:
  explicit Words(std::string_view line, const Separators& separators = kBlanks)
      : first_(line.data()), last_(line.data() + line.size()), separators_(&separators) {}

  /// @returns the next word, empty at the end of the line
  std::string_view next() {
    const char* word = skip_separators(first_, last_, *separators_);
    first_ = skip_word(word, last_, *separators_);
    return {word, static_cast<std::size_t>(first_ - word)};
  }
  /// What has not been taken yet.
  std::string_view rest() const { return {first_, static_cast<std::size_t>(last_ - first_)}; }

 private:
  const char* first_;
  const char* last_;
  const Separators* separators_;
};

/// Equal but for the case of ASCII letters.
bool same_word(std::string_view a, std::string_view b);

/// `name` ends with `ending`, whatever the case: "BUST.PLY", ".ply".
bool has_ending(std::string_view name, std::string_view ending);

/// The start of some bytes of a file, fit to be shown: no control bytes, never longer than a message can take.
class Quote {
 public:
  explicit Quote(std::string_view bytes);
  const char* c_str() const { return text_; }

 private:
  static constexpr std::size_t kLongest = 32;
  char text_[kLongest + 4] = {};
};

}  // namespace plumbline
