#include "firmware/slice/slice_job.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "firmware/io/mask_hash.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/pictures/coverage_picture.hpp"
#include "firmware/pictures/issue_picture.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/pictures/preview/preview_page.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/slice/issue_report.hpp"
#include "firmware/slice/manifest.hpp"
#include "firmware/slice/proof_report.hpp"
#include "hal/units.hpp"
#include "slicer/checks/stack_checker.hpp"
#include "slicer/plan/memory_plan.hpp"
#include "slicer/support_building.hpp"
#include "slicer/supports/drawing/grey_masks.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"

namespace plumbline::firmware {
Expected<SliceJob> SliceJob::prepare(const SliceJobSettings& settings, Arena& arena) {
  auto scan = ScanFiles::open(settings.scan_paths);
  PLUMBLINE_TRY(scan);
  SliceJob job(settings, arena, std::move(*scan));
  if (settings.archive) {
    auto archive = JobArchive::open(settings.output_path);
    PLUMBLINE_TRY(archive);
    job.archive_.emplace(std::move(*archive));
  } else {
    auto directory = JobDirectory::open(settings.output_path);
    PLUMBLINE_TRY(directory);
    job.directory_.emplace(std::move(*directory));
  }
  if (const auto& printer = settings.slice.placement.printer) {
    const MaskDepth in_folder = settings.grey.is_known() ? MaskDepth::kNeeded : MaskDepth::kBit;
    auto masks =
        PngEncoder::for_masks(printer->columns, printer->rows, settings.archive ? MaskDepth::kByte : in_folder);
    PLUMBLINE_TRY(masks);
    job.masks_ = std::move(*masks);
  }
  if (settings.preview) {
    for (auto& encoder : std::span(job.pictures_).first(settings.archive ? 1 : kPages)) {
      auto made = PictureEncoder::create(kPageBytes);
      PLUMBLINE_TRY(made);
      encoder = std::move(*made);
    }
    if (!settings.archive) static_cast<void>(preview::page_faces());  // makes them
  }
  job.settings_.slice.confidence = true;
  start_threads(settings.slice.threads);
  job.report_.scan_name = job.scan_.title();
  job.report_.scan_names = job.scan_.names();
  job.report_.base = settings.slice.base;
  job.report_.sizes = corrections_of(settings.slice);
  job.report_.printer_name = settings.printer_name;
  job.report_.grey = settings.slice.grey;
  job.report_.checks = settings.checks;
  job.report_.draws_coverage = settings.preview && !settings.archive;
  job.report_.arena_bytes = arena.capacity();
  job.report_.threads = settings.slice.threads;
  return job;
}

Status SliceJob::run(JobProgress& progress) {
  const std::size_t bottom = arena_->bottom_mark();
  auto done = work(progress);
  report_.slice.confidence = {};  // its memory is released below
  arena_->release_bottom(bottom);
  if (!done && directory_) directory_->discard();
  if (!done) archive_.reset();
  return done;
}

Status SliceJob::work(JobProgress& progress) {
  auto rrep = slice(scan_.sources(), settings_.slice, *arena_, &progress, report_.slice);
  PLUMBLINE_TRY(rrep);
  PLUMBLINE_TRY(check_proof(report_.slice.proof, scan_.sources()));
  if (!masks_) {
    auto masks = PngEncoder::for_masks(rrep->grid.columns, rrep->grid.rows);
    PLUMBLINE_TRY(masks);
    masks_ = std::move(*masks);
  }
  if (directory_) PLUMBLINE_TRY(directory_->begin());
  report_.support_settings = settings_.slice.supports;
  const auto supports = add_supports(*rrep, settings_.slice, *arena_, &progress, report_.slice, report_.supports);
  PLUMBLINE_TRY(supports);
  plan_layers(*rrep, *supports);
  arena_->reset_peak();
  auto hashes = arena_->take_bottom<std::uint64_t>(rrep->grid.layers, "layers");
  PLUMBLINE_TRY(hashes);
  progress.begin(Stage::kLayers);
  auto written = write_layers(*rrep, *supports, *hashes, progress);
  report_.layers_peak_bytes = arena_->peak();
  progress.end(Stage::kLayers, arena_->peak());
  PLUMBLINE_TRY(written);
  if (!report_.slice.mesh) report_.coverage = report_.slice.confidence.shares();
  find_warnings(report_);
  report_.hash = job_hash(*hashes);
  if (archive_) PLUMBLINE_TRY(write_archive_end(*rrep, *supports));
  if (directory_ && settings_.preview) PLUMBLINE_TRY(write_pages(*rrep, *supports));
  report_.seconds = progress.seconds();
  report_.total_seconds = progress.total_seconds();
  return directory_ ? write_manifest_file(*hashes) : Status();
}

/// Plans the layers anew, since the R-Rep and the supports are known now.
void SliceJob::plan_layers(const RRep& rrep, const Supports& supports) {
  report_.slice.planned(Stage::kLayers) = arena_->used() + rrep.grid.layers * sizeof(std::uint64_t) +
                                          layers_stage_bytes(rrep.grid, supports.list.size(), settings_.slice.grey);
}

Status SliceJob::write_layers(const RRep& rrep, const Supports& supports, std::span<std::uint64_t> hashes,
                              JobProgress& progress) {
  const auto& object_pixels = report_.slice.object_pixels;
  auto stream = MaskStream::create(rrep, supports, *arena_, !object_pixels);
  PLUMBLINE_TRY(stream);
  std::optional<GreyMasks> grey;
  if (settings_.grey.is_known()) {
    const auto machine = machine_grid(rrep.grid, settings_.slice.placement.correction);
    const auto layer_height = Distance::millimetres(static_cast<double>(machine.layer_height_mm));  // as a print's plan
    auto made = GreyMasks::create(rrep, supports, settings_.grey, layer_height.millimetres(), *arena_);
    PLUMBLINE_TRY(made);
    grey.emplace(*made);
  }
  const ArenaScope scratch(*arena_);
  const auto limits = check_limits(settings_.slice.placement, settings_.slice.peel, settings_.slice.overcure_mm,
                                   rule_for(settings_.slice.supports));
  auto checker = StackChecker::create(rrep.grid, limits, *arena_);
  PLUMBLINE_TRY(checker);
  const std::uint32_t layers = rrep.grid.layers;
  ConstBitImage mask = stream->mask(0);
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    if (!progress.advance(Stage::kLayers, static_cast<double>(layer) / layers)) {
      return fail(ErrorCode::kCancelled, "stopped at layer %u of %u", layer, layers);
    }
    checker->take(mask);
    report_.support_pixels += stream->support_pixels();
    Status kept;
    checker->check_while([&] {
      if (grey) mask = grey->find(layer, *stream, mask);
      const auto greys = grey ? grey->greys() : std::span<const GreyRun>();
      hashes[layer] = mask_hash(mask, greys);
      const auto png = masks_->encode(mask, greys);
      kept = directory_ ? directory_->write_layer(layer, png) : archive_->write_layer(layer, png);
      if (layer + 1 < layers) mask = stream->mask(layer + 1);
    });
    PLUMBLINE_TRY(kept);
  }
  report_.findings = checker->finish();
  finish_findings(*report_.findings, supports, report_.supports, report_.slice);
  report_.cured_pixels = report_.findings->voxels;
  if (object_pixels) report_.support_pixels = report_.cured_pixels - *object_pixels;
  return judge(*report_.findings, rrep.grid, settings_.checks);
}

