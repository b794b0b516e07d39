#include "firmware/daemon/upload/upload_name.hpp"

#include <algorithm>
#include <string>

#include "firmware/daemon/stick/stick_scans.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/formats/foreign_formats.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::size_t kLongestName = 79;
constexpr std::string_view kAllowed =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 ._-()+";  // not of the locale

}  // namespace

Status check_upload_name(std::string_view name) {
  if (name.empty() || name.size() > kLongestName || name.find_first_not_of(kAllowed) != std::string_view::npos ||
      std::string_view(" .-").find(name.front()) != std::string_view::npos) {
    return telling(
        Told(PrinterCode::kUploadName, {}, name),
        fail(ErrorCode::kBadSetting,
             "%s: is not a name that the printer's store takes.\tName the file with at most %zu letters, digits, "
             "spaces and ._-()+, a letter or a digit first",
             PrintableText(name, kLongestName).c_str(), kLongestName));
  }
  if (const ForeignFormat* const foreign = foreign_format(name)) {
    return telling(Told(foreign->kind.code, {}, name),
                   fail(ErrorCode::kUnknownFormat, "%s %s (%s).\t%s", PrintableText(name).c_str(), foreign->kind.what,
                        foreign->program, foreign->kind.advice));
  }
  if (is_scan_name(name)) return {};
  return telling(Told(PrinterCode::kUploadKind, {}, name),
                 fail(ErrorCode::kBadSetting,
                      "%s: does not have the ending of a scan, mesh or sliced archive.\tSend an STL, OBJ, PLY, OFF, "
                      "3MF, PCD, XYZ or .sl1 "
                      "file",
                      PrintableText(name).c_str()));
}

FixedText<80> upload_name_of(std::string_view file_name) {
  std::string plain;
  for (const char c : file_name) {
    const bool continues = (static_cast<unsigned char>(c) & 0xc0U) == 0x80U;  // a character of UTF-8
    if (!continues) plain += kAllowed.find(c) != std::string_view::npos ? c : '_';
  }
  plain.erase(0, plain.find_first_not_of(" .-"));
  if (plain.size() > kLongestName) {
    const std::size_t dot = std::min(plain.rfind('.'), plain.size());
    const std::string ending = plain.substr(dot).substr(0, kLongestName);
    plain = plain.substr(0, kLongestName - ending.size()) + ending;
  }
  FixedText<80> name;
  name.add("%s", plain.c_str());
  return name;
}

}  // namespace plumbline::firmware
