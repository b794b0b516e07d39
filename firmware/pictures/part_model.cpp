#include "firmware/pictures/part_model.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "firmware/pictures/preview/preview_layout.hpp"
#include "firmware/pictures/preview/preview_section.hpp"
#include "slicer/core/bit_spans.hpp"

namespace plumbline::firmware::inline pictures {

using namespace preview;

namespace {

static_assert(std::endian::native == std::endian::little, "the model is copied into its bytes");

constexpr const char* kStage = "part model";
constexpr std::uint8_t kFull = 63;

struct Header {
  std::array<char, 4> magic = {'P', 'L', 'M', '1'};
  std::array<std::uint16_t, 3> cells{};
  std::uint16_t flags = 0;
  std::array<float, 3> low_mm{}, cell_mm{};
};
static_assert(sizeof(Header) == 36);

/// The model's cells: whole pixels and layers.
struct Cells {
  std::uint32_t columns = 0, rows = 0, layers = 0;  ///< of a cell
  std::uint32_t width = 0, depth = 0, height = 0;   ///< cells

  /// @param most  cells along the longest side
  static Cells of(const Extent& extent, const PrintGrid& grid, std::uint32_t most) {
    const std::array<std::uint32_t, 3> voxels = {extent.column_end - extent.column, extent.row_end - extent.row,
                                                 extent.layer_end - extent.layer};
    const std::array<float, 3> sizes = {grid.pitch_x_mm, grid.pitch_y_mm, grid.layer_height_mm};
    float side = 0;  // of a cell, mm
    for (std::size_t axis = 0; axis < 3; ++axis) {
      side = std::max(side, static_cast<float>(voxels[axis]) * sizes[axis] / static_cast<float>(most));
    }
    std::array<std::uint32_t, 3> of_cell{}, cells{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto least = (voxels[axis] + most - 1) / most;
      of_cell[axis] = std::max({1U, least, static_cast<std::uint32_t>(side / sizes[axis])});
      cells[axis] = (voxels[axis] + of_cell[axis] - 1) / of_cell[axis];
    }
    return {of_cell[0], of_cell[1], of_cell[2], cells[0], cells[1], cells[2]};
  }
  std::size_t a_layer() const { return std::size_t{width} * depth; }
};

/// How much of each cell of a layer of cells is solid, from runs of pixels.
class Volumes {
 public:
  static std::size_t words(const Cells& cells) { return 2 * std::size_t{cells.width + 1} * cells.depth; }

  Volumes(const Cells& cells, std::span<std::int32_t> memory)
      : cells_(cells), parts_(memory.first(memory.size() / 2)), steps_(memory.last(memory.size() / 2)) {}

  /// @param row, begin, end  pixels from the extent's corner
  void add(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
    const std::size_t line = std::size_t{row / cells_.rows} * (cells_.width + 1);
    mark(line, end, 1);
    mark(line, begin, -1);
  }
  /// Writes the shares of the layer, 0 to 63, and begins the next one.
  void finish(std::span<std::uint8_t> shares) {
    const std::int64_t whole = std::int64_t{cells_.columns} * cells_.rows * cells_.layers;
    for (std::uint32_t y = 0; y < cells_.depth; ++y) {
      const std::size_t line = std::size_t{y} * (cells_.width + 1);
      std::int64_t beyond = steps_[line + cells_.width];  // whole cells of runs that end further on
      for (std::uint32_t x = cells_.width; x-- > 0;) {
        const std::int64_t pixels = parts_[line + x] + beyond * cells_.columns;
        beyond += steps_[line + x];
        const auto share = static_cast<std::uint8_t>((pixels * kFull + whole / 2) / whole);
        shares[std::size_t{y} * cells_.width + x] = pixels <= 0       ? std::uint8_t{0}
                                                    : pixels >= whole ? kFull
                                                                      : std::clamp<std::uint8_t>(share, 1, kFull - 1);
      }
    }
    std::ranges::fill(parts_, 0);
    std::ranges::fill(steps_, 0);
  }

 private:
  /// Adds the pixels below `at`, or takes them away: part of one cell, and all of those before it.
  void mark(std::size_t line, std::uint32_t at, std::int32_t sign) {
    const std::uint32_t x = at / cells_.columns;
    parts_[line + x] += sign * static_cast<std::int32_t>(at - x * cells_.columns);
    steps_[line + x] += sign;
  }

  Cells cells_;
  std::span<std::int32_t> parts_;  ///< pixels of a cell, of runs that begin or end in it
  std::span<std::int32_t> steps_;  ///< runs that end in a cell, less those that begin there: they fill those before it
};

/// Writes runs, as long as there is room.
class RunWriter {
 public:
  explicit RunWriter(PartModel& model) : model_(model), at_(sizeof(Header)) {}

