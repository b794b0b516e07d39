#include "firmware/slice/slice_job.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lodepng.h>

#include <cstdlib>
#include <memory>

#include "firmware/io/mask_hash.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/slice/manifest.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

alignas(64) std::byte arena_block[std::size_t{64} * 1024 * 1024];

constexpr double kRadius = 12;  ///< mm

/// Runs a job in all of the test's arena. @returns its report
Expected<JobReport> run(const SliceJobSettings& settings) {
  Arena arena(arena_block);
  auto job = SliceJob::prepare(settings, arena);
  PLUMBLINE_TRY(job);
  JobProgress progress(nullptr);
  PLUMBLINE_TRY(job->run(progress));
  EXPECT_EQ(arena.used(), 0U) << "a job gives back what it took";
  return job->report();
}

std::string layer_path(const std::string& out, std::uint32_t layer) {
  char name[32];
  std::snprintf(name, sizeof name, "/layers/%05u.png", layer);
  return out + name;
}

/// Pixels of a PNG, one byte each, and its own colour type.
struct Decoded {
  std::unique_ptr<unsigned char, decltype(&std::free)> pixels{nullptr, &std::free};
  unsigned columns = 0;
  unsigned rows = 0;
  unsigned bit_depth = 0;
  LodePNGColorType colour = LCT_MAX_OCTET_VALUE;
};

Decoded decode(const std::string& path) {
  const std::string file = read_text(path);
  Decoded image;
  LodePNGState state;
  lodepng_state_init(&state);
  state.info_raw.colortype = LCT_GREY;
  state.info_raw.bitdepth = 8;
  unsigned char* pixels = nullptr;
  const unsigned error = lodepng_decode(&pixels, &image.columns, &image.rows, &state,
                                        reinterpret_cast<const unsigned char*>(file.data()), file.size());
  image.pixels.reset(pixels);
  image.bit_depth = state.info_png.color.bitdepth;
  image.colour = state.info_png.color.colortype;
  lodepng_state_cleanup(&state);
  EXPECT_EQ(error, 0U) << path << ": " << lodepng_error_text(error);
  return image;
}

/// Expects that the files of a job are, pixel by pixel, what a MaskStream of the same scan makes.
void expect_layers_of_stream(const SliceJobSettings& settings, const JobReport& report) {
  Arena arena(arena_block);
  auto source = FileSource::open(settings.scan_paths[0]);
  ASSERT_TRUE(source.has_value());
  SliceReport ignored;
  auto rrep = slice(*source, settings.slice, arena, nullptr, ignored);
  ASSERT_TRUE(rrep.has_value()) << rrep.error().message();
  SupportCounts counts;
  const auto supports = add_supports(*rrep, settings.slice, arena, nullptr, ignored, counts);
  ASSERT_TRUE(supports.has_value()) << supports.error().message();
  EXPECT_EQ(report.supports.all(), supports->tips());
  auto stream = MaskStream::create(*rrep, *supports, arena);
  ASSERT_TRUE(stream.has_value());
  std::vector<std::uint64_t> hashes;
  std::uint64_t differences = 0;
  std::uint64_t cured = 0;
  for (std::uint32_t layer = 0; layer < rrep->grid.layers; ++layer) {
    const ConstBitImage mask = stream->mask(layer);
    hashes.push_back(mask_hash(mask));
    cured += mask.count();
    const Decoded image = decode(layer_path(settings.output_path, layer));
    ASSERT_EQ(image.columns, mask.columns());
    ASSERT_EQ(image.rows, mask.rows());
    ASSERT_EQ(image.bit_depth, 1U);
    ASSERT_EQ(image.colour, LCT_GREY);
    for (std::uint32_t r = 0; r < mask.rows(); ++r) {
      for (std::uint32_t c = 0; c < mask.columns(); ++c) {
        const int white = image.pixels.get()[std::size_t{r} * mask.columns() + c];
        differences += white == (mask.at(c, r) ? 255 : 0) ? 0U : 1U;
      }
    }
  }
  EXPECT_EQ(differences, 0U);
  EXPECT_EQ(report.hash, job_hash(hashes));
  EXPECT_EQ(report.cured_pixels, cured);
  EXPECT_FALSE(std::filesystem::exists(layer_path(settings.output_path, rrep->grid.layers)));
}

TEST(SliceJob, WritesExactlyTheMasksThatWouldBePrinted) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 40'000, kRadius);
  const auto settings = sphere_job(folder);
  const auto report = run(settings);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  expect_layers_of_stream(settings, *report);
  EXPECT_TRUE(std::filesystem::exists(settings.output_path + "/preview.png"));
}

