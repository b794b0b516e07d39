#pragma once
/// Any number of scan points into a fixed number of places (DESIGN 3, stage 1a).

#include <cstdint>
#include <span>

#include "slicer/cloud/cloud.hpp"
#include "slicer/core/cell_table.hpp"
#include "slicer/reader/stream/scan_point.hpp"

namespace plumbline {

/// Averages the points of each cell of a cubic grid while they stream in. When all places are taken the cell doubles, in
/// place, until at most kRefill of them are. The result depends on the order of the points and on nothing else.
class PointThinner final : public PointSink {
 public:
  /// Share of the capacity that may stay taken after the cell has grown: a scan that ends soon after loses little.
  static constexpr double kRefill = 0.9;

  /// Bytes of scratch a place of capacity, for the table of cells.
  static std::size_t table_bytes(std::uint32_t capacity);

  /// @param cloud     empty, its capacity is the budget
  /// @param table     table_bytes(cloud.capacity()) bytes, aligned to 4
  /// @param rotation  from scan axes to print axes, applied to every point and normal
  /// @param cell      first cell in scan units; 0: no thinning until the places run out, then a cell from the extent
  PointThinner(Cloud& cloud, std::span<std::byte> table, const Mat3d& rotation, double cell);

  /// Once for each file.
  Status begin(const ScanHeader& header) override;
  Status take(std::span<const ScanPoint> points) override;
  bool progress(double fraction) override;

  double cell() const { return cell_; }  ///< scan units; 0: nothing was averaged
  std::uint64_t points_seen() const { return seen_; }
  std::uint64_t points_averaged() const { return averaged_; }  ///< seen points that went into another's place
  /// Scan coordinates, rotated, of the cloud's origin.
  const Vec3d& offset() const { return offset_; }

 private:
  struct Key {
    std::int64_t x, y, z;
    bool operator==(const Key&) const = default;
  };
  Key key_of(const Vec3f& p) const;
  std::uint32_t slot_of(const Key& key) const;  ///< the slot that holds the cell, or the empty one where it would stand
  void merge(std::uint32_t place, const Vec3f& p, const PackedNormal& normal);
  void add(const Vec3f& p, const PackedNormal& normal);
  void grow_cell();

  Cloud& cloud_;
  CellTable<std::uint32_t> table_;  ///< place + 1 of a cell's point
  Mat3d rotation_;
  double cell_;
  Vec3d offset_ = Vec3d::Zero();
  std::uint64_t seen_ = 0;
  std::uint64_t seen_before_ = 0;  ///< in files before this one
  std::uint64_t averaged_ = 0;
};

}  // namespace plumbline