  void cells(std::span<const std::uint8_t> shares) {
    for (std::size_t i = 0; i < shares.size();) {
      const std::uint8_t share = shares[i];
      if (share != 0 && share != kFull) {
        put(share);
        ++i;
        continue;
      }
      std::size_t count = 1;
      while (i + count < shares.size() && shares[i + count] == share && count < kLongest) ++count;
      i += count;
      const bool full = share == kFull;
      if (count <= 64) {
        put((full ? 0x80U : 0x40U) | (count - 1));
      } else {
        put((full ? 0xE0U : 0xC0U) | (count - 1) >> 8U);
        put((count - 1) & 0xFFU);
      }
    }
  }
  void evidence(Evidence one) {
    if (count_ == 64 || (count_ > 0 && one != last_)) end_evidence();
    last_ = one;
    ++count_;
  }
  void end_evidence() {
    if (count_ > 0) put(static_cast<std::size_t>(last_) << 6U | (count_ - 1));
    count_ = 0;
  }
  bool is_full() const { return full_; }
  std::size_t size() const { return at_; }

 private:
  static constexpr std::size_t kLongest = 8192;
  void put(std::size_t byte) {
    full_ |= at_ == model_.memory.size();
    if (!full_) model_.memory[at_++] = static_cast<std::uint8_t>(byte);
  }

  PartModel& model_;
  std::size_t at_;
  bool full_ = false;
  Evidence last_ = Evidence::kMeasured;
  std::size_t count_ = 0;  ///< of last_
};

/// The layers of a model, from below.
class Modeller {
 public:
  Modeller(const RRep& rrep, const Supports& supports, const ConfidenceMap& map, const Extent& extent,
           std::uint32_t most)
      : rrep_(rrep), supports_(supports), map_(map), extent_(extent), cells_(Cells::of(extent, rrep.grid, most)) {}

  Status take(Arena& arena) {
    const auto words = arena.take_top<std::int32_t>(2 * Volumes::words(cells_), kStage);
    PLUMBLINE_TRY(words);
    const auto shares = arena.take_top<std::uint8_t>(4 * cells_.a_layer(), kStage);
    PLUMBLINE_TRY(shares);
    std::ranges::fill(*words, 0);
    std::ranges::fill(*shares, std::uint8_t{0});
    volumes_ = *words;
    for (std::size_t i = 0; i < 3; ++i) shares_[i] = shares->subspan(i * cells_.a_layer(), cells_.a_layer());
    of_supports_ = shares->last(cells_.a_layer());
    return {};
  }

  /// @returns false: the model has no room for it
  bool write(std::span<std::uint64_t> section_words, PartModel& model) {
    Section section(rrep_, section_words);
    Volumes object(cells_, volumes_.first(Volumes::words(cells_)));
    Volumes supports(cells_, volumes_.last(Volumes::words(cells_)));
    RunWriter out(model);
    auto& [below, now, above] = shares_;
    for (std::uint32_t z = 0; z <= cells_.height && !out.is_full(); ++z) {
      if (z < cells_.height) {
        for (std::uint32_t k = 0; k < cells_.layers; ++k) {
          fill(extent_.layer + z * cells_.layers + k, section, object, supports);
        }
        object.finish(above);
        out.cells(above);
        if (!supports_.list.empty()) {
          supports.finish(of_supports_);
          out.cells(of_supports_);
        }
      } else {
        std::ranges::fill(above, std::uint8_t{0});
      }
      if (z > 0 && !map_.empty()) write_evidence(z - 1, out);
      std::swap(below, now);
      std::swap(now, above);
    }
    if (out.is_full()) return false;
    const PrintGrid& grid = rrep_.grid;
    Header header{.cells = {static_cast<std::uint16_t>(cells_.width), static_cast<std::uint16_t>(cells_.depth),
                            static_cast<std::uint16_t>(cells_.height)},
                  .flags = static_cast<std::uint16_t>((supports_.list.empty() ? 0U : 1U) | (map_.empty() ? 0U : 2U)),
                  .low_mm = {static_cast<float>(extent_.column) * grid.pitch_x_mm,
                             static_cast<float>(extent_.row) * grid.pitch_y_mm,
                             static_cast<float>(extent_.layer) * grid.layer_height_mm},
                  .cell_mm = {static_cast<float>(cells_.columns) * grid.pitch_x_mm,
                              static_cast<float>(cells_.rows) * grid.pitch_y_mm,
                              static_cast<float>(cells_.layers) * grid.layer_height_mm}};
    std::memcpy(model.memory.data(), &header, sizeof header);
    model.size = static_cast<std::uint32_t>(out.size());
    model.box = {extent_.column, extent_.row, extent_.column_end - extent_.column, extent_.row_end - extent_.row};
    return true;
  }

