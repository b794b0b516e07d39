#include "firmware/sample/scan_sample.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "firmware/sample/analytic_bust.hpp"
#include "firmware/sample/counter_rng.hpp"
#include "firmware/sample/ply_writer.hpp"
#include "firmware/sample/range_image.hpp"

namespace plumbline::firmware {
namespace {

// The scanner. Lengths in mm.
constexpr double kBaseline = 90.0;           // camera to projector
constexpr double kMisalignment = 0.02;       // sigma of a view's shift, an axis
constexpr double kMisrotation = 0.0005;      // sigma of a view's rotation, radians an axis: 0.015 mm at 30 mm
constexpr double kFlying = 0.03;             // chance that a pixel beside a depth edge is a flying pixel
constexpr std::uint64_t kStrayShare = 1000;  // points for each outlier

constexpr double kCoarsePitch = 0.8;  // of the first pass, which only counts
constexpr double kMargin = 1.05;      // points aimed at for each point wanted, so that few views are scanned twice
const Vec3d kMiddle{0.0, 1.0, 30.0};

constexpr std::size_t kLowViews = 10, kHighViews = 6, kUnderViews = 6;
constexpr std::size_t kViews = kLowViews + kHighViews + kUnderViews;

Station make_view(const Vec3d& towards_camera) {
  Station view;
  view.middle = kMiddle;
  view.forward = -towards_camera;
  view.right = view.forward.cross(Vec3d{0, 0, 1}).normalized();
  view.up = view.right.cross(view.forward);
  view.eye = kMiddle - kStationDistance * view.forward;
  view.projector = view.eye + kBaseline * view.right;
  const Box3d box = bust_bounds();
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1U ? box.high.x() : box.low.x(), corner & 2U ? box.high.y() : box.low.y(),
                  corner & 4U ? box.high.z() : box.low.z()};
    const Vec3d q = p - view.eye;
    const double scale = kStationDistance / q.dot(view.forward);
    const double u = q.dot(view.right) * scale, v = q.dot(view.up) * scale;
    view.low_u = std::min(view.low_u, u);
    view.high_u = std::max(view.high_u, u);
    view.low_v = std::min(view.low_v, v);
    view.high_v = std::max(view.high_v, v);
  }
  return view;
}

/// `count` directions round the z axis, `step` being cosine and sine of the angle between two of them.
void add_ring(std::array<Station, kViews>& views, std::size_t first, std::size_t count, double cos_elevation,
              double sin_elevation, double cos_step, double sin_step) {
  // Rotated away from the symmetry plane of the plinth, so that no view mirrors another.
  double x = 0.28, y = -0.96;
  for (std::size_t i = 0; i < count; ++i) {
    views[first + i] = make_view({cos_elevation * x, cos_elevation * y, sin_elevation});
    const double next = cos_step * x - sin_step * y;
    y = sin_step * x + cos_step * y;
    x = next;
  }
}

std::array<Station, kViews> make_views(std::uint64_t seed) {
  std::array<Station, kViews> views;
  add_ring(views, 0, kLowViews, 0.93969262078590838, 0.34202014332566873, 0.80901699437494742, 0.58778525229247313);
  add_ring(views, kLowViews, kHighViews, 0.5, 0.86602540378443865, 0.5, 0.86602540378443865);
  add_ring(views, kLowViews + kHighViews, kUnderViews, 0.93969262078590838, -0.34202014332566873, 0.5,
           0.86602540378443865);
  const CounterRng rng(seed, 1);
  Vec3d mean_shift = Vec3d::Zero(), mean_rotation = Vec3d::Zero();
  for (std::size_t i = 0; i < kViews; ++i) {
    views[i].shift = kMisalignment * rng.normal3(2 * i);
    views[i].rotation = kMisrotation * rng.normal3(2 * i + 1);
    mean_shift += views[i].shift / double{kViews};
    mean_rotation += views[i].rotation / double{kViews};
  }
  // Registration spreads its error over the views, so the whole does not drift.
  for (Station& view : views) {
    view.shift -= mean_shift;
    view.rotation -= mean_rotation;
  }
  return views;
}

/// Gathers points into batches for the sink.
class Batch {
 public:
  explicit Batch(PointSink& sink) : sink_(sink) {}

