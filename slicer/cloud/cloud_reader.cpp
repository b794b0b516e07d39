#include "slicer/cloud/cloud_reader.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "slicer/cloud/thinning.hpp"
#include "slicer/reader/peeked_source.hpp"
#include "slicer/reader/scan_reader.hpp"

namespace plumbline {
namespace {

constexpr const char* kStage = "read";

/// What is known of the files after the first one when that is begun.
struct LaterScans {
  std::uint64_t points = 0;        ///< at most, of all of them
  std::uint64_t reader_bytes = 0;  ///< the largest
  std::uint64_t kept_bytes = 0;    ///< of their heads
};

/// A part of the progress of reading: of file `from` to `to` of all bytes.
struct ReadShare {
  double from = 0, to = 1;
};

/// Makes room at the top of the arena when the head of the scan is known, and passes the points on to the thinning.
class AdmittingSink final : public PointSink {
 public:
  /// @param budget  bytes of the arena for all of the job, the reader's work space included
  AdmittingSink(const CloudReadSettings& settings, std::size_t budget, const LaterScans& later, Arena& arena,
                ProgressSink* progress)
      : settings_(settings), budget_(budget), later_(later), arena_(arena), progress_(progress) {}

  /// Before a file is read.
  void turn_to(const ByteSource& source, ReadShare share) {
    source_ = &source;
    share_ = share;
  }

  Status begin(const ScanHeader& header) override {
    if (thinner_) return thinner_->begin(header);
    // Files are read one after the other: the columns of one are gone before those of the next come.
    const PlanEvidence evidence{.reader_bytes = std::max(header.reader_bytes, later_.reader_bytes),
                                .kept_bytes = later_.kept_bytes,
                                .confidence = settings_.confidence};
    const auto largest = largest_plan(budget_, std::nullopt, settings_.grid, settings_.threads, evidence);
    PLUMBLINE_TRY(largest);
    reading_.room = largest->points;
    const std::uint64_t most = most_points(header, source_->size()).value_or(kMostPoints) + later_.points;
    const auto capacity = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(most, kFewestPoints, reading_.room));
    reading_.plan = plan_memory(capacity, settings_.grid, settings_.threads, evidence);
    PLUMBLINE_TRY(take_room(capacity));
    const auto table = arena_.take_top<std::byte>(PointThinner::table_bytes(capacity), kStage);
    PLUMBLINE_TRY(table);
    read_ = reading_.cloud;
    read_.position = read_.position.first(capacity);
    thinner_.emplace(read_, *table, settings_.rotation, settings_.first_cell);
    return thinner_->begin(header);
  }
  Status take(std::span<const ScanPoint> points) override {
    const Status taken = thinner_->take(points);
    if (!taken) return tl::unexpected<Error>(taken.error().with_prefix(source_->name()));
    return taken;
  }
  bool progress(double fraction) override {
    return progress_ == nullptr || progress_->advance(Stage::kRead, share_.from + (share_.to - share_.from) * fraction);
  }

  /// Gives back what the points did not take, and everything that was only for reading.
  /// @param top  mark of the arena before the room was taken
  Expected<CloudReading> finish(std::size_t top) {
    reading_.averaged = thinner_->points_averaged();
    reading_.cell = reading_.averaged > 0 ? thinner_->cell() : 0;
    reading_.offset = thinner_->offset();
    arena_.release_top(top);
    PLUMBLINE_TRY(take_room(read_.size));
    // Every block moves up or stays, the highest first, so none lands on what has still to be moved.
    const auto positions = read_.positions();
    const auto normals = read_.normal.first(read_.size);
    std::copy_backward(positions.begin(), positions.end(), reading_.cloud.position.begin() + read_.size);
    std::copy_backward(normals.begin(), normals.end(), reading_.cloud.normal.begin() + read_.size);
    reading_.cloud.size = read_.size;
    return reading_;
  }
  CloudReading& reading() { return reading_; }

