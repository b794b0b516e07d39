#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <vector>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/dropped_files.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/settings_folders.hpp"
#include "firmware/state/state_link.hpp"

namespace plumbline::firmware {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* kSimulateFooter =
    "\nExamples:\n"
    "  plumbline simulate                          then open the address that it prints, and drop scans into its "
    "folder\n"
    "  plumbline simulate bust.ply --speed 600     with a scan on the stick; ten minutes of the printer a second\n"
    "  plumbline simulate --folder try --port 9000\n"
    "\n"
    "It starts plumblined and plumbline-page with a board file of their own. Ctrl-C ends both, and removes the folder\n"
    "unless you named it.\n"
    "In the folder:\n"
    "  stick/              drop scans and meshes here: the printer sees a stick that is plugged in\n"
    "  screen/screen.png   what the printer's small screen shows\n"
    "  board/              the printer's file and profiles: change them, then start again\n"
    "  state/              journal, stored job, the last print's report\n";

constexpr std::chrono::milliseconds kLook{300};
constexpr std::chrono::seconds kStartTime{20};

/// Ends with its owner.
class Child {
 public:
  explicit Child(pid_t process) : process_(process) {}
  Child(Child&& other) noexcept : process_(std::exchange(other.process_, -1)) {}
  Child& operator=(Child&&) = delete;
  ~Child() {
    if (process_ <= 0) return;
    ::kill(process_, SIGTERM);
    ::waitpid(process_, nullptr, 0);
  }
  bool has_ended() {
    if (process_ <= 0 || ::waitpid(process_, nullptr, WNOHANG) == process_) process_ = -1;
    return process_ < 0;
  }

 private:
  pid_t process_;
};

Expected<Child> start(const fs::path& program, std::vector<std::string> arguments, const fs::path& log) {
  std::vector<char*> pointers;
  std::string name = program.string();
  pointers.push_back(name.data());
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) return fail(ErrorCode::kCannotOpen, "%s: no process", name.c_str());
  if (process > 0) return Child(process);
  // Also when this program is killed. And Ctrl-C is for this program, which ends the others in order.
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  ::setpgid(0, 0);
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (::getppid() != parent || file < 0 || ::dup2(file, STDOUT_FILENO) < 0 || ::dup2(file, STDERR_FILENO) < 0)
    ::_exit(126);
  ::execv(name.c_str(), pointers.data());
  ::_exit(127);
}

/// Puts a key into a table of TOML, in place of the one that is there.
std::string with_key(const std::string& text, const std::string& table, const std::string& key,
                     const std::string& value) {
  std::string out, here;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const std::string line = text.substr(at, end - at);
    at = end;
    if (line.starts_with('[')) here = line.substr(1, line.find(']') - 1);
    const std::string word = line.substr(0, line.find_first_of(" \t="));
    if (here == table && word == key) continue;
    out += line;
    if (line.starts_with('[') && here == table) out.append(key).append(" = ").append(value).append("\n");
  }
  return out;
}

/// Writes the printer's file, which has a page and asks before it prints, and the profiles beside it.
Expected<std::string> write_board(const SimulateOptions& options, const fs::path& folder) {
  const auto original = find_board_file(options.printer);
  PLUMBLINE_TRY(original);
  const auto board = read_board_file(*original);
  PLUMBLINE_TRY(board);
  PLUMBLINE_TRY(machine_of(*board, *original));
  auto text = read_settings_text(*original, "a board file");
  PLUMBLINE_TRY(text);
  *text = with_key(*text, "printer", "page", "\"local\"");
  *text = with_key(*text, "printer", "page_port", std::to_string(options.port));
  *text = with_key(*text, "print", "start", "\"after_preview\"");
  const fs::path path = folder / (board->name + ".toml");
  std::error_code error;
  fs::create_directories(folder, error);
  // What somebody has changed there stays.
  if (fs::exists(path, error)) return path.string();
  fs::copy(fs::path(*original).parent_path() / "profiles", folder / "profiles",
           fs::copy_options::recursive | fs::copy_options::skip_existing, error);
  PLUMBLINE_TRY(write_file(path.c_str(), std::as_bytes(std::span(*text))));
  return path.string();
}

/// A folder and whether it is to be removed.
struct SimulationPlace {
  fs::path folder;
  bool own = false;
  ~SimulationPlace() {
    std::error_code ignored;
    if (own) fs::remove_all(folder, ignored);
  }
};

Status make_folder(const SimulateOptions& options, SimulationPlace& place) {
  std::error_code error;
  if (options.folder.empty()) {
    std::string pattern = (fs::temp_directory_path(error) / "plumbline-XXXXXX").string();
    if (error || ::mkdtemp(pattern.data()) == nullptr) {
      return fail(ErrorCode::kCannotOpen, "%s: no folder can be made there.\tName one: --folder", pattern.c_str());
    }
    place.folder = pattern;
    place.own = true;
  } else {
    place.folder = fs::absolute(options.folder, error);
  }
  for (const char* const name : {"stick", "state", "screen"}) {
    if (!error) fs::create_directories(place.folder / name, error);
  }
  if (!error && !fs::exists(place.folder / "state" / "seen", error)) {
    // A new printer's plate is empty.
    for (const char* const name : {"plate-is-empty", "seen"}) {
      PLUMBLINE_TRY(write_file((place.folder / "state" / name).c_str(), {}));
    }
  }
  for (const std::string& scan : options.scans) {
    if (!error) fs::copy(scan, place.folder / "stick", fs::copy_options::overwrite_existing, error);
    if (error) return fail(ErrorCode::kCannotOpen, "%s: %s", scan.c_str(), error.message().c_str());
  }
  if (!error) return {};
  return fail(ErrorCode::kCannotOpen, "%s: %s", place.folder.c_str(), error.message().c_str());
}

