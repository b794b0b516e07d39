#include <chrono>

#include "firmware/cli/commands.hpp"
#include "firmware/io/fixed_text.hpp"
#include "firmware/io/interrupt.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/progress_lines.hpp"
#include "firmware/sample/scan_sample.hpp"

namespace plumbline {

ExitCode run_sample(const SampleOptions& options) {
  catch_interrupts();
  ProgressLines lines;
  const SampleSettings settings{.points = options.points, .seed = options.seed};
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const auto done = write_bust_scan(options.output, settings, [&](double fraction) {
    if (!options.quiet) lines.update("scanning", fraction, seconds());
    return !interrupted();
  });
  if (!options.quiet) lines.clear();
  if (!done) return report_error(done.error());
  if (options.quiet) return ExitCode::kDone;
  FixedText<512> text;
  text.add(
      "%s: %llu points with normals, PLY binary little endian, mm; seed %llu, %.1f s\n"
      "next: plumbline slice %s -o out\n",
      options.output.c_str(), static_cast<unsigned long long>(options.points),
      static_cast<unsigned long long>(options.seed), seconds(), options.output.c_str());
  OutputFile out = OutputFile::standard_output();
  const auto written = out.write(text.view());
  return written ? ExitCode::kDone : report_error(written.error());
}

}  // namespace plumbline