 private:
  /// For so many points of the scan, and what may be added to them.
  Status take_room(std::uint32_t points) {
    points += Cloud::spare(points);
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
  LaterScans later_;
  Arena& arena_;
  ProgressSink* progress_;
  const ByteSource* source_ = nullptr;  ///< the file that is being read
  ReadShare share_;
  CloudReading reading_;
  Cloud read_;  ///< reading_.cloud, of its capacity only what is for the scan
  std::optional<PointThinner> thinner_;
};

/// Files in the order in which they are read, those after the first with their heads looked at.
class ScanQueue {
 public:
  explicit ScanQueue(ScanSources sources) : sources_(sources) {}

  /// @param workspace  kReaderWorkspace
  Expected<LaterScans> peek(std::span<std::byte> workspace, Arena& arena) {
    LaterScans later;
    for (std::size_t i = 1; i < sources_.size(); ++i) {
      const auto room = arena.take_bottom<std::byte>(PeekedSource::kBytes, kStage);
      PLUMBLINE_TRY(room);
      later.kept_bytes += Arena::rounded(PeekedSource::kBytes);
      peeked_[i].emplace(*sources_[i], *room);
      const auto head = peeked_[i]->peek(workspace);
      PLUMBLINE_TRY(head);
      // Without its head a file promises what its size has room for.
      ScanHeader unknown;
      unknown.encoding = "binary";
      const ScanHeader header = head->value_or(unknown);
      later.points +=
          std::min<std::uint64_t>(kMostPoints, most_points(header, sources_[i]->size()).value_or(kMostPoints));
      later.reader_bytes = std::max(later.reader_bytes, header.reader_bytes);
    }
    return later;
  }
  ByteSource& operator[](std::size_t i) { return i == 0 ? *sources_[0] : static_cast<ByteSource&>(*peeked_[i]); }
  std::size_t size() const { return sources_.size(); }

  /// Of all bytes, or of the files where a size is unknown.
  ReadShare share(std::size_t i) const {
    double before = 0;
    double all = 0;
    bool known = true;
    for (const ByteSource* source : sources_) known &= source->size().has_value();
    const auto weight = [&](std::size_t k) { return known ? static_cast<double>(*sources_[k]->size()) + 1 : 1.0; };
    for (std::size_t k = 0; k < sources_.size(); ++k) {
      if (k < i) before += weight(k);
      all += weight(k);
    }
    return {before / all, (before + weight(i)) / all};
  }

 private:
  ScanSources sources_;
  std::array<std::optional<PeekedSource>, kMostScans> peeked_;
};

/// Leaves what is at the bottom to the caller, and after an error what is at the top too.
Expected<CloudReading> read_all(ScanSources sources, const CloudReadSettings& settings, std::size_t budget,
                                Arena& arena, ProgressSink* progress) {
  const std::size_t top = arena.top_mark();
  // What the reader needs lies at the bottom meanwhile: how large the cloud at the top will be only its head tells.
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  ScanQueue queue(sources);
  const auto later = queue.peek(*workspace, arena);
  PLUMBLINE_TRY(later);
  const std::size_t bottom = arena.bottom_mark();
  AdmittingSink sink(settings, budget, *later, arena, progress);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    sink.turn_to(queue[i], queue.share(i));
    const auto summary = read_scan(queue[i], sink, *workspace, &arena);
    PLUMBLINE_TRY(summary);
    arena.release_bottom(bottom);
    sink.reading().scans.add(*summary);
  }
  return sink.finish(top);
}

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

Expected<CloudReading> read_cloud(ScanSources sources, const CloudReadSettings& settings, Arena& arena,
                                  ProgressSink* progress) {
  const std::size_t budget = arena.available();
  PLUMBLINE_TRY(
      largest_plan(budget, std::nullopt, settings.grid, settings.threads, {.confidence = settings.confidence}));
  const std::size_t top = arena.top_mark();
  const std::size_t bottom = arena.bottom_mark();
  auto reading = read_all(sources, settings, budget, arena, progress);
  arena.release_bottom(bottom);
  if (!reading) arena.release_top(top);
  return reading;
}

}  // namespace plumbline