/// The state's name, or nothing if the printer does not answer.
std::string state_of(const std::string& socket) {
  auto link = StateLink::open(socket, false);
  if (!link) return {};
  const auto line = link->next_of_type("state", 2s);
  if (!line) return {};
  const auto state = json_member(*line, "state").value_or("");
  return state.size() > 2 ? std::string(state.substr(1, state.size() - 2)) : std::string();
}

/// The address that the page has printed into its log.
std::string address_in(const fs::path& log) {
  const auto text = read_settings_text(log.string(), "a log");
  if (!text) return {};
  const std::size_t begin = text->find("http://"), end = text->find('\n', begin);
  return begin == std::string::npos || end == std::string::npos ? std::string() : text->substr(begin, end - begin);
}

/// A program that should not have ended, with the last line of its log.
ExitCode has_ended(const char* program, const fs::path& log) {
  const auto text = read_settings_text(log.string(), "a log");
  std::string_view line = text ? std::string_view(*text) : "its log can't be read";
  while (line.ends_with('\n')) line.remove_suffix(1);
  if (const std::size_t begin = line.rfind('\n'); begin != std::string_view::npos) line.remove_prefix(begin + 1);
  return report_error(
      Error::format(ErrorCode::kCannotOpen, "%s has ended: %s", program, PrintableText(line, 300).c_str()));
}

ExitCode simulate(const SimulateOptions& options) {
  catch_interrupts();
  SimulationPlace place;
  if (const auto made = make_folder(options, place); !made) return report_error(made.error());
  const auto board = write_board(options, place.folder / "board");
  if (!board) return report_error(board.error());
  std::error_code unknown;
  const fs::path programs = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  if (!fs::exists(programs / "plumbline-page", unknown)) {
    return report_error(
        Error::format(ErrorCode::kUnsupported,
                      "there is no plumbline-page beside plumbline.\tInstall libmicrohttpd-dev, then build again"));
  }
  const fs::path state = place.folder / "state", link = state / "stick";
  const std::string socket = (state / "state").string();
  const fs::path log = state / "plumblined.log", page_log = state / "plumbline-page.log";
  fs::remove(page_log, unknown);
  DroppedFiles stick((place.folder / "stick").string(), link.string());
  FixedText<32> speed;
  speed.add("%.1f", options.speed);
  auto printer = start(programs / "plumblined",
                       {"--printer", *board, "--simulate", "--state", state.string(), "--stick", link.string(),
                        "--screen", (place.folder / "screen").string(), "--speedup", speed.c_str()},
                       log);
  if (!printer) return report_error(printer.error());
  std::optional<Child> page;
  const auto began = std::chrono::steady_clock::now();
  bool told = false;
  while (!interrupted()) {
    if (printer->has_ended()) return has_ended("plumblined", log);
    if (page && page->has_ended()) return has_ended("plumbline-page", page_log);
    const std::string now = state_of(socket), address = told ? std::string() : address_in(page_log);
    if (!page && !now.empty()) {
      // Once there is a printer to show.
      auto started = start(programs / "plumbline-page",
                           {"--printer", *board, "--socket", socket, "--port", std::to_string(options.port)}, page_log);
      if (!started) return report_error(started.error());
      page.emplace(std::move(*started));
    }
    stick.look(now.empty() || now == "slicing");
    if (!told && !now.empty() && !address.empty()) {
      told = true;
      FixedText<3 * kMaxPath> text;
      text.add("open        %s\ndrop scans  %s\nscreen      %s\nCtrl-C ends it\n", address.c_str(),
               (place.folder / "stick").c_str(), (place.folder / "screen" / "screen.png").c_str());
      OutputFile out = OutputFile::standard_output();
      if (const auto written = out.write(text.view()); !written) return report_error(written.error());
    }
    if (!told && std::chrono::steady_clock::now() - began > kStartTime) {
      return report_error(
          Error::format(ErrorCode::kDeviceTimeout, "the simulated printer does not start.\tLook at %s", log.c_str()));
    }
    std::this_thread::sleep_for(kLook);
  }
  write_line("ending the simulated printer");
  return ExitCode::kDone;
}

}  // namespace

CLI::App* add_simulate_command(CLI::App& app, SimulateOptions& options) {
  auto* command = app.add_subcommand(
      "simulate", "Open a simulated printer, with its page in the browser and a stick to drop files into");
  command->footer(kSimulateFooter);
  command->add_option("scans", options.scans, "Scans and meshes to copy onto the stick")->type_name("FILE");
  command->add_option("--printer", options.printer, "Board file of a simulated printer [sim2k]")->type_name("TOML");
  command->add_option("--speed", options.speed, "Simulated seconds per second, 0.1 to 1000000 [60]")
      ->type_name("N")
      ->check(number_from(0.1, 1e6));
  command->add_option("--port", options.port, "TCP port of the page, on this machine only [8080]")
      ->type_name("N")
      ->check(whole_number_from(1024, 65535));
  command
      ->add_option("--folder", options.folder, "Folder for everything, which is kept [a new one, removed at the end]")
      ->type_name("DIR");
  return command;
}

ExitCode run_simulate(const SimulateOptions& options) { return simulate(options); }

}  // namespace plumbline::firmware
