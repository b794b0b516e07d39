#include "firmware/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "firmware/io/version.hpp"
#include "firmware/sample/scan_sample.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline {
namespace {

constexpr const char* kAbout =
    "Turns a scanned point cloud straight into the layer masks of a resin print: no mesh, fixed memory.\n"
    "\n"
    "  plumbline sample bust.ply                                a scan to try: a bust with noise and an open "
    "underside\n"
    "  plumbline inspect bust.ply --printer board/mono2k.toml   what is in it, and will it fit\n"
    "  plumbline slice bust.ply -o out                          layers, preview and manifest\n"
    "  plumbline print bust.ply --printer board/sim2k.toml      print it, on the simulated printer\n"
    "\n"
    "Lengths are mm, angles degrees. 'plumbline slice --help' explains every option.\n";

constexpr const char* kSliceFooter =
    "\nExamples:\n"
    "  plumbline slice scan.ply -o out                                  pixels and layers of 0.05 mm, the grid fits "
    "the object\n"
    "  plumbline slice scan.ply -o out --printer board/mono2k.toml      the printer's panel, object centred on the "
    "plate\n"
    "  plumbline slice scan.ply -o out --printer board/mono2k.toml --fit   as large as the printer takes\n"
    "  plumbline slice scan.ply -o out --units m --rotate-x 90          a scan in metres whose y points up\n"
    "  plumbline slice front.ply back.ply -o out                        a scan in several files, of one frame\n"
    "  plumbline slice scan.ply -o out --supports auto                  with supports below what would hang in the "
    "air\n"
    "\n"
    "Scans: PLY (ascii, binary), PCD (ascii, binary, compressed), OBJ, XYZ/PTS/ASC/TXT.\n"
    "\n"
    "What comes out:\n"
    "  OUT/layers/00000.png ...  a mask for each layer, lowest first: 1-bit greyscale, white cures; row 0 has the "
    "smallest y\n"
    "  OUT/preview.png           front, side and top view\n"
    "  OUT/confidence.png        what each place rests on: the scan, a repair, or the base plane\n"
    "  OUT/manifest.json         grid, transform, hashes, counts, times; written last: where it is, the job is whole\n"
    "An older job in OUT is replaced. A directory with anything else in it is refused.\n"
    "\n"
    "Exit status: 0 done, 1 an error of file, scan or medium, 2 a wrong command line, 130 interrupted.\n";

constexpr const char* kPrintFooter =
    "\nExamples:\n"
    "  plumbline print scan.ply --printer board/sim2k.toml                     hours of printing in seconds\n"
    "  plumbline print scan.ply --printer board/sim2k.toml --keep-part part    and the part that came of it\n"
    "  plumbline print scan.ply --printer board/sim2k.toml --fault cover.opens@layer=40,for=5s\n"
    "  plumbline print scan.ply --printer board/sim2k.toml --state job --fault power.cut@layer=40\n"
    "  plumbline print --resume --printer board/sim2k.toml --state job         go on where the power was cut\n"
    "\n"
    "What comes out: the checks, a live line, and at the end every exposure's dose, the slowest layer, the smallest "
    "slack\n"
    "and what went wrong, with a code that firmware/README.md explains. hal/sim/README.md lists the faults.\n"
    "\n"
    "Exit status: 0 printed, 1 a fault or an error, 2 a wrong command line, 130 cancelled.\n";

constexpr const char* kDoctorFooter =
    "\nExamples:\n"
    "  plumbline doctor --printer board/my_printer.toml\n"
    "\n"
    "Looks for every line, the panel, sensors, fans, the stick's port and the rights that a print needs, and says what "
    "it "
    "found,\n"
    "what is wrong and what to do. Moves and lights nothing, and disturbs no print that runs.\n"
    "\n"
    "Exit status: 0 it prints, though something may be poor; 1 something is wrong; 2 a wrong command line.\n";

constexpr const char* kInspectFooter =
    "\nExamples:\n"
    "  plumbline inspect scan.ply\n"
    "  plumbline inspect scan.ply --printer board/mono2k.toml --rotate-x 90\n"
    "  plumbline inspect scan.ply --picture seen.png\n"
    "\n"
    "What comes out: points and normals, extent, the unit that fits its size, spacing, noise, what the scan has not "
    "seen,\n"
    "whether and how large the printer takes it, and the arena that each stage of slicing needs. For what it has not "
    "seen\n"
    "the scan is read a second time and sliced coarsely. Nothing but the picture is written to disk.\n";

constexpr const char* kSampleFooter =
    "\nExamples:\n"
    "  plumbline sample bust.ply\n"
    "  plumbline sample big.ply --points 5000000 --seed 7\n"
    "\n"
    "What comes out: a virtual structured-light scan of an analytic bust, 22 views, with noise, a few strays and an "
    "open\n"
    "underside. PLY, binary, mm, with normals. The same seed and count give the same file everywhere.\n";

/// Numbers that CLI11 takes, but no print: NaN passes its range check.
CLI::Validator finite_range(double low, double high) {
  return CLI::Validator(
      [low, high](std::string& text) -> std::string {
        double number = 0;
        if (CLI::detail::lexical_cast(text, number) && number >= low && number <= high) return {};
        char message[128];
        std::snprintf(message, sizeof message, "'%.40s' is not a number from %g to %g", text.c_str(), low, high);
        return message;
      },
      "");
}

constexpr std::array kUnits = {Units::kMillimetres, Units::kCentimetres, Units::kMetres, Units::kInches, Units::kAuto};

std::vector<std::string> unit_names() {
  std::vector<std::string> names;
  names.reserve(kUnits.size());
  for (const Units units : kUnits) names.emplace_back(to_string(units));
  return names;
}

/// @param name  one of unit_names()
Units units_named(const std::string& name) {
  return *std::find_if(kUnits.begin(), kUnits.end(), [&](Units units) { return name == to_string(units); });
}

/// @param name  "none", "flat" or "auto"
BaseChoice base_named(const std::string& name) {
  for (const BaseChoice choice : {BaseChoice::kNone, BaseChoice::kFlat}) {
    if (name == to_string(choice)) return choice;
  }
  return BaseChoice::kAuto;
}

void add_print_options(CLI::App& app, PrintOptions& print) {
  constexpr const char* kJob = "Job";
  app.add_option("--profile", print.profile, "Resin and print settings: a name in profiles/, or a file [the printer's]")
      ->type_name("NAME")
      ->group(kJob);
  auto* state = app.add_option("--state", print.state,
                               "Folder for the journal, with which a print goes on after a power cut [none is kept]")
                    ->type_name("DIR")
                    ->group(kJob);
  app.add_flag("--resume", print.resume, "Go on with the interrupted print in --state")->needs(state)->group(kJob);
  app.add_option("--report", print.report, "Write the report, with every exposure, as JSON")
      ->type_name("FILE")
      ->group(kJob);

  constexpr const char* kSimulation = "Simulation";
  SimulationOptions& simulation = print.simulation;
  app.add_flag("--simulate", simulation.simulate, "Simulate the printer, also one that exists")->group(kSimulation);
  auto* speedup = app.add_option("--speedup", simulation.speedup,
                                 "Virtual seconds a second, 0.1 to 1000000 [as fast as this machine can]")
                      ->type_name("N")
                      ->check(finite_range(0.1, 1e6))
                      ->group(kSimulation);
  app.add_flag_callback(
         "--realtime", [&simulation] { simulation.speedup = 1; }, "--speedup 1")
      ->excludes(speedup)
      ->group(kSimulation);
  app.add_option("--fault", simulation.faults, "What goes wrong, such as lamp.stuck_on@layer=40; any number of times")
      ->type_name("FAULT")
      ->take_all()
      ->group(kSimulation);
  app.add_option("--lamp-line", simulation.lamp_line,
                 "Lamp line that plumbline-keeper lights as the simulated lamp is lit; file:PATH writes each change. "
                 "Needs --speedup or --realtime")
      ->type_name("LINE")
      ->group(kSimulation);
  app.add_option("--keep-part", print.keep_part, "Write what was cured: layers, preview and manifest")
      ->type_name("DIR")
      ->group(kSimulation);
}

/// @returns the scan, which is required unless the caller says otherwise
CLI::Option* add_job_options(CLI::App& app, JobOptions& job) {
  auto* scan =
      app.add_option("scan", job.scans,
                     "The scan: .ply, .pcd, .obj, .xyz, .pts, .asc or .txt. Several files in one frame are one "
                     "scan, read in this order")
          ->required()
          ->expected(1, static_cast<int>(kMostScans))
          ->type_name("SCAN");
  constexpr const char* kPrint = "Print";
  auto* printer =
      app.add_option("--printer", job.printer,
                     "Board file: gives panel, pitch, travel, layer height and arena. Without one the grid fits "
                     "the object")
          ->type_name("TOML")
          ->group(kPrint);
  app.add_option("--pixel-pitch", job.pixel_pitch_mm, "Pixel size, 0.005 to 1 mm; without --printer [0.05]")
      ->type_name("MM")
      ->check(finite_range(kFinestMm, kCoarsestMm))
      ->excludes(printer)
      ->group(kPrint);
  app.add_option("--layer-height", job.layer_height_mm, "Layer height, 0.005 to 1 mm [0.05, or the printer's]")
      ->type_name("MM")
      ->check(finite_range(kFinestMm, kCoarsestMm))
      ->group(kPrint);

  app.add_option_function<std::string>(
         "--base", [&job](const std::string& name) { job.base = base_named(name); },
         "Underside: auto closes it flat where the scan is open there, flat always stands it on that plane, none "
         "closes it as any other hole [auto]")
      ->type_name("KIND")
      ->check(CLI::IsMember({"none", "flat", "auto"}).description(""))
      ->group(kPrint);
  app.add_flag("--keep-all", job.keep_all,
               "Keep stray pieces: small ones apart from the object, such as a bit of what stood behind it, and small "
               "hollows inside it")
      ->group(kPrint);

  constexpr const char* kPlacement = "Placement";
  app.add_option_function<std::string>(
         "--units", [&job](const std::string& name) { job.units = units_named(name); },
         "Unit of the scan's coordinates: mm, cm, m, in, or auto (the one that makes it 20 to 500 mm long) [mm]")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unit_names()).description(""))
      ->group(kPlacement);
  auto* scale = app.add_option("--scale", job.scale, "Times the size in the scan [1]")
                    ->type_name("F")
                    ->check(finite_range(kSmallestScale, kLargestScale))
                    ->group(kPlacement);
  app.add_flag("--fit", job.fit, "The largest scale that the printer takes")
      ->needs(printer)
      ->excludes(scale)
      ->group(kPlacement);
  const char* const names[] = {"--rotate-x", "--rotate-y", "--rotate-z"};
  const char* const help[] = {"Turn about x, first; right-handed [0]", "Turn about y, then [0]",
                              "Turn about z, last [0]"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    app.add_option(names[axis], job.rotate_degrees[axis], help[axis])
        ->type_name("DEG")
        ->check(finite_range(-360, 360))
        ->group(kPlacement);
  }

  constexpr const char* kMachine = "Machine";
  app.add_option(
         "--arena-mib", job.arena_mib,
         "Memory for the work, MiB; points are thinned until they fit [the printer's, or all that was built in]")
      ->type_name("N")
      ->check(CLI::Range(1U, 1U << 20U).description(""))
      ->group(kMachine);
  app.add_option("--threads", job.threads,
                 "1 to 64; the masks do not depend on it [OMP_NUM_THREADS, or the cores, at most 8]")
      ->type_name("N")
      ->check(CLI::Range(1U, kMostThreads).description(""))
      ->group(kMachine);
  app.add_flag("--quiet", job.quiet, "Print errors only")->group(kMachine);
  app.add_flag("--json", job.json, "Print the report as one JSON object, and nothing else")->group(kMachine);
  return scan;
}

