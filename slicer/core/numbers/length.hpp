#pragma once
/// Lengths with their unit in the type, where they leave the stage that measured them.

namespace plumbline::inline slicer {

struct ScanUnit;    ///< a unit of the scan's own coordinates, whatever its size in mm
struct Millimetre;  ///< of the print

/// Lengths of different units are different types. Loops use the raw value, with the unit in its name or docstring.
template <class Unit>
struct Length {
  float value = 0;
};
using ScanLength = Length<ScanUnit>;
using PrintLength = Length<Millimetre>;

/// Size of a scan unit on the print. The only way from scan units to mm.
class ScanScale {
 public:
  explicit ScanScale(double mm_per_unit) : mm_per_unit_(mm_per_unit) {}
  PrintLength operator()(ScanLength length) const { return {length.value * static_cast<float>(mm_per_unit_)}; }

 private:
  double mm_per_unit_;
};

}  // namespace plumbline::inline slicer