  Status add(const Vec3d& p, const Vec3d& n) {
    // Round to what a file would hold. From -O2 on, GCC 12 drops the rounding of two neighbours when it vectorises them
    // (it stores the doubles unrounded), hence volatile. Remove it once the oldest compiler passes the test of the file.
    const auto rounded = [](double value) {
      const volatile float nearest = static_cast<float>(value);
      return nearest;
    };
    points_[count_++] = {rounded(p.x()), rounded(p.y()), rounded(p.z()),
                         rounded(n.x()), rounded(n.y()), rounded(n.z())};
    return count_ == points_.size() ? flush() : Status{};
  }
  Status flush() {
    const std::size_t count = count_;
    count_ = 0;
    return count == 0 ? Status{} : sink_.take(std::span(points_).first(count));
  }

 private:
  PointSink& sink_;
  std::array<ScanPoint, 512> points_;
  std::size_t count_ = 0;
};

/// Traces and selects. `from` to `to` is this image's share of the whole scan's progress.
Expected<std::size_t> look(RangeImage& image, const CounterRng& rng, PointSink& sink, double from, double to) {
  for (std::size_t row = 0; row < image.rows(); row += RangeImage::kTile) {
    const double done = static_cast<double>(row) / static_cast<double>(image.rows());
    if (!sink.progress(from + (to - from) * done)) return fail(ErrorCode::kCancelled, "the scan was cancelled");
    image.trace_band(row);
  }
  return image.select(rng);
}

/// Moves a few pixels beside depth edges to somewhere between the two surfaces: flying pixels.
double flying_range(const RangeImage& image, std::size_t pixel, const CounterRng& rng) {
  const double range = image.range(pixel);
  const std::array<std::size_t, 4> beside{pixel - 1, pixel + 1, pixel - image.columns(), pixel + image.columns()};
  for (const std::size_t other : beside) {
    if (!image.seen(other) || !image.jump(pixel, other)) continue;
    if (rng.uniform(2 * pixel) < kFlying) return range + rng.uniform(2 * pixel + 1) * (image.range(other) - range);
  }
  return range;
}

/// Emits exactly `quota` of the image's `kept` points, at random but in order (Knuth, algorithm 3.4.2 S).
Status emit(const Station& view, const RangeImage& image, std::uint64_t kept, std::uint64_t quota, std::uint64_t seed,
            std::uint64_t stream, Batch& batch) {
  const CounterRng choice(seed, stream), flight(seed, stream + 1);
  for (std::size_t j = 0; j < image.rows() && quota > 0; ++j) {
    for (std::size_t i = 0; i < image.columns() && quota > 0; ++i) {
      const std::size_t pixel = image.index(i, j);
      if (image.state(pixel) != PixelState::kKept) continue;
      const bool chosen = choice.uniform(pixel) * static_cast<double>(kept) < static_cast<double>(quota);
      --kept;
      if (!chosen) continue;
      --quota;
      const Vec3d p = view.eye + flying_range(image, pixel, flight) * image.direction(i, j);
      const Vec3d moved = p + view.rotation.cross(p - view.middle) + view.shift;
      const Vec3d n = image.normal(i, j);
      PLUMBLINE_TRY(batch.add(moved, n + view.rotation.cross(n)));
    }
  }
  return {};
}

/// Outliers: dust and reflections, in a box 1.5 times the size of the bust, not below the table.
Status emit_strays(std::uint64_t first, std::uint64_t count, std::uint64_t seed, Batch& batch) {
  const CounterRng rng(seed, 2);
  const Box3d box = bust_bounds();
  for (std::uint64_t k = first; k < first + count; ++k) {
    const Vec3d unit{rng.uniform(6 * k) - 0.5, rng.uniform(6 * k + 1) - 0.5, rng.uniform(6 * k + 2)};
    const Vec3d base{box.centre().x(), box.centre().y(), 0.0};
    const Vec3d p = base + 1.5 * box.size().cwiseProduct(unit);
    const Vec3d n{rng.uniform(6 * k + 3) - 0.5, rng.uniform(6 * k + 4) - 0.5, rng.uniform(6 * k + 3) - 0.5};
    PLUMBLINE_TRY(batch.add(p, n.normalized()));
  }
  return {};
}

