#include "firmware/archive/archive_settings.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "firmware/archive/layer_numbers.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/resin/bottom_fade.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware::inline archive {

enum class KeyNote : std::uint8_t {
  kNone,
  kUnitLies,  ///< Creation Workshop writes mm/s beside millimetres a minute
  kAlways     ///< a setting of the print that counts whatever another dialect says: the masks were cut for it
};

/// A setting that a slicer writes.
struct ArchiveKey {
  std::string_view name;
  std::variant<PrintKey, ArchiveFact> what;
  double factor = 1;  ///< to mm, s, mm/min, unless the value has a unit
  KeyNote note = KeyNote::kNone;
};

namespace {

/// An archive's own exposures say that the others don't count: see SettingsReader.
enum class Dialect : std::uint8_t { kSl1, kPrusaSlicer, kUvj, kGcode, kNanoDlp, kUvTools };

constexpr double kMilli = 0.001;

constexpr ArchiveKey kSl1Keys[] = {
    {"layerHeight", PrintKey::kLayerHeight}, {"layerHeightFirst", PrintKey::kInitialLayerHeight},
    {"expTime", PrintKey::kExposureTime},    {"expTimeFirst", PrintKey::kInitialExposureTime},
    {"numFade", PrintKey::kFadedLayers},     {"numFast", ArchiveFact::kFastLayers},
    {"numSlow", ArchiveFact::kSlowLayers},   {"calibrateRegions", ArchiveFact::kRegions},
};

constexpr ArchiveKey kPrusaSlicerKeys[] = {
    {"layer_height", PrintKey::kLayerHeight},
    {"initial_layer_height", PrintKey::kInitialLayerHeight, 1, KeyNote::kAlways},
    {"exposure_time", PrintKey::kExposureTime},
    {"initial_exposure_time", PrintKey::kInitialExposureTime},
    {"faded_layers", PrintKey::kFadedLayers},
    {"display_width", ArchiveFact::kWidthMm},
    {"display_height", ArchiveFact::kDepthMm},
    {"display_mirror_x", ArchiveFact::kMirrorX},
    {"display_mirror_y", ArchiveFact::kMirrorY},
    {"display_orientation", ArchiveFact::kPortrait},
};

constexpr ArchiveKey kUvjKeys[] = {
    {"Properties.Size.X", ArchiveFact::kColumns},
    {"Properties.Size.Y", ArchiveFact::kRows},
    {"Properties.Size.Millimeter.X", ArchiveFact::kWidthMm},
    {"Properties.Size.Millimeter.Y", ArchiveFact::kDepthMm},
    {"Properties.Size.Layers", ArchiveFact::kLayers},
    {"Properties.Size.LayerHeight", PrintKey::kLayerHeight},
    {"Properties.Bottom.Count", PrintKey::kBottomLayerCount},
    {"Properties.Bottom.LightOnTime", PrintKey::kInitialExposureTime},
    {"Properties.Exposure.LightOnTime", PrintKey::kExposureTime},
    {"Properties.Exposure.LightPWM", ArchiveFact::kPower},
    {"Properties.Exposure.WaitTimeBeforeCure", PrintKey::kDelayBeforeExposure},
    {"Properties.Exposure.WaitTimeAfterCure", PrintKey::kDelayAfterExposure},
    {"Properties.Exposure.LiftHeight", PrintKey::kLiftHeight},
    {"Properties.Exposure.LiftSpeed", PrintKey::kLiftSpeed},
    {"Properties.Exposure.LiftHeight2", PrintKey::kLiftHeight2},
    {"Properties.Exposure.LiftSpeed2", PrintKey::kLiftSpeed2},
    {"Properties.Exposure.WaitTimeAfterLift", PrintKey::kWaitTimeAfterLift},
    {"Properties.Exposure.RetractSpeed", PrintKey::kRetractSpeed},
    {"Properties.Exposure.RetractHeight2", PrintKey::kRetractHeight2},
    {"Properties.Exposure.RetractSpeed2", PrintKey::kRetractSpeed2},
};

constexpr ArchiveKey kGcodeKeys[] = {
    // Chitubox, and UVtools for Klipper, which uses many of Chitubox's names. kNoteKeys has those that only Klipper uses.
    {"layerHeight", PrintKey::kLayerHeight},
    {"normalExposureTime", PrintKey::kExposureTime},
    {"bottomLayerExposureTime", PrintKey::kInitialExposureTime},
    {"bottomLayExposureTime", PrintKey::kInitialExposureTime},
    {"bottomLayerCount", PrintKey::kBottomLayerCount},
    {"bottomLayCount", PrintKey::kBottomLayerCount},
    {"normalLayerLiftHeight", PrintKey::kLiftHeight},
    {"normalLayerLiftSpeed", PrintKey::kLiftSpeed},
    {"normalDropSpeed", PrintKey::kRetractSpeed},
    {"totalLayer", ArchiveFact::kLayers},
    {"resolutionX", ArchiveFact::kColumns},
    {"resolutionY", ArchiveFact::kRows},
    {"machineX", ArchiveFact::kWidthMm},
    {"machineY", ArchiveFact::kDepthMm},
    {"mirror", ArchiveFact::kMirrors},
    {"PWMLight", ArchiveFact::kPower},
    {"ExposureTime", PrintKey::kExposureTime},
    {"BottomExposureTime", PrintKey::kInitialExposureTime},
    {"TransitionLayerCount", PrintKey::kFadedLayers},
    {"LayerCount", ArchiveFact::kLayers},
    {"DisplayHeight", ArchiveFact::kDepthMm},
    {"LightPWM", ArchiveFact::kPower},
    {"TOTAL_LAYER", ArchiveFact::kLayers},
    {"LAYERS", ArchiveFact::kLayers},
    // Creation Workshop
    {"Layer Thickness", PrintKey::kLayerHeight},
    {"Layer Time", PrintKey::kExposureTime, kMilli},
    {"Bottom Layers Time", PrintKey::kInitialExposureTime, kMilli},
    {"Number of Bottom Layers", PrintKey::kBottomLayerCount},
    {"Lift Distance", PrintKey::kLiftHeight},
    {"Z Lift Feed Rate", PrintKey::kLiftSpeed, 1, KeyNote::kUnitLies},
    {"Z Lift Retract Rate", PrintKey::kRetractSpeed, 1, KeyNote::kUnitLies},
    {"Number of Slices", ArchiveFact::kLayers},
    {"X Resolution", ArchiveFact::kColumns},
    {"Y Resolution", ArchiveFact::kRows},
    {"Pix per mm X", ArchiveFact::kPixelsPerMmX},
    {"Pix per mm Y", ArchiveFact::kPixelsPerMmY},
    {"Flip X", ArchiveFact::kMirrorX},
    {"Flip Y", ArchiveFact::kMirrorY},
    {"Layer Light PWM", ArchiveFact::kPower},
};

/// Of Creation Workshop archives for Novamaker's printers.
constexpr ArchiveKey kSliceConfKeys[] = {
    {"thickness", PrintKey::kLayerHeight},
    {"layers_expo_ms", PrintKey::kExposureTime, kMilli},
    {"head_layers_expo_ms", PrintKey::kInitialExposureTime, kMilli},
    {"head_layers_num", PrintKey::kBottomLayerCount},
    {"wait_before_expo_ms", PrintKey::kDelayBeforeExposure, kMilli},
    {"lift_distance", PrintKey::kLiftHeight},
    {"lift_up_speed", PrintKey::kLiftSpeed},
    {"lift_down_speed", PrintKey::kRetractSpeed},
    {"layers_num", ArchiveFact::kLayers},
    {"xres", ArchiveFact::kColumns},
    {"yres", ArchiveFact::kRows},
    {"xppm", ArchiveFact::kPixelsPerMmX},
    {"yppm", ArchiveFact::kPixelsPerMmY},
};

constexpr ArchiveKey kSlicingKeys[] = {
    {"SliceHeight", PrintKey::kLayerHeight},
    {"LayerTime", PrintKey::kExposureTime, kMilli},
    {"FirstLayerTime", PrintKey::kInitialExposureTime, kMilli},
    {"NumberofBottomLayers", PrintKey::kBottomLayerCount},
    {"LiftDistance", PrintKey::kLiftHeight},
    {"LiftFeedRate", PrintKey::kLiftSpeed},
    {"LiftRetractRate", PrintKey::kRetractSpeed},
    {"XResolution", ArchiveFact::kColumns},
    {"YResolution", ArchiveFact::kRows},
    {"DotsPermmX", ArchiveFact::kPixelsPerMmX},
    {"DotsPermmY", ArchiveFact::kPixelsPerMmY},
};

/// NanoDLP's five JSON files. They give depths in micrometres.
constexpr ArchiveKey kNanoDlpKeys[] = {
    {"Depth", PrintKey::kLayerHeight, kMilli},
    {"Thickness", PrintKey::kLayerHeight, kMilli},
    {"SupportDepth", ArchiveFact::kBottomLayerHeightMm, kMilli},
    {"CureTime", PrintKey::kExposureTime},
    {"SupportCureTime", PrintKey::kInitialExposureTime},
    {"SupportLayerNumber", PrintKey::kBottomLayerCount},
    {"TransitionalLayer", PrintKey::kFadedLayers},
    {"WaitBeforePrint", PrintKey::kDelayBeforeExposure},
    {"WaitAfterPrint", PrintKey::kDelayAfterExposure},
    {"WaitHeight", PrintKey::kLiftHeight},
    {"TopWait", PrintKey::kWaitTimeAfterLift},
    {"LayersCount", ArchiveFact::kLayers},
    {"LayerCount", ArchiveFact::kLayers},
    {"PWidth", ArchiveFact::kColumns},
    {"PHeight", ArchiveFact::kRows},
    {"XPixelSize", ArchiveFact::kPitchXMm},
    {"YPixelSize", ArchiveFact::kPitchYMm},
    {"ImageMirror", ArchiveFact::kMirrors},
};

/// Of UVtools' plain zip.
constexpr ArchiveKey kUvToolsKeys[] = {
    {"LayerHeight", PrintKey::kLayerHeight},  {"ResolutionX", ArchiveFact::kColumns},
    {"ResolutionY", ArchiveFact::kRows},      {"DisplayWidth", ArchiveFact::kWidthMm},
    {"DisplayHeight", ArchiveFact::kDepthMm},
};

struct SettingsFile {
  std::string_view name;  ///< "*": any
  Dialect dialect;
  SettingsForm form;
  std::span<const ArchiveKey> keys;
};

/// config.ini first: an SL1 reads nothing else. What a printer carries out comes before what its slicer keeps beside it.
constexpr std::array<SettingsFile, kSettingsFiles> kFiles = {{
    {"config.ini", Dialect::kSl1, SettingsForm::kIni, kSl1Keys},
    {"prusaslicer.ini", Dialect::kPrusaSlicer, SettingsForm::kIni, kPrusaSlicerKeys},
    {"config.json", Dialect::kUvj, SettingsForm::kJson, kUvjKeys},
    {"*.gcode", Dialect::kGcode, SettingsForm::kGcode, kGcodeKeys},
    {"slice.conf", Dialect::kGcode, SettingsForm::kIni, kSliceConfKeys},
    {"*.slicing", Dialect::kGcode, SettingsForm::kXml, kSlicingKeys},
    {"override.json", Dialect::kNanoDlp, SettingsForm::kJson, kNanoDlpKeys},
    {"profile.json", Dialect::kNanoDlp, SettingsForm::kJson, kNanoDlpKeys},
    {"slicer.json", Dialect::kNanoDlp, SettingsForm::kJson, kNanoDlpKeys},
    {"options.json", Dialect::kNanoDlp, SettingsForm::kJson, kNanoDlpKeys},
    {"plate.json", Dialect::kNanoDlp, SettingsForm::kJson, kNanoDlpKeys},
    {"manifest.uvtools", Dialect::kUvTools, SettingsForm::kJson, kUvToolsKeys},
}};

struct FactRange {
  double low, high;
  const char* unit;
};
/// In the order of ArchiveFact.
constexpr std::array<FactRange, kArchiveFactCount> kFactRanges = {{
    {0, 1e6, ""},
    {0, 1e6, ""},
    {0, 1e6, ""},
    {1, 10000, " mm"},
    {1, 10000, " mm"},
    {1, 1e5, ""},
    {1, 1e5, ""},
    {0.001, 1, " mm"},
    {0.001, 1, " mm"},
    {1, 1000, " px/mm"},
    {1, 1000, " px/mm"},
    {0, 1, ""},
    {0, 1, ""},
    {0, 3, ""},
    {0, 1, ""},
    {0, 100, ""},
    {0, 255, ""},
    {0.005, 1, " mm"},
}};

struct ValueUnit {
  std::string_view word, of;  ///< `of`: the unit of a field
  double factor;
};
constexpr ValueUnit kUnits[] = {
    {"mm", " mm", 1},        {"um", " mm", kMilli},  {"\xc2\xb5m", " mm", kMilli}, {"\xce\xbcm", " mm", kMilli},
    {"s", " s", 1},          {"sec", " s", 1},       {"ms", " s", kMilli},         {"mm/min", " mm/min", 1},
    {"mm/s", " mm/min", 60}, {"px/mm", " px/mm", 1}, {"layers", " layers", 1},
};

struct ValueWord {
  std::string_view word;
  double value;
};
constexpr ValueWord kValueWords[] = {{"true", 1}, {"false", 0}, {"portrait", 1}, {"landscape", 0}};

/// A number as slicers write it, in any country, in the unit of its field; none: it is none.
std::optional<double> parse_setting(std::string_view text, std::string_view unit, const ArchiveKey& key) {
  for (const ValueWord& known : kValueWords) {
    if (unit.empty() && same_word(known.word, text)) return known.value;
  }
  std::array<char, 32> digits{};
  std::size_t size = 0;
  const auto comma = text.find(',');
  const bool decimal_comma = comma == text.rfind(',') && text.find('.') == std::string_view::npos;
  for (; size < std::min(text.size(), digits.size()); ++size) {
    digits[size] = decimal_comma && size == comma ? '.' : text[size];
  }
  double number = 0;
  const char* const end = parse_real(digits.data(), digits.data() + size, number);
  if (end == nullptr || text.size() > digits.size()) return std::nullopt;
  auto rest = text.substr(static_cast<std::size_t>(end - digits.data()));
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  if (rest.empty() || key.note == KeyNote::kUnitLies) return number * key.factor;
  for (const ValueUnit& known : kUnits) {
    if (same_word(known.word, rest) && (known.of == unit || unit.empty())) return number * known.factor;
  }
  return rest == "px" && unit.empty() ? std::optional(number) : std::nullopt;
}

const NoteKey* note_key(std::string_view name) {
  const auto* const found =
      std::ranges::find_if(kNoteKeys, [name](const NoteKey& k) { return same_word(k.name, name); });
  return found == kNoteKeys.end() ? nullptr : found;
}

bool is_count(const PrintField& field) { return std::holds_alternative<std::uint32_t PrintProfile::*>(field.member); }

/// A speed or a lift of 0 says that there is none such.
bool is_silent_at_zero(PrintKey key) {
  return key == PrintKey::kLiftHeight || key == PrintKey::kLiftSpeed || key == PrintKey::kLiftSpeed2 ||
         key == PrintKey::kRetractSpeed || key == PrintKey::kRetractSpeed2;
}

/// A panel's side: as it is said, or of its pixels.
std::optional<double> side_mm(const std::optional<double>& mm, const std::optional<double>& pixels,
                              const std::optional<double>& pitch_mm, const std::optional<double>& per_mm) {
  if (mm || !pixels) return mm;
  if (pitch_mm) return *pixels * *pitch_mm;
  return per_mm ? std::optional(*pixels / *per_mm) : std::nullopt;
}

}  // namespace

