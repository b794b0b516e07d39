#include "slicer/source_checks.hpp"

#include <algorithm>

namespace plumbline::inline slicer {
namespace {

/// An object with fewer pixels along its longest side must be in another unit: nobody prints anything so small.
constexpr double kFewestPixels = 8;

}  // namespace

Status check_units(ScanSources sources, Units units, bool some_in_mm, bool some_in_any_unit) {
  if (!some_in_mm || !some_in_any_unit || units == Units::kAuto || units == Units::kMillimetres) return {};
  return fail(ErrorCode::kBadSetting,
              "%s: the E57 and 3MF files are in mm once they are read, as tables that name a unit, the others would be "
              "in %s.\tExport all files as "
              "one of these, or the others in mm, and leave out the units",
              title_of(sources).c_str(), to_string(units));
}

Expected<std::optional<Units>> check_units(ScanSources sources, Units units, const ScanSummaries& scans) {
  const auto is_in_mm = [](const ScanSummary& scan) { return scan.header.is_in_mm; };
  if (std::ranges::none_of(scans.all(), is_in_mm)) return std::nullopt;
  PLUMBLINE_TRY(check_units(sources, units, true, !std::ranges::all_of(scans.all(), is_in_mm)));
  // An E57 is in metres, so whoever asks for these means the same; a table may be in any unit.
  const bool has_table =
      std::ranges::any_of(scans.all(), [](const ScanSummary& scan) { return scan.header.format == ScanFormat::kXyz; });
  const bool ignored =
      units == Units::kCentimetres || units == Units::kInches || (units == Units::kMetres && has_table);
  return ignored ? std::optional(units) : std::nullopt;
}

PlacementSettings heed_header(const PlacementSettings& settings, const ScanHeader& header) {
  return header.is_in_mm ? settings.with_units(Units::kMillimetres) : settings;
}

Status check_extent(const Box3d& bounds, ScanSources sources) {
  if (bounds.size().maxCoeff() > 0) return {};
  return telling(Told(ToldCode::kOnePlace),
                 fail(ErrorCode::kNoSurface, "%s: all of it lies at one place, %.6g %.6g %.6g.\tExport it again",
                      title_of(sources).c_str(), bounds.low[0], bounds.low[1], bounds.low[2]));
}

Status check_no_speck(const Box3d& bounds, ScanSources sources, const PlacementSettings& settings,
                      const ScanHeader& header) {
  PLUMBLINE_TRY(check_extent(bounds, sources));
  if (settings.fit || settings.size) return {};
  const double unit_mm = millimetres_per(units_of(bounds, heed_header(settings, header)));
  const double longest = bounds.size().maxCoeff() * unit_mm * settings.scale;
  if (longest >= kFewestPixels * settings.finest_pitch_mm()) return {};
  const char* const advice = header.is_in_mm ? "Give a size or a scale" : "Check its unit, or give a size";
  return telling(
      Told(ToldCode::kTooSmall, {{Fact::kLongestMm, longest}}, header.is_in_mm ? "" : "units"),
      fail(ErrorCode::kNoSurface, "%s: the object would be %.2g mm long, less than %.0f pixels of the printer.\t%s",
           title_of(sources).c_str(), longest, kFewestPixels, advice));
}

Units units_of(const Box3d& bounds, const PlacementSettings& settings) {
  if (settings.units != Units::kAuto) return settings.units;
  return guess_units(settings.sized_extent.value_or(bounds.size()).maxCoeff());
}

}  // namespace plumbline::inline slicer
