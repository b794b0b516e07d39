#include "firmware/archive/settings_scanner.hpp"

#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware::inline archive {
namespace {

std::string_view trimmed_of(std::string_view text, std::string_view blanks) {
  const auto begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

constexpr std::string_view kRound = " \t\"'";

}  // namespace

Status SettingsScanner::tell(std::string_view key, std::string_view value) {
  if (key_.cut || value_.cut) return {};
  key = trimmed_of(key, kRound);
  value = trimmed_of(value, kRound);
  return key.empty() ? Status() : visit_(key, value);
}

Status SettingsScanner::feed(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) PLUMBLINE_TRY(take_byte(static_cast<unsigned char>(byte)));
  return {};
}

Status SettingsScanner::take_byte(unsigned char byte) {
  unit_[bytes_++ % 2] = byte;
  if (bytes_ == 1) return {};
  if (bytes_ == 2) {
    const auto [first, second] = unit_;
    const bool marked = (first == 0xFF && second == 0xFE) || (first == 0xFE && second == 0xFF);
    // Settings begin with an ASCII character, so that a zero beside it is the half of one.
    wide_ = marked || first == 0 || second == 0;
    high_first_ = marked ? first == 0xFE : first == 0;
    if (marked) return {};
    if (!wide_ && first < 0x80) PLUMBLINE_TRY(take(static_cast<char>(first)));
  }
  if (!wide_) {
    const bool marks = bytes_ <= 3 && byte >= 0x80;  // UTF-8 may begin with EF BB BF
    return marks ? Status() : take(static_cast<char>(byte));
  }
  if (bytes_ % 2 != 0) return {};
  const unsigned code = high_first_ ? 256U * unit_[0] + unit_[1] : 256U * unit_[1] + unit_[0];
  if (code < 0x80) return take(static_cast<char>(code));
  if (code >= 0x800) return take('?');
  PLUMBLINE_TRY(take(static_cast<char>(0xC0U | (code >> 6U))));
  return take(static_cast<char>(0x80U | (code & 0x3FU)));
}

Status SettingsScanner::take(char c) {
  switch (form_) {
    case SettingsForm::kIni:
    case SettingsForm::kGcode: return take_of_lines(c);
    case SettingsForm::kJson: return take_of_json(c);
    case SettingsForm::kXml: return take_of_xml(c);
  }
  return {};
}

Status SettingsScanner::finish() {
  if (bytes_ == 1) PLUMBLINE_TRY(take(static_cast<char>(unit_[0])));
  if (form_ == SettingsForm::kJson && (level_ > 0 || inside_)) return fail(ErrorCode::kMalformed, "is cut off");
  return form_ == SettingsForm::kIni || form_ == SettingsForm::kGcode ? end_line() : Status();
}

Status SettingsScanner::take_of_lines(char c) {
  if (c == '\n' || c == '\r') return end_line();
  value_.add(c);
  return {};
}

Status SettingsScanner::end_line() {
  const Text text = value_;
  value_.keep(0);
  if (text.cut) return {};
  std::string_view line = trimmed_of(text.view(), " \t");
  const bool is_comment = line.starts_with(';') || line.starts_with('#');
  if (is_comment == (form_ == SettingsForm::kIni)) {
    if (is_comment) return {};
    LineWords words(line);
    const auto command = words.next();
    if (command.find('=') == std::string_view::npos) {
      const auto rest = words.rest();
      if (!command.empty()) PLUMBLINE_TRY(tell(command, rest.substr(0, rest.find(';'))));
    } else {
      words = LineWords(line);
    }
    for (auto word = words.next(); !word.empty(); word = words.next()) {
      const auto equals = word.find('=');
      if (equals != std::string_view::npos) PLUMBLINE_TRY(tell(word.substr(0, equals), word.substr(equals + 1)));
    }
    return {};
  }
  if (is_comment) line = trimmed_of(line, " \t;#()");
  if (line.starts_with('<')) {  // <Delay> 8000
    const auto end = std::min(line.find('>') + 1, line.size());
    return tell(line.substr(0, end), line.substr(end));
  }
  const auto at = line.find_first_of("=:");
  return at == std::string_view::npos ? Status() : tell(line.substr(0, at), line.substr(at + 1));
}

Status SettingsScanner::take_of_json(char c) {
  if (inside_) {
    if (escaped_ || (c != '"' && c != '\\')) value_.add(c);
    inside_ = escaped_ || c != '"';
    escaped_ = !escaped_ && c == '\\';
    return {};
  }
  const auto end_value = [this]() -> Status {
    if (value_.size > 0) PLUMBLINE_TRY(tell(key_.view(), value_.view()));
    value_.keep(0);
    key_.keep(path_[level_]);
    return {};
  };
  switch (c) {
    case '"': inside_ = true; return {};
    case ' ':
    case '\t':
    case '\r':
    case '\n': return {};
    case ':':
      key_.keep(path_[level_]);
      if (key_.size > 0) key_.add('.');
      key_.add(value_.view());
      value_.keep(0);
      return {};
    case ',': return end_value();
    case '{':
    case '[':
      if (level_ == kMostLevels) return fail(ErrorCode::kMalformed, "is nested too deeply");
      if (c == '[') key_.add("[]");
      value_.keep(0);
      path_[++level_] = key_.size;
      return {};
    case '}':
    case ']':
      if (level_ == 0) return fail(ErrorCode::kMalformed, "closes more brackets than it opens");
      PLUMBLINE_TRY(end_value());
      key_.keep(path_[--level_]);
      return {};
    default: value_.add(c); return {};
  }
}

Status SettingsScanner::take_of_xml(char c) {
  if (inside_) {
    inside_ = c != '>';
    if (inside_) key_.add(c);
    return {};
  }
  if (c != '<') {
    value_.add(c);
    return {};
  }
  inside_ = true;
  const Text key = key_, value = value_;
  key_.keep(0);
  value_.keep(0);
  const std::string_view tag = key.view().substr(0, key.view().find_first_of(" \t"));
  const auto text = trimmed_of(value.view(), " \t\r\n");
  if (key.cut || value.cut || text.empty() || tag.empty() || tag.starts_with('/')) return {};
  return tell(tag, text);
}

}  // namespace plumbline::firmware::inline archive
