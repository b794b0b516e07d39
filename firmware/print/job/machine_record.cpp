#include "firmware/print/job/machine_record.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "firmware/io/hash64.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kMachine = "machine";
constexpr const char* kNewMachine = "machine.new";
constexpr const char* kPlateWord = "plate-is-empty";
constexpr const char* kTankWord = "tank-is-full";

constexpr std::uint32_t kMachineMagic = 0x314D4C50;  // "PLM1"
constexpr std::uint32_t kAnyVersion = 0x00FF'FFFF;   // of the magic: "PLM"
constexpr std::size_t kMachinePage = 4096;           // so that a write to one copy never touches the other
constexpr std::size_t kMachineBytes = 2 * kMachinePage;
constexpr std::int32_t kNeverRead = std::numeric_limits<std::int32_t>::min();

constexpr double kMillidegrees = 1000;

}  // namespace

MachineRecord::Facts MachineRecord::fresh() {
  Facts facts;
  facts.magic = kMachineMagic;
  facts.bytes = sizeof facts;
  facts.hottest_mc.fill(kNeverRead);
  return facts;
}

std::uint64_t MachineRecord::hash_of(const Facts& facts) {
  static_assert(std::is_trivially_copyable_v<Facts> && sizeof(Facts) <= kMachinePage);
  static_assert(sizeof(Facts) == 112 + kMostFaults * sizeof(KeptFault) + 8 && sizeof(KeptFault) == 160, "padding");
  Hash64 hash;
  hash.add(std::as_bytes(std::span(&facts, 1)).first(sizeof facts - sizeof facts.hash));
  return hash.value();
}

MachineRecord::MachineRecord(double tank_ml) : tank_ml_(tank_ml) {
  facts_.tank_is_known = 1;
  facts_.filled_ml = tank_ml;
}

tl::unexpected<Error> MachineRecord::cannot_write(const char* name) const {
  const int reason = errno;
  return fail(ErrorCode::kCannotWrite, "%s/%s: %s", path_.c_str(), name, std::strerror(reason));
}

Expected<MachineRecord> MachineRecord::open(const std::string& folder, double tank_ml) {
  MachineRecord record(tank_ml);
  record.facts_ = fresh();
  record.path_.add("%s", folder.c_str());
  record.folder_ = Descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!record.folder_.is_open()) return fail(ErrorCode::kCannotOpen, "%s: %s", folder.c_str(), std::strerror(errno));
  Descriptor file(::openat(record.folder_.get(), kMachine, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file.is_open()) {
    struct stat facts {};
    const bool is_file = ::fstat(file.get(), &facts) == 0 && S_ISREG(facts.st_mode);
    if (!is_file) return fail(ErrorCode::kCannotOpen, "%s/%s: is not a file", folder.c_str(), kMachine);
    record.file_.emplace(std::move(file), kMachineBytes, "the machine's record");
    PLUMBLINE_TRY(record.read_copies(static_cast<std::size_t>(facts.st_size)));
  } else if (errno == ENOENT) {
    PLUMBLINE_TRY(record.create());
  } else {
    return fail(ErrorCode::kCannotOpen, "%s/%s: %s", folder.c_str(), kMachine, std::strerror(errno));
  }
  PLUMBLINE_TRY(record.take_words());
  return record;
}

/// Takes the newer copy; what neither has is lost.
/// @param bytes  of the file: one that is cut off has lost a copy
Status MachineRecord::read_copies(std::size_t bytes) {
  std::size_t whole = 0;
  bool is_other = false, is_alike = true;
  for (std::size_t copy = 0; copy < 2; ++copy) {
    Facts here;
    if (bytes < copy * kMachinePage + sizeof here) continue;
    PLUMBLINE_TRY(file_->read(copy * kMachinePage, std::as_writable_bytes(std::span(&here, 1))));
    is_other = is_other || ((here.magic & kAnyVersion) == (kMachineMagic & kAnyVersion) && here.magic != kMachineMagic);
    if (here.magic != kMachineMagic || here.bytes != sizeof here || here.hash != hash_of(here)) continue;
    is_alike = here.number == facts_.number;
    if (whole++ == 0 || here.number > facts_.number) facts_ = here;
  }
  if (whole == 0 && is_other) {
    return fail(ErrorCode::kUnsupported,
                "%s/%s: another version of plumbline wrote it.\tUse that version, or remove the file: then the plate "
                "counts as in use, and the resin as unknown",
                path_.c_str(), kMachine);
  }
  was_damaged_ = whole == 0;
  return whole == 2 && is_alike ? Status() : keep();
}

