#pragma once
/// What a printer remembers between prints, beside the print's own journal:
///
///   STATE/machine   plate, resin, lamp, film, temperatures, faults that nobody has seen yet
///
/// It is written twice, in pages of its own, with a number that rises and a hash; each copy is made durable and read back before the
/// next one is begun. So a power cut can spoil one copy, and the other has the state before or after it. Nothing is written while a
/// layer is printed: what an interrupted print has used is added from its journal when the printer starts again.
///
/// Two empty files are a person's word for a printer without a record, and are removed when they have been read:
///
///   STATE/plate-is-empty   the plate is empty
///   STATE/tank-is-full     the tank is full

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/job_store.hpp"
#include "firmware/print/job/journal_file.hpp"
#include "firmware/print/status/fault.hpp"
#include "hal/thermals.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// How much resin the masks of a print take.
struct ResinScale {
  double pixel_ml = 0;             ///< a pixel of a layer
  double first_layer_more_ml = 0;  ///< that the first layer takes more than one of the usual height
};

/// What a print has used so far.
struct PrintUse {
  std::uint64_t pixels = 0;  ///< that were cured, and those of a layer that may have been lit
  std::uint32_t layers = 0;  ///< cured
  nanoseconds lamp{};        ///< light
};

/// A fault that nobody has seen yet.
struct UnseenFault {
  FaultCode code = FaultCode::kNone;
  std::string_view finding;  ///< cut after 151 bytes
};

class MachineRecord {
 public:
  static constexpr std::size_t kMostFaults = 4;

  /// Keeps nothing: the plate is in use, and the tank full.
  /// @param tank_ml  resin in a full tank
  explicit MachineRecord(double tank_ml);

  /// Reads the record, or makes a new one: the plate is in use, and the resin unknown.
  /// @param folder   that of the JobStore, which has created and locked it
  /// @param tank_ml  resin in a full tank
  /// @retval ErrorCode::kCannotOpen, kCannotRead, kCannotWrite  the path, the reason
  /// @retval ErrorCode::kUnsupported  another version of plumbline wrote it
  [[nodiscard]] static Expected<MachineRecord> open(const std::string& folder, double tank_ml);

  /// Both copies were damaged when the record was opened: what they held is lost.
  bool was_damaged() const { return was_damaged_; }

  bool plate_is_empty() const { return facts_.plate_is_empty != 0; }
  /// Somebody says that the plate is empty. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite  the plate still counts as in use
  [[nodiscard]] Status confirm_empty();
  /// Something may be on the plate. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status take_plate();

  /// Resin in the tank, ml, never more than there is; none: nobody has said.
  std::optional<double> resin_ml() const;
  /// What was in the tank when somebody said so last, ml.
  double filled_ml() const { return facts_.filled_ml; }
  double tank_ml() const { return tank_ml_; }
  /// How often somebody has filled the tank since the program started.
  std::uint32_t fills() const { return fills_; }
  /// Somebody says how much resin is in the tank now. Durable when it returns.
  /// @param ml  0 to tank_ml(); more counts as tank_ml()
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status fill(double ml);

  /// A print begins or goes on: the plate is taken. Durable when it returns.
  /// @param job_hash  of its journal; 0: it has none
  /// @retval ErrorCode::kCannotWrite  the print must not begin
  [[nodiscard]] Status begin_print(std::uint64_t job_hash, const ResinScale& scale);
  /// What the print has used so far, over all runs. Not durable: the journal has it.
  void note(const PrintUse& use);
  /// Adds what an interrupted print has used since this record was written, by its journal. Without its record, or if its journal is
  /// damaged, the resin is unknown from now on. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status add_interrupted(const JobStore& store);
  /// Writes all that was noted. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status keep();

  std::chrono::milliseconds lamp_lit() const { return std::chrono::milliseconds(facts_.lamp_ms); }
  std::uint64_t film_layers() const { return facts_.film_layers; }  ///< cured on the film

