#include "slicer/reader/records/record_text.hpp"

#include "slicer/reader/records/records_end.hpp"
#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

using Kind = RowOutcome::Kind;

constexpr const char* kSlotNames[kRowSlots] = {
    "x",       "y",       "z",       "the normal's x", "the normal's y", "the normal's z", "the opacity",
    "a scale", "a scale", "a scale", "a rotation",     "a rotation",     "a rotation",     "a rotation"};

tl::unexpected<Error> fail_truncated(const LineInput& lines, const char* what, std::uint64_t read,
                                     std::uint64_t declared) {
  return lines.input().fail(
      ErrorCode::kTruncated,
      "the file ends after line %llu, with %llu of the %llu %s that its header declares;\tcopy or export it again",
      static_cast<unsigned long long>(lines.number()), static_cast<unsigned long long>(read),
      static_cast<unsigned long long>(declared), what);
}

/// @returns false if there are fewer than `count`
bool skip_words(const char*& at, const char* last, std::uint64_t count, const Separators& separators) {
  for (std::uint64_t i = 0; i < count; ++i) {
    at = skip_separators(at, last, separators);
    if (at == last) return false;
    at = skip_word(at, last, separators);
  }
  return true;
}

}  // namespace

const char* slot_name(std::size_t slot) { return kSlotNames[slot]; }

bool is_blank(std::string_view text) {
  return skip_separators(text.data(), text.data() + text.size(), kBlanks) == text.data() + text.size();
}

RowOutcome parse_row(std::string_view text, const RecordLayout& layout, const Separators& separators, SlotValues& row,
                     const char** end) {
  const char* at = text.data();
  const char* const last = at + text.size();
  const auto steps = layout.steps();
  for (const RecordStep& step : steps) {
    if (step.kind == RecordStep::Kind::kSkip) {
      if (!skip_words(at, last, step.words, separators)) return {.kind = Kind::kTooFew, .wanted = "a column"};
      continue;
    }
    at = skip_separators(at, last, separators);
    if (step.kind == RecordStep::Kind::kField) {
      if (at == last) return {.kind = Kind::kTooFew, .wanted = kSlotNames[step.slot]};
      const char* stop = parse_real(at, last, row[step.slot]);
      if (stop == nullptr || (stop != last && !separators(*stop))) {
        const auto length = static_cast<std::size_t>(skip_word(at, last, separators) - at);
        return {.kind = Kind::kNotANumber, .word = {at, length}, .wanted = kSlotNames[step.slot]};
      }
      at = stop;
      continue;
    }
    if (at == last && &step == &steps.back()) break;
    if (at == last) return {.kind = Kind::kTooFew, .wanted = "the length of a list"};
    const char* stop = skip_word(at, last, separators);
    const std::string_view word(at, static_cast<std::size_t>(stop - at));
    const auto count = parse_count(word);
    if (!count) return {.kind = Kind::kNotANumber, .word = word, .wanted = "the length of a list"};
    at = stop;
    if (!skip_words(at, last, *count, separators)) return {.kind = Kind::kTooFew, .wanted = "an item of a list"};
  }
  if (end != nullptr) *end = at;
  return {};
}

tl::unexpected<Error> fail_zeros(const LineInput& lines) {
  return lines.input().fail(ErrorCode::kMalformed,
                            "line %llu: has bytes that are zero: the file is damaged;\tcopy or export it again",
                            static_cast<unsigned long long>(lines.number()));
}

tl::unexpected<Error> fail_row(const LineInput& lines, const Line& line, const RowOutcome& outcome) {
  const ByteInput& input = lines.input();
  const auto number = static_cast<unsigned long long>(lines.number());
  const bool at_end =
      outcome.kind == Kind::kTooFew || outcome.word.data() + outcome.word.size() == line.text.data() + line.text.size();
  if (line.cut && at_end) {
    return input.fail(ErrorCode::kUnsupported,
                      "line %llu: longer than a row may be (%zu bytes);\texport only the points, one a line", number,
                      input.capacity());
  }
  if (line.unterminated && at_end) {
    return input.fail(ErrorCode::kTruncated,
                      "line %llu: the file ends in the middle of a point, before %s;\tcopy or export it again", number,
                      outcome.wanted);
  }
  if (outcome.kind == Kind::kOtherCells) {
    return input.fail(ErrorCode::kMalformed,
                      "line %llu: has more or fewer cells than the rows before it, in '%s';\tput quotes around names "
                      "that have separators, or export the file again",
                      number, Quote(line.text).c_str());
  }
  if (outcome.kind == Kind::kTooFew) {
    return input.fail(ErrorCode::kMalformed,
                      "line %llu: too few numbers, %s is missing in '%s';\tcorrect the line or export the file again",
                      number, outcome.wanted, Quote(line.text).c_str());
  }
  return input.fail(ErrorCode::kMalformed,
                    "line %llu: expected a number for %s, found '%s';\tcorrect the line or export the file again",
                    number, outcome.wanted, Quote(outcome.word).c_str());
}

