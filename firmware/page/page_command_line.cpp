#include "firmware/page/page_command_line.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <string>

#include "firmware/io/version.hpp"
#include "firmware/page/clients/paired_browsers.hpp"
#include "firmware/page/http_server.hpp"
#include "firmware/page/page_rights.hpp"
#include "firmware/page/page_server.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/state/socket_place.hpp"

namespace plumbline::firmware::inline page {
namespace {

constexpr const char* kAbout =
    "The printer's page: shows what plumblined does, and takes commands, in a browser.\n"
    "\n"
    "The board file says whether there is one: [printer] page = \"off\", \"local\" (only on this machine) or "
    "\"network\".\n"
    "With \"network\" a browser is paired by a code on the printer's screen before it may command.\n";

constexpr const char* kFooter =
    "\nExamples:\n"
    "  plumbline-page --printer board/my_printer.toml\n"
    "  plumbline-page --printer board/my_printer.toml --listen 127.0.0.1      behind a reverse proxy of this machine\n"
    "\n"
    "firmware/page/README.md says what the page may do, and how to put HTTPS before it.\n";

struct PageOptions {
  std::string printer;
  std::string socket;
  std::string listen;
  std::optional<std::uint16_t> port;
  std::string state;
};

/// "http://127.0.0.1:8080/ (this machine)"
FixedText<200> address_of(const PageOptions& options, const MachineFile& machine, std::uint16_t port) {
  const bool is_six = options.listen.find(':') != std::string::npos;
  const char* const host = options.listen.empty() ? "localhost" : options.listen.c_str();
  FixedText<200> text;
  text.add(is_six ? "http://[%s]:%u/" : "http://%s:%u/", host, port);
  if (machine.page == PageChoice::kNetwork && options.listen.empty()) text.add(" and at this machine's addresses");
  return text;
}

ExitCode serve(PageOptions options) {
  const auto board = read_board_file(options.printer);
  if (!board) return report_error(board.error());
  const auto machine = machine_of(*board, board->path);
  if (!machine) return report_error(machine.error());
  if (machine->page == PageChoice::kOff) {
    std::printf("plumbline-page: %s has no [printer] page = \"local\" or \"network\", so there is no page\n",
                board->path.c_str());
    return ExitCode::kDone;
  }
  if (machine->page == PageChoice::kLocal) {
    if (options.listen.empty()) options.listen = "127.0.0.1";
    if (options.listen != "127.0.0.1" && options.listen != "::1") {
      return report_error(Error::format(ErrorCode::kBadSetting,
                                        "--listen %s: page = \"local\" is for this machine: 127.0.0.1 or ::1",
                                        options.listen.c_str()));
    }
  }
  if (options.socket.empty()) options.socket = machine->state_socket.empty() ? kStateSocket : machine->state_socket;
  // The browsers of this machine are paired whenever they ask, so there is nothing to remember.
  const bool is_local = machine->page == PageChoice::kLocal;
  auto browsers = PairedBrowsers::open(is_local ? std::string() : options.state);
  if (!browsers) return report_error(browsers.error());
  // Writing to a browser that has gone is an error of write().
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));  // NOLINT(cert-err33-c)
  PageServer page(options.socket, machine->page, machine->page_host, std::move(*browsers));
  const auto port = static_cast<std::uint16_t>(machine->page_port);
  const auto server = HttpServer::open(options.listen, options.port.value_or(port), page);
  if (!server) return report_error(server.error());
  std::printf("plumbline-page: %s\n", address_of(options, *machine, (*server)->port()).c_str());
  static_cast<void>(std::fflush(stdout));
  if (const auto given_up = give_up_page_rights(); !given_up) return report_error(given_up.error());
  page.run(**server);
}

}  // namespace

ExitCode run_page_command_line(int argc, char** argv) {
  CLI::App app(kAbout, "plumbline-page");
  app.set_version_flag("--version", std::string("plumbline-page ") + kVersion);
  app.footer(kFooter);
  PageOptions options;
  app.add_option("--printer", options.printer, "Board file")->required()->type_name("TOML");
  app.add_option("--socket", options.socket, "The daemon's state socket [the board file's, else /run/plumbline/state]")
      ->type_name("PATH");
  app.add_option("--listen", options.listen, "Address to serve at [page = \"local\": 127.0.0.1; \"network\": all]")
      ->type_name("ADDRESS");
  app.add_option("--port", options.port, "TCP port; 0: any that is free [the board file's page_port, else 8080]")
      ->type_name("N");
  app.add_option("--state", options.state,
                 "Folder that remembers which browsers are paired [none: until the page ends]")
      ->type_name("DIR");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return status == 0 ? ExitCode::kDone : ExitCode::kUsageError;
  }
  return serve(std::move(options));
}

}  // namespace plumbline::firmware::inline page