 private:
  void fill(std::uint32_t layer, Section& section, Volumes& object, Volumes& supports) {
    if (layer >= extent_.layer_end) return;
    for (; done_ <= std::min(layer, rrep_.grid.layers - 1); ++done_) {
      section.advance(done_, [](std::uint32_t, std::uint32_t, bool) {});
    }
    if (layer < rrep_.grid.layers) {
      for (std::uint32_t row = extent_.row; row < extent_.row_end; ++row) {
        for_each_run(std::span<const std::uint64_t>(section.image().row(row)),
                     [&](std::uint32_t begin, std::uint32_t end) {
                       object.add(row - extent_.row, begin - extent_.column, end - extent_.column);
                     });
      }
    }
    for (const Strut& strut : supports_.list) {
      if (!strut.is_in(layer)) continue;
      for_each_span(supports_, strut, layer, rrep_.grid,
                    [&](std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
                      begin = std::max(begin, extent_.column);
                      end = std::min(end, extent_.column_end);
                      if (begin >= end || row < extent_.row || row >= extent_.row_end) return;
                      supports.add(row - extent_.row, begin - extent_.column, end - extent_.column);
                    });
    }
  }

  void write_evidence(std::uint32_t z, RunWriter& out) const {
    const auto& [below, now, above] = shares_;
    const std::uint32_t wide = cells_.width;
    const PrintGrid& grid = rrep_.grid;
    const std::uint32_t layer = std::min(extent_.layer + z * cells_.layers + cells_.layers / 2, grid.layers - 1);
    for (std::uint32_t y = 0; y < cells_.depth; ++y) {
      const std::uint32_t row = std::min(extent_.row + y * cells_.rows + cells_.rows / 2, grid.rows - 1);
      for (std::uint32_t x = 0; x < wide; ++x) {
        const std::size_t at = std::size_t{y} * wide + x;
        if (now[at] == 0) continue;
        const bool inside = now[at] == kFull && below[at] == kFull && above[at] == kFull && x > 0 && x + 1 < wide &&
                            y > 0 && y + 1 < cells_.depth && now[at - 1] == kFull && now[at + 1] == kFull &&
                            now[at - wide] == kFull && now[at + wide] == kFull;
        if (inside) continue;
        const std::uint32_t column =
            std::min(extent_.column + x * cells_.columns + cells_.columns / 2, grid.columns - 1);
        out.evidence(map_.at(column, row, layer));
      }
    }
    out.end_evidence();
  }

  const RRep& rrep_;
  const Supports& supports_;
  const ConfidenceMap& map_;
  const Extent& extent_;
  Cells cells_;
  std::uint32_t done_ = 0;                         ///< layers of the section
  std::span<std::int32_t> volumes_;                ///< of the object and of the supports
  std::array<std::span<std::uint8_t>, 3> shares_;  ///< of the layer below, the one at hand and the one above
  std::span<std::uint8_t> of_supports_;
};

}  // namespace

std::size_t part_model_bytes(const PrintGrid& grid) {
  constexpr Cells kMost{.width = PartModel::kMostCells, .depth = PartModel::kMostCells};
  return Arena::rounded(BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t)) +
         Arena::rounded(2 * Volumes::words(kMost) * sizeof(std::int32_t)) + Arena::rounded(4 * kMost.a_layer());
}

Status make_part_model(const RRep& rrep, const Supports& supports, const ConfidenceMap& map, Arena& arena,
                       PartModel& model) {
  model.clear();
  const PrintGrid& grid = rrep.grid;
  const ArenaScope scope(arena);
  const auto words = arena.take_top<std::uint64_t>(BitImage::words_needed(grid.columns, grid.rows), kStage);
  PLUMBLINE_TRY(words);
  const Extent object = find_extent(rrep, *words);
  if (object.empty()) return {};
  const Extent extent = with_supports(object, supports, grid);
  for (std::uint32_t most = PartModel::kMostCells; most >= 32; most -= most / 4) {
    const ArenaScope scratch(arena);
    Modeller modeller(rrep, supports, map, extent, most);
    PLUMBLINE_TRY(modeller.take(arena));
    if (modeller.write(*words, model)) return {};
  }
  return {};
}

}  // namespace plumbline::firmware::inline pictures