Expected<bool> TextRecords::next_line() {
  const auto found = lines_.next_part(line_);
  PLUMBLINE_TRY(found);
  rest_ = line_.text;
  if (!*found || is_blank(rest_)) {
    if (*found && line_.cut && rest_.empty()) {
      return lines_.input().fail(ErrorCode::kUnsupported, "line %llu: a word longer than %zu bytes;\texport it again",
                                 static_cast<unsigned long long>(lines_.number()), lines_.input().capacity());
    }
    return *found;
  }
  return true;
}

Expected<std::string_view> TextRecords::next_word() {
  while (is_blank(rest_)) {
    const auto found = next_line();
    PLUMBLINE_TRY(found);
    if (!*found) return std::string_view();
  }
  LineWords words(rest_);
  const auto word = words.next();
  rest_ = words.rest();
  return word;
}

Expected<bool> TextRecords::next(const RecordLayout& layout, SlotValues& row) {
  const bool begins_line = is_blank(rest_);
  while (is_blank(rest_)) {
    const auto found = next_line();
    PLUMBLINE_TRY(found);
    if (!*found) return false;
  }
  const char* end = nullptr;
  const RowOutcome outcome = parse_row(rest_, layout, kBlanks, row, &end);
  if (outcome.kind == Kind::kNotANumber) return fail_row(lines_, line_, outcome);
  if (outcome.kind == Kind::kWhole) {
    rest_ = {end, static_cast<std::size_t>(rest_.data() + rest_.size() - end)};
    return true;
  }
  const auto read = next_by_words(layout, row);
  is_loose_ = is_loose_ || !begins_line || !is_line_end();
  return read;
}

/// Reads a record that goes on in the next line.
Expected<bool> TextRecords::next_by_words(const RecordLayout& layout, SlotValues& row) {
  const auto truncated = [this](const char* wanted) {
    line_.unterminated = true;
    return fail_row(lines_, line_, {.kind = Kind::kTooFew, .word = {}, .wanted = wanted});
  };
  const auto skip = [&](std::uint64_t words, const char* what) -> Status {
    for (std::uint64_t i = 0; i < words; ++i) {
      const auto word = next_word();
      PLUMBLINE_TRY(word);
      if (word->empty()) return truncated(what);
    }
    return {};
  };
  const auto steps = layout.steps();
  for (const RecordStep& step : steps) {
    if (step.kind == RecordStep::Kind::kSkip) {
      PLUMBLINE_TRY(skip(step.words, "a column"));
      continue;
    }
    if (step.kind == RecordStep::Kind::kList && &step == &steps.back() && is_line_end()) return true;
    const auto word = next_word();
    PLUMBLINE_TRY(word);
    const char* const end = word->data() + word->size();
    if (step.kind == RecordStep::Kind::kField) {
      if (word->empty()) return truncated(kSlotNames[step.slot]);
      if (parse_real(word->data(), end, row[step.slot]) == end) continue;
      return fail_row(lines_, line_, {.kind = Kind::kNotANumber, .word = *word, .wanted = kSlotNames[step.slot]});
    }
    const auto count = parse_count(*word);
    if (word->empty()) return truncated("the length of a list");
    if (!count) {
      return fail_row(lines_, line_, {.kind = Kind::kNotANumber, .word = *word, .wanted = "the length of a list"});
    }
    PLUMBLINE_TRY(skip(*count, "an item of a list"));
  }
  return true;
}

Status TextRecords::read_points(const RecordLayout& layout, std::uint64_t count, PointBatch& batch) {
  SlotValues row = {};
  for (std::uint64_t done = 0; done < count; ++done) {
    const auto found = next(layout, row);
    PLUMBLINE_TRY(found);
    if (!*found) return fail_truncated(lines_, "points", done, count);
    batch.add(row);
    if (batch.full()) PLUMBLINE_TRY(batch.flush());
  }
  return {};
}

Status TextRecords::skip(const RecordLayout& layout, std::uint64_t count, const char* what) {
  SlotValues row = {};
  if (layout.steps().empty()) return {};  // no properties: no words
  for (std::uint64_t done = 0; done < count; ++done) {
    const auto found = next(layout, row);
    PLUMBLINE_TRY(found);
    if (!*found) return fail_truncated(lines_, what, done, count);
  }
  return {};
}

Status TextRecords::check_end(const char* what, std::uint64_t count) {
  if (is_line_end()) return check_text_end(lines_, what, count);
  return lines_.input().fail(ErrorCode::kMalformed,
                             "line %llu: its header declares %llu %s, but '%s' follows them, or its rows don't fit its "
                             "header;\texport it again",
                             static_cast<unsigned long long>(lines_.number()), static_cast<unsigned long long>(count),
                             what, Quote(rest_).c_str());
}

Status read_text_points(LineInput& lines, const RecordLayout& layout, std::uint64_t count, PointBatch& batch) {
  Line line;
  SlotValues row = {};
  for (std::uint64_t done = 0; done < count;) {
    const auto found = lines.next(line);
    PLUMBLINE_TRY(found);
    if (!*found) return fail_truncated(lines, "points", done, count);
    const RowOutcome outcome = parse_row(line.text, layout, kBlanks, row);
    if (outcome.kind != Kind::kWhole) {
      if (!line.cut && is_blank(line.text)) continue;
      return fail_row(lines, line, outcome);
    }
    ++done;
    batch.add(row);
    if (batch.full()) PLUMBLINE_TRY(batch.flush());
  }
  return {};
}

}  // namespace plumbline::inline slicer
