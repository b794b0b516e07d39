#pragma once
/// Splits lines into words, and quotes them in messages.

#include <array>
#include <cstddef>
#include <string_view>

namespace plumbline::inline slicer {

/// The bytes that separate words. A table, since a large scan looks up a hundred million bytes.
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
inline constexpr Separators kBlanksAndCommas{" \t\v\f,;|"};
inline constexpr Separators kAllButCommas{" \t\v\f;|"};

inline const char* skip_separators(const char* first, const char* last, const Separators& separators) {
  while (first != last && separators(*first)) ++first;
  return first;
}
inline const char* skip_word(const char* first, const char* last, const Separators& separators) {
  while (first != last && !separators(*first)) ++first;
  return first;
}

/// Splits a line into words, from the left.
class LineWords {
 public:
  explicit LineWords(std::string_view line, const Separators& separators = kBlanks)
      : first_(line.data()), last_(line.data() + line.size()), separators_(&separators) {}

  /// @returns the next word, empty at the end of the line
  std::string_view next() {
    const char* word = skip_separators(first_, last_, *separators_);
    first_ = skip_word(word, last_, *separators_);
    return {word, static_cast<std::size_t>(first_ - word)};
  }
  /// What next() has not returned yet.
  std::string_view rest() const { return {first_, static_cast<std::size_t>(last_ - first_)}; }

 private:
  const char* first_;
  const char* last_;
  const Separators* separators_;
};

constexpr char lower_letter(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Whether two words are equal, ignoring the case of ASCII letters.
inline bool same_word(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (lower_letter(a[i]) != lower_letter(b[i])) return false;
  }
  return true;
}

/// Whether `name` ends with `ending`, ignoring case: "BUST.PLY" ends with ".ply".
bool has_ending(std::string_view name, std::string_view ending);

/// The start of some bytes of a file, for a message: at most kLongest characters, '?' for each that is not printable.
class Quote {
 public:
  explicit Quote(std::string_view bytes);
  const char* c_str() const { return text_; }

 private:
  static constexpr std::size_t kLongest = 32;  ///< characters; leaves the message room for what went wrong
  char text_[kLongest + 4] = {};
};

}  // namespace plumbline::inline slicer