/// "--support-head-width" for support_head_width.
std::string option_name(const SupportField& field) {
  std::string name = "--" + std::string(field.key);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

/// `--supports`, and an option for each setting.
/// @param otherwise   "[none]": what holds where the option is not given
void add_support_options(CLI::App& app, SupportChoice& choice, const char* otherwise) {
  constexpr const char* kSupports = "Supports";
  app.add_option_function<std::string>(
         "--supports", [&choice](const std::string& kind) { choice.enable = kind == "auto"; },
         std::string("none, or auto: below islands and overhangs, from the layers alone ") + otherwise)
      ->type_name("KIND")
      ->check(CLI::IsMember({"none", "auto"}).description(""))
      ->group(kSupports);
  for (std::size_t i = 0; i < kSupportFields.size(); ++i) {
    const SupportField& field = kSupportFields[i];
    const std::string name = option_name(field);
    char range[64];
    std::snprintf(range, sizeof range, ", %g to %g %s [%g]", field.low, field.high, field.unit.data(),
                  SupportSettings().*field.member);
    app.add_option(name, choice.values[i], std::string(field.help) + range)
        ->type_name(field.unit == "deg" ? "DEG" : "MM")
        ->check(finite_range(field.low, field.high))
        ->group(kSupports);
  }
}

}  // namespace

