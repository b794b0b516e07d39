/// Thins a hundred million points in the arena of a printer with 96 MiB (board/mono2k.toml).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "tests/slicer/support/slicing.hpp"

namespace plumbline {
namespace {

using namespace testing;

/// A sphere scanned in passes of a million points, each over the whole sphere and between the points of earlier passes.
/// Generated while it is read: a spiral from the top down, advanced by one complex multiplication a point.
class SphereStream final : public ByteSource {
 public:
  static constexpr std::uint32_t kPass = 1'000'000;

  SphereStream(std::uint32_t passes, double radius)
      : passes_(passes),
        radius_(radius),
        head_("ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(std::uint64_t{passes} * kPass) +
              "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
              "property float ny\nproperty float nz\nend_header\n") {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    std::size_t written = 0;
    while (written < buffer.size()) {
      if (ready_.empty() && !refill()) break;
      const std::size_t count = std::min(ready_.size(), buffer.size() - written);
      std::memcpy(buffer.data() + written, ready_.data(), count);
      ready_.remove_prefix(count);
      written += count;
    }
    return written;
  }
  std::string_view name() const override { return "sphere.ply"; }
  std::optional<std::uint64_t> size() const override {
    return head_.size() + std::uint64_t{passes_} * kPass * sizeof(Record);
  }

 private:
  using Record = std::array<float, 6>;

  bool refill() {
    if (!head_given_) {
      head_given_ = true;
      ready_ = head_;
      return true;
    }
    if (pass_ == passes_) return false;
    constexpr double kCosine = -0.73736887807831963;  // of the golden angle
    constexpr double kSine = 0.67549029426152362;
    if (at_ == 0) {
      const double phase = 2.0 * pass_;
      x_ = std::cos(phase);
      y_ = std::sin(phase);
    }
    for (Record& record : records_) {
      const double z = 1 - 2 * (at_ + (pass_ + 0.5) / passes_) / kPass;
      const double r = std::sqrt(std::max(0.0, 1 - z * z));
      const Vec3d n(r * x_, r * y_, z);
      for (int a = 0; a < 3; ++a) {
        record[static_cast<std::size_t>(a)] = static_cast<float>(radius_ * n[a]);
        record[static_cast<std::size_t>(a) + 3] = static_cast<float>(n[a]);
      }
      const double turned = x_ * kCosine - y_ * kSine;
      y_ = x_ * kSine + y_ * kCosine;
      x_ = turned;
      ++at_;
    }
    if (at_ == kPass) {
      at_ = 0;
      ++pass_;
    }
    ready_ = {reinterpret_cast<const char*>(records_.data()), sizeof records_};
    return true;
  }

  std::uint32_t passes_;
  double radius_;
  std::string head_;
  std::array<Record, 1000> records_{};  // a divisor of a pass
  std::string_view ready_;
  bool head_given_ = false;
  std::uint32_t pass_ = 0;
  std::uint32_t at_ = 0;
  double x_ = 0;
  double y_ = 0;
};

/// Whether both colours are within `reach` pixels.
bool at_an_edge(ConstBitImage mask, std::uint32_t column, std::uint32_t row, std::uint32_t reach) {
  bool black = false;
  bool white = false;
  for (std::uint32_t r = row - std::min(row, reach); r <= std::min(mask.rows() - 1, row + reach); ++r) {
    for (std::uint32_t c = column - std::min(column, reach); c <= std::min(mask.columns() - 1, column + reach); ++c) {
      (mask.at(c, r) ? white : black) = true;
    }
  }
  return black && white;
}

TEST(ThinningLong, AHundredMillionPointsPassThroughTheArenaOfAPrinterAndPrintTheSame) {
  SliceSettings settings = settings_with_pitch(0.05F);
  settings.placement.printer = PrinterVolume{1440, 2560, 0.04725F, 0.04725F, 160};
  constexpr double kRadius = 25;

  SphereStream many(100, kRadius);
  Slicing thinned(many, settings, 96 * kMiB);
  EXPECT_EQ(thinned.report().scan.points, 100'000'000U);
  EXPECT_LE(thinned.report().cloud_points, thinned.report().cloud_capacity);
  EXPECT_GT(thinned.report().lengths.thinning_cell.value, 0);
  EXPECT_GT(thinned.report().averaged_points, 90'000'000U);

  SphereStream few(1, kRadius);
  Slicing reference(few, settings, 512 * kMiB);
  ASSERT_LT(reference.report().averaged_points, 10'000U);

  ASSERT_EQ(thinned.grid().layers, reference.grid().layers);
  LayerStream masks = value_of(LayerStream::create(thinned.rrep(), thinned.arena()));
  LayerStream expected = value_of(LayerStream::create(reference.rrep(), reference.arena()));
  std::uint64_t different = 0;
  std::uint64_t white = 0;
  std::uint64_t beyond_the_edge = 0;
  for (std::uint32_t k = 0; k < thinned.grid().layers; ++k) {
    const ConstBitImage a = masks.mask(k);
    const ConstBitImage b = expected.mask(k);
    white += b.count();
    for (std::uint32_t r = 0; r < a.rows(); ++r) {
      for (std::uint32_t w = 0; w < a.stride(); ++w) {
        for (std::uint64_t bits = a.row(r)[w] ^ b.row(r)[w]; bits != 0; bits &= bits - 1) {
          ++different;
          beyond_the_edge += at_an_edge(b, w * 64 + static_cast<std::uint32_t>(std::countr_zero(bits)), r, 2) ? 0 : 1;
        }
      }
    }
  }
  RecordProperty("cell_um", static_cast<int>(1000 * thinned.report().lengths.thinning_cell.value));
  RecordProperty("different_pixels", std::to_string(different));
  EXPECT_GT(white, 100'000'000U);
  // A sphere's lowest and highest layers are nearly flat: a micrometre of height moves their edge by many pixels.
  EXPECT_LT(beyond_the_edge, white / 1'000'000);
  EXPECT_LT(different, white / 1000);
}

}  // namespace
}  // namespace plumbline