/// The R-Rep and the supports are known when these stages begin.
void expect_exact_plan(const JobReport& report, Stage stage) {
  const auto used = static_cast<double>(report.peak_bytes(stage));
  const auto planned = static_cast<double>(report.slice.planned_bytes[static_cast<std::size_t>(stage)]);
  EXPECT_LE(used, planned) << to_string(stage);
  EXPECT_LE(planned, 1.05 * used) << to_string(stage);
}

TEST(SliceJob, WritesMasksWithTheirSupports) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 40'000, kRadius);
  auto settings = sphere_job(folder);
  const auto without = run(settings);
  ASSERT_TRUE(without.has_value()) << without.error().message();
  settings.slice.supports = SupportSettings{};
  const auto report = run(settings);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  expect_layers_of_stream(settings, *report);
  EXPECT_GT(report->supports.all(), 0U);
  EXPECT_EQ(report->cured_pixels - report->support_pixels, without->cured_pixels);
  EXPECT_GT(report->peak_bytes(Stage::kSupports), 0U);
  for (const Stage stage : {Stage::kSupports, Stage::kLayers}) expect_exact_plan(*report, stage);
  expect_exact_plan(*without, Stage::kLayers);
  EXPECT_EQ(without->peak_bytes(Stage::kSupports), 0U);
}

TEST(SliceJob, WritesGreyPixelsInMemoryThatItHasPlanned) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 40'000, kRadius);
  auto settings = sphere_job(folder);
  for (const auto& [grey, has_supports] : {std::pair(Grey::kVertical, false), std::pair(Grey::kVertical, true),
                                           std::pair(Grey::kFull, false), std::pair(Grey::kFull, true)}) {
    settings.slice.supports = has_supports ? std::optional(SupportSettings{}) : std::nullopt;
    settings.grey = {};
    settings.slice.grey = Grey::kOff;
    const auto without = run(settings);
    ASSERT_TRUE(without.has_value()) << without.error().message();
    settings.grey = {
        .penetration_mm = 0.12, .critical_dose = 3.2, .dose = 8.75, .bottom_dose = 105, .bottom_layers = 5};
    settings.slice.grey = grey;
    const auto report = run(settings);
    ASSERT_TRUE(report.has_value()) << report.error().message();
    for (const Stage stage : {Stage::kRRep, Stage::kLayers}) expect_exact_plan(*report, stage);
    const auto cured = static_cast<double>(report->cured_pixels), before = static_cast<double>(without->cured_pixels);
    EXPECT_NEAR(cured / before, 1,
                grey != Grey::kFull ? 0
                : has_supports      ? 0.03
                                    : 1e-3)
        << "grey pixels are those of the object";
    EXPECT_NE(report->hash, without->hash);
    const Decoded bottom = decode(layer_path(settings.output_path, 0));
    EXPECT_EQ(bottom.bit_depth, 1U);
    const std::uint32_t low = report->slice.placement.grid.layers / 4;
    const Decoded image = decode(layer_path(settings.output_path, low));
    EXPECT_EQ(image.bit_depth, 8U);
    EXPECT_EQ(image.colour, LCT_GREY);
    const std::span pixels(image.pixels.get(), std::size_t{image.columns} * image.rows);
    EXPECT_GT(std::ranges::count_if(pixels, is_grey), 100);
  }
}

TEST(SliceJob, WritesMasksWithoutAPrinterToo) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 40'000, kRadius);
  auto settings = sphere_job(folder);
  settings.slice.placement.printer.reset();
  settings.slice.placement.pixel_pitch_mm = 0.13F;
  settings.preview = false;
  const auto report = run(settings);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  expect_layers_of_stream(settings, *report);
  EXPECT_FALSE(std::filesystem::exists(settings.output_path + "/preview.png"));
}

