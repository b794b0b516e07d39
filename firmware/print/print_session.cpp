#include "firmware/print/print_session.hpp"

#include <utility>

#include "firmware/io/random_id.hpp"
#include "firmware/print/sliced_contract.hpp"
#include "firmware/slice/issue_report.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline {

PrintSession::PrintSession(const BoardFile& board, const MachineFile& machine, Arena& arena, JobStore* store,
                           LayerDecoder* decoder)
    : board_(board),
      machine_(machine),
      arena_(arena),
      store_(store),
      bottom_(arena.bottom_mark()),
      top_(arena.top_mark()),
      decoder_(decoder != nullptr ? decoder : &own_decoder_) {}

PrintSession::~PrintSession() {
  arena_.release_bottom(bottom_);
  arena_.release_top(top_);
}

Status PrintSession::slice_scan(ScanSources scan, const SliceSettings& settings,
                                const std::optional<SupportSettings>& supports, const PrintProfile& profile,
                                ProgressSink* progress, Acceptance accept) {
  const auto layer_height = static_cast<double>(settings.placement.layer_height_mm);
  // Checks that don't depend on the height run before slicing, which may take minutes.
  PLUMBLINE_TRY(plan_print(profile, machine_, layer_height, 1));
  const auto sliced = slice_for_print(scan, settings, supports, arena_, progress, slice_report_);
  PLUMBLINE_TRY(sliced);
  PLUMBLINE_TRY(judge(sliced->findings, sliced->rrep.grid, profile.checks));
  support_settings_ = supports;
  for (const ByteSource* const file : scan) add_scan_file(file->name());
  const auto contract = contract_of(*sliced, settings, profile, machine_);
  PLUMBLINE_TRY(contract);
  PLUMBLINE_TRY(accept(*contract));
  return take(*sliced, title_of(scan).c_str(), profile.name, *contract);
}

void PrintSession::add_scan_file(std::string_view name) {
  facts_.files[facts_.file_count++] = file_name(PrintableText(name, 79).view());
}

Status PrintSession::take(const SlicedScan& sliced, std::string_view scan, std::string_view profile,
                          const Contract& contract) {
  parts_ = {sliced.rrep, sliced.supports, {}};
  support_counts_ = sliced.support_counts;
  support_pixels_ = sliced.support_pixels;
  facts_.scan_hash = sliced.scan_hash;
  return begin(scan, profile, contract, sliced.findings);
}

Status PrintSession::take(const SlicedArchive& sliced, std::string_view name, std::string_view profile,
                          const Contract& contract, Descriptor archive, std::uint64_t hash) {
  parts_ = {{.grid = sliced.grid, .first = {}, .pixel = {}, .is_exact = true}, {}, sliced.layers};
  facts_.turn = sliced.turn;
  facts_.scan_hash = hash;
  archive_ = std::move(archive);
  return begin(name, profile, contract, sliced.findings);
}

/// Makes the print of parts_ ready, and stores it.
Status PrintSession::begin(std::string_view scan, std::string_view profile, const Contract& contract,
                           const StackFindings& findings) {
  findings_ = findings;
  first_layer_pixels_ = findings.first_layer_pixels;
  facts_.cured_pixels = findings.voxels;
  if (facts_.print_id == 0) facts_.print_id = RandomIds().next();
  facts_.scan = short_name(PrintableText(scan, facts_.scan.size()).view());
  facts_.printer = short_name(board_.name);
  facts_.profile = short_name(profile);
  facts_.printer_hash = hash_of(board_);
  facts_.contract = contract;
  PLUMBLINE_TRY(make_ready());
  if (store_ == nullptr) return {};
  auto file = store_->begin(facts_, parts_);
  PLUMBLINE_TRY(file);
  journal_file_ = std::move(*file);
  const auto journal = Journal::open(*journal_file_);
  PLUMBLINE_TRY(journal);
  journal_ = *journal;
  return {};
}

Status PrintSession::load() {
  auto stored = store_->load(arena_);
  PLUMBLINE_TRY(stored);
  const StoredJob& job = stored->job;
  if (job.facts.printer_hash != hash_of(board_)) {
    const auto printer = view(job.facts.printer);
    return fail(ErrorCode::kUnsupported,
                "the interrupted print was made for printer %.*s, whose board file was another then",
                static_cast<int>(printer.size()), printer.data());
  }
  facts_ = job.facts;
  parts_ = job.parts;
  archive_ = std::move(stored->archive);
  journal_file_ = std::move(stored->journal);
  const auto journal = Journal::open(*journal_file_);
  PLUMBLINE_TRY(journal);
  if (journal->job_hash() != job.hash || journal->layers() != grid().layers) {
    return fail(ErrorCode::kMalformed, "the stored job and its journal are of different prints");
  }
  journal_ = *journal;
  resumed_ = true;
  PLUMBLINE_TRY(make_ready());
  const auto first = source_->mask(0);
  PLUMBLINE_TRY(first);
  first_layer_pixels_ = first->count();
  return {};
}