Status MachineRecord::create() {
  Descriptor file(::openat(folder_.get(), kNewMachine, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode));
  if (!file.is_open()) return cannot_write(kNewMachine);
  file_.emplace(std::move(file), kMachineBytes, "the machine's record");
  PLUMBLINE_TRY(write(*file_));
  if (::renameat(folder_.get(), kNewMachine, folder_.get(), kMachine) != 0) return cannot_write(kNewMachine);
  return ::fsync(folder_.get()) == 0 ? Status() : Status(cannot_write("."));
}

/// What somebody has said by a file. It is removed when the record has it, so it counts once.
Status MachineRecord::take_words() {
  const auto said = [this](const char* name) {
    struct stat facts {};
    return ::fstatat(folder_.get(), name, &facts, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(facts.st_mode);
  };
  const bool plate = said(kPlateWord), tank = said(kTankWord);
  if (!plate && !tank) return {};
  if (plate) PLUMBLINE_TRY(confirm_empty());
  if (tank) PLUMBLINE_TRY(fill(tank_ml_));
  for (const char* name : {kPlateWord, kTankWord}) {
    if (::unlinkat(folder_.get(), name, 0) != 0 && errno != ENOENT) return cannot_write(name);
  }
  return ::fsync(folder_.get()) == 0 ? Status() : Status(cannot_write("."));
}

Status MachineRecord::keep() { return file_ ? write(*file_) : Status(); }

Status MachineRecord::write(JournalFile& file) {
  ++facts_.number;
  facts_.hash = hash_of(facts_);
  const auto bytes = std::as_bytes(std::span(&facts_, 1));
  for (std::size_t copy = 0; copy < 2; ++copy) {
    PLUMBLINE_TRY(file.write(copy * kMachinePage, bytes));
    PLUMBLINE_TRY(file.sync());
    // Worn-out cards take writes and drop them.
    Facts kept;
    PLUMBLINE_TRY(file.read(copy * kMachinePage, std::as_writable_bytes(std::span(&kept, 1))));
    if (std::memcmp(&kept, &facts_, sizeof kept) != 0) {
      return fail(ErrorCode::kCannotWrite,
                  "the machine's record can't be written: the storage did not keep what it was given.\tReplace the "
                  "storage");
    }
  }
  return {};
}

Status MachineRecord::confirm_empty() {
  facts_.plate_is_empty = 1;
  auto kept = keep();
  if (!kept) facts_.plate_is_empty = 0;
  return kept;
}

Status MachineRecord::take_plate() {
  if (!plate_is_empty()) return {};
  facts_.plate_is_empty = 0;
  return keep();
}

std::optional<double> MachineRecord::resin_ml() const {
  if (facts_.tank_is_known == 0) return std::nullopt;
  return std::max(0.0, facts_.filled_ml - facts_.used_ml);
}

Status MachineRecord::fill(double ml) {
  facts_.tank_is_known = 1;
  facts_.filled_ml = std::clamp(ml, 0.0, tank_ml_);
  facts_.used_ml = 0;
  ++fills_;
  return keep();
}

Status MachineRecord::begin_print(std::uint64_t job_hash, const ResinScale& scale) {
  facts_.plate_is_empty = 0;
  if (facts_.job_hash != job_hash || job_hash == 0) {
    facts_.job_hash = job_hash;
    facts_.scale = scale;
    facts_.pixels = 0;
    facts_.layers = facts_.print_lamp_ms = 0;
  }
  return keep();
}

double MachineRecord::used_ml(std::uint64_t pixels) const {
  return pixels == 0 ? 0 : static_cast<double>(pixels) * facts_.scale.pixel_ml + facts_.scale.first_layer_more_ml;
}

void MachineRecord::note(const PrintUse& use) {
  if (use.pixels > facts_.pixels) {
    facts_.used_ml += used_ml(use.pixels) - used_ml(facts_.pixels);
    facts_.pixels = use.pixels;
  }
  if (use.layers > facts_.layers) {
    facts_.film_layers += use.layers - facts_.layers;
    facts_.layers = use.layers;
  }
  const auto lamp = static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(use.lamp).count());
  if (lamp > facts_.print_lamp_ms) {
    facts_.lamp_ms += lamp - facts_.print_lamp_ms;
    facts_.print_lamp_ms = lamp;
  }
}