std::optional<std::uint32_t> ArchiveSettings::layers() const {
  const auto& fast = fact(ArchiveFact::kFastLayers);
  const auto& slow = fact(ArchiveFact::kSlowLayers);
  if (const auto& all = fact(ArchiveFact::kLayers)) return static_cast<std::uint32_t>(*all);
  if (!fast && !slow) return std::nullopt;
  return static_cast<std::uint32_t>(fast.value_or(0) + slow.value_or(0));
}

std::optional<double> ArchiveSettings::width_mm() const {
  return side_mm(fact(ArchiveFact::kWidthMm), fact(ArchiveFact::kColumns), fact(ArchiveFact::kPitchXMm),
                 fact(ArchiveFact::kPixelsPerMmX));
}

std::optional<double> ArchiveSettings::depth_mm() const {
  return side_mm(fact(ArchiveFact::kDepthMm), fact(ArchiveFact::kRows), fact(ArchiveFact::kPitchYMm),
                 fact(ArchiveFact::kPixelsPerMmY));
}

bool ArchiveSettings::mirrors_x() const {
  const double both = fact(ArchiveFact::kMirrors).value_or(0);
  return fact(ArchiveFact::kMirrorX).value_or(0) > 0 || both == 1 || both == 3;
}

bool ArchiveSettings::mirrors_y() const {
  return fact(ArchiveFact::kMirrorY).value_or(0) > 0 || fact(ArchiveFact::kMirrors).value_or(0) >= 2;
}

