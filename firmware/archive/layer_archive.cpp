#include "firmware/archive/layer_archive.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "firmware/archive/layer_numbers.hpp"
#include "firmware/io/scan_names.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/pictures/reduced_picture.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/reader/formats/scan_endings.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware::inline archive {
namespace {

/// No slicer writes settings this large, even G-code and .uvj, which grow by a few lines with each layer.
constexpr std::size_t kMostSettingsBytes = std::size_t{64} << 20U;

Status decode(ZipReader& zip, const ArchiveLayer& layer, const MaskTurn& turn, BitImage out, GreyShare* grey,
              GreyRuns* greys) {
  PLUMBLINE_TRY(zip.open_entry(layer.place));
  const auto bytes = [&zip](std::span<std::byte> buffer) { return zip.read(buffer); };
  auto done = decode_turned_mask(bytes, most_mask_bytes(out.columns(), out.rows()), turn, out, grey, greys);
  if (done || done.error().code() == ErrorCode::kCannotRead) return done;
  FixedText<300> where;
  where.add("%s: layer %llu", zip.name().c_str(), static_cast<unsigned long long>(layer.number));
  return tl::unexpected<Error>(done.error().with_prefix(where.view()));
}

constexpr std::size_t kProbedBytes = 4096;

/// The first bytes of a file, to be probed.
class FileHead final : public ByteSource, public ReadProgress {
 public:
  FileHead(std::span<const std::byte> head, std::uint64_t size, std::string_view name)
      : head_(head), size_(size), name_(name) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    const auto got = std::min(buffer.size(), head_.size());
    std::copy_n(head_.begin(), got, buffer.begin());
    head_ = head_.subspan(got);
    return got;
  }
  std::string_view name() const override { return name_; }
  std::optional<std::uint64_t> size() const override { return size_; }
  bool progress(double /*fraction*/) override { return true; }

 private:
  std::span<const std::byte> head_;
  std::uint64_t size_;
  std::string_view name_;
};

/// What is no zip archive, if its bytes say so.
/// @param broken  what is said otherwise
Error name_content(std::span<const std::byte> head, std::uint64_t size, std::string_view name, const Error& broken) {
  if (std::string_view(reinterpret_cast<const char*>(head.data()), head.size()).starts_with(kZipSignature))
    return broken;
  FileHead source(head, size, name);
  std::array<std::byte, kProbedBytes> window;
  ByteInput input(source, source, window);
  const auto format = probe_format(input);
  if (!format) return format.error();
  return Error::format(ErrorCode::kUnknownFormat, "%s: is a scan or mesh, no sliced print.\tGive it the ending .%s",
                       PrintableText(name).c_str(), in_lower_case(to_string(*format)).c_str())
      .tell({ToldCode::kNotSliced, {}, name});
}

}  // namespace

bool is_archive_name(std::string_view name) {
  return std::any_of(kArchiveEndings.begin(), kArchiveEndings.end(),
                     [name](std::string_view ending) { return has_ending(name, ending); });
}

Expected<LayerArchive> LayerArchive::open(int file, std::string_view name) {
  auto zip = ZipReader::open(file, PrintableText(name).view());
  if (zip || zip.error().code() != ErrorCode::kMalformed) return open(std::move(zip));
  std::array<std::byte, kProbedBytes> head;
  const ::off_t size = ::lseek(file, 0, SEEK_END);  // the child may not call stat()
  const ::ssize_t got = ::lseek(file, 0, SEEK_SET) == 0 ? ::read(file, head.data(), head.size()) : -1;
  if (got < 0 || size < got) return open(std::move(zip));
  return tl::unexpected<Error>(name_content(std::span(head).first(static_cast<std::size_t>(got)),
                                            static_cast<std::uint64_t>(size), name, zip.error()));
}

Expected<LayerArchive> LayerArchive::open(std::span<const std::byte> file, std::string_view name) {
  auto zip = ZipReader::open(file, PrintableText(name).view());
  if (zip || zip.error().code() != ErrorCode::kMalformed) return open(std::move(zip));
  const auto head = file.first(std::min(file.size(), kProbedBytes));
  return tl::unexpected<Error>(name_content(head, file.size(), name, zip.error()));
}

