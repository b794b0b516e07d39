/// Finds the supports of any object of blocks and balls, draws and checks its masks: struts are on the grid, no pixel of the object is
/// lost, the memory is what was foretold, and a second run gives the same.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "slicer/checks/stack_checker.hpp"
#include "slicer/core/numbers/mix64.hpp"
#include "slicer/layers/layer_stream.hpp"
#include "slicer/supports/drawing/mask_stream.hpp"
#include "slicer/supports/support_finder.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/require.hpp"

namespace plumbline::firmware::fuzz {
namespace {

struct Job {
  PrintGrid grid;
  std::vector<bool> voxels;  ///< column + columns * (row + rows * layer)
  SupportSettings settings;
  bool is_exact = false;
  std::uint32_t most_layers = PrintGrid::kMaxLayers;
  std::size_t arena_bytes = std::size_t{48} << 20U;

  bool at(std::uint32_t column, std::uint32_t row, std::uint32_t layer) const {
    return voxels[column + std::size_t{grid.columns} * (row + std::size_t{grid.rows} * layer)];
  }
};

/// A block, a ball or noise in a part of the grid, which is added or taken away.
void add_shape(Job& job, Input& input) {
  const auto kind = input.take<std::uint8_t>();
  std::uint32_t from[3];
  std::uint32_t end[3];
  const std::uint32_t sides[3] = {job.grid.columns, job.grid.rows, job.grid.layers};
  for (int a = 0; a < 3; ++a) {
    from[a] = static_cast<std::uint32_t>(input.take<std::uint8_t>()) % sides[a];
    end[a] = std::min(sides[a], from[a] + 1 + input.take<std::uint8_t>() % sides[a]);
  }
  std::uint64_t seed = mix64(kind);
  for (std::uint32_t k = from[2]; k < end[2]; ++k) {
    for (std::uint32_t r = from[1]; r < end[1]; ++r) {
      for (std::uint32_t c = from[0]; c < end[0]; ++c) {
        const std::uint32_t place[3] = {c, r, k};
        double square = 0;
        for (int a = 0; a < 3; ++a) {
          const double x = (2.0 * place[a] + 1 - from[a] - end[a]) / (end[a] - from[a]);
          square += x * x;
        }
        const bool inside = kind % 4 < 2 || (kind % 4 == 2 ? square < 1 : mix64(seed += kGoldenStep64) % 16 < 1);
        if (inside) {
          job.voxels[c + std::size_t{job.grid.columns} * (r + std::size_t{job.grid.rows} * k)] = kind / 4 % 4 != 3;
        }
      }
    }
  }
}

Job decode(Input input) {
  constexpr float kPitches[] = {0.02F, 0.05F, 0.1F, 0.1F, 0.2F, 0.4F};
  Job job;
  const auto pitch = [&] { return kPitches[input.take<std::uint8_t>() % std::size(kPitches)]; };
  job.grid.pitch_x_mm = pitch();
  job.grid.pitch_y_mm = job.grid.pitch_x_mm;
  job.grid.layer_height_mm = pitch();
  job.grid.columns = 1 + input.take<std::uint8_t>() % 130;
  job.grid.rows = 1 + input.take<std::uint8_t>() % 70;
  job.grid.layers = 1 + input.take<std::uint8_t>() % 60;
  const auto flags = input.take<std::uint8_t>();
  if ((flags & 1U) != 0) job.grid.pitch_y_mm = pitch();
  job.is_exact = (flags & 2U) != 0;
  if (flags / 4 % 8 == 7) job.most_layers = job.grid.layers + input.take<std::uint8_t>();
  if (flags / 4 % 8 < 3) job.settings.stand = static_cast<SupportStand>(flags / 4 % 8);
  job.settings.buildplate_only = flags / 32 == 6;
  if (flags / 32 == 7) job.arena_bytes = (1 + std::size_t{input.take<std::uint8_t>()}) << 16U;
  for (unsigned changes = input.take<std::uint8_t>() % 4; changes > 0; --changes) {
    const SupportField& field = kSupportFields[input.take<std::uint8_t>() % kSupportFields.size()];
    const double before = job.settings.*field.member;
    job.settings.*field.member = field.low + (field.high - field.low) * input.take<std::uint8_t>() / 255;
    if (!check_support_settings(job.settings)) job.settings.*field.member = before;
  }
  job.voxels.resize(std::size_t{job.grid.columns} * job.grid.rows * job.grid.layers);
  for (int shapes = 0; !input.empty() && shapes < 12; ++shapes) add_shape(job, input);
  return job;
}

/// The R-Rep of the voxels at the bottom of an arena, by its definition.
RRep rrep_of(const Job& job, Arena& arena) {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> packed;
  const PrintGrid& grid = job.grid;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    first.push_back(static_cast<std::uint32_t>(packed.size()));
    for (std::uint32_t p = 0; p < grid.columns * grid.rows; ++p) {
      const std::uint32_t c = p % grid.columns;
      const std::uint32_t r = p / grid.columns;
      if (job.at(c, r, k) != (k > 0 && job.at(c, r, k - 1))) packed.push_back(CrossingPacking(grid).packed(p));
    }
  }
  first.push_back(static_cast<std::uint32_t>(packed.size()));
  RRep rrep{grid, {}, {}, job.is_exact};
  const auto first_there = arena.take_bottom<std::uint32_t>(first.size(), "fuzzing");
  const auto packed_there = arena.take_bottom<std::uint32_t>(packed.size(), "fuzzing");
  if (!first_there || !packed_there) return rrep;
  std::ranges::copy(first, first_there->begin());
  std::ranges::copy(packed, packed_there->begin());
  rrep.first = *first_there;
  rrep.packed = *packed_there;
  return rrep;
}

void check_struts(const Supports& supports, const PrintGrid& grid) {
  std::uint32_t before = 0;
  for (const Strut& strut : supports.list) {
    require(strut.first >= before, "struts out of order");
    before = strut.first;
    require(strut.first <= strut.end && strut.end <= grid.layers, "layers of a strut");
    require(std::max(strut.column0, strut.column1) < grid.columns, "a strut beside the grid");
    require(std::max(strut.row0, strut.row1) < grid.rows, "a strut in front of the grid");
    require(static_cast<unsigned>(strut.kind) < kStrutKinds, "a strut for nothing");
  }
}

/// Pixels of all masks without supports; 0 if there is no room for these.
std::uint64_t pixels_of(const RRep& rrep, Arena& arena) {
  const std::size_t mark = arena.bottom_mark();
  std::uint64_t pixels = 0;
  if (auto stream = LayerStream::create(rrep, arena)) {
    for (std::uint32_t k = 0; k < rrep.grid.layers; ++k) pixels += stream->mask(k).count();
  }
  arena.release_bottom(mark);
  return pixels;
}

std::uint64_t run(const Job& job, std::byte content) {
  static std::vector<std::byte> memory;
  memory.assign(job.arena_bytes, content);
  Arena arena(memory);
  RRep rrep = rrep_of(job, arena);
  if (rrep.first.empty()) return 0;
  const std::size_t used = arena.used();
  const std::uint64_t pixels_before = pixels_of(rrep, arena);
  const std::size_t foretold = find_supports_bytes(rrep, job.settings);
  require(foretold <= find_supports_bytes(rrep.grid), "this object needs more than any");
  arena.reset_peak();
  SupportCounts counts;
  const auto supports = find_supports(rrep, job.settings, job.most_layers, arena, nullptr, counts);
  require(arena.top_used() == 0, "scratch is left in the arena");
  require(arena.peak() <= used + foretold + Arena::kAlignment, "more memory than was foretold");
  std::uint64_t hash = kGoldenStep64;
  const auto add = [&hash](std::uint64_t value) { hash = mix64(hash + value); };
  if (!supports) {
    require(std::strlen(supports.error().message()) > 10, "an error without a message");
    const auto code = supports.error().code();
    require(code == ErrorCode::kOutOfMemory || code == ErrorCode::kDoesNotFit, "another kind of error");
    return static_cast<std::uint64_t>(code);
  }
  const PrintGrid& grid = rrep.grid;
  require(grid.layers <= job.most_layers, "more layers than the printer can print");
  require(counts.all() == supports->tips(), "another number of tips is reported");
  check_struts(*supports, grid);
  Arena rest(std::span<std::byte>(memory).subspan(arena.used()));
  if (const std::uint64_t pixels = pixels_of(rrep, rest); pixels > 0 && pixels_before > 0 && counts.lost_pixels) {
    require(pixels + *counts.lost_pixels == pixels_before, "another number of pixels was lost");
  }
  auto stream = MaskStream::create(rrep, *supports, rest, true);
  const Supports none;
  auto object = MaskStream::create(rrep, none, rest);
  auto checker = StackChecker::create(grid, {}, rest);
  if (!stream || !object || !checker) return hash;
  for (std::uint32_t k = 0; k < grid.layers; ++k) {
    const ConstBitImage mask = stream->mask(k);
    const ConstBitImage alone = object->mask(k);
    require(mask.count() - alone.count() == stream->support_pixels(), "another number of pixels was drawn");
    for (std::uint32_t r = 0; r < grid.rows; ++r) {
      for (std::size_t w = 0; w < mask.row(r).size(); ++w) {
        require((alone.row(r)[w] & ~mask.row(r)[w]) == 0, "a pixel of the object is lost");
        add(mask.row(r)[w]);
      }
      require((mask.row(r).back() & ~mask.last_word_mask()) == 0, "a pixel outside the mask");
    }
    checker->next(mask);
  }
  const StackFindings& findings = checker->finish();
  for (const IssueGroup& group : findings.groups) add(group.count + 1000003 * group.voxels);
  return hash;
}

}  // namespace
}  // namespace plumbline::firmware::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline::firmware::fuzz;
  const Job job = decode(Input({bytes, size}));
  const std::uint64_t first = run(job, std::byte{0xA5});
  require(run(job, std::byte{0x5A}) == first, "the second run differs");
  return 0;
}