void ExposureRuns::add(double seconds) {
  if (count > 0 && runs[count - 1].seconds == seconds) {
    ++runs[count - 1].layers;
  } else if (count < runs.size()) {
    runs[count++] = {seconds, 1};
  } else {
    too_many = true;
  }
}

/// Finds the ramp of the layers' own exposures, and that they are otherwise those of the bottom and normal layers.
Status ArchiveSettings::fit_ramp() {
  const auto &normal = value(PrintKey::kExposureTime), &initial = value(PrintKey::kInitialExposureTime);
  const auto& bottom = value(PrintKey::kBottomLayerCount);
  if (exposures.count == 0 || !normal || !initial || !bottom) return {};
  const auto alike = [](double a, double b) { return std::abs(a - b) <= 0.02; };  // s: slicers round to 0.01
  std::uint32_t last = 0, layers = 0;  // the last layer that is no normal one
  for (const auto& run : std::span(exposures.runs).first(exposures.count)) {
    layers += run.layers;
    if (!alike(run.seconds, *normal)) last = layers;
  }
  const auto bottoms = static_cast<std::uint32_t>(*bottom);
  const std::uint32_t faded = std::max(last, bottoms) - bottoms;
  bool fits = !exposures.too_many && faded <= kPrintFields[index_of(PrintKey::kFadedLayers)].high;
  std::uint32_t layer = 0;
  for (const auto& run : std::span(exposures.runs).first(exposures.count)) {
    for (std::uint32_t i = 0; fits && i < run.layers; ++i, ++layer) {
      fits = alike(run.seconds, *initial + (*normal - *initial) * bottom_fade(layer, bottoms, faded));
    }
  }
  if (fits) {
    value(PrintKey::kFadedLayers) = faded;
    return {};
  }
  return telling(
      Told(PrinterCode::kArchiveValue, {}, "exposure"),
      fail(ErrorCode::kUnsupported,
           "layer %u has an exposure of its own, which this version can't print.\tSlice it with one exposure", layer));
}

