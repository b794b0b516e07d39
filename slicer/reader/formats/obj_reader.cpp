#include <algorithm>
#include <cassert>

#include "slicer/reader/formats/obj_lines.hpp"
#include "slicer/reader/formats/scan_formats.hpp"
#include "slicer/reader/records/record_text.hpp"

namespace plumbline::inline slicer {
namespace {

/// Assigns normals to vertices.
///
/// In OBJ, faces link normals to vertices by index. A stream can't wait for the faces, and a point cloud has none. So
/// normals are used only if the file alternates "vn v vn v" or "v vn v vn", as programs write point clouds; its first two
/// such lines decide which. Meshes have a block of `v` and a block of `vn`: their points stay without normals. Where the
/// pattern breaks later, a point without exactly one `vn` beside it gets none.
class NormalPairing {
 public:
  explicit NormalPairing(PointBatch& batch) : batch_(batch) {}

  Status vertex(const SlotValues& position) {
    switch (order_) {
      case Order::kUnknown:
        if (held_ || normals_ > 1) {
          PLUMBLINE_TRY(begin(Order::kNone));
        } else if (normals_ == 1) {
          PLUMBLINE_TRY(begin(Order::kNormalFirst));
        } else {
          break;
        }
        if (held_) PLUMBLINE_TRY(deliver());
        break;
      case Order::kVertexFirst: PLUMBLINE_TRY(deliver()); break;
      case Order::kNormalFirst:
      case Order::kNone: break;
    }
    std::copy_n(position, 3, point_ + kX);
    held_ = true;
    if (order_ == Order::kNormalFirst || order_ == Order::kNone) return deliver();
    return {};
  }

  Status normal(const SlotValues& direction) {
    if (order_ == Order::kUnknown && held_) PLUMBLINE_TRY(begin(Order::kVertexFirst));
    std::copy_n(direction, 3, point_ + kNx);
    normals_ = std::min(normals_ + 1, 2);
    return {};
  }

  Status finish() {
    if (order_ == Order::kUnknown) PLUMBLINE_TRY(begin(Order::kNone));
    return held_ ? deliver() : Status{};
  }

 private:
  enum class Order : std::uint8_t { kUnknown, kNormalFirst, kVertexFirst, kNone };

  Status begin(Order order) {
    order_ = order;
    return batch_.begin(
        {.format = ScanFormat::kObj, .encoding = "ascii", .has_normals = order != Order::kNone, .declared_points = {}});
  }

  Status deliver() {
    if (normals_ != 1) std::fill_n(point_ + kNx, 3, 0.0);
    batch_.add(point_);
    held_ = false;
    normals_ = 0;
    return batch_.full() ? batch_.flush() : Status{};
  }

  PointBatch& batch_;
  Order order_ = Order::kUnknown;
  SlotValues point_ = {};
  bool held_ = false;  ///< point_ has a position that was not delivered yet
  int normals_ = 0;    ///< found for point_: 0, 1, or 2 if more
};

class ObjReader {
 public:
  ObjReader(ByteInput& input, PointBatch& batch, std::span<char> joined) : lines_(input, joined), pairing_(batch) {
    for (const std::size_t slot : {kX, kY, kZ}) {
      [[maybe_unused]] const bool fits = three_.add_field(ScalarType::kDouble, slot);
      assert(fits);
    }
  }

  Status read() {
    const auto wanted = [](std::string_view keyword) { return keyword == "v" || keyword == "vn"; };
    for (;;) {
      const auto found = lines_.next(wanted);
      PLUMBLINE_TRY(found);
      if (!*found) return pairing_.finish();
      SlotValues row = {};
      const RowOutcome outcome = parse_row(lines_.rest(), three_, kBlanks, row);
      if (outcome.kind != RowOutcome::Kind::kWhole) return fail_row(lines_.lines(), lines_.line(), outcome);
      PLUMBLINE_TRY(lines_.keyword() == "v" ? pairing_.vertex(row) : pairing_.normal(row));
    }
  }

 private:
  ObjLines lines_;
  NormalPairing pairing_;
  RecordStep steps_[3];
  RecordLayout three_{steps_};
};

}  // namespace

Status read_obj(ByteInput& input, PointBatch& batch, Arena& memory) {
  const auto joined = memory.take_bottom<char>(ObjLines::kLongestJoined, "reading OBJ");
  PLUMBLINE_TRY(joined);
  return ObjReader(input, batch, *joined).read();
}

}  // namespace plumbline::inline slicer
