#pragma once
/// Reads the print settings of a sliced archive, whichever slicer wrote it: .sl1 (PrusaSlicer), .uvj, and zips of Chitubox, Creation Workshop,
/// NanoDLP and UVtools (Klipper).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/archive/settings_scanner.hpp"
#include "firmware/settings/print_fields.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline archive {

/// What is known of an archive besides the settings of its print.
enum class ArchiveFact : std::uint8_t {
  kLayers,
  kFastLayers,  ///< an SL1's: with kSlowLayers all of them
  kSlowLayers,
  kWidthMm,  ///< of the panel, along x
  kDepthMm,
  kColumns,
  kRows,
  kPitchXMm,
  kPitchYMm,
  kPixelsPerMmX,
  kPixelsPerMmY,
  kMirrorX,  ///< 1: the masks are mirrored for the panel
  kMirrorY,
  kMirrors,             ///< both in one: 1: x, 2: y, 3: both
  kPortrait,            ///< 1: the masks lie across the panel
  kRegions,             ///< of an exposure test
  kPower,               ///< of 255
  kBottomLayerHeightMm  ///< of all bottom layers
};
inline constexpr std::size_t kArchiveFactCount = 18;

/// Exposures as the layers come, equal ones joined.
struct ExposureRuns {
  struct Run {
    double seconds = 0;
    std::uint32_t layers = 0;
  };
  std::array<Run, 128> runs{};  ///< far more than bottom layers and a ramp take
  std::size_t count = 0;
  bool too_many = false;

  void add(double seconds);
};

/// Each number is in the range of kPrintFields; the printer's own limits are checked elsewhere.
struct ArchiveSettings {
  PrintValues values;  ///< initial_layer_height is that of the first mask
  std::array<std::optional<double>, kArchiveFactCount> facts;
  std::optional<std::uint8_t> dialect;  ///< of the file that `values` are from
  bool turns = false;                   ///< it says how its masks lie
  ExposureRuns exposures;               ///< of each layer, where a file says them so; empty: it does not

  std::optional<double>& value(PrintKey key) { return values[index_of(key)]; }
  const std::optional<double>& value(PrintKey key) const { return values[index_of(key)]; }
  std::optional<double>& fact(ArchiveFact fact) { return facts[static_cast<std::size_t>(fact)]; }
  const std::optional<double>& fact(ArchiveFact fact) const { return facts[static_cast<std::size_t>(fact)]; }

  /// How many layers it declares.
  std::optional<std::uint32_t> layers() const;
  /// Of the panel that it is sliced for.
  std::optional<double> width_mm() const;
  std::optional<double> depth_mm() const;
  bool mirrors_x() const;
  bool mirrors_y() const;
  bool portrait() const { return fact(ArchiveFact::kPortrait).value_or(0) > 0; }

  /// Once all files are read: adds what their printers do without being told, such as an SL1's three full bottom layers.
  /// @retval ErrorCode::kUnsupported  a print that this printer cannot carry out: what it is
  [[nodiscard]] Status complete();

 private:
  [[nodiscard]] Status fit_ramp();
};

/// Names of settings in the printer_notes of prusaslicer.ini, between START_CUSTOM_VALUES and END_CUSTOM_VALUES, each with "_" and its
/// value: UVtools' way to write what .sl1 has no key for. In G-code for Klipper it writes them by the same names. BottomLayerCount is
/// plumbline's own.
struct NoteKey {
  const char* name;
  PrintKey key;
};
inline constexpr std::array<NoteKey, 11> kNoteKeys = {{
    {"BottomLayerCount", PrintKey::kBottomLayerCount},
    {"WaitTimeBeforeCure", PrintKey::kDelayBeforeExposure},
    {"WaitTimeAfterCure", PrintKey::kDelayAfterExposure},
    {"LiftHeight", PrintKey::kLiftHeight},
    {"LiftSpeed", PrintKey::kLiftSpeed},
    {"LiftHeight2", PrintKey::kLiftHeight2},
    {"LiftSpeed2", PrintKey::kLiftSpeed2},
    {"WaitTimeAfterLift", PrintKey::kWaitTimeAfterLift},
    {"RetractSpeed", PrintKey::kRetractSpeed},
    {"RetractHeight2", PrintKey::kRetractHeight2},
    {"RetractSpeed2", PrintKey::kRetractSpeed2},
}};

/// Files that hold settings. Where several say the settings of the print, those of the first dialect count alone, as on its printer.
inline constexpr std::size_t kSettingsFiles = 12;
/// @param entry  with the folders before it
/// @returns its place in their order; none: it holds no settings
std::optional<std::size_t> settings_file(std::string_view entry);
/// What it is called in messages: "config.ini", "*.gcode".
const char* settings_file_name(std::size_t file);

struct ArchiveKey;

/// Reads one of an archive's settings files. Unknown keys are passed over, and so is what a file before it has said.
class SettingsReader {
 public:
  /// @param file  settings_file(); the files are read in their order
  SettingsReader(std::size_t file, ArchiveSettings& settings);
  SettingsReader(const SettingsReader&) = delete;
  SettingsReader& operator=(const SettingsReader&) = delete;

  /// @retval ErrorCode::kMalformed  a known key whose value is no number in its range, or that has two values; and any error of
  ///                                SettingsScanner
  [[nodiscard]] Status feed(std::span<const std::byte> bytes) { return scanner_.feed(bytes); }
  [[nodiscard]] Status finish() { return scanner_.finish(); }

 private:
  [[nodiscard]] Status take(std::string_view key, std::string_view text);
  [[nodiscard]] Status take_notes(std::string_view notes);
  bool take_exposure(std::string_view key, std::string_view text);
  [[nodiscard]] Status take(const ArchiveKey& row, std::string_view key, std::string_view text);

  std::size_t file_;
  ArchiveSettings* settings_;
  bool counts_;           ///< for the settings of the print
  bool lamp_on_ = false;  ///< by the last command of G-code
  std::array<bool, kPrintKeyCount + kArchiveFactCount> closed_{};
  struct Taker {
    SettingsReader* reader;
    Status operator()(std::string_view key, std::string_view text) const { return reader->take(key, text); }
  } taker_{this};
  SettingsScanner scanner_;
};

}  // namespace plumbline::firmware::inline archive
