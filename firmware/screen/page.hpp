#pragma once
/// Sets text on a canvas, and notes where it went and what did not fit: a test looks at the notes of every screen.

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "firmware/canvas/canvas.hpp"
#include "firmware/canvas/face.hpp"
#include "firmware/screen/look.hpp"

namespace plumbline::firmware::inline screen {

enum class Align : std::uint8_t { kLeft, kCentre, kRight };

/// Whether a text may be cut where it is too long for its box.
enum class Fit : std::uint8_t {
  kMust,    ///< the table's: a mistake if it does not fit
  kMayCut,  ///< names and messages, which can have any length: an ellipsis shows that there is more
};

struct TextStyle {
  const Face& face;
  Colour ink = ink::kText;
  Align align = Align::kLeft;
  Fit fit = Fit::kMust;
};

class Page {
 public:
  Page(Canvas& canvas, const Look& look) : canvas_(canvas), look_(look) {}

  Canvas& canvas() { return canvas_; }
  const Look& look() const { return look_; }

  /// One line, in the middle of the box's height.
  /// @returns x of its end
  int line(const PixelBox& box, std::string_view text, const TextStyle& style);
  /// As many lines as the text needs, from the box's top. Breaks at spaces; a word that is longer than a line is broken.
  /// @returns y below the last line
  int paragraph(const PixelBox& box, std::string_view text, const TextStyle& style);

  /// How many lines paragraph() needs for a text.
  static int lines_of(std::string_view text, int width, const Face& face);
  /// As much of a text as fits in `lines`, without what follows the last of its colons, semicolons and full stops that must go: no
  /// sentence breaks off. All of it if its first part is too long already.
  static std::string_view whole_parts(std::string_view text, int width, int lines, const Face& face);

  /// Where text was set, and whether one that must fit did not.
  struct Note {
    PixelBox box;
    bool too_long = false;
  };
  static constexpr std::size_t kMostNotes = 96;
  std::span<const Note> notes() const { return {notes_.data(), note_count_}; }

 private:
  void set(int x, int baseline, std::string_view text, bool cut, const TextStyle& style, bool too_long);

  Canvas& canvas_;
  const Look& look_;
  std::array<Note, kMostNotes> notes_;
  std::size_t note_count_ = 0;
};

}  // namespace plumbline::firmware::inline screen
