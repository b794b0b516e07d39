#include "firmware/child/archive_task.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include "firmware/child/given_file.hpp"
#include "firmware/child/rights.hpp"
#include "firmware/child/scan_task.hpp"
#include "firmware/child/shared_progress.hpp"
#include "firmware/pictures/issue_picture.hpp"
#include "firmware/print/job/archive_glance.hpp"
#include "firmware/print/job/sliced_archive.hpp"
#include "firmware/settings/job_options.hpp"

namespace plumbline::firmware {
namespace {

/// Draws where the checks have found something. The layers shown, a dozen at most, are decoded again.
/// @param arena  an image is taken from its top and released, as is what draw_issues_picture() takes
Status draw_issues(const SlicedArchive& sliced, std::string_view name, Arena& arena, IssuesPicture& picture) {
  const ArenaScope scope(arena);
  const PrintGrid& grid = sliced.grid;
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), "masks");
  PLUMBLINE_TRY(words);
  const BitImage image(*words, grid.columns, grid.rows);
  const auto mask = [&](std::uint32_t layer) -> Expected<ConstBitImage> {
    PLUMBLINE_TRY(read_archive_layer(STDIN_FILENO, name, sliced.layers[layer], sliced.turn, image));
    return ConstBitImage(image);
  };
  return draw_issues_picture(sliced.findings, grid, mask, arena, picture);
}

Status check(SharedMemory& memory) {
  MessagePage& page = memory.page();
  ScanAnswer& answer = page.answer;
  Arena arena(memory.arena());
  SharedProgress progress(page.progress);
  const PlacementSettings& placement = page.request.settings.placement;
  const ArchiveTarget target{*placement.printer, static_cast<double>(placement.layer_height_mm),
                             page.request.settings.peel, page.request.archive.shows_grey};
  const auto sliced = check_archive(STDIN_FILENO, page.request.name.view(), target, arena, &progress);
  PLUMBLINE_TRY(sliced);
  answer.layers = sliced->grid.layers;
  answer.archive_at =
      static_cast<std::uint64_t>(reinterpret_cast<const std::byte*>(sliced->layers.data()) - memory.arena().data());
  answer.bottom_used = sliced->layers_end;
  answer.findings = sliced->findings;
  const MaskTurn& turn = sliced->turn;
  answer.turn = {turn.mirror_x ? 1U : 0U, turn.mirror_y ? 1U : 0U, turn.swaps ? 1U : 0U};
  answer.turned = sliced->turned ? 1 : 0;
  answer.grey = {sliced->grey.lit, sliced->grey.grey, sliced->grey.lost};
  const MaskExtent& extent = sliced->extent;
  answer.extent = {extent.left, extent.right, extent.top, extent.bottom};
  answer.layer_height_mm = static_cast<double>(sliced->grid.layer_height_mm);
  answer.values = pass(sliced->settings.values);
  answer.kind = ScanAnswer::kArchive;
  // If the arena has no room for them, the job has no pictures.
  if (!sliced->rrep.first.empty()) {
    static_cast<void>(draw_preview_picture(sliced->rrep, Supports{}, arena, page.pictures.preview));
    static_cast<void>(make_part_model(sliced->rrep, Supports{}, ConfidenceMap(), arena, page.pictures.part));
  }
  arena.release_bottom(sliced->layers_end);  // the R-Rep's room
  static_cast<void>(draw_issues(*sliced, page.request.name.view(), arena, page.pictures.issues));
  return {};
}

Status decode(SharedMemory& memory) {
  MessagePage& page = memory.page();
  const ScanRequest& request = page.request;
  const PrinterVolume& printer = *request.settings.placement.printer;
  const auto words = BitImage::words_needed(printer.columns, printer.rows);
  auto* const mask = reinterpret_cast<std::uint64_t*>(memory.arena().data() + request.archive.mask_at);
  GreyRuns greys;
  if (request.archive.shows_grey) {
    const std::size_t runs = GreyRuns::runs_needed(printer.columns, printer.rows);
    greys = GreyRuns({reinterpret_cast<GreyRun*>(mask + words), runs}, printer.columns);
  }
  PLUMBLINE_TRY(read_archive_layer(STDIN_FILENO, request.name.view(), request.archive.layer, request.archive.turn,
                                   BitImage({mask, words}, printer.columns, printer.rows), &greys));
  page.answer.greys = greys.runs().size();
  page.answer.kind = ScanAnswer::kLayer;
  return {};
}

/// Opens an archive where it is, or, if it comes through a pipe, when all of it is in the arena.
Expected<LayerArchive> open_given(const ScanRequest& request, Arena& arena) {
  const auto name = request.name.view();
  if (::lseek(STDIN_FILENO, 0, SEEK_CUR) >= 0) return LayerArchive::open(STDIN_FILENO, name);
  GivenFile file(STDIN_FILENO, request.file[0]);
  const auto room = arena.take_top<std::byte>(static_cast<std::size_t>(file.size().value_or(0)), "archive");
  PLUMBLINE_TRY(room);
  std::size_t filled = 0;
  while (filled < room->size()) {
    const auto got = file.read(room->subspan(filled));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  return LayerArchive::open(std::span<const std::byte>(room->first(filled)), name);
}

Status glance_at_archive(SharedMemory& memory) {
  MessagePage& page = memory.page();
  Arena arena(memory.arena());
  auto archive = open_given(page.request, arena);
  PLUMBLINE_TRY(archive);
  PLUMBLINE_TRY(draw_archive_picture(*archive, *page.request.settings.placement.printer, arena, page.glance));
  page.answer.kind = ScanAnswer::kGlance;
  return {};
}

}  // namespace

void run_archive_task(SharedMemory& memory, std::uint32_t threads) {
  MessagePage& page = memory.page();
  const ArchiveRequest& request = page.request.archive;
  const bool one = request.ask == ArchiveRequest::Ask::kLayer;
  const bool looks = request.ask == ArchiveRequest::Ask::kGlance;
  if (!one) start_threads(threads);
  // The firmware is printing from the arena.
  if (one && ::mprotect(memory.arena().data(), static_cast<std::size_t>(request.mask_at), PROT_READ) != 0) {
    return refuse_without_filter(page.answer);
  }
  if (!filter_system_calls()) return refuse_without_filter(page.answer);
  const Status done = one ? decode(memory) : looks ? glance_at_archive(memory) : check(memory);
  if (!done) hand_back_error(done.error(), page.answer);
}

}  // namespace plumbline::firmware
