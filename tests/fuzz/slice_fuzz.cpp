/// Slices any cloud: the R-Rep and its masks are whole and the same on a second run, or the cloud is refused in words.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/layers/morphology.hpp"
#include "slicer/slicer.hpp"
#include "tests/fuzz/cloud_input.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {
namespace {

class Bytes final : public ByteSource {
 public:
  explicit Bytes(const std::string& bytes) : bytes_(bytes), left_(bytes_) {}
  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    const std::size_t count = std::min(buffer.size(), left_.size());
    std::memcpy(buffer.data(), left_.data(), count);
    left_.remove_prefix(count);
    return count;
  }
  std::string_view name() const override { return "fuzzed.ply"; }
  std::optional<std::uint64_t> size() const override { return bytes_.size(); }

 private:
  const std::string& bytes_;
  std::string_view left_;
};

/// Checks the order of what is reported, and cancels.
class CheckingProgress final : public ProgressSink {
 public:
  explicit CheckingProgress(std::uint32_t cancel_at) : cancel_at_(cancel_at) {}
  void begin(Stage stage) override {
    require(!open_, "a stage begins within another");
    open_ = stage;
  }
  bool advance(Stage stage, double fraction) override {
    require(open_ == stage, "progress of a stage that is not open");
    require(fraction >= 0 && fraction <= 1, "a fraction is outside of 0 to 1");
    return ++calls_ != cancel_at_;
  }
  void end(Stage stage, std::size_t /*peak_bytes*/) override {
    require(open_ == stage, "another stage ends than began");
    open_.reset();
  }
  bool cancelled() const { return cancel_at_ > 0 && calls_ >= cancel_at_; }
  bool is_open() const { return open_.has_value(); }

 private:
  std::uint32_t cancel_at_;
  std::uint32_t calls_ = 0;
  std::optional<Stage> open_;
};

class Fingerprint {
 public:
  template <class T>
  void add(std::span<T> values) {
    for (const auto value : values) hash_ = mix64(hash_ + kGoldenStep64 + static_cast<std::uint64_t>(value));
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

/// Memory whose content tells whether anything is read before it is written.
std::span<std::byte> block_of(std::size_t bytes, std::byte content) {
  static std::vector<std::byte> block;
  if (block.size() < bytes) block.resize(bytes);
  std::fill_n(block.data(), bytes, content);
  return std::span(block).first(bytes);
}

/// Whether the reader may drop the point or refuse the file: it is not finite, or farther than 1e18 from the first one.
bool is_odd(const CloudPoint& p) { return !(p.at.cwiseAbs().array() < 0.5e18).all(); }

void check_error(const Error& error, const CloudInput& job, bool cancelled) {
  require(std::strlen(error.message()) > 10, "an error without a message");
  require(std::strstr(error.message(), "nan") == nullptr, "a message with a NaN");
  switch (error.code()) {
    case ErrorCode::kCancelled: require(cancelled, "cancelled, but nobody asked"); break;
    case ErrorCode::kOutOfMemory:
    case ErrorCode::kDoesNotFit:
    case ErrorCode::kNoSurface: break;
    case ErrorCode::kNoPoints:
    case ErrorCode::kMalformed:
      require(job.points.size() < job.files || std::ranges::any_of(job.points, is_odd),
              "a cloud with points in every file can't be read");
      break;
    default: require(false, "another kind of error");
  }
}

/// Every layer has its pixels in ascending order, none twice: so every ray alternates between entering and exiting.
void check_crossings(const RRep& rrep) {
  const PrintGrid& grid = rrep.grid;
  require(grid.columns >= 1 && grid.columns <= PrintGrid::kMaxSide, "columns");
  require(grid.rows >= 1 && grid.rows <= PrintGrid::kMaxSide, "rows");
  require(grid.layers >= 1 && grid.layers <= PrintGrid::kMaxLayers, "layers");
  require(rrep.first.size() == std::size_t{grid.layers} + 1, "an entry for each layer and the end");
  require(rrep.first.front() == 0 && rrep.first.back() == rrep.packed.size(), "the layers hold all crossings");
  const std::uint32_t pixels = grid.columns * grid.rows;
  const CrossingPacking packing(grid);
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    require(rrep.first[k] <= rrep.first[k + 1], "layers in order");
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      require(packing.pixel(rrep.packed[i]) < pixels, "a crossing outside of the grid");
      require(i == rrep.first[k] || packing.pixel(rrep.packed[i - 1]) < packing.pixel(rrep.packed[i]),
              "a pixel twice in a layer, or out of order");
    }
  }
}

