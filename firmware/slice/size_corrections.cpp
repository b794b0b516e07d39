#include "firmware/slice/size_corrections.hpp"

#include <cmath>

#include "firmware/io/text/json_writer.hpp"

namespace plumbline::firmware {

FixedText<160> SizeCorrections::text() const {
  FixedText<160> text;
  if (size != SizeCorrections().size) {
    text.add("masks %.5g, %.5g, %.5g times as large in x, y, z", size[0], size[1], size[2]);
  }
  if (std::abs(absolute_mm) > 0) {
    text.add("%soutlines moved by %+.4g mm", text.view().empty() ? "" : "; ", absolute_mm);
  }
  return text;
}

SizeCorrections corrections_of(const SliceSettings& settings) {
  const Vec3d& by = settings.placement.correction;
  return {{by[0], by[1], by[2]}, settings.absolute_correction_mm};
}

void write_corrections(JsonWriter& json, const SizeCorrections& corrections) {
  json.member("size_correction", corrections.size);
  json.member("absolute_correction_mm", corrections.absolute_mm);
}

}  // namespace plumbline::firmware