  /// A temperature that was read in a print. Not durable before the next keep().
  void felt(TemperatureSite site, Celsius temperature);
  /// One that was read at rest; none: its sensor does not answer. It is not kept.
  void feels(TemperatureSite site, std::optional<Celsius> temperature) {
    latest_[static_cast<std::size_t>(site)] = temperature;
  }
  /// The one that was read last; none: none was, or its sensor did not answer.
  std::optional<Celsius> latest(TemperatureSite site) const { return latest_[static_cast<std::size_t>(site)]; }
  /// The highest that was read in a print; none: none was.
  std::optional<Celsius> hottest(TemperatureSite site) const;

  /// Keeps a fault until somebody has seen it. Of more than kMostFaults the oldest is dropped. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status add_fault(FaultCode code, std::string_view finding);
  /// Somebody has seen the oldest one. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite
  [[nodiscard]] Status fault_seen();
  std::size_t fault_count() const { return facts_.fault_count; }
  /// @param index  0: the oldest. Below fault_count()
  UnseenFault fault(std::size_t index) const;

 private:
  struct KeptFault {
    std::uint32_t code = 0;
    std::uint32_t reserved = 0;
    std::array<char, 152> finding = {};  ///< filled with 0
  };
  /// As on the medium: little-endian, no padding. The hash covers the bytes before it.
  struct Facts {
    std::uint32_t magic = 0;
    std::uint32_t bytes = 0;
    std::uint64_t number = 0;  ///< rises with each write
    std::uint32_t plate_is_empty = 0;
    std::uint32_t tank_is_known = 0;
    double filled_ml = 0;
    double used_ml = 0;          ///< since then
    std::uint64_t job_hash = 0;  ///< of the print that has taken the plate last
    ResinScale scale;            ///< its
    std::uint64_t pixels = 0;    ///< of its, in used_ml or cured before the tank was filled
    std::uint64_t lamp_ms = 0;
    std::uint64_t film_layers = 0;
    std::uint32_t layers = 0;         ///< of its, in film_layers
    std::uint32_t print_lamp_ms = 0;  ///< of its, in lamp_ms
    std::array<std::int32_t, kTemperatureSiteCount> hottest_mc = {};
    std::uint32_t fault_count = 0;
    std::array<KeptFault, kMostFaults> faults = {};
    std::uint64_t hash = 0;
  };

  [[nodiscard]] static Facts fresh();
  [[nodiscard]] static std::uint64_t hash_of(const Facts& facts);
  [[nodiscard]] Status read_copies(std::size_t bytes);
  [[nodiscard]] Status create();
  [[nodiscard]] Status write(JournalFile& file);
  [[nodiscard]] Status take_words();
  double used_ml(std::uint64_t pixels) const;
  tl::unexpected<Error> cannot_write(const char* name) const;

  double tank_ml_;
  FixedPath path_;  ///< of the folder
  Descriptor folder_;
  std::optional<JournalFile> file_;  ///< none: nothing is kept
  Facts facts_ = fresh();
  bool was_damaged_ = false;
  std::uint32_t fills_ = 0;
  std::array<std::optional<Celsius>, kTemperatureSiteCount> latest_;
};

/// Opens the printer's record and adds what an interrupted print has used since.
/// @param tank_ml    resin in a full tank
/// @param simulated  its tank is full until something is printed
/// @retval the errors of MachineRecord::open() and add_interrupted()
[[nodiscard]] Expected<MachineRecord> open_machine_record(const std::string& folder, const JobStore& store,
                                                          double tank_ml, bool simulated);

/// Whether the store holds a print that has begun, in which case the plate is marked as taken. A print that has not begun is removed: power
/// failed before its checks had passed, so nothing of it is on the plate.
/// @retval the errors of JobStore::end() and MachineRecord::take_plate()
[[nodiscard]] Expected<bool> has_interrupted_print(JobStore& store, MachineRecord& machine);

}  // namespace plumbline::firmware
