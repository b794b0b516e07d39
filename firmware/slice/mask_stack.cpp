#include "firmware/slice/mask_stack.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <utility>

#include "firmware/archive/layer_numbers.hpp"
#include "firmware/io/file_source.hpp"
#include "firmware/pictures/mask_decoder.hpp"
#include "firmware/pictures/png.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware {
namespace {

namespace fs = std::filesystem;

/// A file larger than this is no layer: 16384 x 16384 pixels of noise have 32 MiB at one bit, 256 MiB in grey.
constexpr std::uint64_t kLargestFile = std::uint64_t{512} << 20U;
/// A manifest with a hash for each of 65535 layers has 2 MB.
constexpr std::uint64_t kLargestManifest = std::uint64_t{16} << 20U;

Status read_whole(const std::string& path, std::uint64_t largest, std::vector<std::byte>& bytes) {
  auto file = FileSource::open(path);
  PLUMBLINE_TRY(file);
  if (file->size().value_or(0) > largest) {
    return fail(ErrorCode::kMalformed, "%s: has %llu bytes, %llu are allowed", path.c_str(),
                static_cast<unsigned long long>(*file->size()), static_cast<unsigned long long>(largest));
  }
  bytes.resize(static_cast<std::size_t>(file->size().value_or(0)));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const auto got = file->read(std::span(bytes).subspan(filled));
    PLUMBLINE_TRY(got);
    if (*got == 0) break;
    filled += *got;
  }
  bytes.resize(filled);
  return {};
}

/// The number after "key": and perhaps a bracket.
const char* number_after(std::string_view json, std::string_view key, double& number) {
  const std::string quoted = '"' + std::string(key) + '"';
  auto at = json.find(quoted);
  if (at == std::string_view::npos) return nullptr;
  at = json.find_first_not_of(" \t\r\n:[", at + quoted.size());
  if (at == std::string_view::npos) return nullptr;
  const auto [end, error] = std::from_chars(json.data() + at, json.data() + json.size(), number);
  return error == std::errc() ? end : nullptr;
}

bool plausible(double mm) { return mm >= 0.001 && mm <= 10; }

}  // namespace

std::optional<StackScale> scale_in_manifest(std::string_view json) {
  StackScale scale;
  const char* const after = number_after(json, "pixel_pitch_mm", scale.pitch_x_mm);
  if (after == nullptr || number_after(json, "layer_height_mm", scale.layer_height_mm) == nullptr) return std::nullopt;
  scale.pitch_y_mm = scale.pitch_x_mm;
  const std::string_view rest = json.substr(static_cast<std::size_t>(after - json.data()));
  const auto next = rest.find_first_not_of(" \t\r\n");
  if (next != std::string_view::npos && rest[next] == ',') {
    const auto second = rest.find_first_not_of(" \t\r\n", next + 1);
    if (second == std::string_view::npos) return std::nullopt;
    double pitch_y = 0;
    const auto [end, error] = std::from_chars(rest.data() + second, rest.data() + rest.size(), pitch_y);
    if (error == std::errc()) scale.pitch_y_mm = pitch_y;
  }
  if (!plausible(scale.pitch_x_mm) || !plausible(scale.pitch_y_mm) || !plausible(scale.layer_height_mm))
    return std::nullopt;
  const auto printer = json.find("\"printer\"");
  scale.has_panel =
      printer == std::string_view::npos || json.substr(printer, 32).find("null") == std::string_view::npos;
  return scale;
}

