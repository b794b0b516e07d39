#include "firmware/cli/reports/printed_part.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

#include "firmware/io/mask_hash.hpp"
#include "firmware/pictures/deviation_picture.hpp"
#include "firmware/pictures/issue_picture.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/pictures/preview/preview.hpp"
#include "firmware/slice/job_report.hpp"
#include "firmware/slice/manifest.hpp"

namespace plumbline::firmware {
namespace {

/// The cured part as an R-Rep: the pixels that differ from the layer below.
struct PartRRep {
  std::vector<std::uint32_t> first{0};
  std::vector<std::uint32_t> packed;
  std::vector<std::uint64_t> below;

  void add(ConstBitImage layer) {
    below.resize(layer.words().size());
    const CrossingPacking packing({.columns = layer.columns(), .rows = layer.rows()});
    for (std::uint32_t r = 0; r < layer.rows(); ++r) {
      const auto words = layer.row(r);
      const auto row_below = std::span(below).subspan(std::size_t{r} * layer.stride(), words.size());
      if (std::ranges::equal(words, row_below)) continue;
      for (std::size_t w = 0; w < words.size(); ++w) {
        std::uint64_t& before = row_below[w];
        for (std::uint64_t changed = words[w] ^ before; changed != 0; changed &= changed - 1) {
          const auto column =
              static_cast<std::uint32_t>(w * 64) + static_cast<std::uint32_t>(std::countr_zero(changed));
          packed.push_back(packing.packed(r * layer.columns() + column));
        }
        before = words[w];
      }
    }
    first.push_back(static_cast<std::uint32_t>(packed.size()));
  }
};

/// Writes the picture of the issues that the masks had, if there are any and the arena has room for it.
Status write_issue_picture(JobDirectory& directory, const PrintSession& session, const RRep& sliced,
                           std::string_view name, Arena& arena, PictureEncoder& encoder) {
  const auto& findings = session.printable().findings;
  if (!findings || ShownIssues(*findings).count == 0) return {};
  const auto png = encode_page(arena, encoder, [&](std::span<std::uint8_t> rgb) {
    return draw_issues(*findings, sliced, session.printable().parts.supports, name, arena, rgb);
  });
  return png ? directory.write_picture(JobPicture::kIssues, *png) : Status();
}

/// Writes the preview of the cured part, and a comparison that shows what was to be printed to its left, its deviation to its right.
Status write_pictures(JobDirectory& directory, PrintSession& session, const RRep& part, const JobReport& job,
                      const MeasuredSurface* measured, Arena& arena) {
  const std::uint32_t columns = (measured != nullptr ? 3 : 2) * kPreviewColumns;
  const std::size_t bytes = picture_bytes(columns, kPreviewRows);
  auto encoder = PictureEncoder::create(bytes);
  PLUMBLINE_TRY(encoder);
  std::vector<std::uint8_t> sliced(kPageBytes);
  std::vector<std::uint8_t> printed(kPageBytes);
  std::vector<std::uint8_t> deviation(measured != nullptr ? kPageBytes : 0);
  FixedText<128> caption;
  const LayerSteps& steps = session.plan().steps;
  caption.add("printed: %u of %u layers, %.1f ml", steps.layers(part.grid.layers), session.plan().layers,
              static_cast<double>(job.cured_pixels) * session.pixel_ml());
  const std::array<std::string_view, 1> printed_captions = {caption.view()};
  const std::array<std::string_view, 1> sliced_captions = {"to be printed"};
  // A print resumed from its store has no placement.
  const Placement& placement = session.printable().slice.placement;
  FixedText<160> size;
  if (!steps.all_one()) {
    size = size_line(session.contract());
  } else if (placement.grid.layers > 0) {
    size.add("%s", size_text(placement).c_str());
  }
  PartRRep masks;
  RRep rrep = session.printable().parts.rrep;
  if (session.printable().parts.is_archive()) {
    for (std::uint32_t layer = 0; layer < session.plan().layers; ++layer) {
      const auto mask = session.mask(layer);
      PLUMBLINE_TRY(mask);
      masks.add(*mask);
    }
    rrep.first = masks.first;
    rrep.packed = masks.packed;
  }
  PLUMBLINE_TRY(draw_preview(rrep, session.printable().parts.supports, {job.scan_name, size.view(), sliced_captions},
                             arena, std::span(sliced)));
  // The layers already include the cured supports.
  PLUMBLINE_TRY(draw_preview(part, Supports{}, {job.scan_name, {}, printed_captions}, arena, printed));
  if (measured != nullptr) {
    FixedText<128> from;
    from.add("deviation from %s: blue too little, red too much", measured->name.c_str());
    const std::array<std::string_view, 1> captions = {from.view()};
    PLUMBLINE_TRY(draw_deviation(rrep, session.printable().parts.supports, {job.scan_name, {}, captions},
                                 measured->points, measured->deviations_mm, arena, deviation));
  }
  std::vector<std::uint8_t> all;
  all.reserve(bytes);
  constexpr auto kRow = static_cast<std::ptrdiff_t>(3 * kPreviewColumns);
  for (std::ptrdiff_t row = 0; row < std::ptrdiff_t{kPreviewRows}; ++row) {
    for (const auto* picture : {&sliced, &printed, &deviation}) {
      if (picture->empty()) continue;
      all.insert(all.end(), picture->begin() + row * kRow, picture->begin() + (row + 1) * kRow);
    }
  }
  all.resize(bytes);
  PLUMBLINE_TRY(directory.write_picture(JobPicture::kPreview, encoder->encode(printed, kPreviewColumns, kPreviewRows)));
  PLUMBLINE_TRY(directory.write_picture(JobPicture::kComparison, encoder->encode(all, columns, kPreviewRows)));
  return write_issue_picture(directory, session, rrep, job.scan_name, arena, *encoder);
}

}  // namespace

Status check_room_for_part(const JobDirectory& directory, PrintSession& session) {
  const PrintGrid& grid = session.grid();
  auto encoder = PngEncoder::for_masks(grid.columns, grid.rows);
  PLUMBLINE_TRY(encoder);
  // Neighbouring masks are alike, so these are enough for the mean size of a file.
  constexpr std::uint32_t kMostSamples = 64;
  const std::uint32_t all = session.plan().layers, samples = std::min(all, kMostSamples);
  constexpr std::uint64_t kBlock = 4096;  // file systems give whole ones
  std::uint64_t sampled = 0;
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    const auto layer = static_cast<std::uint32_t>(std::uint64_t{sample} * all / samples);
    const auto mask = session.mask(layer);
    PLUMBLINE_TRY(mask);
    sampled += (encoder->encode(*mask).size() + kBlock - 1) / kBlock * kBlock;
  }
  constexpr std::uint64_t kPicturesAndManifest = 2'000'000;
  const std::uint64_t layers = samples > 0 ? sampled * all / samples : 0;
  return directory.check_room("the printed part", layers + kPicturesAndManifest);
}