/// Two balls, one above the other: the upper one touches nothing.
void write_hanging_scan(const std::string& path) {
  std::vector<ScanPoint> cloud = sphere_scan(20'000, 6);
  std::vector<ScanPoint> upper = sphere_scan(10'000, 4);
  for (ScanPoint& p : upper) p.z += 12;
  cloud.insert(cloud.end(), upper.begin(), upper.end());
  write_scan(path, cloud);
}

TEST(SliceJob, TellsWhatFallsWithoutSupportsAndDrawsIt) {
  const TemporaryFolder folder;
  write_hanging_scan(folder / "sphere.ply");
  auto settings = sphere_job(folder);
  settings.slice.keep_all = true;
  const auto report = run(settings);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  ASSERT_TRUE(report->findings);
  EXPECT_EQ(report->findings->voxels, report->cured_pixels);
  const IssueGroup& pieces = report->findings->of(IssueKind::kFreePiece);
  ASSERT_EQ(pieces.count, 1U);
  const double ball = 4.0 / 3 * 3.14159265358979 * 4 * 4 * 4;
  EXPECT_NEAR(static_cast<double>(pieces.voxels) * 1e-3, ball, 0.01 * ball);
  EXPECT_NEAR(report->findings->fallen_share(), 64.0 / (64 + 216), 0.005);
  EXPECT_TRUE(std::filesystem::exists(settings.output_path + "/issues.png"));
  EXPECT_TRUE(report->has_issue_picture);
  EXPECT_THAT(read_text(settings.output_path + "/manifest.json"), HasSubstr("\"free_piece\""));
  bool told = false;
  for (const auto& line : report->warnings.all()) told |= line.view().find("that nothing holds") != std::string::npos;
  EXPECT_TRUE(told);

  settings.slice.supports = SupportSettings{};
  settings.slice.placement.room = support_room(*settings.slice.supports);
  const auto supported = run(settings);
  ASSERT_TRUE(supported.has_value()) << supported.error().message();
  EXPECT_EQ(supported->findings->count(IssueKind::kFreePiece), 0U);
  EXPECT_EQ(supported->findings->count(IssueKind::kIsland), 0U);
  for (const Stage stage : {Stage::kSupports, Stage::kLayers}) expect_exact_plan(*supported, stage);
}

TEST(SliceJob, LeavesNothingOfAJobThatItsChecksRefuse) {
  const TemporaryFolder folder;
  write_hanging_scan(folder / "sphere.ply");
  auto settings = sphere_job(folder);
  settings.slice.keep_all = true;
  settings.checks.of(IssueKind::kFreePiece) = CheckAction::kRefuse;
  const auto refused = run(settings);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kBadSetting);
  EXPECT_THAT(refused.error().message(), HasSubstr("1 piece that nothing holds, 23 % of the print"));
  EXPECT_FALSE(std::filesystem::exists(settings.output_path));
}

TEST(SliceJob, CuresTheVolumeOfTheSphere) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 40'000, kRadius);
  const auto report = run(sphere_job(folder));
  ASSERT_TRUE(report.has_value()) << report.error().message();
  const double volume = 4.0 / 3 * 3.14159265358979 * kRadius * kRadius * kRadius;
  EXPECT_NEAR(report->volume_mm3(), volume, 0.005 * volume);
}

TEST(SliceJob, ReplacesAnOlderJobWithMoreLayers) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 20'000, kRadius);
  auto settings = sphere_job(folder);
  const auto first = run(settings);
  ASSERT_TRUE(first.has_value()) << first.error().message();
  settings.slice.placement.scale = 0.5;
  const auto second = run(settings);
  ASSERT_TRUE(second.has_value()) << second.error().message();
  const std::uint32_t layers = second->slice.placement.grid.layers;
  EXPECT_LT(layers, first->slice.placement.grid.layers);
  EXPECT_TRUE(std::filesystem::exists(layer_path(settings.output_path, layers - 1)));
  EXPECT_FALSE(std::filesystem::exists(layer_path(settings.output_path, layers)));
}

TEST(SliceJob, KeepsAnOlderJobIfTheScanCannotBeSliced) {
  const TemporaryFolder folder;
  write_sphere_scan(folder / "sphere.ply", 20'000, kRadius);
  auto settings = sphere_job(folder);
  ASSERT_TRUE(run(settings).has_value());
  const std::string manifest = read_text(settings.output_path + "/manifest.json");
  settings.slice.placement.scale = 10;
  const auto refused = run(settings);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code(), ErrorCode::kDoesNotFit);
  EXPECT_EQ(read_text(settings.output_path + "/manifest.json"), manifest);
}

TEST(SliceJob, LeavesNothingBehindIfTheScanIsBroken) {
  const TemporaryFolder folder;
  write_text(folder / "sphere.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n");
  const auto settings = sphere_job(folder);
  const auto broken = run(settings);
  ASSERT_FALSE(broken.has_value());
  EXPECT_THAT(broken.error().message(), HasSubstr("sphere.ply"));
  EXPECT_FALSE(std::filesystem::exists(settings.output_path));
}

TEST(JobWarnings, NameUnitsSizeThinningHolesAndNormals) {
  auto report = std::make_unique<JobReport>();
  report->slice.units_guessed = true;
  report->slice.units = Units::kMetres;
  report->slice.placement.size_mm = {700, 1, 1};
  report->slice.placement.scale = 1000;
  report->slice.lengths.thinning_cell = {0.2F};
  report->coverage = ConfidenceShares{.surface = {0.979, 0.01, 0.011}};
  report->slice.normals.estimated = 5;
  find_warnings(*report);
  const auto lines = report->warnings.all();
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_THAT(lines[0].c_str(),
              HasSubstr("the scan is 0.7 units long and says no unit; m, which make it 700 mm, are a guess"));
  EXPECT_THAT(lines[1].c_str(), HasSubstr("the object is 700 mm long"));
  EXPECT_THAT(lines[2].c_str(), HasSubstr("cells of 0.2 mm, coarser than the pixels of 0.05 mm"));
  EXPECT_THAT(lines[4].c_str(), HasSubstr("the underside (1.1 % of the surface) was not scanned and had to be closed"));
  EXPECT_THAT(lines[3].c_str(), HasSubstr("5 points of the scan have no usable normal"));
  for (const auto& line : lines) EXPECT_FALSE(line.cut()) << line.c_str();
}