struct Image {
  explicit Image(const PrintGrid& grid)
      : words(BitImage::words_needed(grid.columns, grid.rows)), view(words, grid.columns, grid.rows) {}
  std::vector<std::uint64_t> words;
  BitImage view;
};

/// Compares each mask with one made by toggling the crossings, and opening and closing the whole section.
/// @returns pixels of all masks
std::uint64_t check_masks(const RRep& rrep, Fingerprint& all) {
  const PrintGrid& grid = rrep.grid;
  Arena arena(block_of(LayerStream::bytes_needed(grid) + Arena::kAlignment, std::byte{0x3C}));
  auto stream = LayerStream::create(rrep, arena);
  require(stream.has_value(), "no room for a layer stream");
  const CrossingPacking packing(grid);
  Image section(grid);
  Image mask(grid);
  std::uint64_t pixels = 0;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    for (std::uint32_t i = rrep.first[k]; i < rrep.first[k + 1]; ++i) {
      const std::uint32_t column = packing.pixel(rrep.packed[i]) % grid.columns;
      section.view.row(packing.pixel(rrep.packed[i]) / grid.columns)[column / 64] ^= std::uint64_t{1} << (column % 64);
    }
    for (std::uint32_t s = 0; s < 2 * mask.view.stride(); ++s)
      open_and_close_rows(section.view, mask.view, s, 0, grid.rows);
    const ConstBitImage made = stream->mask(k);
    require(made.columns() == grid.columns && made.rows() == grid.rows, "a mask of another size");
    require(std::ranges::equal(stream->section().words(), section.words), "another section");
    require(std::ranges::equal(made.words(), mask.words), "another mask");
    for (std::uint32_t r = 0; r < grid.rows; ++r) {
      require((made.row(r).back() & ~made.last_word_mask()) == 0, "a mask outside of the grid");
    }
    pixels += made.count();
    all.add(made.words());
  }
  return pixels;
}

/// @param content  of the arena's memory before
/// @returns a number for the whole outcome
std::uint64_t run(const CloudInput& job, const std::vector<std::string>& files, std::byte content) {
  std::vector<Bytes> sources(files.begin(), files.end());
  std::vector<ByteSource*> pointers;
  for (Bytes& source : sources) pointers.push_back(&source);
  static std::vector<std::byte> memory;
  memory.assign(job.arena_bytes, content);
  Arena arena(memory, job.refused_block);
  CheckingProgress progress(job.cancel_at);
  SliceReport report;
  const auto rrep = slice(pointers, job.settings, arena, &progress, report);
  require(!progress.is_open(), "a stage did not end");
  require(arena.top_used() == 0, "scratch is left in the arena");
  require(arena.peak() <= arena.capacity(), "more than the arena");
  Fingerprint outcome;
  if (!rrep) {
    require(arena.used() == 0, "an error leaves something in the arena");
    check_error(rrep.error(), job, progress.cancelled());
    outcome.add(std::span(rrep.error().message(), std::strlen(rrep.error().message())));
    return outcome.value();
  }
  require(report.crossings == rrep->crossings(), "another number of crossings is reported");
  require(report.scan.points <= job.points.size(), "more points than there are");
  require(report.placement.grid.layers == rrep->grid.layers, "another number of layers is reported");
  require(report.placement.transform().allFinite(), "placed nowhere");
  check_crossings(*rrep);
  outcome.add(rrep->first);
  outcome.add(rrep->packed);
  const std::uint64_t pixels = check_masks(*rrep, outcome);
  if (report.object_pixels) require(*report.object_pixels == pixels, "other pixels were counted");
  return outcome.value();
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  const CloudInput job = CloudDecoder({bytes, size}).decode();
  std::vector<std::string> files;
  for (std::uint32_t file = 0; file < job.files; ++file) files.push_back(ply_of(job, file));
  const std::uint64_t first = run(job, files, std::byte{0xA5});
  require(run(job, files, std::byte{0x5A}) == first, "the second run differs");
  return 0;
}