Status ArchiveSettings::complete() {
  if (const double regions = fact(ArchiveFact::kRegions).value_or(0); regions > 1) {
    return telling(Told(PrinterCode::kArchiveRegions, {{Fact::kCount, regions}}),
                   fail(ErrorCode::kUnsupported,
                        "is an exposure test of %.0f exposures, which this version can't print.\tExport it without "
                        "calibration",
                        regions));
  }
  if (const double power = fact(ArchiveFact::kPower).value_or(0); power != 0 && power != 255) {
    return telling(
        Told(PrinterCode::kArchivePower, {{Fact::kCount, power / 2.55}}),
        fail(ErrorCode::kUnsupported,
             "asks for %.0f %% of the lamp's power, which this printer's lamp can't give.\tSlice it for full "
             "power",
             power / 2.55));
  }
  const auto add = [this](PrintKey key, double said) {
    if (!value(key)) value(key) = said;
  };
  const bool by_prusa = dialect == static_cast<std::uint8_t>(Dialect::kSl1) ||
                        dialect == static_cast<std::uint8_t>(Dialect::kPrusaSlicer);
  if (by_prusa) {
    // sla-fw up to 1.7, slafw/project/project.py: _fill_layers_times() exposes the first layer and
    // exposure_time_first_extra_layers = 2 more for expTimeFirst, then fades over numFade as this printer does.
    add(PrintKey::kBottomLayerCount, 3);
  } else if (value(PrintKey::kBottomLayerCount) || value(PrintKey::kInitialExposureTime)) {
    add(PrintKey::kFadedLayers, 0);  // the others' printers fade only where they are told to
  }
  if (value(PrintKey::kLiftHeight)) add(PrintKey::kLiftHeight2, 0);
  if (value(PrintKey::kRetractSpeed)) add(PrintKey::kRetractHeight2, 0);
  PLUMBLINE_TRY(fit_ramp());
  // No bottom layers: one, exposed as all others are.
  const auto& exposure = value(PrintKey::kExposureTime);
  if (value(PrintKey::kBottomLayerCount) == 0.0) {
    value(PrintKey::kBottomLayerCount) = 1;
    value(PrintKey::kInitialExposureTime) = exposure;
    value(PrintKey::kFadedLayers) = 0;
  }
  const auto& height = value(PrintKey::kLayerHeight);
  const auto& bottom = fact(ArchiveFact::kBottomLayerHeightMm);
  if (bottom && height && *bottom != *height) {
    if (value(PrintKey::kBottomLayerCount) != 1.0) {
      return telling(Told(PrinterCode::kArchiveHeights),
                     fail(ErrorCode::kUnsupported,
                          "its bottom layers are %.4g mm high and the others %.4g mm, which this version can't print.\t"
                          "Slice it with one layer height",
                          *bottom, *height));
    }
    add(PrintKey::kInitialLayerHeight, *bottom);
  }
  return {};
}

