#include <CLI/CLI.hpp>
#include <chrono>
#include <climits>

#include "firmware/cli/commands.hpp"
#include "firmware/cli/options/accepted_values.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/sample/scan_sample.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kSampleFooter =
    "\nExamples:\n"
    "  plumbline sample bust.ply\n"
    "  plumbline sample big.ply --points 5000000 --seed 7\n"
    "\n"
    "Output: a structured-light scan of a bust as a virtual scanner takes it: 22 views, noise, some outliers and an "
    "open\n"
    "underside. Binary PLY with normals, mm. The same seed and number of points give the same file on every machine.\n";

}  // namespace

CLI::App* add_sample_command(CLI::App& app, SampleOptions& options) {
  auto* command = app.add_subcommand("sample", "Make a scan to try plumbline with");
  command->footer(kSampleFooter);
  command->add_option("file", options.output, "The file to write, PLY")->required()->type_name("PLY");
  command->add_option("--points", options.points, "1000 to 50000000 [300000]")
      ->type_name("N")
      ->check(whole_number_from(kMinSamplePoints, kMaxSamplePoints));
  command->add_option("--seed", options.seed, "A whole number from 0; each gives another scan of the bust [1]")
      ->type_name("S")
      ->check(whole_number_from(0, ULLONG_MAX));
  command->add_flag("--quiet", options.quiet, "Print errors only");
  return command;
}

ExitCode run_sample(const SampleOptions& options) {
  catch_interrupts();
  ProgressBar bar;
  const SampleSettings settings{.points = options.points, .seed = options.seed};
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const auto done = write_bust_scan(options.output, settings, [&](double fraction) {
    if (!options.quiet) bar.update("scanning the bust", fraction, seconds());
    return !interrupted();
  });
  bar.clear();
  if (!done) return report_error(done.error());
  if (options.quiet) return ExitCode::kDone;
  FixedText<2 * kMaxPath> text;
  text.add("%s: a scan of a bust, %llu points with normals, mm\nnext: plumbline slice %s -o out\n",
           options.output.c_str(), static_cast<unsigned long long>(options.points), options.output.c_str());
  OutputFile out = OutputFile::standard_output();
  const auto written = out.write(text.view());
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline::firmware
