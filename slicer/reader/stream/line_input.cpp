#include "slicer/reader/stream/line_input.hpp"

#include <cstring>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

const char* LineInput::find_end(const char* first, const char* last) {
  if (terminator_ == 0) {
    for (const char* p = first; p != last; ++p) {
      if (*p == '\n') {
        terminator_ = '\n';
        return p;
      }
      if (*p == '\r') {
        // CR LF or CR alone: the next byte that is no CR decides. "\r\r\n" comes from text that was converted twice.
        const char* after = p;
        while (after != last && *after == '\r') ++after;
        if (after == last) return nullptr;
        terminator_ = *after == '\n' ? '\n' : '\r';
        return terminator_ == '\n' ? after : p;
      }
    }
    return nullptr;
  }
  return first == last
             ? nullptr
             : static_cast<const char*>(std::memchr(first, terminator_, static_cast<std::size_t>(last - first)));
}

Expected<bool> LineInput::next(Line& line) {
  if (rest_) PLUMBLINE_TRY(skip_rest());
  std::size_t seen = 0;  // bytes without a line end: not searched again, or small reads would make the search quadratic
  for (;;) {
    const char* first = input_.begin();
    const char* last = input_.end();
    const char* end = find_end(first + seen, last);
    line.cut = line.unterminated = false;
    if (end == nullptr) {
      if (input_.full()) {
        end = last;
        line.cut = rest_ = true;
      } else {
        if (terminator_ != 0) seen = input_.available();
        const auto grown = input_.more();
        PLUMBLINE_TRY(grown);
        if (*grown) continue;
        if (input_.available() == 0) return false;
        first = input_.begin();
        end = input_.end();
        line.unterminated = true;
        if (terminator_ == 0 && end[-1] == '\r') line.unterminated = false;
      }
    }
    line.text = {first, static_cast<std::size_t>(end - first)};
    if (line.cut) {
      // Leave the last word, which may be half of a number, unless there is no other.
      while (!line.text.empty() && !kBlanksAndCommas(line.text.back())) line.text.remove_suffix(1);
      if (!line.text.empty()) end = first + line.text.size();
    }
    input_.consume(static_cast<std::size_t>(end - first) + (line.cut || end == input_.end() ? 0 : 1));
    while (!line.cut && !line.text.empty() && line.text.back() == '\r') line.text.remove_suffix(1);
    if (terminator_ == '\r' && !line.text.empty() && line.text.front() == '\n') line.text.remove_prefix(1);
    ++number_;
    return true;
  }
}

Expected<bool> LineInput::next_part(Line& line) {
  if (rest_) {
    rest_ = false;
    --number_;
  }
  return next(line);
}

Expected<char> LineInput::skip_rest() {
  char final = 0;
  while (rest_) {
    const char* first = input_.begin();
    const char* last = input_.end();
    const char* end = find_end(first, last);
    const bool found = end != nullptr;
    if (!found) {
      end = last;
      // Keep a CR at the end of the window: until the next byte comes, it may be a line end or half of one.
      while (terminator_ == 0 && end != first && end[-1] == '\r') --end;
      if (end == first && input_.full()) terminator_ = '\r';
    }
    for (const char* p = end; p != first; --p) {
      if (p[-1] == '\r') continue;
      final = p[-1];
      break;
    }
    input_.consume(static_cast<std::size_t>(end - first) + (found ? 1 : 0));
    if (found) {
      rest_ = false;
    } else if (!input_.full()) {
      const auto grown = input_.more();
      PLUMBLINE_TRY(grown);
      if (!*grown) {
        input_.consume(input_.available());
        rest_ = false;
      }
    }
  }
  return final;
}

}  // namespace plumbline::inline slicer