std::optional<std::size_t> settings_file(std::string_view entry) {
  const auto name = file_of_entry(entry);
  if (name.starts_with('.')) return std::nullopt;  // macOS adds a second, hidden file for each
  const auto* const found = std::find_if(kFiles.begin(), kFiles.end(), [name](const SettingsFile& file) {
    return file.name.starts_with('*') ? has_ending(name, file.name.substr(1)) : same_word(name, file.name);
  });
  if (found == kFiles.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kFiles.begin());
}

const char* settings_file_name(std::size_t file) { return kFiles[file].name.data(); }

SettingsReader::SettingsReader(std::size_t file, ArchiveSettings& settings)
    : file_(file),
      settings_(&settings),
      counts_(!settings.dialect || *settings.dialect == static_cast<std::uint8_t>(kFiles[file].dialect)),
      scanner_(kFiles[file].form, taker_) {
  for (std::size_t i = 0; i < kPrintKeyCount; ++i) closed_[i] = settings.values[i].has_value();
  for (std::size_t i = 0; i < kArchiveFactCount; ++i) closed_[kPrintKeyCount + i] = settings.facts[i].has_value();
  settings.turns = settings.turns || kFiles[file].dialect == Dialect::kPrusaSlicer;
}

Status SettingsReader::take(std::string_view key, std::string_view text) {
  const SettingsFile& file = kFiles[file_];
  if (counts_ && take_exposure(key, text)) return {};
  if (file.dialect == Dialect::kPrusaSlicer && key == "printer_notes") return take_notes(text);
  const auto row =
      std::find_if(file.keys.begin(), file.keys.end(), [key](const ArchiveKey& k) { return same_word(k.name, key); });
  if (row != file.keys.end()) return text == "null" ? Status() : take(*row, key, text);
  const NoteKey* const note = file.form == SettingsForm::kGcode ? note_key(key) : nullptr;
  return note == nullptr ? Status() : take({note->name, note->key}, key, text);
}

