#pragma once
/// Reads XML as a stream, by expat, in fixed memory.

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "slicer/core/error.hpp"
#include "slicer/reader/stream/byte_input.hpp"
#include "slicer/reader/stream/fixed_heap.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

struct XML_ParserStruct;  ///< of expat

namespace plumbline::inline slicer {

/// The attributes of an element, valid while its begin() runs.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** list) : list_(list) {}

  /// @returns empty if there is none of that name
  std::string_view operator[](std::string_view name) const {
    for (const char** at = list_; *at != nullptr; at += 2) {
      if (is(at[0], name)) return at[1];
    }
    return {};
  }
  /// The same, whatever prefix stands before the name: "path" finds p:path.
  std::string_view any(std::string_view name) const;

 private:
  /// Compares without measuring the text first: a mesh has millions of names of one or two letters.
  static bool is(const char* text, std::string_view name) {
    for (const char letter : name) {
      if (*text++ != letter) return false;
    }
    return *text == 0;
  }

  const char** list_;
};

inline constexpr Separators kXmlBlanks{" \t\r\n"};

/// Parses a whole attribute or text, with blanks around it.
/// @returns false if it is empty, no number, or not a finite one
template <class Number>
bool parse_number(std::string_view text, Number& number) {
  while (!text.empty() && kXmlBlanks(text.front())) text.remove_prefix(1);
  while (!text.empty() && kXmlBlanks(text.back())) text.remove_suffix(1);
  const char* const end = text.data() + text.size();
  if constexpr (std::is_floating_point_v<Number>) {
    return !text.empty() && parse_real(text.data(), end, number) == end && std::isfinite(number);
  } else {
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc{} && stop == end;
  }
}

class XmlParser;

/// What is done with the elements of a document.
class XmlHandler {
 public:
  virtual ~XmlHandler() = default;
  virtual void begin(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void end(std::string_view name) = 0;
  /// @param piece  of the text of the open element
  virtual void text(std::string_view /*piece*/) {}

 protected:
  XmlParser* parser_ = nullptr;  ///< that reads the document, for complaints

 private:
  friend class XmlParser;
};

/// One document. Document types are refused, so there are no entities to expand. One parser a thread at a time.
class XmlParser {
 public:
  /// @param heap  outlives the parser
  XmlParser(FixedHeap& heap, XmlHandler& handler);
  XmlParser(const XmlParser&) = delete;
  XmlParser& operator=(const XmlParser&) = delete;
  ~XmlParser();

  /// @param last   whether the document ends here
  /// @param input  named in errors
  /// @param part   of the file, for messages: "its XML"
  /// @retval ErrorCode::kMalformed     not XML, or what complain() was told
  /// @retval ErrorCode::kUnsupported   tags too long or too deep for the heap
  [[nodiscard]] Status parse(std::span<const char> piece, bool last, const ByteInput& input, const char* part);

  /// Stops with a message, which is put after the line's number.
  [[gnu::format(printf, 2, 3)]] void complain(const char* pattern, ...);

 private:
  FixedHeap& heap_;
  XmlHandler& handler_;
  XML_ParserStruct* parser_;
  std::array<char, 160> complaint_ = {};
};

}  // namespace plumbline::inline slicer
