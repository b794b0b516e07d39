#include "firmware/daemon/stick/scan_series.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "firmware/io/scan_names.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::array<std::string_view, 16> kSides = {"front",  "back", "rear",  "left",  "right",  "top",
                                                     "bottom", "side", "vorn",  "vorne", "hinten", "links",
                                                     "rechts", "oben", "unten", "seite"};
/// Each file of these is a whole object.
constexpr std::array<std::string_view, 3> kMeshEndings = {".stl", ".off", ".3mf"};

/// Bytes of letters beyond ASCII are letters, too.
bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 128;
}

/// Puts `#` in the place of the last number.
bool mark_number(std::string& stem) {
  constexpr const char* kDigits = "0123456789";
  const auto last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return false;
  const auto before = stem.find_last_not_of(kDigits, last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  stem = stem.substr(0, first) + "#" + stem.substr(last + 1);
  return true;
}

/// Puts `@` in the place of each word that is a side.
bool mark_sides(std::string& stem) {
  bool marked = false;
  std::string result;
  for (std::size_t at = 0; at < stem.size();) {
    const auto end = static_cast<std::size_t>(
        std::find_if_not(stem.begin() + static_cast<std::ptrdiff_t>(at), stem.end(), is_letter) - stem.begin());
    if (end == at) {
      result += stem[at++];
      continue;
    }
    const std::string_view word = std::string_view(stem).substr(at, end - at);
    const bool side = std::find(kSides.begin(), kSides.end(), word) != kSides.end();
    marked |= side;
    result += side ? "@" : word;
    at = end;
  }
  stem = std::move(result);
  return marked;
}

}  // namespace

std::string series_of(std::string_view name) {
  std::string stem = in_lower_case(name);
  if (!is_scan_file_name(stem)) return {};
  const std::string ending = stem.substr(stem.rfind('.'));
  if (std::find(kMeshEndings.begin(), kMeshEndings.end(), ending) != kMeshEndings.end()) return {};
  stem.resize(stem.size() - ending.size());
  const bool numbered = mark_number(stem);
  const bool sided = mark_sides(stem);
  return numbered || sided ? stem + ending : std::string();
}

std::vector<std::vector<std::size_t>> find_series(std::span<const std::string> names) {
  std::map<std::string, std::vector<std::size_t>> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string series = series_of(names[i]);
    if (!series.empty()) found[series].push_back(i);
  }
  std::vector<std::vector<std::size_t>> several;
  for (auto& [series, files] : found) {
    if (files.size() > 1) several.push_back(std::move(files));
  }
  return several;
}

}  // namespace plumbline::firmware