Status write_printed_part(JobDirectory& directory, const Witness& witness, PrintSession& session,
                          const MeasuredSurface* measured, Arena& arena) {
  PLUMBLINE_TRY(directory.begin());
  const PrintGrid& grid = session.grid();
  auto masks = PngEncoder::for_masks(grid.columns, grid.rows);
  PLUMBLINE_TRY(masks);
  JobReport job;
  PartRRep part;
  std::vector<std::uint64_t> hashes;
  Status done;
  const LayerSteps& steps = session.plan().steps;
  witness.for_each_cured_layer([&](ZPosition z, ConstBitImage cured) {
    if (!done) return;
    // A height that got no light becomes a black layer, so that those above keep their numbers.
    const std::int64_t height = session.plan().layer_height.nanometres();
    const auto top = static_cast<std::size_t>((z.above_film().nanometres() + height / 2) / height);
    const std::size_t first = top > 0 ? steps.of(steps.layer_at(static_cast<std::uint32_t>(top - 1))).first : 0;
    const std::size_t at = std::min<std::size_t>(top, grid.layers);
    const std::vector<std::uint64_t> black(cured.words().size());
    while (done && hashes.size() < std::max<std::size_t>(at, 1)) {
      const bool is_it = hashes.size() >= first;
      const ConstBitImage layer = is_it ? cured : ConstBitImage(black, cured.columns(), cured.rows());
      part.add(layer);
      job.cured_pixels += layer.count();
      done = directory.write_layer(static_cast<std::uint32_t>(hashes.size()), masks->encode(layer));
      hashes.push_back(mask_hash(layer));
    }
  });
  PLUMBLINE_TRY(done);
  job.scan_name = view(session.printable().facts.scan);
  job.printer_name = view(session.printable().facts.printer);
  job.slice = session.printable().slice;
  job.support_settings = session.printable().support_settings;
  job.supports = session.printable().support_counts;
  job.support_pixels = session.printable().support_pixels;
  job.findings = session.printable().findings;
  job.arena_bytes = arena.capacity();
  job.hash = job_hash(hashes);
  if (!hashes.empty()) {
    PrintGrid printed = grid;
    printed.layers = static_cast<std::uint32_t>(hashes.size());
    PLUMBLINE_TRY(write_pictures(directory, session, {.grid = printed, .first = part.first, .packed = part.packed}, job,
                                 measured, arena));
    job.has_preview = true;
  }
  if (session.printable().slice.placement.grid.layers != hashes.size()) return {};
  auto manifest = directory.create_manifest();
  PLUMBLINE_TRY(manifest);
  JsonWriter json(*manifest);
  write_manifest(json, job, hashes);
  PLUMBLINE_TRY(json.finish());
  return directory.finish(*manifest);
}

}  // namespace plumbline::firmware