/// A layer's own exposure: in .uvj, or in G-code the wait after the lamp was switched on.
bool SettingsReader::take_exposure(std::string_view key, std::string_view text) {
  const SettingsFile& file = kFiles[file_];
  double number = 0;
  const auto parse = [&number](std::string_view digits) {
    return parse_real(digits.data(), digits.data() + digits.size(), number) != nullptr;
  };
  if (file.dialect == Dialect::kUvj && same_word(key, "Layers[].Exposure.LightOnTime")) {
    if (parse(text)) settings_->exposures.add(number);
    return true;
  }
  if (file.form != SettingsForm::kGcode) return false;
  if (same_word(key, "M106")) {
    lamp_on_ = text.size() > 1 && parse(text.substr(1)) && number > 0;
    return true;
  }
  const bool waits = same_word(key, "<Delay>");
  if (!waits && !same_word(key, "G4")) return false;
  const bool milliseconds = waits || lower_letter(text.empty() ? ' ' : text[0]) == 'p';
  if (lamp_on_ && milliseconds && parse(waits ? text : text.substr(1)) && number > 0) {
    settings_->exposures.add(number * kMilli);
    lamp_on_ = false;
  }
  return true;
}

Status SettingsReader::take_notes(std::string_view notes) {
  constexpr std::string_view kStart = "START_CUSTOM_VALUES", kEnd = "END_CUSTOM_VALUES";
  notes.remove_prefix(std::min(notes.find(kStart), notes.size()));
  notes = notes.substr(0, notes.find(kEnd));
  while (!notes.empty()) {
    const auto note = notes.substr(0, notes.find("\\n"));  // a line break as the file has it
    notes.remove_prefix(std::min(note.size() + 2, notes.size()));
    const auto name = note.substr(0, note.find('_'));
    const NoteKey* const known = note_key(name);
    if (known == nullptr || name.size() == note.size()) continue;
    PLUMBLINE_TRY(take({known->name, known->key, 1, KeyNote::kAlways}, name, note.substr(name.size() + 1)));
  }
  return {};
}

