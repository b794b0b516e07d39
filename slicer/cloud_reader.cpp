#include "slicer/cloud_reader.hpp"

#include <algorithm>
#include <string_view>

#include "slicer/reader/scan_reader.hpp"
#include "slicer/thinning.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "read";

/// Makes room at the top of the arena when the head of the scan is known, and passes the points on to the thinning.
class AdmittingSink final : public PointSink {
 public:
  /// @param budget  bytes of the arena for all of the job, the reader's work space included
  AdmittingSink(const CloudReadSettings& settings, std::size_t budget, std::optional<std::uint64_t> file_bytes,
                Arena& arena, ProgressSink* progress)
      : settings_(settings), budget_(budget), file_bytes_(file_bytes), arena_(arena), progress_(progress) {}

  Status begin(const ScanHeader& header) override {
    const auto largest =
        largest_plan(budget_, std::nullopt, settings_.grid, settings_.threads, {.reader_bytes = header.reader_bytes});
    PLUMBLINE_TRY(largest);
    reading_.room = largest->points;
    const std::uint64_t most = most_points(header, file_bytes_).value_or(kMostPoints);
    const auto capacity = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(most, kFewestPoints, reading_.room));
    reading_.plan = plan_memory(capacity, settings_.grid, settings_.threads, {.reader_bytes = header.reader_bytes});
    PLUMBLINE_TRY(take_room(capacity));
    const auto table = arena_.take_top<std::byte>(PointThinner::table_bytes(capacity), kStage);
    PLUMBLINE_TRY(table);
    thinner_.emplace(reading_.cloud, *table, settings_.rotation, settings_.first_cell);
    return thinner_->begin(header);
  }
  Status take(std::span<const ScanPoint> points) override { return thinner_->take(points); }
  bool progress(double fraction) override { return progress_ == nullptr || progress_->advance(Stage::kRead, fraction); }

  /// Gives back what the points did not take, and everything that was only for reading.
  /// @param top  mark of the arena before the room was taken
  Expected<CloudReading> finish(std::size_t top) {
    const Cloud read = reading_.cloud;
    reading_.averaged = thinner_->points_averaged();
    reading_.cell = reading_.averaged > 0 ? thinner_->cell() : 0;
    reading_.offset = thinner_->offset();
    arena_.release_top(top);
    PLUMBLINE_TRY(take_room(read.size));
    // Every block moves up or stays, the highest first, so none lands on what has still to be moved.
    const auto positions = read.positions();
    const auto normals = read.normal.first(read.size);
    std::copy_backward(positions.begin(), positions.end(), reading_.cloud.position.end());
    std::copy_backward(normals.begin(), normals.end(), reading_.cloud.normal.end());
    reading_.cloud.size = read.size;
    return reading_;
  }
  CloudReading& reading() { return reading_; }

 private:
  Status take_room(std::uint32_t points) {
    const auto nodes =
        arena_.take_top<WindingTree::Node>(settings_.winding_nodes ? WindingTree::nodes_needed(points) : 0, kStage);
    PLUMBLINE_TRY(nodes);
    reading_.winding_nodes = *nodes;
    const auto cloud = Cloud::create(points, arena_);
    PLUMBLINE_TRY(cloud);
    reading_.cloud = *cloud;
    return {};
  }

  const CloudReadSettings& settings_;
  std::size_t budget_;
  std::optional<std::uint64_t> file_bytes_;
  Arena& arena_;
  ProgressSink* progress_;
  CloudReading reading_;
  std::optional<PointThinner> thinner_;
};

}  // namespace

std::optional<std::uint64_t> most_points(const ScanHeader& header, std::optional<std::uint64_t> file_bytes) {
  constexpr std::uint64_t kShortestRow = 6;     // "0 0 0" and its end
  constexpr std::uint64_t kShortestRecord = 3;  // three numbers of a byte each
  std::optional<std::uint64_t> most;
  // A count in PTS stands before each part of a scan that was put together: more may follow.
  if (header.format == ScanFormat::kPly || header.format == ScanFormat::kPcd) most = header.declared_points;
  // A compressed block has no least size a point.
  if (!file_bytes || header.reader_bytes > 0) return most;
  const bool binary = std::string_view(header.encoding).starts_with("binary");
  const std::uint64_t rows = *file_bytes / (binary ? kShortestRecord : kShortestRow) + 1;
  return std::min(most.value_or(rows), rows);
}

Expected<CloudReading> read_cloud(ByteSource& source, const CloudReadSettings& settings, Arena& arena,
                                  ProgressSink* progress) {
  const std::size_t budget = arena.available();
  const std::size_t top = arena.top_mark();
  const std::size_t bottom = arena.bottom_mark();
  PLUMBLINE_TRY(largest_plan(budget, std::nullopt, settings.grid, settings.threads));

  // What the reader needs lies at the bottom meanwhile: how large the cloud at the top will be only its head tells.
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  AdmittingSink sink(settings, budget, source.size(), arena, progress);
  const auto summary = read_scan(source, sink, *workspace, &arena);
  arena.release_bottom(bottom);
  if (!summary) {
    arena.release_top(top);
    return tl::unexpected<Error>(summary.error());
  }
  sink.reading().scan = *summary;
  return sink.finish(top);
}

}  // namespace plumbline
