#include "slicer/cloud/cloud_reader.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "slicer/cloud/thinning.hpp"
#include "slicer/reader/formats/format_probe.hpp"
#include "slicer/reader/peeked_source.hpp"
#include "slicer/reader/scan_reader.hpp"
#include "slicer/reader/view_poses.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "read";

/// Sums upper bounds of points. A point's index has 32 bits, so a file that declares more counts as 2^32.
std::optional<std::uint64_t> sum_of_bounds(std::optional<std::uint64_t> a, std::optional<std::uint64_t> b) {
  if (!a || !b) return std::nullopt;
  return *a + std::min(*b, std::uint64_t{1} << 32);
}

/// Takes room at the top of the arena when the first header arrives, and passes the points on to the thinning.
class CloudSink final : public PointSink {
 public:
  /// @param later  what the files after the first announce
  CloudSink(const CloudReadSettings& settings, RoomForPoints room, const ScanAnnouncement& later, Arena& arena)
      : settings_(settings), room_(room), later_(later), arena_(arena) {}

  /// Call before each file is read.
  void start_file(const ByteSource& source, const ScanPose& pose, const StageProgress& progress) {
    source_ = &source;
    pose_ = pose;
    progress_ = progress;
  }

  Status begin(const ScanHeader& header) override {
    if (!thinner_) PLUMBLINE_TRY(take_room(header));
    thinner_->begin(header, pose_);
    // Files are told apart: each was seen as a whole, if it doesn't say more.
    if (!header.has_views) thinner_->begin_view({});
    return {};
  }
  void begin_view(const ScanView& view) override { thinner_->begin_view(view); }
  Status take(std::span<const ScanPoint> points) override {
    const Status taken = thinner_->take(points);
    if (!taken) return tl::unexpected<Error>(taken.error().with_prefix(source_->name()));
    return taken;
  }
  bool progress(double fraction) override { return progress_.advance(fraction); }

  /// Releases the room that no point took, and everything that was only for reading.
  Expected<CloudReading> finish() {
    reading_.averaged = thinner_->points_averaged();
    reading_.cell = reading_.averaged > 0 ? thinner_->cell() : 0;
    reading_.offset = thinner_->offset();
    Cloud& cloud = reading_.cloud;
    arena_.release_top(below_cloud_);
    PLUMBLINE_TRY(cloud.give_back(arena_));
    return reading_;
  }
  CloudReading& reading() { return reading_; }

 private:
  Status take_room(const ScanHeader& header) {
    // The columns of a compressed file are released before the next file is read, so the largest counts.
    const std::uint32_t views = header.has_views ? kMaxViews : later_.most_views;
    const auto capacity = room_({.points = sum_of_bounds(later_.points, most_points(header, source_->size())),
                                 .reader_bytes = std::max(header.reader_bytes, later_.reader_bytes),
                                 .kept_bytes = later_.kept_bytes,
                                 .most_views = views,
                                 .some_in_mm = later_.some_in_mm || header.is_in_mm,
                                 .some_in_any_unit = later_.some_in_any_unit || !header.is_in_mm});
    PLUMBLINE_TRY(capacity);
    const auto cloud = Cloud::create(*capacity, arena_, true);
    PLUMBLINE_TRY(cloud);
    reading_.cloud = *cloud;
    below_cloud_ = arena_.top_mark();
    const auto table = arena_.take_top<std::byte>(PointThinner::table_bytes(*capacity), kStage);
    PLUMBLINE_TRY(table);
    const double cell = header.is_in_mm ? settings_.first_cell_mm : settings_.first_cell;
    thinner_.emplace(reading_.cloud, *capacity, *table, settings_.rotation, cell);
    return {};
  }

  const CloudReadSettings& settings_;
  RoomForPoints room_;
  ScanAnnouncement later_;
  Arena& arena_;
  const ByteSource* source_ = nullptr;  ///< the file that is being read
  ScanPose pose_;                       ///< of that file, as is the progress
  StageProgress progress_;
  CloudReading reading_;
  std::size_t below_cloud_ = 0;  ///< mark of the arena
  std::optional<PointThinner> thinner_;
};

/// The files in the order in which they are read. The heads of those after the first are read ahead.
class ScanQueue {
 public:
  explicit ScanQueue(ScanSources sources) : sources_(sources) {}

