/// Embeds plumbline: the bytes of a scan in, the masks of its layers out, in an arena that the program owns.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slicer/layers/layer_stream.hpp"
#include "slicer/slicer.hpp"

namespace {

/// A scan in memory. Yours may come from a file, a socket or a scanner.
class MemorySource final : public plumbline::ByteSource {
 public:
  explicit MemorySource(std::string bytes) : bytes_(std::move(bytes)) {}
  plumbline::Expected<std::size_t> read(std::span<std::byte> buffer) override {
    const std::size_t count = std::min(buffer.size(), bytes_.size() - at_);
    std::copy_n(reinterpret_cast<const std::byte*>(bytes_.data()) + at_, count, buffer.begin());
    at_ += count;
    return count;
  }
  std::string_view name() const override { return "ball.xyz"; }  // the ending marks it as XYZ: x y z nx ny nz
  std::optional<std::uint64_t> size() const override { return bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// A ball 10 mm wide: 30,000 points on a Fibonacci spiral, with normals.
std::string scan_of_a_ball() {
  constexpr int kPoints = 30'000;
  constexpr double kRadius = 5;
  std::string scan;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1 - (2 * i + 1.0) / kPoints, r = std::sqrt(1 - z * z), angle = 2.399963 * i;
    const double x = r * std::cos(angle), y = r * std::sin(angle);
    char line[128];
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.4f %.4f %.4f\n", kRadius * x, kRadius * y, kRadius * z, x, y, z);
    scan += line;
  }
  return scan;
}

int failed(const plumbline::Error& error) {
  std::fprintf(stderr, "embed: %s\n", error.message());
  return 1;
}

}  // namespace

int main() {
  std::vector<std::byte> memory(std::size_t{32} << 20U);  // 32 MiB; the slicer takes no other memory
  plumbline::Arena arena(memory);
  plumbline::SliceSettings settings;
  settings.placement.pixel_pitch_mm = settings.placement.layer_height_mm = 0.1F;

  MemorySource source(scan_of_a_ball());
  plumbline::SliceReport report;
  const auto rrep = plumbline::slice(source, settings, arena, nullptr, report);
  if (!rrep) return failed(rrep.error());
  auto layers = plumbline::LayerStream::create(*rrep, arena);
  if (!layers) return failed(layers.error());

  std::uint64_t pixels = 0;
  for (std::uint32_t k = 0; k < rrep->grid.layers; ++k) {
    const plumbline::ConstBitImage mask = layers->mask(k);  // a bit a pixel, 1 cures: show it, light the lamp
    pixels += mask.count();
  }
  std::printf("%u layers, %.0f mm^3\n", rrep->grid.layers, static_cast<double>(pixels) * 0.1 * 0.1 * 0.1);
  return 0;
}
