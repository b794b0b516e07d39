#include "firmware/settings/settings_folders.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/setting_words.hpp"

namespace plumbline::firmware::inline settings {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".toml";

bool is_path(std::string_view text) { return text.find('/') != std::string_view::npos || text.ends_with(kEnding); }

bool is_there(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// Names of the TOML files in some folders, sorted.
std::vector<std::string> names_in(const std::vector<std::string>& folders) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() == kEnding) names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

/// The first `folder/name.toml` that exists.
/// @param what  "printer" or "profile"
Expected<std::string> find(const std::string& name, const std::vector<std::string>& folders, const char* what) {
  for (const auto& folder : folders) {
    const std::string path = (fs::path(folder) / (name + std::string(kEnding))).string();
    if (is_there(path)) return path;
  }
  const auto names = names_in(folders);
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::vector<std::string_view> looked_in(folders.begin(), folders.end());
  if (known.empty()) {
    return fail(
        ErrorCode::kCannotOpen,
        "no %s is called %s: there is no .toml file in %s.\tGive the path of one: plumbline's sources have them in "
        "board/, an installation in share/plumbline/board/",
        what, printable(name).c_str(), joined(looked_in).c_str());
  }
  const auto near = nearest_within(name, known);
  std::string advice = near ? "Did you mean " + std::string(*near) + "? " : std::string();
  advice += "There are " + joined(known);
  return fail(ErrorCode::kCannotOpen, "no %s is called %s. %s in %s. Or give the path of its .toml file", what,
              printable(name).c_str(), advice.c_str(), joined(looked_in).c_str());
}

}  // namespace

std::vector<std::string> board_folders() {
  std::vector<std::string> folders = {"board"};
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  if (unknown) return folders;
  // bin/plumbline of an installation, build/PRESET/firmware/plumbline of a source tree.
  for (const char* way : {"../share/plumbline/board", "../../../board"}) {
    const fs::path folder = (program.parent_path() / way).lexically_normal();
    if (fs::is_directory(folder, unknown)) folders.push_back(folder.string());
  }
  return folders;
}

Expected<std::string> find_board_file(const std::string& name_or_path) {
  if (!is_path(name_or_path) && !is_there(name_or_path)) return find(name_or_path, board_folders(), "printer");
  if (is_there(name_or_path)) return name_or_path;
  const auto names = names_in(board_folders());
  const std::string known =
      names.empty() ? std::string() : ", or name a printer: " + joined({names.begin(), names.end()});
  return fail(ErrorCode::kCannotOpen, "%s: no such board file.\tCheck the path%s", printable(name_or_path).c_str(),
              known.c_str());
}

Expected<std::string> find_profile(const std::string& name_or_path, const std::string& board_path) {
  if (is_path(name_or_path)) return name_or_path;
  std::vector<std::string> folders = {(fs::path(board_path).parent_path() / "profiles").string()};
  for (const auto& board : board_folders()) {
    std::string folder = board + "/profiles";
    if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(std::move(folder));
  }
  auto found = find(name_or_path, folders, "profile");
  if (!found) found.error().tell({PrinterCode::kProfileUnknown, {}, name_or_path});
  return found;
}

std::vector<std::string> profile_names(const std::string& board_path) {
  return names_in({(fs::path(board_path).parent_path() / "profiles").string()});
}

Status check_file_name(const std::string& path, const char* key, const std::string& name) {
  const fs::path file(path);
  if (file.extension() != kEnding || file.stem() == name) return {};
  return fail(ErrorCode::kBadSetting, "%s: %s is \"%s\", but the file is called %s.\tChange one of them",
              printable(path).c_str(), key, name.c_str(), file.filename().c_str());
}

}  // namespace plumbline::firmware::inline settings
