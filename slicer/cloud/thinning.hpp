#pragma once
/// Thins any number of scan points to a fixed number.

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/cell_table.hpp"
#include "slicer/reader/records/scan_pose.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline::inline slicer {

/// Averages the points in each cell of a cubic grid while they stream in. When the cloud is full, cells double in size, in
/// place, until at most kRefill of the capacity is used. The result depends only on the points and their order.
class PointThinner {
 public:
  /// Most of the capacity that may stay used after the cell has grown. A lower value would thin more than needed if the scan
  /// ends soon after; a higher one could find the cloud full again at once.
  static constexpr double kRefill = 0.9;

  /// Bytes of the table of cells for a cloud of `capacity` points.
  static std::size_t table_bytes(std::uint32_t capacity);

  /// @param cloud     empty
  /// @param capacity  most points, at most those that the cloud has room for
  /// @param table     table_bytes(capacity) bytes, aligned to 4
  /// @param rotation  from scan axes to print axes, applied to every point and normal
  /// @param cell      edge of the first cells, scan units; 0: no thinning until the cloud is full, then 1/4096 of the
  ///                  longest side, which points far away from the others don't make longer
  PointThinner(Cloud& cloud, std::uint32_t capacity, std::span<std::byte> table, const Mat3d& rotation, double cell);

  /// Call for each file before its points.
  /// @param pose  of the file
  void begin(const ScanHeader& header, const ScanPose& pose = {});
  /// Call before the points of each view. Beyond kMaxViews, a view joins the one whose scanner is nearest.
  void begin_view(const ScanView& view);
  /// @retval ErrorCode::kMalformed  a point is too far away for a float
  [[nodiscard]] Status take(std::span<const ScanPoint> points);

  double cell() const { return cell_; }                        ///< edge, scan units; 0: nothing was averaged
  std::uint64_t points_averaged() const { return averaged_; }  ///< points merged into another one
  /// Rotated scan coordinates of the cloud's origin.
  const Vec3d& offset() const { return offset_; }

 private:
  struct Key {
    std::int64_t x, y, z;
    bool operator==(const Key&) const = default;
  };
  /// A point on its way to its cell.
  struct Incoming {
    Vec3f position;
    PackedNormal normal;
    std::uint8_t view;
    Key key;             ///< of its cell, as is `hash`
    std::uint64_t hash;  ///< bits from 20 on find the slot, the highest are the tag
  };
  /// Points whose cells are fetched together: a scan in random order has each in another place of the memory, and a processor
  /// waits no longer for many of them than for one.
  static constexpr std::uint32_t kTogether = 64;

  Key key_of(const Vec3f& p) const;
  static std::uint64_t hash_of(const Key& key);
  /// The number of a new view.
  std::uint8_t number_of(const ScanView& view);
  void find_cell(Incoming& point) const;  ///< sets its key and hash
  std::uint32_t tag_of(std::uint64_t hash) const { return static_cast<std::uint32_t>(hash >> 32) & ~index_mask_; }
  std::uint32_t place_of(std::uint32_t entry) const { return (entry & index_mask_) - 1; }
  /// The slot of the cell, or the empty one where it belongs.
  std::uint32_t slot_of(const Key& key, std::uint64_t hash) const;
  void merge(std::uint32_t place, const Vec3f& p, const PackedNormal& normal);
  void add(const Incoming& point);       ///< one whose cell is found
  void add(std::span<Incoming> points);  ///< in their order, after finding their cells
  void grow_cell();

  Cloud& cloud_;
  std::uint32_t capacity_;
  /// Index + 1 of a cell's point, and the tag of the point's cell in the bits above index_mask_: of two cells that want the same
  /// slot, the tag nearly always tells which one has it, without a look at the point.
  CellTable<std::uint32_t> table_;
  std::uint32_t index_mask_;
  Mat3d rotation_;  ///< from scan axes to print axes
  ScanPose pose_;   ///< from the current file's axes to print axes
  double cell_;
  Vec3d offset_ = Vec3d::Zero();
  std::uint64_t seen_ = 0;
  std::uint64_t seen_before_ = 0;  ///< in files before this one
  std::uint64_t averaged_ = 0;
  ScanView view_;
  std::optional<std::uint8_t> view_number_;  ///< of `view_`, once it has a point: the first point sets the offset
  bool unsigned_normals_ = false;
  std::uint64_t opposite_ = 0;  ///< of these, with a normal that faces the opposite side of its cell's
};

}  // namespace plumbline::inline slicer
