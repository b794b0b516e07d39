#pragma once
/// Makes a point cloud and settings for slice() from the bytes of a fuzzer.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "slicer/core/numbers/mix64.hpp"
#include "slicer/core/numbers/vec.hpp"
#include "slicer/slice_settings.hpp"
#include "tests/fuzz/edits.hpp"

namespace plumbline::firmware::fuzz {

struct CloudPoint {
  Vec3d at = Vec3d::Zero();
  Vec3d normal = Vec3d::Zero();  ///< zero: unknown
};

/// A job for slice(). Small, so that an execution takes milliseconds.
struct CloudInput {
  static constexpr std::size_t kMostPoints = 300;

  std::vector<CloudPoint> points;
  bool has_normals = true;
  std::uint32_t files = 1;
  SliceSettings settings;
  std::size_t arena_bytes = 0;
  std::uint64_t refused_block = ~std::uint64_t{0};  ///< of the arena; none by default
  std::uint32_t cancel_at = 0;                      ///< call of ProgressSink::advance(); 0: never
};

/// Reads shapes from the input: each byte string is a job.
class CloudDecoder {
 public:
  explicit CloudDecoder(std::span<const std::uint8_t> bytes) : input_(bytes) {}

  CloudInput decode() {
    const auto how = byte();
    const int exponent = static_cast<int>(byte() % 61) - 30;
    const double far_away = byte() % 8 == 7 ? 1e6 : 0;
    decode_settings();
    while (!input_.empty() && job_.points.size() < CloudInput::kMostPoints) add_shape();
    job_.has_normals = how % 8 != 0;
    job_.files = 1 + (how / 8 % 4 == 3 ? 1 : 0);
    // Three of four clouds have the size of objects that people print.
    const double unit = how / 32 % 4 == 3 ? power_of_ten(exponent) : 1;
    for (CloudPoint& p : job_.points) p.at = (p.at + Vec3d::Constant(far_away)) * unit;
    choose_grid();
    return std::move(job_);
  }

 private:
  static constexpr int kMostPixels = 20;     ///< a side of the grid
  static constexpr float kPitchMm = 0.125F;  ///< of pixels

  std::uint8_t byte() { return input_.take<std::uint8_t>(); }
  double signed_byte() { return static_cast<double>(input_.take<std::int8_t>()); }
  Vec3d vector() {
    const double x = signed_byte();
    const double y = signed_byte();
    return {x, y, signed_byte()};
  }
  /// 0 to 1
  double random() { return static_cast<double>(mix64(seed_ += kGoldenStep64) >> 11U) * 0x1p-53; }
  Vec3d random_vector() {
    const double x = 2 * random() - 1;
    const double y = 2 * random() - 1;
    return {x, y, 2 * random() - 1};
  }
  Vec3d random_direction() {
    for (;;) {
      const Vec3d v = random_vector();
      const double length = v.norm();
      if (length > 0.1 && length <= 1) return v / length;
    }
  }
  static double power_of_ten(int exponent) {
    double power = 1;
    for (int i = 0; i < std::abs(exponent); ++i) power *= 10;
    return exponent < 0 ? 1 / power : power;
  }

  void decode_settings() {
    SliceSettings& settings = job_.settings;
    const auto flags = byte();
    settings.confidence = flags % 2 == 1;
    settings.keep_all = flags / 2 % 2 == 1;
    settings.base = static_cast<BaseChoice>(flags / 4 % 3);
    with_printer_ = flags / 16 % 4 == 1;
    settings.placement.fit = flags / 64 % 2 == 1;
    with_scale_ = flags / 128 == 0 || !settings.placement.fit;
    settings.placement.units = static_cast<Units>(byte() % 5);
    pixels_ = 4 + byte() % (kMostPixels - 3);
    layers_ = 4 + byte() % (kMostPixels - 3);
    const auto turn = byte();
    if (turn % 4 == 3) settings.placement.rotation_degrees = vector() * (turn / 4 % 2 == 0 ? 1.0 : 45.0);
    const auto memory = byte();
    job_.arena_bytes = std::size_t{6} << 20U;
    if (memory % 8 == 7) job_.arena_bytes = (std::size_t{memory} / 8 + 1) << 17U;  // 128 KiB to 4 MiB
    if (memory % 8 == 6) job_.refused_block = std::uint64_t{input_.take<std::uint16_t>()} % 256;
    if (memory % 8 == 5) job_.cancel_at = 1U + input_.take<std::uint16_t>() % 1024;
  }

