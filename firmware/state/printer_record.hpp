#pragma once
/// What others may know of the printer: the state socket's source. README.md explains each field as clients see it.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "firmware/print/job/contract.hpp"
#include "firmware/print/job/kept_prints.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/print/status/print_report.hpp"
#include "firmware/print/status/print_state.hpp"
#include "firmware/settings/job_settings.hpp"
#include "firmware/slice/orientation_proposals.hpp"
#include "hal/clock.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/progress.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/core/words/told.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware::inline state {

/// Replaces a text, cut between two characters where it is too long.
template <std::size_t Capacity>
void assign(FixedText<Capacity>& to, std::string_view text) {
  to.clear();
  to.add("%s", PrintableText(text, Capacity - 1).c_str());
}

struct ScanRecord {
  FixedText<80> name;         ///< as it is shown: a longer one is cut
  std::uint32_t files = 1;    ///< more: that many scans as one, and the name is that of the first
  std::uint64_t bytes = 0;    ///< of all files
  FixedText<120> problem;     ///< what is wrong with it; empty: nothing is known to be
  std::uint32_t picture = 0;  ///< number of its picture, which rises with each; 0: there is none
  Told told;                  ///< the problem as a code
};

inline constexpr std::size_t kMostListedScans = 64;
inline constexpr std::size_t kMostListedFolders = 32;

/// A folder of the stick that can be opened.
struct FolderRecord {
  FixedText<80> name;         ///< in the folder that is listed, as it is shown: a longer one is cut
  std::uint32_t entries = 0;  ///< scans, meshes and prints in it and in the folders below it
};

/// What the stick has beside the list, and nobody can choose.
struct LeftOutRecord {
  std::size_t files = 0;
  std::size_t folders = 0;     ///< that were not looked into to the end, or are not listed
  std::size_t partitions = 0;  ///< that can't be read
  FixedText<120> text;         ///< empty: there is nothing
  Told told;
};

using ScanPictures = std::array<ScanPicture, kMostListedScans>;

/// What is offered or printed, and how.
struct JobRecord : JobSettings {
  FixedText<256> scan;
  std::array<FixedText<80>, kMostScans> files;  ///< of the scan, as ScanRecord::name
  std::size_t file_count = 0;
  FixedText<64> profile;
  std::optional<std::size_t>
      chosen;  ///< index of the scan among those on the stick; none: job.toml names it, or it is a resumed print
};

struct SlicingRecord {
  Stage stage = Stage::kRead;
  double fraction = 0;    ///< of the stage
  bool proposes = false;  ///< only the best ways up are looked for
  double whole = 0;       ///< done of all stages, 0 to 1
};

struct ProgressRecord {
  std::uint32_t layers_done = 0;
  std::uint32_t layers = 0;
  double height_mm = 0;
  std::chrono::seconds elapsed{};
  std::chrono::seconds left{};
  std::int64_t ends_at =
      0;  ///< s since 1970, by this machine's wall clock; 0: the print waits, or the clock is not set
  std::optional<nanoseconds> slack;
  double resin_ml = 0;
};

struct ResinRecord {
  double needed_ml = 0;  ///< for the whole print
  double tank_ml = 0;    ///< a full tank
};

enum class Severity : std::uint8_t { kNote, kWarning };

/// A setting of the job that mends a finding.
struct Remedy {
  FixedText<16> key, value;  ///< as `set` takes them
};
struct Remedies {
  std::array<Remedy, 3> list;
  std::size_t count = 0;

  void add(std::string_view key, std::string_view value) {
    if (count == list.size()) return;
    list[count].key.add("%.*s", static_cast<int>(key.size()), key.data());
    list[count++].value.add("%.*s", static_cast<int>(value.size()), value.data());
  }
};

/// Where something was found, mm on the panel and above the plate.
struct IssuePlaces {
  std::array<std::array<double, 3>, IssueGroup::kKept> mm{};
  std::size_t count = 0;
};

/// Something that whoever prints should know before or afterwards.
struct FindingRecord {
  Severity severity = Severity::kNote;
  Sentence text;
  Told told;
  Remedies remedies;
  IssuePlaces places;
};

/// The uploaded scan in the printer's store.
struct StoredRecord {
  FixedText<80> name;  ///< as it is shown: a longer one is cut
  std::uint64_t bytes = 0;
};

/// The last scan that somebody has sent to the printer's store, since the daemon started.
struct UploadRecord {
  enum class Stage : std::uint8_t {
    kComing,
    kKept,    ///< whole and durable; what it holds is not known yet
    kFailed,  ///< nothing of it is left
  };
  std::uint32_t number = 0;  ///< from 1, rises with each
  Stage stage = Stage::kComing;
  FixedText<80> name;
  std::uint64_t bytes = 0;     ///< that were announced
  std::uint64_t received = 0;  ///< so far
  FixedText<200> problem;      ///< of kFailed: why
  Told told;
};