  /// @param workspace  kReaderWorkspace bytes
  Expected<ScanAnnouncement> peek(std::span<std::byte> workspace, Arena& arena) {
    ScanAnnouncement later{.points = 0};
    for (std::size_t i = 1; i < sources_.size(); ++i) {
      const auto room = arena.take_bottom<std::byte>(PeekedSource::kBytes, kStage);
      PLUMBLINE_TRY(room);
      later.kept_bytes += Arena::rounded(PeekedSource::kBytes);
      peeked_[i].emplace(*sources_[i], *room);
      const auto head = peeked_[i]->peek(workspace);
      PLUMBLINE_TRY(head);
      // A file whose header could not be read ahead may hold as many points as its size allows.
      ScanHeader unknown;
      unknown.encoding = "binary";
      const ScanHeader header = head->value_or(unknown);
      later.points = sum_of_bounds(later.points, most_points(header, sources_[i]->size()));
      later.reader_bytes = std::max(later.reader_bytes, header.reader_bytes);
      // The header of an E57 is at its end.
      const bool is_in_mm = header.is_in_mm || peeked_[i]->begins_with(kE57Signature);
      if (header.has_views || !head->has_value()) later.most_views = kMaxViews;
      later.some_in_mm |= is_in_mm;
      later.some_in_any_unit |= head->has_value() && !is_in_mm;
    }
    return later;
  }
  ByteSource& operator[](std::size_t i) { return i == 0 ? *sources_[0] : static_cast<ByteSource&>(*peeked_[i]); }
  std::size_t size() const { return sources_.size(); }

  /// File i's part of the progress: its share of all bytes; of the number of files where a size is unknown.
  StageProgress part(const StageProgress& whole, std::size_t i) const {
    double before = 0;
    double all = 0;
    bool known = true;
    for (const ByteSource* source : sources_) known &= source->size().has_value();
    const auto weight = [&](std::size_t k) { return known ? static_cast<double>(*sources_[k]->size()) + 1 : 1.0; };
    for (std::size_t k = 0; k < sources_.size(); ++k) {
      if (k < i) before += weight(k);
      all += weight(k);
    }
    return whole.part(before / all, (before + weight(i)) / all);
  }

 private:
  ScanSources sources_;
  std::array<std::optional<PeekedSource>, kMostScans> peeked_;
};

/// Leaves the release of the bottom to the caller, and on error that of the top too.
Expected<CloudReading> read_all(ScanSources sources, const CloudReadSettings& settings, RoomForPoints room,
                                Arena& arena, ProgressSink* progress) {
  // The reader's workspace is at the bottom, since the size of the cloud at the top depends on the header it reads.
  const auto workspace = arena.take_bottom<std::byte>(kReaderWorkspace, kStage);
  PLUMBLINE_TRY(workspace);
  const auto poses = ViewPoses::read(sources, *workspace);
  PLUMBLINE_TRY(poses);
  ScanQueue queue(sources.first(poses->scans()));
  const auto later = queue.peek(*workspace, arena);
  PLUMBLINE_TRY(later);
  const std::size_t bottom = arena.bottom_mark();
  CloudSink sink(settings, room, *later, arena);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    sink.start_file(queue[i], poses->of(i), queue.part({progress, Stage::kRead}, i));
    const auto summary = read_scan(queue[i], sink, *workspace, &arena);
    PLUMBLINE_TRY(summary);
    arena.release_bottom(bottom);
    sink.reading().scans.add(*summary);
  }
  return sink.finish();
}

}  // namespace

std::optional<std::uint64_t> most_points(const ScanHeader& header, std::optional<std::uint64_t> file_bytes) {
  constexpr std::uint64_t kShortestRow = 6;     // "0 0 0" and the end of the line
  constexpr std::uint64_t kShortestRecord = 3;  // three numbers of one byte each
  std::optional<std::uint64_t> most;
  // A PTX and a merged PTS have a count before each of their parts, so the first one limits nothing.
  if (header.format != ScanFormat::kXyz && header.format != ScanFormat::kPtx) most = header.declared_points;
  if (!file_bytes || header.is_packed) return most;
  const bool binary = std::string_view(header.encoding).starts_with("binary");
  const std::uint64_t rows = *file_bytes / (binary ? kShortestRecord : kShortestRow) + 1;
  return std::min(most.value_or(rows), rows);
}

Expected<CloudReading> read_cloud(ScanSources sources, const CloudReadSettings& settings, RoomForPoints room,
                                  Arena& arena, ProgressSink* progress) {
  const std::size_t top = arena.top_mark();
  const std::size_t bottom = arena.bottom_mark();
  auto reading = read_all(sources, settings, room, arena, progress);
  arena.release_bottom(bottom);
  if (!reading) {
    arena.release_top(top);
    return reading;
  }
  Cloud& cloud = reading->cloud;
  if (cloud.views.count < 2 && cloud.views.scanners() == 0) cloud.set_runs();
  return reading;
}

}  // namespace plumbline::inline slicer