Status check(const SampleSettings& settings) {
  if (settings.points < kMinSamplePoints || settings.points > kMaxSamplePoints) {
    return fail(ErrorCode::kBadSetting, "%llu sample points were asked for; %llu to %llu can be made",
                static_cast<unsigned long long>(settings.points), static_cast<unsigned long long>(kMinSamplePoints),
                static_cast<unsigned long long>(kMaxSamplePoints));
  }
  return {};
}

}  // namespace

Status scan_bust(const SampleSettings& settings, PointSink& sink) {
  PLUMBLINE_TRY(check(settings));
  PLUMBLINE_TRY(sink.begin({.format = ScanFormat::kPly,
                            .encoding = "binary little endian",
                            .has_normals = true,
                            .declared_points = settings.points}));
  const std::array<Station, kViews> views = make_views(settings.seed);
  const auto stream = [](std::size_t view, std::uint64_t use) { return 100 + 8 * std::uint64_t{view} + use; };

  // A coarse pass finds each view's share of the points and the pitch that yields it.
  constexpr double kCoarseShare = 0.1;  // of the time, at 300 000 points
  std::array<std::uint64_t, kViews + 1> before{};
  for (std::size_t v = 0; v < kViews; ++v) {
    RangeImage image(views[v], kCoarsePitch);
    const auto kept = look(image, CounterRng(settings.seed, stream(v, 0)), sink, kCoarseShare * double(v) / kViews,
                           kCoarseShare * double(v + 1) / kViews);
    PLUMBLINE_TRY(kept);
    before[v + 1] = before[v] + *kept;
  }

  const std::uint64_t strays = settings.points / kStrayShare, surface = settings.points - strays;
  Batch batch(sink);
  for (std::size_t v = 0; v < kViews; ++v) {
    const auto share = [&](std::uint64_t points, std::size_t view) { return points * before[view] / before[kViews]; };
    const std::uint64_t quota = share(surface, v + 1) - share(surface, v);
    const double coarse = static_cast<double>(before[v + 1] - before[v]);
    double pitch = kCoarsePitch * std::sqrt(coarse / (static_cast<double>(quota) * kMargin + 8.0));
    while (true) {
      RangeImage image(views[v], pitch);
      const double start = kCoarseShare + (1.0 - kCoarseShare) * double(v) / kViews;
      const auto kept = look(image, CounterRng(settings.seed, stream(v, 1)), sink, start, start + 0.9 / kViews);
      PLUMBLINE_TRY(kept);
      if (*kept < quota) {
        pitch *= 0.97;
        continue;
      }
      image.add_noise(CounterRng(settings.seed, stream(v, 2)));
      PLUMBLINE_TRY(emit(views[v], image, *kept, quota, settings.seed, stream(v, 3), batch));
      break;
    }
    const std::uint64_t first = strays * v / kViews, last = strays * (v + 1) / kViews;
    PLUMBLINE_TRY(emit_strays(first, last - first, settings.seed, batch));
  }
  PLUMBLINE_TRY(batch.flush());
  sink.progress(1.0);
  return {};
}

Status write_bust_scan(const std::string& path, const SampleSettings& settings,
                       const std::function<bool(double)>& progress) {
  class FileSink : public PointSink {
   public:
    FileSink(PlyWriter& writer, const std::function<bool(double)>& progress) : writer_(writer), progress_(progress) {}
    Status begin(const ScanHeader& /*header*/) override { return {}; }
    Status take(std::span<const ScanPoint> points) override { return writer_.write(points); }
    bool progress(double fraction) override { return !progress_ || progress_(fraction); }

   private:
    PlyWriter& writer_;
    const std::function<bool(double)>& progress_;
  };
  PLUMBLINE_TRY(check(settings));  // before an old file is replaced
  const std::string seed = "seed " + std::to_string(settings.seed) + ", 10 views at 20 degrees, 6 at 60, 6 at -20";
  const std::array<std::string_view, 4> comments{"plumbline sample: virtual structured-light scan of an analytic bust",
                                                 seed, "unit mm, z up, the underside at z = 0 was not seen",
                                                 "noise 0.02 mm in depth, 0.1 % stray points"};
  auto writer = PlyWriter::create(path, comments, settings.points);
  PLUMBLINE_TRY(writer);
  FileSink sink(*writer, progress);
  PLUMBLINE_TRY(scan_bust(settings, sink));
  return writer->close();
}

}  // namespace plumbline::firmware
