#include "firmware/screen/page.hpp"

#include <algorithm>
#include <cassert>

namespace plumbline::firmware::inline screen {
namespace {

constexpr std::string_view kEllipsis = "…";

/// Takes the next line off a text.
std::string_view take_line(std::string_view& text, int width, const Face& face) {
  std::string_view line = face.start_of(text, width);
  if (line.size() < text.size() && text[line.size()] != ' ') {
    // A word is cut: it goes to the next line, unless it is the only one.
    if (const auto space = line.rfind(' '); space != std::string_view::npos) line = line.substr(0, space);
  }
  if (line.empty()) {  // not even one character fits
    std::string_view after = text;
    take_character(after);
    line = text.substr(0, text.size() - after.size());
  }
  text.remove_prefix(line.size());
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (line.ends_with(' ')) line.remove_suffix(1);
  return line;
}

}  // namespace

int Page::line(const PixelBox& box, std::string_view text, const TextStyle& style) {
  const bool cut = style.face.width(text) > box.width;
  const std::string_view shown = cut ? style.face.start_of(text, box.width - style.face.width(kEllipsis)) : text;
  const int width = style.face.width(shown) + (cut ? style.face.width(kEllipsis) : 0);
  int x = box.x;
  if (style.align == Align::kCentre) x += (box.width - width) / 2;
  if (style.align == Align::kRight) x += box.width - width;
  const int baseline = box.y + (box.height + style.face.cap_height()) / 2;
  set(x, baseline, shown, cut, style, (cut && style.fit == Fit::kMust) || box.height < style.face.cap_height());
  return x + width;
}

int Page::paragraph(const PixelBox& box, std::string_view text, const TextStyle& style) {
  const int step = style.face.line_height();
  const int room = std::max(1, box.height / step);
  int y = box.y;
  for (int i = 0; i < room && !text.empty(); ++i, y += step) {
    std::string_view shown = take_line(text, box.width, style.face);
    const bool last = i + 1 == room && !text.empty();
    if (last) shown = style.face.start_of(shown, box.width - style.face.width(kEllipsis));
    int x = box.x;
    const int width = style.face.width(shown) + (last ? style.face.width(kEllipsis) : 0);
    if (style.align == Align::kCentre) x += (box.width - width) / 2;
    if (style.align == Align::kRight) x += box.width - width;
    const int baseline = y + (step + style.face.cap_height() - style.face.descent() + 1) / 2;
    set(x, baseline, shown, last, style, (last && style.fit == Fit::kMust) || box.height < step);
  }
  return y;
}

std::string_view Page::whole_parts(std::string_view text, int width, int lines, const Face& face) {
  std::string_view shown = text;
  while (lines_of(shown, width, face) > lines) {
    std::size_t end = 0;
    for (const std::string_view mark : {": ", "; ", ". ", ", the largest of "}) {
      const std::size_t found = shown.rfind(mark);
      if (found != std::string_view::npos) end = std::max(end, found);
    }
    if (end == 0) return text;
    shown = shown.substr(0, end);
  }
  return shown;
}

int Page::lines_of(std::string_view text, int width, const Face& face) {
  int lines = 0;
  for (; !text.empty(); ++lines) take_line(text, width, face);
  return lines;
}

void Page::set(int x, int baseline, std::string_view text, bool cut, const TextStyle& style, bool too_long) {
  int end = style.face.draw(canvas_, x, baseline, text, style.ink);
  if (cut) end = style.face.draw(canvas_, end, baseline, kEllipsis, style.ink);
  assert(note_count_ < kMostNotes);
  if (note_count_ == kMostNotes || end == x) return;
  const int top = baseline - style.face.cap_height();
  notes_[note_count_++] = {{x, top, end - x, style.face.cap_height() + style.face.descent()}, too_long};
}

}  // namespace plumbline::firmware::inline screen