TEST(JobWarnings, SayThatNoiseWasAveragedAndHowWideItIs) {
  auto report = std::make_unique<JobReport>();
  report->slice.placement.size_mm = {50, 50, 20};
  report->slice.averagings = 2;
  report->slice.lengths.averaged_noise = {1.4321F};
  report->slice.normals.estimated = 5;
  find_warnings(*report);
  const auto lines = report->warnings.all();
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0].c_str(), HasSubstr("too noisy to show a surface (about 1.4 mm), so neighbours were "
                                          "averaged, 2 times: finer details are lost"));
  EXPECT_FALSE(lines[0].cut()) << lines[0].c_str();
}

TEST(JobWarnings, SayThatAUnitWasIgnoredAndAdviseNoneForAnE57) {
  auto report = std::make_unique<JobReport>();
  report->slice.scan.header.is_in_mm = true;
  report->slice.ignored_units = Units::kCentimetres;
  report->slice.placement.size_mm = {4, 4, 4};
  report->slice.placement.scale = 1;
  find_warnings(*report);
  const auto lines = report->warnings.all();
  ASSERT_GE(lines.size(), 2U);
  EXPECT_THAT(lines[0].c_str(), HasSubstr("the unit cm was ignored: the file says its own (E57 in metres"));
  EXPECT_THAT(lines[1].c_str(), HasSubstr("only 4 mm long. If that is wrong, give a size: --height 80mm, or --scale."));
  for (const auto& line : lines) EXPECT_FALSE(line.cut()) << line.c_str();
}

TEST(JobWarnings, SayHowMuchIsRemovedAsNoise) {
  auto report = std::make_unique<JobReport>();
  report->slice.placement.size_mm = {30, 30, 1};
  report->slice.placement.grid.pitch_x_mm = report->slice.placement.grid.pitch_y_mm = 0.1F;
  report->slice.placement.grid.layer_height_mm = 0.1F;
  report->slice.components = {.dropped_solids = 366, .dropped_voxels = 120'000, .voxels = 400'000};
  report->slice.clustering.points[PointClass::kNoise] = 400;
  report->slice.clustering.points[PointClass::kExiting] = 600;
  find_warnings(*report);
  const auto lines = report->warnings.all();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0].c_str(), HasSubstr("small solids were removed (366, 0.12 ml, 30 % of what stays)"));
  EXPECT_THAT(lines[1].c_str(), HasSubstr("40 % of the points lie on no surface"));
  for (const auto& line : lines) EXPECT_FALSE(line.cut()) << line.c_str();
}

TEST(Unseen, IsReportedAsSharesOfTheWholeSurface) {
  EXPECT_STREQ(unseen_sentence({0.126, 0.041}).c_str(),
               "the underside (12.6 % of the surface) and 4.1 % elsewhere were not scanned");
  EXPECT_STREQ(unseen_sentence({0.126, 0.004}).c_str(), "the underside (12.6 % of the surface) was not scanned");
  EXPECT_STREQ(unseen_sentence({0, 0.041}).c_str(), "4.1 % of the surface was not scanned");
  EXPECT_STREQ(unseen_sentence({0.01, 0.01}).c_str(), "");
}

TEST(JobWarnings, SayThatAScanOfOneSideLiesOnItsFace) {
  const TemporaryFolder folder;
  std::vector<ScanPoint> below = sphere_scan(20'000, kRadius);
  std::erase_if(below, [](const ScanPoint& p) { return p.z > -1; });
  write_scan(folder / "sphere.ply", below);
  auto settings = sphere_job(folder);
  const auto warnings = [&] {
    std::string all;
    auto report = run(settings);
    EXPECT_TRUE(report.has_value());
    if (report) {
      for (const auto& line : report->warnings.all()) all += line.c_str() + std::string("\n");
    }
    return all;
  };
  EXPECT_THAT(warnings(), HasSubstr("--rotate-x 180"));
  settings.slice.placement.rotation_degrees = {180, 0, 0};
  EXPECT_THAT(warnings(), Not(HasSubstr("--rotate-x 180")));
}

TEST(JobWarnings, AreSilentAboutAnOrdinaryScan) {
  auto report = std::make_unique<JobReport>();
  report->slice.placement.size_mm = {40, 30, 60};
  report->coverage = ConfidenceShares{.surface = {0.98, 0.01, 0.01}};
  find_warnings(*report);
  EXPECT_TRUE(report->warnings.all().empty());
}

}  // namespace
}  // namespace plumbline::firmware
