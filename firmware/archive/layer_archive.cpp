#include "firmware/archive/layer_archive.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "firmware/io/fixed_text.hpp"
#include "firmware/io/last_number.hpp"
#include "firmware/pictures/png_writer.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/printable_text.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline {
namespace {

/// More than any slicer's settings have.
constexpr std::size_t kMostSettingsBytes = 65536;

bool holds(std::string_view name, std::string_view word) {
  for (std::size_t at = 0; at + word.size() <= name.size(); ++at) {
    if (same_word(name.substr(at, word.size()), word)) return true;
  }
  return false;
}

/// The layer's number in an entry's name; none if the entry is no layer.
std::optional<std::uint64_t> layer_number(std::string_view name) {
  if (!has_ending(name, ".png")) return std::nullopt;
  const auto slash = name.rfind('/');
  const auto file = slash == std::string_view::npos ? name : name.substr(slash + 1);
  // macOS adds a second, hidden file for each.
  if (file.starts_with('.') || holds(name, "thumbnail") || holds(name, "preview")) return std::nullopt;
  return last_number(file.substr(0, file.size() - 4));
}

Status decode(ZipReader& zip, const ArchiveLayer& layer, const MaskTurn& turn, BitImage out) {
  PLUMBLINE_TRY(zip.open_entry(layer.place));
  const auto bytes = [&zip](std::span<std::byte> buffer) { return zip.read(buffer); };
  auto done = decode_turned_mask(bytes, most_mask_bytes(out.columns(), out.rows()), turn, out);
  if (done || done.error().code() == ErrorCode::kCannotRead) return done;
  FixedText<300> where;
  where.add("%s: layer %llu", zip.name().c_str(), static_cast<unsigned long long>(layer.number));
  return tl::unexpected<Error>(done.error().with_prefix(where.view()));
}

}  // namespace

bool is_archive_name(std::string_view name) {
  return has_ending(name, ".sl1") || has_ending(name, ".sl1s") || has_ending(name, ".zip");
}

Expected<LayerArchive> LayerArchive::open(int file, std::string_view name) {
  auto zip = ZipReader::open(file, PrintableText(name).view());
  PLUMBLINE_TRY(zip);
  LayerArchive archive(std::move(*zip));
  std::optional<ZipPlace> first, config, prusaslicer;
  std::uint64_t least = 0;
  PLUMBLINE_TRY(archive.zip_.for_each([&](std::string_view entry, const ZipPlace& place) -> Status {
    if (same_word(entry, "config.ini")) config = place;
    if (same_word(entry, "prusaslicer.ini")) prusaslicer = place;
    const auto number = layer_number(entry);
    if (!number) return {};
    if (!first || *number < least) {
      first = place;
      least = *number;
    }
    ++archive.layers_;
    return {};
  }));
  if (archive.layers_ == 0 || archive.layers_ > PrintGrid::kMaxLayers) {
    return fail(
        ErrorCode::kNoPoints,
        "%s: has %u PNG files with a number in their name, a sliced print has 1 to %u.\tExport a print as .sl1; "
        "unpack a scan or mesh",
        archive.zip_.name().c_str(), archive.layers_, PrintGrid::kMaxLayers);
  }
  // Where both have a key, the value of the first one counts.
  if (prusaslicer) PLUMBLINE_TRY(archive.read_settings(*prusaslicer, "prusaslicer.ini"));
  if (config) PLUMBLINE_TRY(archive.read_settings(*config, "config.ini"));
  if (prusaslicer) {
    // As PrusaSlicer draws them: RasterBase.hpp, Trafo. Its first row has the largest y, and portrait mirrors x.
    const Sl1Settings& s = archive.settings_;
    archive.turn_ = {s.portrait ? !s.mirror_x : s.mirror_x, !s.mirror_y, s.portrait};
  }
  PLUMBLINE_TRY(archive.read_size(*first));
  return archive;
}

Status LayerArchive::read_settings(const ZipPlace& place, const char* name) {
  PLUMBLINE_TRY(zip_.open_entry(place));
  std::string text(kMostSettingsBytes, '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const auto got = zip_.read(std::as_writable_bytes(std::span(text).subspan(filled)));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  const auto read = read_sl1_settings(std::string_view(text).substr(0, filled), settings_);
  if (read) return {};
  return tl::unexpected<Error>(read.error().with_prefix(zip_.name() + ": " + name));
}

Status LayerArchive::read_size(const ZipPlace& place) {
  PLUMBLINE_TRY(zip_.open_entry(place));
  std::array<std::byte, 33> head = {};  // signature and header of a PNG
  std::size_t filled = 0;
  while (filled < head.size()) {
    const auto got = zip_.read(std::span(head).subspan(filled));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  const auto size = png_size(std::span(head).first(filled));
  if (!size) return tl::unexpected<Error>(size.error().with_prefix(zip_.name() + ": the first layer"));
  columns_ = turn_.swaps ? size->rows : size->columns;
  rows_ = turn_.swaps ? size->columns : size->rows;
  return {};
}

Status LayerArchive::list(std::span<ArchiveLayer> out) {
  std::size_t count = 0;
  PLUMBLINE_TRY(zip_.for_each([&](std::string_view entry, const ZipPlace& place) -> Status {
    const auto number = layer_number(entry);
    if (number && count < out.size()) out[count++] = {place, *number, 0};
    return {};
  }));
  const auto listed = out.first(count);
  std::sort(listed.begin(), listed.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  const auto twice = std::adjacent_find(listed.begin(), listed.end(),
                                        [](const auto& a, const auto& b) { return a.number == b.number; });
  if (count != out.size() || twice != listed.end()) {
    return fail(ErrorCode::kMalformed, "%s: two layers have the number %llu.\tPack one print into one archive",
                zip_.name().c_str(), static_cast<unsigned long long>(twice != listed.end() ? twice->number : 0));
  }
  return {};
}

Status LayerArchive::read(const ArchiveLayer& layer, BitImage out) { return decode(zip_, layer, turn_, out); }

Status read_archive_layer(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn,
                          BitImage out) {
  auto zip = ZipReader::open(file, PrintableText(name).view());
  PLUMBLINE_TRY(zip);
  return decode(*zip, layer, turn, out);
}

}  // namespace plumbline