  void add_shape() {
    const auto kind = byte();
    const auto count = std::min<std::size_t>(1 + std::size_t{byte()}, CloudInput::kMostPoints - job_.points.size());
    const auto facing = byte();
    const double noise = (facing / 16) * 0.02;
    seed_ = mix64(byte());
    const Vec3d middle = vector() * 0.1;
    const Vec3d size = vector() * 0.1;
    const std::size_t first = job_.points.size();
    const auto sides = static_cast<std::size_t>(std::sqrt(static_cast<double>(count)));
    for (std::size_t i = 0; i < count; ++i) {
      const double u = sides > 1 ? static_cast<double>(i % sides) / static_cast<double>(sides - 1) - 0.5 : 0;
      const double v = sides > 1 ? static_cast<double>(i / sides) / static_cast<double>(sides - 1) - 0.5 : 0;
      CloudPoint p{middle, {0, 0, 1}};
      switch (kind % 8) {
        case 0: {  // an ellipsoid: flat or a line where a size is 0
          p.normal = random_direction();
          p.at += p.normal.cwiseProduct(size);
          break;
        }
        case 1: {  // a box
          Vec3d q = random_vector();
          const auto side = static_cast<Eigen::Index>(i % 3);
          q[side] = q[side] < 0 ? -1 : 1;
          p.normal = Vec3d::Unit(side) * q[side];
          p.at += q.cwiseProduct(size);
          break;
        }
        case 2: p.at += Vec3d(u * size[0], v * size[1], (u + v) * size[2]); break;            // a lattice on a plane
        case 3: p.at += size * (static_cast<double>(i) / static_cast<double>(count)); break;  // a line
        case 4: break;                                                                        // one place
        case 5: p.at += random_vector().cwiseProduct(size); break;                            // a cloud
        case 6: {  // what a camera sees of a wavy surface
          const double depth = size[2] * (1 + u * u - v * v);
          p.at += Vec3d(u * size[0], v * size[1], 1) * depth;
          p.normal = Vec3d(2 * u, -2 * v, -1);
          break;
        }
        default: {  // points of the input
          if (input_.empty()) return;
          p.at = vector() * 0.1;
          p.normal = vector();
        }
      }
      p.at += noise * random_vector();
      job_.points.push_back(p);
    }
    face(std::span(job_.points).subspan(first), facing % 16);
  }

  void face(std::span<CloudPoint> points, unsigned how) {
    static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3d& normal = points[i].normal;
      switch (how) {
        case 1: normal = -normal; break;
        case 2: normal *= i % 2 == 0 ? 1 : -1; break;
        case 3: normal.setZero(); break;
        case 4: normal *= i % 3 == 0 ? 0 : 1; break;
        case 5: normal = random_direction(); break;
        case 6: normal *= 1e-30; break;
        case 7: normal *= 1e30; break;
        case 8: normal[0] = kNan; break;
        case 9: points[i].at[static_cast<Eigen::Index>(i % 3)] *= i % 64 == 0 ? 1e30 : 1; break;
        case 10: points[i].at[2] = i % 16 == 0 ? kNan : points[i].at[2]; break;
        default: break;
      }
    }
  }

  /// A scale that gives the cloud the grid asked for, if it is one that the command line takes. What then has too large a grid
  /// goes to a small printer.
  void choose_grid() {
    Box3d box;
    for (const CloudPoint& p : job_.points) {
      if (p.at.allFinite()) box.extend(p.at);
    }
    PlacementSettings& placement = job_.settings.placement;
    const double unit_mm = millimetres_per(placement.units == Units::kAuto ? Units::kInches : placement.units);
    const double longest = box.empty() ? 1 : std::max(1e-300, box.size().maxCoeff() * unit_mm);
    const double wanted = pixels_ * static_cast<double>(kPitchMm);
    placement.pixel_pitch_mm = kPitchMm;
    placement.layer_height_mm = kPitchMm * static_cast<float>(pixels_) / static_cast<float>(layers_);
    if (with_scale_) placement.scale = std::clamp(wanted / longest, 1e-6, 1e6);
    if (with_printer_ || longest * placement.scale > 4 * wanted) {
      placement.printer = PrinterVolume{.columns = static_cast<std::uint32_t>(pixels_) + 3,
                                        .rows = static_cast<std::uint32_t>(pixels_) + 5,
                                        .pitch_x_mm = kPitchMm,
                                        .pitch_y_mm = kPitchMm,
                                        .travel_mm = static_cast<float>(wanted)};
    } else {
      placement.fit = false;
    }
  }

  Input input_;
  CloudInput job_;
  std::uint64_t seed_ = 0;
  bool with_printer_ = false;
  bool with_scale_ = true;
  int pixels_ = 8;
  int layers_ = 8;
};

/// A file of the job as binary PLY: part `file` of the points, in order.
inline std::string ply_of(const CloudInput& job, std::uint32_t file) {
  const std::size_t first = job.points.size() * file / job.files;
  const std::size_t end = job.points.size() * (file + 1) / job.files;
  std::array<char, 256> header;
  std::snprintf(header.data(), header.size(),
                "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty double x\nproperty double y\n"
                "property double z\n%send_header\n",
                end - first, job.has_normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "");
  std::string bytes = header.data();
  const auto add = [&bytes](const auto& number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  for (std::size_t i = first; i < end; ++i) {
    for (int a = 0; a < 3; ++a) add(job.points[i].at[a]);
    for (int a = 0; job.has_normals && a < 3; ++a) add(static_cast<float>(job.points[i].normal[a]));
  }
  return bytes;
}

}  // namespace plumbline::firmware::fuzz
