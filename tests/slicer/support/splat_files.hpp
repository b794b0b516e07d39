#pragma once
/// Gaussian splats as PLY and SPZ.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "slicer/core/numbers/vec.hpp"
#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/deflated.hpp"

namespace plumbline::testing {

struct Splat {
  Vec3d position = Vec3d::Zero();
  double opacity = 0.9;                       ///< 0 to 1
  Vec3d radius = {0.1, 0.1, 0.001};           ///< along its own axes
  std::array<double, 4> turn = {1, 0, 0, 0};  ///< w, x, y, z
};

/// The quaternion that turns z to the direction `n`, which is not -z.
inline std::array<double, 4> turn_from_z(const Vec3d& n) {
  const double w = 1 + n[2];
  const double length = std::sqrt(w * w + n[0] * n[0] + n[1] * n[1]);
  return {w / length, -n[1] / length, n[0] / length, 0};
}

/// With the properties in the order of the reference implementation, spherical harmonics of the first degree included.
inline std::string splat_ply(const std::vector<Splat>& splats, bool ascii = false) {
  std::string out = std::string("ply\nformat ") + (ascii ? "ascii" : "binary_little_endian") + " 1.0\nelement vertex " +
                    std::to_string(splats.size()) + "\n";
  std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (int i = 0; i < 9; ++i) names.push_back("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    names.emplace_back(name);
  for (const std::string& name : names) out += "property float " + name + "\n";
  out += "end_header\n";
  for (const Splat& s : splats) {
    std::vector<double> row = {s.position[0], s.position[1], s.position[2]};
    row.resize(18, 0);
    row.push_back(std::log(s.opacity / (1 - s.opacity)));
    for (const double r : s.radius) row.push_back(std::log(r));
    for (const double q : s.turn) row.push_back(2 * q);
    for (const double value : row) {
      out += ascii ? std::to_string(value) + " " : little(static_cast<float>(value));
    }
    if (ascii) out += "\n";
  }
  return out;
}

inline std::string gzip(std::string_view bytes) { return deflated(bytes, 16 + 15); }

/// The nearest float of 16 bits, of a normal number.
inline std::uint16_t half_of_double(double v) {
  if (v == 0) return 0;
  int exponent = 0;
  const double fraction = std::frexp(std::abs(v), &exponent);  // 0.5 to 1
  const auto bits = static_cast<unsigned>(std::lround(2048 * fraction)) + static_cast<unsigned>(exponent + 13) * 1024;
  return static_cast<std::uint16_t>(bits | (v < 0 ? 0x8000U : 0U));
}

/// The bytes of an SPZ before its compression.
inline std::string plain_spz(const std::vector<Splat>& splats, std::uint32_t version, int fraction_bits = 12) {
  const auto byte = [](double value) {
    return static_cast<char>(static_cast<int>(std::clamp(std::round(value), 0.0, 255.0)));
  };
  std::string positions, opacities, colours, scales, turns;
  for (const Splat& s : splats) {
    for (const double v : s.position) {
      if (version == 1) {
        positions += little(half_of_double(v));
        continue;
      }
      positions += little(static_cast<std::int32_t>(std::round(std::ldexp(v, fraction_bits)))).substr(0, 3);
    }
    opacities += byte(s.opacity * 255);
    colours += "rgb";
    for (const double r : s.radius) scales += byte(16 * (std::log(r) + 10));
    std::array<double, 4> q = {s.turn[1], s.turn[2], s.turn[3], s.turn[0]};
    if (version != 3) {
      for (std::size_t i = 0; i < 3; ++i) turns += byte(127.5 * ((q[3] < 0 ? -q[i] : q[i]) + 1));
      continue;
    }
    std::size_t largest = 0;
    for (std::size_t i = 1; i < 4; ++i) {
      if (std::abs(q[i]) > std::abs(q[largest])) largest = i;
    }
    auto packed = static_cast<std::uint32_t>(largest);
    for (std::size_t i = 0; i < 4; ++i) {
      if (i == largest) continue;
      const auto size = static_cast<std::uint32_t>(511 * std::abs(q[i]) * std::sqrt(2.0) + 0.5);
      packed = packed << 10 | ((q[i] < 0) != (q[largest] < 0) ? 512U : 0U) | size;
    }
    turns += little(packed);
  }
  return "NGSP" +
         little(version, static_cast<std::uint32_t>(splats.size()), std::uint8_t{1},
                static_cast<std::uint8_t>(fraction_bits), std::uint8_t{0}, std::uint8_t{0}) +
         positions + opacities + colours + scales + turns + std::string(9 * splats.size(), 's');
}

}  // namespace plumbline::testing