Status MachineRecord::add_interrupted(const JobStore& store) {
  if (!store.has_job()) return {};
  const auto journal = store.progress();
  const bool is_new = !journal && journal.error().code() == ErrorCode::kTruncated;
  if (is_new || (journal && journal->last == JournalEntry())) return {};  // nothing was lit
  if (!journal || journal->job_hash != facts_.job_hash) {
    if (facts_.tank_is_known == 0) return {};
    facts_.tank_is_known = 0;
    return keep();
  }
  const JournalEntry& last = journal->last;
  // The layer at hand may have been cured.
  note({.pixels = last.cured_pixels + last.at_hand_pixels, .layers = last.next_layer, .lamp = last.lamp});
  return keep();
}

void MachineRecord::felt(TemperatureSite site, Celsius temperature) {
  feels(site, temperature);
  std::int32_t& hottest = facts_.hottest_mc[static_cast<std::size_t>(site)];
  hottest = std::max(hottest, static_cast<std::int32_t>(std::lround(temperature.value() * kMillidegrees)));
}

std::optional<Celsius> MachineRecord::hottest(TemperatureSite site) const {
  const std::int32_t hottest = facts_.hottest_mc[static_cast<std::size_t>(site)];
  if (hottest == kNeverRead) return std::nullopt;
  return Celsius(hottest / kMillidegrees);
}

Status MachineRecord::add_fault(FaultCode code, std::string_view finding) {
  if (facts_.fault_count == kMostFaults) {
    std::shift_left(facts_.faults.begin(), facts_.faults.end(), 1);
    --facts_.fault_count;
  }
  KeptFault& fault = facts_.faults[facts_.fault_count++];
  fault = {.code = static_cast<std::uint32_t>(code)};
  std::copy_n(finding.begin(), std::min(finding.size(), fault.finding.size() - 1), fault.finding.begin());
  return keep();
}

Status MachineRecord::fault_seen() {
  if (facts_.fault_count == 0) return {};
  std::shift_left(facts_.faults.begin(), facts_.faults.end(), 1);
  facts_.faults[--facts_.fault_count] = {};
  return keep();
}

UnseenFault MachineRecord::fault(std::size_t index) const {
  const KeptFault& fault = facts_.faults[index];
  return {.code = static_cast<FaultCode>(fault.code), .finding = fault.finding.data()};
}

Expected<MachineRecord> open_machine_record(const std::string& folder, const JobStore& store, double tank_ml,
                                            bool simulated) {
  auto record = MachineRecord::open(folder, tank_ml);
  PLUMBLINE_TRY(record);
  PLUMBLINE_TRY(record->add_interrupted(store));
  if (simulated && !record->resin_ml() && !store.has_job()) PLUMBLINE_TRY(record->fill(tank_ml));
  return record;
}

Expected<bool> has_interrupted_print(JobStore& store, MachineRecord& machine) {
  if (!store.has_job()) return false;
  const auto progress = store.progress();
  const bool none_cured =
      progress ? progress->last == JournalEntry() : progress.error().code() == ErrorCode::kTruncated;
  if (machine.plate_is_empty() && none_cured) {
    PLUMBLINE_TRY(store.end());
    return false;
  }
  PLUMBLINE_TRY(machine.take_plate());
  return true;
}

}  // namespace plumbline::firmware
