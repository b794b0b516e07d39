#include <CLI/CLI.hpp>
#include <array>
#include <cstddef>
#include <vector>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/reports/status_text.hpp"
#include "firmware/io/json_cursor.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/state/state_link.hpp"

namespace plumbline {
namespace {

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumbline status                       what the printer does, what it waits for, and what is wrong\n"
    "  plumbline status --follow              a line for each change, until the daemon ends\n"
    "  plumbline status --json --follow       the same for programs: firmware/state/README.md explains each member\n"
    "  plumbline status --picture layer -o layer.png   the mask of the layer that is printed\n"
    "  plumbline status --socket state/state  of a simulated printer whose daemon has --state state\n";

/// Bytes of a base64 text without line breaks. @returns none: it is none
std::optional<std::vector<std::byte>> bytes_of_base64(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::byte> bytes;
  unsigned bits = 0;
  int count = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const auto digit = kDigits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6U | static_cast<unsigned>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 255U));
  }
  return bytes;
}

/// The daemon answers within a fifth of a second, unless it computes.
constexpr std::chrono::seconds kPatience{10};

}  // namespace

CLI::App* add_status_command(CLI::App& app, StatusOptions& options) {
  auto* command = app.add_subcommand("status", "Show what the running daemon does");
  command->footer(kFooter);
  command->add_option("--socket", options.socket, "The daemon's state socket [/run/plumbline/state]")
      ->type_name("PATH");
  command->add_flag("--follow", options.follow, "Go on: a line for each change");
  command->add_flag("--json", options.json, "For programs: the socket's own lines");
  auto* picture =
      command
          ->add_option("--picture", options.picture,
                       "Write a picture to --output: the preview of what was sliced, or the layer being printed")
          ->type_name("NAME")
          ->check(CLI::IsMember({"preview", "layer"}).description(""));
  auto* output = command->add_option("-o,--output", options.output, "PNG file for the picture")->type_name("FILE");
  picture->needs(output)->excludes("--follow")->excludes("--json");
  output->needs(picture);
  return command;
}

namespace {

/// Asks for a picture and writes it into a file.
Status fetch_picture(const StatusOptions& options) {
  auto link = StateLink::open(options.socket, false);
  PLUMBLINE_TRY(link);
  PLUMBLINE_TRY(link->send("{\"do\": \"picture\", \"picture\": \"" + options.picture + "\"}\n"));
  const auto reply = link->next_of_type("reply", kPatience);
  PLUMBLINE_TRY(reply);
  if (json_member(*reply, "ok") != "true") {
    std::array<char, 1024> room;
    JsonCursor error(json_member(*reply, "error").value_or("null"));
    const auto said = error.take_text(room).value_or("the daemon refused");
    return fail(ErrorCode::kCannotRead, "%.*s", static_cast<int>(said.size()), said.data());
  }
  std::string_view text = json_member(*reply, "png").value_or("");
  if (text.size() < 2) return fail(ErrorCode::kMalformed, "the daemon's reply has no picture");
  const auto bytes = bytes_of_base64(text.substr(1, text.size() - 2));
  if (!bytes) return fail(ErrorCode::kMalformed, "the daemon's reply has no picture");
  return write_file(options.output.c_str(), *bytes);
}

}  // namespace

ExitCode run_status(const StatusOptions& options) {
  if (!options.picture.empty()) {
    const auto fetched = fetch_picture(options);
    return fetched ? ExitCode::kDone : report_error(fetched.error());
  }
  auto link = StateLink::open(options.socket, false);
  if (!link) return report_error(link.error());
  const auto first = link->next_of_type("state", kPatience);
  if (!first) return report_error(first.error());
  OutputFile out = OutputFile::standard_output();
  if (const auto told = out.write(options.json ? *first + "\n" : status_page(*first)); !told) {
    return report_error(told.error());
  }
  std::string shown = status_line(*first);
  while (options.follow) {
    const auto line = link->next_line(std::nullopt);
    if (!line) return report_error(line.error());
    if (!*line) break;
    std::string text = options.json ? **line : status_line(**line);
    if (!options.json && text == shown) continue;
    if (const auto told = out.write(text + "\n"); !told) return report_error(told.error());
    shown = std::move(text);
  }
  return ExitCode::kDone;
}

}  // namespace plumbline
