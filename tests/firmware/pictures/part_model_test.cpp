#include "firmware/pictures/part_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <vector>

#include "tests/slicer/support/solid.hpp"

namespace plumbline::firmware {
namespace {

using namespace testing;

/// A model as whoever draws it reads it.
struct Decoded {
  std::array<std::uint16_t, 4> head{};
  std::array<float, 6> mm{};
  std::vector<std::uint8_t> object, supports, evidence;  ///< by cell; 255: not on the surface

  explicit Decoded(std::span<const std::uint8_t> bytes) {
    EXPECT_EQ(std::memcmp(bytes.data(), "PLM1", 4), 0);
    std::memcpy(head.data(), bytes.data() + 4, sizeof head);
    std::memcpy(mm.data(), bytes.data() + 12, sizeof mm);
    const auto [nx, ny, nz, flags] = head;
    const std::size_t layer = std::size_t{nx} * ny;
    supports.resize((flags & 1U) != 0 ? layer * nz : 0);
    at_ = 36;
    for (std::size_t z = 0; z <= nz; ++z) {
      if (z < nz) read_cells(bytes, layer, object);
      if (z < nz && !supports.empty()) {
        std::vector<std::uint8_t> of_layer;
        read_cells(bytes, layer, of_layer);
        std::ranges::copy(of_layer, supports.begin() + static_cast<std::ptrdiff_t>(z * layer));
      }
      if (z > 0 && (flags & 2U) != 0) read_evidence(bytes, z - 1);
    }
    EXPECT_EQ(at_, bytes.size());
  }

 private:
  void read_cells(std::span<const std::uint8_t> bytes, std::size_t layer, std::vector<std::uint8_t>& out) {
    const std::size_t end = out.size() + layer;
    while (out.size() < end) {
      const unsigned token = bytes[at_++];
      if (token < 0x40) {
        out.push_back(static_cast<std::uint8_t>(token));
      } else if (token < 0xC0) {
        out.insert(out.end(), (token & 0x3FU) + 1, token < 0x80 ? 0 : 63);
      } else {
        out.insert(out.end(), ((token & 0x1FU) << 8U | bytes[at_++]) + 1, token < 0xE0 ? 0 : 63);
      }
    }
    ASSERT_EQ(out.size(), end) << "a run ends with its layer";
  }
  void read_evidence(std::span<const std::uint8_t> bytes, std::size_t z) {
    const std::size_t nx = head[0], ny = head[1], nz = head[2];
    const auto at = [&](std::size_t x, std::size_t y, std::size_t k) {
      return x < nx && y < ny && k < nz ? object[(k * ny + y) * nx + x] : 0;
    };
    unsigned left = 0, value = 0;
    for (std::size_t y = 0; y < ny; ++y) {
      for (std::size_t x = 0; x < nx; ++x) {
        const bool inside = at(x, y, z) == 63 && at(x - 1, y, z) == 63 && at(x + 1, y, z) == 63 &&
                            at(x, y - 1, z) == 63 && at(x, y + 1, z) == 63 && at(x, y, z - 1) == 63 &&
                            at(x, y, z + 1) == 63;
        if (at(x, y, z) == 0 || inside) {
          evidence.push_back(255);
          continue;
        }
        if (left == 0) {
          value = bytes[at_] >> 6U;
          left = (bytes[at_++] & 0x3FU) + 1;
        }
        --left;
        evidence.push_back(static_cast<std::uint8_t>(value));
      }
    }
    ASSERT_EQ(left, 0U);
  }