Expected<LayerArchive> LayerArchive::open(Expected<ZipReader> zip) {
  PLUMBLINE_TRY(zip);
  LayerArchive archive(std::move(*zip));
  std::optional<ZipPlace> first;
  std::array<std::optional<ZipPlace>, kSettingsFiles> settings;
  FixedText<64> inner;  // an archive in the archive
  bool has_model = false;
  std::uint64_t least = 0;
  PLUMBLINE_TRY(archive.zip_.for_each([&](std::string_view entry, const ZipPlace& place) -> Status {
    has_model = has_model || same_word(entry, "3D/3dmodel.model");
    const auto name = file_of_entry(entry);
    if (inner.view().empty() && is_archive_name(name)) inner.add("%s", PrintableText(name).c_str());
    // Whoever packs a folder packs its name, too.
    if (const auto file = settings_file(entry)) {
      if (settings[*file]) {
        return fail(ErrorCode::kMalformed, "%s: has two files %s.\tPack one print into one archive",
                    archive.zip_.name().c_str(), PrintableText(name).c_str());
      }
      settings[*file] = place;
    }
    if (is_thumbnail(entry) && archive.thumbnail_count_ < kMostThumbnails) {
      archive.thumbnails_[archive.thumbnail_count_++] = place;
    }
    const auto number = number_of_layer(entry);
    if (!number) return {};
    if (!first || *number < least) {
      first = place;
      least = *number;
    }
    ++archive.layers_;
    return {};
  }));
  if (archive.layers_ == 0 && has_model) {
    const auto& named = archive.zip_.name();
    return tl::unexpected<Error>(
        Error::format(ErrorCode::kNoPoints, "%s: is a mesh, no sliced print.\tGive it the ending .3mf", named.c_str())
            .tell({ToldCode::kNotSliced, {}, named.c_str()}));
  }
  if (archive.layers_ == 0 && !inner.view().empty()) {
    return telling(Told(PrinterCode::kArchiveInside, {}, inner.view()),
                   fail(ErrorCode::kNoPoints, "%s: holds %s.\tUnpack it, and print that", archive.zip_.name().c_str(),
                        inner.c_str()));
  }
  if (archive.layers_ == 0 || archive.layers_ > PrintGrid::kMaxLayers) {
    return fail(
        ErrorCode::kNoPoints,
        "%s: has %u PNG files with a number in their name, a sliced print has 1 to %u.\tExport a print as .sl1; "
        "unpack a scan or mesh to print it",
        archive.zip_.name().c_str(), archive.layers_, PrintGrid::kMaxLayers);
  }
  for (std::size_t file = 0; file < kSettingsFiles; ++file) {
    if (settings[file]) PLUMBLINE_TRY(archive.read_settings(*settings[file], file));
  }
  if (const auto done = archive.settings_.complete(); !done) {
    return tl::unexpected<Error>(done.error().with_prefix(archive.zip_.name()));
  }
  const ArchiveSettings& said = archive.settings_;
  if (const auto declared = said.layers(); declared && *declared != archive.layers_) {
    return telling(Told(PrinterCode::kArchiveCount, {{Fact::kLayers, archive.layers_}, {Fact::kOf, *declared}}),
                   fail(ErrorCode::kTruncated, "%s: declares %u layers, has %u.\tCopy or export it again",
                        archive.zip_.name().c_str(), *declared, archive.layers_));
  }
  // As PrusaSlicer draws them: RasterBase.hpp, Trafo. Its first row has the largest y, and portrait mirrors x.
  if (said.turns) {
    archive.turn_ = {said.portrait() != said.mirrors_x(), !said.mirrors_y(), said.portrait()};
  }
  const auto size = archive.read_size(*first, "the first layer");
  PLUMBLINE_TRY(size);
  archive.columns_ = archive.turn_.swaps ? size->rows : size->columns;
  archive.rows_ = archive.turn_.swaps ? size->columns : size->rows;
  return archive;
}

Status LayerArchive::read_settings(const ZipPlace& place, std::size_t file) {
  PLUMBLINE_TRY(zip_.open_entry(place));
  SettingsReader reader(file, settings_);
  std::array<std::byte, 4096> block;
  for (std::size_t read = 0;;) {
    const auto got = zip_.read(block);
    PLUMBLINE_TRY(got);
    const auto taken = *got > 0 ? reader.feed(std::span(block).first(*got)) : reader.finish();
    if (!taken) return tl::unexpected<Error>(taken.error().with_prefix(zip_.name() + ": " + settings_file_name(file)));
    if (*got == 0) return {};
    read += *got;
    if (read > kMostSettingsBytes) {
      return fail(ErrorCode::kUnsupported, "%s: its settings have more than %zu MiB.\tExport it again",
                  zip_.name().c_str(), kMostSettingsBytes >> 20U);
    }
  }
}

Expected<PngSize> LayerArchive::read_size(const ZipPlace& place, const char* what) {
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
  if (!size) return tl::unexpected<Error>(size.error().with_prefix(zip_.name() + ": " + what));
  return *size;
}

Status LayerArchive::list(std::span<ArchiveLayer> out) {
  std::size_t count = 0;
  PLUMBLINE_TRY(zip_.for_each([&](std::string_view entry, const ZipPlace& place) -> Status {
    const auto number = number_of_layer(entry);
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
  return check_none_missing(
      count, [&](std::size_t i) { return listed[i].number; }, zip_.name().c_str());
}

Status LayerArchive::read(const ArchiveLayer& layer, BitImage out, GreyShare* grey, GreyRuns* greys) {
  return decode(zip_, layer, turn_, out, grey, greys);
}

void LayerArchive::turn_for(std::uint32_t columns, std::uint32_t rows) {
  if (columns == rows || columns != rows_ || rows != columns_) return;
  turned_ = !turned_;
  turn_ = turn_.quarter();
  std::swap(columns_, rows_);
}

Expected<bool> LayerArchive::draw_thumbnail(std::span<std::uint8_t> rgb, const PngSize& wanted) {
  std::optional<ZipPlace> best;
  bool best_serves = false;
  std::uint64_t best_pixels = 0;
  for (const ZipPlace& place : std::span(thumbnails_).first(thumbnail_count_)) {
    const auto size = read_size(place, "a thumbnail");
    if (!size) continue;
    const bool serves = size->columns >= wanted.columns && size->rows >= wanted.rows;
    const std::uint64_t pixels = std::uint64_t{size->columns} * size->rows;
    const bool better = serves != best_serves ? serves : serves ? pixels < best_pixels : pixels > best_pixels;
    if (best && !better) continue;
    best = place;
    best_serves = serves;
    best_pixels = pixels;
  }
  if (!best) return false;
  PLUMBLINE_TRY(zip_.open_entry(*best));
  PLUMBLINE_TRY(decode_reduced([this](std::span<std::byte> buffer) { return zip_.read(buffer); }, rgb, wanted));
  return true;
}

Status read_archive_layer(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn,
                          BitImage out, GreyRuns* greys) {
  auto zip = ZipReader::open(file, PrintableText(name).view());
  PLUMBLINE_TRY(zip);
  return decode(*zip, layer, turn, out, nullptr, greys);
}

}  // namespace plumbline::firmware::inline archive
