#include "firmware/daemon/upload/upload_name.hpp"

#include "firmware/daemon/stick/stick_scans.hpp"
#include "slicer/core/printable_text.hpp"
#include "slicer/reader/formats/sliced_formats.hpp"

namespace plumbline {
namespace {

constexpr std::size_t kLongestName = 79;
constexpr std::string_view kAllowed =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 ._-()+";  // not of the locale

}  // namespace

Status check_upload_name(std::string_view name) {
  if (name.empty() || name.size() > kLongestName || name.find_first_not_of(kAllowed) != std::string_view::npos ||
      std::string_view(" .-").find(name.front()) != std::string_view::npos) {
    return fail(ErrorCode::kBadSetting,
                "%s: is no name for a scan in the printer's store.\tName the file with at most %zu letters, digits, "
                "spaces and ._-()+, a letter or a digit first",
                PrintableText(name, kLongestName).c_str(), kLongestName);
  }
  if (const ForeignFormat* const foreign = foreign_format(name)) {
    return fail(ErrorCode::kUnknownFormat, "%s %s (%s).\t%s", PrintableText(name).c_str(), foreign->what,
                foreign->program, foreign->advice);
  }
  if (is_scan_name(name)) return {};
  return fail(ErrorCode::kBadSetting,
              "%s: is no scan, mesh or sliced archive by its name.\tSend an STL, OBJ, PLY, OFF, 3MF, PCD, XYZ or .sl1 "
              "file",
              PrintableText(name).c_str());
}

}  // namespace plumbline
