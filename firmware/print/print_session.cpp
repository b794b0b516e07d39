#include "firmware/print/print_session.hpp"

#include <utility>

#include "firmware/io/random_id.hpp"
#include "firmware/print/loop/print_job.hpp"
#include "firmware/slice/issue_report.hpp"

namespace plumbline::firmware {

PrintSession::PrintSession(const BoardFile& board, const MachineFile& machine, Arena& arena, JobStore* store,
                           LayerDecoder* decoder)
    : board_(board),
      machine_(machine),
      arena_(arena),
      bottom_(arena),
      top_(arena),
      store_(store),
      decoder_(decoder != nullptr ? decoder : &own_decoder_) {}

Status PrintSession::take(Printable what) {
  what_ = std::move(what);
  JobFacts& facts = what_.facts;
  if (facts.print_id == 0) facts.print_id = RandomIds().next();
  facts.printer = short_name(board_.name);
  facts.printer_hash = hash_of(board_);
  PLUMBLINE_TRY(make_ready());
  if (store_ == nullptr) return {};
  auto file = store_->begin(facts, what_.parts);
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
  what_.facts = job.facts;
  what_.parts = job.parts;
  what_.archive = std::move(stored->archive);
  journal_file_ = std::move(stored->journal);
  const auto journal = Journal::open(*journal_file_);
  PLUMBLINE_TRY(journal);
  if (journal->job_hash() != job.hash || journal->layers() != plan().layers) {
    return fail(ErrorCode::kMalformed, "the stored job and its journal are of different prints");
  }
  journal_ = *journal;
  resumed_ = true;
  PLUMBLINE_TRY(make_ready());
  const auto first = mask(0);
  PLUMBLINE_TRY(first);
  what_.first_layer_pixels = first->count();
  return {};
}

/// Checks the plan, and makes the masks' source and the room for the report.
Status PrintSession::make_ready() {
  const auto run = check_plan(plan(), view(what_.facts.scan), machine_);
  PLUMBLINE_TRY(run);
  run_ = *run;
  if (what_.parts.is_archive()) {
    auto layers = ArchiveMasks::create(what_.archive.get(), view(what_.facts.scan), grid(), what_.parts.archive,
                                       what_.facts.turn, *decoder_, machine_.panel.grey.has_grey(), arena_);
    PLUMBLINE_TRY(layers);
    source_ = std::move(*layers);
  } else {
    const auto stream = StreamMasks::create(what_.parts.rrep, what_.parts.supports, plan().grey,
                                            plan().layer_height.millimetres(), arena_, plan().steps);
    PLUMBLINE_TRY(stream);
    source_ = *stream;
  }
  const auto masks = MaskRenderer::create(source(), plan(), arena_);
  PLUMBLINE_TRY(masks);
  masks_ = *masks;
  const std::size_t exposures = most_exposures(plan()) + kSpareExposures;
  const auto lines = arena_.take_bottom<ExposureLine>(exposures, "report");
  PLUMBLINE_TRY(lines);
  lines_ = *lines;
  const auto scratch = arena_.take_bottom<nanoseconds>(exposures, "report");
  PLUMBLINE_TRY(scratch);
  scratch_ = *scratch;
  return {};
}

MaskSource& PrintSession::source() {
  if (auto* const layers = std::get_if<ArchiveMasks>(&source_)) return *layers;
  return std::get<StreamMasks>(source_);
}

double PrintSession::pixel_ml() const {
  return resin_ml(1, board_.pixel_pitch_x_mm, board_.pixel_pitch_y_mm, plan().layer_height.millimetres());
}

double PrintSession::first_layer_more_ml() const {
  return resin_ml(what_.first_layer_pixels, board_.pixel_pitch_x_mm, board_.pixel_pitch_y_mm,
                  plan().first_layer_more.millimetres());
}

double PrintSession::needed_ml() const {
  return static_cast<double>(what_.facts.cured_pixels) * pixel_ml() + first_layer_more_ml();
}

PrintSettings PrintSession::settings() const {
  PrintSettings settings;
  settings.plan = plan();
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
  settings.cured_pixels = what_.facts.cured_pixels;
  settings.first_layer_pixels = what_.first_layer_pixels;
  settings.cure_depth = contract().cure_depth;
  settings.first_cure_depth = contract().first_cure_depth;
  if (what_.findings) settings.issues = issue_counts(*what_.findings);
  settings.has_issues = what_.findings && what_.findings->any();
  settings.memory_needed = arena_.used();
  settings.memory_budget = arena_.capacity();
  return settings;
}

PrintReport PrintSession::print(Machine& machine, PrintObserver& observer, MachineRecord* record) {
  MachineRecord& machine_record = record != nullptr ? *record : unkept_;
  const JournalEntry from = journal_ ? journal_->last() : JournalEntry();
  const PrintReport report = run_print(machine, settings(), *masks_, journal_ ? &*journal_ : nullptr, machine_record,
                                       lines_, observer, resumed_ ? std::optional(from) : std::nullopt);
  lines_ = report.exposures;
  const bool refused = !report.begun && from == JournalEntry();
  const bool for_good = refused || report.state == PrintState::kFinished || report.state == PrintState::kCancelled;
  // The journal has what the record lacks, so it is removed last. If it can't be removed, the next start offers to resume a print whose
  // last layer is done.
  const auto kept = machine_record.keep();
  if (for_good && kept && store_ != nullptr) static_cast<void>(store_->end());
  return report;
}

}  // namespace plumbline::firmware