/// Thumbnails and settings: what follows the masks in an archive.
Status SliceJob::write_archive_end(const RRep& rrep, const Supports& supports) {
  if (settings_.preview) {
    for (const ThumbnailSize size : kThumbnailSizes) {
      const ArenaScope scope(*arena_);
      const auto rgb = draw_thumbnail(rrep, supports, size.columns, size.rows, *arena_);
      if (!rgb) {
        // The masks are complete without the picture.
        report_.warnings.add().add("no thumbnails: %s", rgb.error().message());
        break;
      }
      PLUMBLINE_TRY(archive_->write_thumbnail(size, pictures_[0]->encode(*rgb, size.columns, size.rows)));
    }
  }
  const ArchiveOutput& archive = *settings_.archive;
  const PrintGrid grid = machine_grid(rrep.grid, settings_.slice.placement.correction);
  return archive_->finish(
      {archive.board, archive.profile, grid, report_.volume_mm3() / 1000, archive.seconds ? archive.seconds(grid) : 0});
}

Status SliceJob::draw_preview_page(const RRep& rrep, const Supports& supports, std::span<std::uint8_t> rgb) {
  const SliceReport& s = report_.slice;
  const auto size = size_text(s.placement);
  FixedText<64> resin;
  resin.add("%.1f ml of resin", report_.volume_mm3() / 1000);
  FixedText<128> grid;
  grid.add("%u x %u pixels of %.4g x %.4g mm%s%s", rrep.grid.columns, rrep.grid.rows,
           static_cast<double>(rrep.grid.pitch_x_mm), static_cast<double>(rrep.grid.pitch_y_mm),
           report_.printer_name.empty() ? "" : ", printer ", report_.printer_name.c_str());
  const std::array<std::string_view, 2> captions = {resin.view(), grid.view()};
  return draw_preview(rrep, supports, {report_.scan_name, size.view(), captions}, *arena_, rgb);
}

