#include "slicer/reader/formats/obj_lines.hpp"

#include <algorithm>

namespace plumbline::inline slicer {

void ObjLines::split() {
  LineWords words(line_.text);
  keyword_ = words.next();
  rest_ = words.rest();
}

/// Joins a continued line in `joined_`.
Status ObjLines::join() {
  std::size_t used = 0;
  for (;;) {
    const bool continued = is_continued();
    auto part = line_.text;
    if (continued) part.remove_suffix(1);
    if (line_.cut || part.size() + 1 > joined_.size() - used) {
      return lines_.input().fail(ErrorCode::kUnsupported,
                                 "line %llu: a vertex is continued over more than %zu bytes;\texport the file again",
                                 static_cast<unsigned long long>(lines_.number()), joined_.size());
    }
    std::copy(part.begin(), part.end(), joined_.begin() + static_cast<std::ptrdiff_t>(used));
    used += part.size();
    joined_[used++] = ' ';
    if (continued) {
      const auto found = lines_.next(line_);
      PLUMBLINE_TRY(found);
      if (*found) continue;
      line_.unterminated = true;
      line_.cut = false;
    }
    line_.text = {joined_.data(), used};
    return {};
  }
}

/// Skips the lines that continue the current one, whatever their length.
Status ObjLines::skip_continuation() {
  for (;;) {
    bool continued = is_continued() && !line_.cut;
    if (line_.cut) {
      const auto last = lines_.skip_rest();
      PLUMBLINE_TRY(last);
      continued = *last == '\\';
    }
    if (!continued) return {};
    const auto found = lines_.next(line_);
    PLUMBLINE_TRY(found);
    if (!*found) return {};
  }
}

}  // namespace plumbline::inline slicer