Status PrintSession::make_source() {
  if (parts_.is_archive()) {
    auto masks =
        ArchiveMasks::create(archive_.get(), view(facts_.scan), grid(), parts_.archive, facts_.turn, *decoder_, arena_);
    PLUMBLINE_TRY(masks);
    archive_masks_.emplace(std::move(*masks));
    source_ = &*archive_masks_;
    return {};
  }
  const auto stream = MaskStream::create(parts_.rrep, parts_.supports, arena_);
  PLUMBLINE_TRY(stream);
  stream_masks_.emplace(*stream);
  source_ = &*stream_masks_;
  return {};
}

/// Checks the plan, and makes the masks' source and the room for the report, after slicing or loading.
Status PrintSession::make_ready() {
  const auto run = check_plan(facts_.contract.plan, view(facts_.scan), machine_);
  PLUMBLINE_TRY(run);
  run_ = *run;
  PLUMBLINE_TRY(make_source());
  auto masks = MaskRenderer::create(*source_, facts_.contract.plan, arena_);
  PLUMBLINE_TRY(masks);
  masks_ = *masks;
  const std::size_t exposures = std::size_t{grid().layers} + kSpareExposures;
  const auto lines = arena_.take_bottom<ExposureLine>(exposures, "report");
  PLUMBLINE_TRY(lines);
  lines_ = *lines;
  const auto scratch = arena_.take_bottom<nanoseconds>(exposures, "report");
  PLUMBLINE_TRY(scratch);
  scratch_ = *scratch;
  return {};
}

double PrintSession::pixel_ml() const {
  return resin_ml(1, board_.pixel_pitch_x_mm, board_.pixel_pitch_y_mm, facts_.contract.plan.layer_height.millimetres());
}

double PrintSession::first_layer_more_ml() const {
  const double more = facts_.contract.plan.first_layer_more.millimetres();
  return resin_ml(first_layer_pixels_, board_.pixel_pitch_x_mm, board_.pixel_pitch_y_mm, more);
}

double PrintSession::needed_ml() const {
  return static_cast<double>(facts_.cured_pixels) * pixel_ml() + first_layer_more_ml();
}

MaskFigures PrintSession::mask_figures() const { return plumbline::mask_figures(exposures_, scratch_); }

PrintReport PrintSession::print(Machine& machine, PrintObserver& observer, MachineRecord* record) {
  MachineRecord& machine_record = record != nullptr ? *record : unkept_;
  PrintSettings settings;
  settings.plan = facts_.contract.plan;
  settings.run = run_;
  settings.lamp_resume = Celsius(machine_.lamp_resume_c);
  settings.lamp_max = Celsius(machine_.lamp_max_c);
  settings.resin_min = Celsius(machine_.resin_min_c);
  settings.resin_max = Celsius(machine_.resin_max_c);
  settings.board_max = Celsius(machine_.board_max_c);
  settings.has_cover_switch = machine_.has_cover_switch;
  settings.tank_ml = machine_.tank_volume_ml;
  settings.pixel_ml = pixel_ml();
  settings.first_layer_more_ml = first_layer_more_ml();
  settings.cured_pixels = facts_.cured_pixels;
  settings.first_layer_pixels = first_layer_pixels_;
  settings.cure_depth = facts_.contract.cure_depth;
  settings.first_cure_depth = facts_.contract.first_cure_depth;
  if (findings_) settings.issues = issue_counts(*findings_);
  settings.has_issues = findings_ && findings_->any();
  settings.memory_needed = arena_.used();
  settings.memory_budget = arena_.capacity();
  const JournalEntry from = journal_ ? journal_->last() : JournalEntry();
  const PrintReport report = run_print(machine, settings, *masks_, journal_ ? &*journal_ : nullptr, machine_record,
                                       lines_, observer, resumed_ ? std::optional(from) : std::nullopt);
  exposures_ = report.exposures;
  const bool refused = !report.begun && from == JournalEntry();
  const bool for_good = refused || report.state == PrintState::kFinished || report.state == PrintState::kCancelled;
  // The journal has what the record lacks, so it is removed last. If it can't be removed, the next start offers to resume a print whose
  // last layer is done.
  const auto kept = machine_record.keep();
  if (for_good && kept && store_ != nullptr) static_cast<void>(store_->end());
  return report;
}

}  // namespace plumbline