  std::size_t at_ = 0;
};

PrintGrid grid_of(std::uint32_t columns, std::uint32_t rows, std::uint32_t layers) {
  PrintGrid grid;
  grid.columns = columns;
  grid.rows = rows;
  grid.layers = layers;
  return grid;
}

Decoded model_of(const RRep& rrep, const Supports& supports = {}, const ConfidenceMap& map = {}) {
  std::vector<std::byte> memory(part_model_bytes(rrep.grid) + Arena::kAlignment);
  Arena arena(memory);
  const auto model = std::make_unique<PartModel>();
  EXPECT_TRUE(make_part_model(rrep, supports, map, arena, *model));
  EXPECT_EQ(arena.used(), 0U);
  EXPECT_TRUE(model->there());
  return Decoded(model->bytes());
}

double sum(const std::vector<std::uint8_t>& cells) { return std::accumulate(cells.begin(), cells.end(), 0.0) / 63; }

// Cells of 1 x 1 x 1 voxels hold the print itself; larger ones its volume.
TEST(PartModel, HoldsThePrint) {
  const auto inside = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double x = c - 60.0, y = r - 50.0, z = k - 40.0;
    return x * x + y * y + z * z < 30.0 * 30.0 && !(x > 5 && y > 5) && k < 65;
  };
  const Solid solid(grid_of(140, 130, 90), inside);
  const Decoded model = model_of(solid.rrep);
  ASSERT_LE(model.head[0], 60);
  std::size_t wrong = 0;
  for (std::uint32_t z = 0; z < model.head[2]; ++z) {
    for (std::uint32_t y = 0; y < model.head[1]; ++y) {
      for (std::uint32_t x = 0; x < model.head[0]; ++x) {
        const auto voxel = [&](std::size_t axis, std::uint32_t i) {
          return static_cast<std::uint32_t>(model.mm[axis] / 0.05F + 0.5F) + i;
        };
        const std::uint8_t cell = model.object[(std::size_t{z} * model.head[1] + y) * model.head[0] + x];
        wrong += cell == (inside(voxel(0, x), voxel(1, y), voxel(2, z)) ? 63 : 0) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_FLOAT_EQ(model.mm[3], 0.05F);
  EXPECT_TRUE(model.supports.empty());
  EXPECT_TRUE(model.evidence.empty()) << "of a mesh all is known";
}

TEST(PartModel, KeepsTheVolumeInLargerCells) {
  const auto inside = [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    const double x = c - 300.0, y = r - 70.0, z = k - 60.0;
    return x * x / 25 + y * y + z * z < 58.0 * 58.0;
  };
  const Solid solid(grid_of(700, 160, 130), inside);
  double voxels = 0;
  for (std::uint32_t k = 0; k < 130; ++k) {
    for (std::uint32_t r = 0; r < 160; ++r) {
      for (std::uint32_t c = 0; c < 700; ++c) voxels += inside(c, r, k) ? 1 : 0;
    }
  }
  const Decoded model = model_of(solid.rrep);
  EXPECT_FLOAT_EQ(model.mm[3], 0.15F);
  const double of_cell = static_cast<double>(model.mm[3] * model.mm[4] * model.mm[5]) / (0.05 * 0.05 * 0.05);
  EXPECT_NEAR(sum(model.object) * of_cell / voxels, 1, 2e-3);
}

TEST(PartModel, TellsSupportsFromTheObject) {
  const Solid solid(grid_of(100, 100, 60), [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return c > 20 && c < 80 && r > 20 && r < 80 && k >= 30;
  });
  const std::vector<Strut> struts{
      {.column0 = 50, .row0 = 50, .column1 = 50, .row1 = 50, .first = 0, .end = 30, .radius0 = 500, .radius1 = 500}};
  const Supports supports{struts, PixelPitch(solid.rrep.grid)};
  const Decoded model = model_of(solid.rrep, supports);
  EXPECT_EQ(model.head[3], 1);
  EXPECT_EQ(sum(model.object), 59.0 * 59 * 30);
  EXPECT_NEAR(sum(model.supports), 3.1416 * 10 * 10 * 30, 500);
}

// A byte a cell of a surface that is rough everywhere has no room: then cells are larger.
TEST(PartModel, StaysInItsRoom) {
  const Solid solid(grid_of(300, 300, 260), [](std::uint32_t c, std::uint32_t r, std::uint32_t k) {
    return ((c / 2 * 7919U + r / 2 * 104729U + k / 2 * 1299709U) >> 3U) % 2 == 0;
  });
  const Decoded model = model_of(solid.rrep);
  EXPECT_GT(model.head[0], 32);
  EXPECT_LT(model.head[0], 256);
}

TEST(PartModel, IsLeftOutWhereTheArenaHasNoRoom) {
  const Solid solid(grid_of(100, 100, 20), [](std::uint32_t, std::uint32_t, std::uint32_t) { return true; });
  std::vector<std::byte> little(20'000);
  Arena small(little);
  const auto model = std::make_unique<PartModel>();
  EXPECT_FALSE(make_part_model(solid.rrep, {}, {}, small, *model));
  EXPECT_FALSE(model->there());
}

}  // namespace
}  // namespace plumbline::firmware