ExitCode run_command_line(int argc, char** argv, std::span<std::byte> arena_block) {
  CLI::App app(kAbout, "plumbline");
  app.set_version_flag("--version", std::string("plumbline ") + kVersion);
  app.require_subcommand(1);
  app.get_formatter()->column_width(30);

  SliceOptions slice;
  auto* slice_app = app.add_subcommand("slice", "Slice a scan into layer masks");
  slice_app->footer(kSliceFooter);
  add_job_options(*slice_app, slice.job);
  slice_app->add_option("-o,--output", slice.output, "Directory for the layers; created if it is missing")
      ->required()
      ->type_name("OUT");
  SupportChoice slice_supports;
  add_support_options(*slice_app, slice_supports, "[none]");
  bool no_preview = false;
  slice_app->add_flag("--no-preview", no_preview, "Do not draw preview.png and confidence.png");

  InspectOptions inspect;
  auto* inspect_app =
      app.add_subcommand("inspect", "Say what is in a scan, what slicing it needs, and whether it fits");
  inspect_app->footer(kInspectFooter);
  add_job_options(*inspect_app, inspect.job);
  inspect_app->add_option("--picture", inspect.picture, "Draw what the scan has seen and what it has not")
      ->type_name("PNG");

  PrintOptions print;
  auto* print_app = app.add_subcommand("print", "Print a scan");
  print_app->footer(kPrintFooter);
  auto* print_scan = add_job_options(*print_app, print.job)->required(false);
  add_support_options(*print_app, print.supports, "[as the profile has it]");
  add_print_options(*print_app, print);
  print_app->get_option("--printer")->required();
  auto* resume = print_app->get_option("--resume")->excludes(print_scan)->excludes("--supports");
  for (const SupportField& field : kSupportFields) {
    resume->excludes(option_name(field));
  }

  SampleOptions sample;
  const SampleSettings defaults;
  sample.points = defaults.points;
  sample.seed = defaults.seed;
  auto* sample_app = app.add_subcommand("sample", "Write the project's own scan: something to try");
  sample_app->footer(kSampleFooter);
  sample_app->add_option("file", sample.output, "The file to write: PLY")->required()->type_name("PLY");
  sample_app->add_option("--points", sample.points, "1000 to 50000000 [300000]")
      ->type_name("N")
      ->check(CLI::Range(kMinSamplePoints, kMaxSamplePoints).description(""));
  sample_app
      ->add_option("--seed", sample.seed, "Any whole number from 0: another one is another scan of the same bust [1]")
      ->type_name("S")
      ->check(CLI::NonNegativeNumber.description(""));
  sample_app->add_flag("--quiet", sample.quiet, "Print errors only");

  DoctorOptions doctor;
  auto* doctor_app = app.add_subcommand("doctor", "Look at the board this runs on: is the printer's hardware there");
  doctor_app->footer(kDoctorFooter);
  doctor_app->add_option("--printer", doctor.printer, "The printer's board file")->required()->type_name("TOML");
  doctor_app->add_flag("--json", doctor.json, "Print the findings as one JSON object, and nothing else");

  try {
    app.parse(argc, argv);
    const auto supports = slice_supports.over(false, {});
    if (!supports) throw CLI::ValidationError(supports.error().message());
    slice.supports = *supports;
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);  // prints help, version, or what is wrong
    return status == 0 ? ExitCode::kDone : ExitCode::kUsageError;
  }
  if (print_app->parsed() && !print.resume && print.job.scans.empty()) {
    const int status = app.exit(CLI::RequiredError("print: scan, or --resume with --state,"));
    return status == 0 ? ExitCode::kDone : ExitCode::kUsageError;
  }
  slice.preview = !no_preview;
  if (slice_app->parsed()) return run_slice(slice, arena_block);
  if (inspect_app->parsed()) return run_inspect(inspect, arena_block);
  if (print_app->parsed()) return run_print(print, arena_block);
  if (doctor_app->parsed()) return run_doctor(doctor);
  return run_sample(sample);
}

}  // namespace plumbline