Status SettingsReader::take(const ArchiveKey& row, std::string_view key, std::string_view text) {
  const SettingsFile& file = kFiles[file_];
  const auto* const print = std::get_if<PrintKey>(&row.what);
  if (print != nullptr && !counts_ && row.note != KeyNote::kAlways) return {};
  const std::size_t at =
      print != nullptr ? index_of(*print) : kPrintKeyCount + static_cast<std::size_t>(std::get<ArchiveFact>(row.what));
  if (closed_[at]) return {};
  const PrintField* const field = print != nullptr ? &kPrintFields[at] : nullptr;
  const FactRange range = field == nullptr ? kFactRanges[at - kPrintKeyCount]
                                           : FactRange{at == index_of(PrintKey::kBottomLayerCount) ? 0 : field->low,
                                                       field->high, field->unit};
  const auto number = parse_setting(text, range.unit, row);
  if (number == 0.0 && print != nullptr && is_silent_at_zero(*print)) return {};
  const bool whole = field == nullptr || !is_count(*field) || (number && *number == std::floor(*number));
  if (!number || !whole || !(*number >= range.low && *number <= range.high)) {
    return telling(
        Told(PrinterCode::kArchiveValue, {}, key),
        fail(ErrorCode::kMalformed, "%.*s is '%s', allowed is %g to %g%s.\tExport it again",
             static_cast<int>(key.size()), key.data(), Quote(text).c_str(), range.low, range.high, range.unit));
  }
  std::optional<double>& to = print != nullptr ? settings_->values[at] : settings_->facts[at - kPrintKeyCount];
  if (to && *to != *number) {
    if (file.form != SettingsForm::kXml) {
      return telling(Told(PrinterCode::kArchiveValue, {}, key),
                     fail(ErrorCode::kMalformed, "%.*s is '%s', but another line says %g.\tExport it again",
                          static_cast<int>(key.size()), key.data(), Quote(text).c_str(), *to));
    }
    to.reset();  // a Creation Workshop file lists all the resins that it knows
    closed_[at] = true;
    return {};
  }
  to = number;
  if (print == nullptr) {
    const auto fact = std::get<ArchiveFact>(row.what);
    if (file.dialect == Dialect::kSl1) settings_->dialect = static_cast<std::uint8_t>(file.dialect);
    settings_->turns = settings_->turns || fact == ArchiveFact::kMirrors || fact == ArchiveFact::kMirrorX ||
                       fact == ArchiveFact::kMirrorY;
  } else if (row.note != KeyNote::kAlways) {
    settings_->dialect = static_cast<std::uint8_t>(file.dialect);
  }
  return {};
}

}  // namespace plumbline::firmware::inline archive