struct FaultRecord {
  FaultCode code = FaultCode::kNone;
  FixedText<448> message;  ///< what happened this time; may be empty
  Told told;
  FixedText<400> remedy;  ///< what to do, for somebody who has buttons
};

/// One writer, the thread that prints; the same thread serves it. Fixed in size.
struct PrinterRecord {
  static constexpr std::size_t kMostScans = kMostListedScans;
  static constexpr std::size_t kMostFindings = 12;
  static constexpr std::size_t kMostProfiles = 16;

  FixedText<64> printer;
  bool simulated = false;

  PrintState state = PrintState::kIdle;
  bool waits = false;                 ///< somebody at rest waits for a person's answer
  std::uint64_t asks = 0;             ///< random, of the question that is put: new with each. See question_id()
  TimePoint asked_at;                 ///< when, by the machine's clock
  FixedText<512> message;             ///< what the daemon said last
  Told message_told;                  ///< empty: it says no more than the state does
  PrintNote note = PrintNote::kNone;  ///< of the print that runs
  FixedText<160> question;            ///< that start or cancel answers while a print is paused; empty: none
  Told question_told;
  bool has_stick = false;
  bool scans_uploaded = false;  ///< `scans` are in the printer's store, not on a stick
  std::array<ScanRecord, kMostScans> scans;
  std::size_t scan_count = 0;
  FixedText<80> folder;  ///< that is listed, as it is shown; empty: the stick's top folder
  std::array<FolderRecord, kMostListedFolders> folders;
  std::size_t folder_count = 0;
  LeftOutRecord left_out;
  std::uint64_t most_upload_bytes = 0;  ///< of a scan; 0: none is taken
  std::optional<UploadRecord> upload;
  std::optional<StoredRecord> stored;  ///< none: the store is empty
  bool has_job_file = false;           ///< job.toml says what is printed
  std::uint64_t job_id = 0;            ///< random, of `job`: new with each offer. Pictures and reports carry it
  std::optional<JobRecord> job;        ///< offered, printing, or the last one
  std::array<FixedText<64>, kMostProfiles> profiles;  ///< names, for a job's setting `profile`
  std::size_t profile_count = 0;
  std::optional<Proposals> proposals;  ///< ways up of the job's scan, to choose from
  std::optional<SlicingRecord> slicing;
  std::optional<Contract> sliced;  ///< what will be done, from the end of slicing on
  std::optional<ProgressRecord> progress;
  std::optional<ResinRecord> resin;
  std::optional<PrintState> result;  ///< how the last print ended
  std::array<CheckResult, kCheckCount> checks;
  std::array<FindingRecord, kMostFindings> findings;
  std::size_t finding_count = 0;
  std::optional<FaultRecord> fault;
  const ScanPictures* scan_pictures = nullptr;  ///< of `scans`; none: nobody makes them
  const JobPictures* pictures = nullptr;        ///< none: nobody makes them
  std::array<std::uint32_t, 2> mask_pixels{};   ///< of the panel, columns and rows
  std::array<double, 2> mask_pixel_mm{};        ///< of one, x and y
  bool has_masks = false;                       ///< the mask of any layer may be asked for
  bool has_report = false;                 ///< that of the last print may be asked for, when the printer is at rest
  const MachineRecord* machine = nullptr;  ///< what the printer remembers; none: nothing
  const KeptPrints* prints = nullptr;      ///< reports and previews of the last prints; none: nobody keeps them
  FixedText<96> address;  ///< of the printer's page, as a browser takes it; empty: there is none, or no network
  FixedText<8> code;      ///< that the screen shows to pair a browser; empty: none. Never in a state line

  /// What an answer answers now; 0: nobody is asked.
  std::uint64_t question_id() const { return (at_rest(state) && waits) || waits_for_start(state) ? asks : 0; }
  /// A person is asked.
  /// @param id  of RandomIds
  void ask(std::uint64_t id, TimePoint now) {
    asks = id;
    asked_at = now;
  }
  /// Forgets the job of before.
  void begin_job();
  /// The index of the proposal that the job follows; none: there are none, or it follows none of them.
  std::optional<std::size_t> proposal() const;
  void add_finding(Severity severity, std::string_view text, const Told& told = {}, const Remedies& remedies = {},
                   const IssuePlaces& places = {});
  void remove_findings(ToldCode which);
  /// @param clock_s  as wall_clock_s()
  void set_progress(const PrintStatus& status, std::int64_t clock_s);
  void set_fault(FaultCode which, std::string_view finding, std::string_view remedy, const Told& told = {});
};

}  // namespace plumbline::firmware::inline state