/// Draws the pages one after another, with all threads, and compresses them side by side, each with one.
Status SliceJob::write_pages(const RRep& rrep, const Supports& supports) {
  const auto start = std::chrono::steady_clock::now();
  arena_->reset_peak();
  const ArenaScope scope(*arena_);
  struct Page {
    JobPicture picture;
    std::span<std::uint8_t> memory;
    std::span<const std::byte> file;
  };
  std::array<Page, kPages> pages;
  std::size_t count = 0;
  const auto add = [&](JobPicture picture, auto draw) {
    const auto memory = arena_->take_top<std::uint8_t>(kPageBytes, "preview");
    const Status drawn = memory ? draw(*memory) : tl::unexpected<Error>(memory.error());
    if (drawn) {
      pages[count++] = {picture, *memory, {}};
    } else {
      // The layers are complete without the picture.
      report_.warnings.add().add("no %s: %s", JobDirectory::name(picture), drawn.error().message());
    }
    return drawn.has_value();
  };
  report_.has_preview =
      add(JobPicture::kPreview, [&](std::span<std::uint8_t> rgb) { return draw_preview_page(rrep, supports, rgb); });
  if (report_.coverage) {
    report_.has_coverage = add(JobPicture::kCoverage, [&](std::span<std::uint8_t> rgb) {
      return draw_coverage(rrep, report_.slice.confidence, report_.scan_name, *arena_, rgb);
    });
  }
  if (ShownIssues(*report_.findings).count > 0) {
    report_.has_issue_picture = add(JobPicture::kIssues, [&](std::span<std::uint8_t> rgb) {
      return draw_issues(*report_.findings, rrep, supports, report_.scan_name, *arena_, rgb);
    });
  }
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t i = 0; i < count; ++i) {
    pages[i].file = pictures_[i]->encode(pages[i].memory, kPreviewColumns, kPreviewRows);
  }
  for (const Page& page : std::span(pages).first(count)) {
    PLUMBLINE_TRY(directory_->write_picture(page.picture, page.file));
  }
  report_.preview_peak_bytes = arena_->peak();
  report_.preview_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

Status SliceJob::write_manifest_file(std::span<const std::uint64_t> hashes) {
  auto file = directory_->create_manifest();
  PLUMBLINE_TRY(file);
  JsonWriter json(*file);
  write_manifest(json, report_, hashes);
  PLUMBLINE_TRY(json.finish());
  return directory_->finish(*file);
}

}  // namespace plumbline::firmware