Expected<MaskStack> MaskStack::open_archive(const std::string& path) {
  MaskStack stack;
  stack.file_ = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!stack.file_.is_open()) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be opened: %s", path.c_str(), std::strerror(errno));
  }
  auto archive = LayerArchive::open(stack.file_.get(), path);
  PLUMBLINE_TRY(archive);
  stack.archive_.emplace(std::move(*archive));
  stack.archive_layers_.resize(stack.archive_->layers());
  PLUMBLINE_TRY(stack.archive_->list(stack.archive_layers_));
  stack.columns_ = stack.archive_->columns();
  stack.rows_ = stack.archive_->rows();
  const ArchiveSettings& settings = stack.archive_->settings();
  const auto layer_height = settings.value(PrintKey::kLayerHeight);
  const auto width = settings.width_mm(), depth = settings.depth_mm();
  if (width && depth && layer_height) {
    stack.scale_ = {*width / stack.columns_, *depth / stack.rows_, *layer_height};
  }
  return stack;
}

void MaskStack::turn_for(std::uint32_t columns, std::uint32_t rows) {
  if (!archive_) return;
  archive_->turn_for(columns, rows);
  if (columns_ == archive_->columns()) return;
  std::swap(columns_, rows_);
  if (scale_) std::swap(scale_->pitch_x_mm, scale_->pitch_y_mm);
}

Expected<MaskStack> MaskStack::open(const std::string& path) {
  std::error_code error;
  if (is_archive_name(path) && !fs::is_directory(path, error)) return open_archive(path);
  const fs::path top(path);
  const fs::path folder = fs::is_directory(top / "layers", error) ? top / "layers" : top;
  std::vector<std::pair<std::uint64_t, std::string>> numbered;
  fs::directory_iterator entries(folder, error);
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    const std::string name = entries->path().filename().string();
    if (const auto number = number_of_layer(name)) numbered.emplace_back(*number, name);
  }
  if (error) {
    return fail(ErrorCode::kCannotOpen, "%s: cannot be listed: %s.\tName a folder of PNG files", folder.c_str(),
                error.message().c_str());
  }
  if (numbered.empty() || numbered.size() > kMostLayers) {
    return fail(
        ErrorCode::kNoPoints,
        "%s: has %zu PNG files with a number in their name, a stack has 1 to %u.\tName the folder of the layers",
        folder.c_str(), numbered.size(), kMostLayers);
  }
  std::sort(numbered.begin(), numbered.end());
  const auto twice = std::adjacent_find(numbered.begin(), numbered.end(),
                                        [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != numbered.end()) {
    return fail(ErrorCode::kMalformed, "%s: '%s' and '%s' have the same number.\tName a folder that holds one stack",
                folder.c_str(), twice->second.c_str(), std::next(twice)->second.c_str());
  }
  PLUMBLINE_TRY(check_none_missing(
      numbered.size(), [&](std::size_t i) { return numbered[i].first; }, folder.c_str()));
  MaskStack stack;
  for (const auto& [number, name] : numbered) stack.files_.push_back((folder / name).string());
  PLUMBLINE_TRY(stack.load(0));
  const auto size = png_size(stack.bytes_);
  if (!size) return tl::unexpected<Error>(size.error().with_prefix(stack.files_[0]));
  stack.columns_ = size->columns;
  stack.rows_ = size->rows;
  for (const fs::path& manifest : {top / "manifest.json", folder / "manifest.json", folder / ".." / "manifest.json"}) {
    std::vector<std::byte> text;
    if (stack.scale_ || !fs::is_regular_file(manifest, error)) continue;
    if (!read_whole(manifest.string(), kLargestManifest, text)) continue;
    stack.scale_ = scale_in_manifest({reinterpret_cast<const char*>(text.data()), text.size()});
  }
  return stack;
}

Status MaskStack::load(std::uint32_t layer) { return read_whole(files_[layer], kLargestFile, bytes_); }

Status MaskStack::read(std::uint32_t layer, BitImage out) {
  if (archive_) return archive_->read(archive_layers_[layer], out, &grey_);
  PLUMBLINE_TRY(load(layer));
  const auto done = decode_mask(bytes_, out);
  if (!done) return tl::unexpected<Error>(done.error().with_prefix(files_[layer]));
  return {};
}

}  // namespace plumbline::firmware
