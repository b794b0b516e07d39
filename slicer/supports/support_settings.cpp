#include "slicer/supports/support_settings.hpp"

namespace plumbline::inline slicer {

Status check_support_settings(const SupportSettings& settings) {
  for (const SupportField& field : kSupportFields) {
    const double value = settings.*field.member;
    if (value >= field.low && value <= field.high) continue;
    return fail(ErrorCode::kBadSetting, "%.*s is %g, allowed are %g to %g %.*s", static_cast<int>(field.key.size()),
                field.key.data(), value, field.low, field.high, static_cast<int>(field.unit.size()), field.unit.data());
  }
  if (settings.head_front_diameter > settings.pillar_diameter) {
    return fail(ErrorCode::kBadSetting,
                "support_head_front_diameter is %g mm, more than support_pillar_diameter with %g mm: a head narrows "
                "towards the object",
                settings.head_front_diameter, settings.pillar_diameter);
  }
  if (settings.pillar_diameter > settings.base_diameter) {
    return fail(ErrorCode::kBadSetting,
                "support_pillar_diameter is %g mm, more than support_base_diameter with %g mm: a base widens towards "
                "the plate",
                settings.pillar_diameter, settings.base_diameter);
  }
  if (settings.pad_wall_thickness > 0 &&
      settings.pad_wall_thickness > settings.base_diameter / 2 + settings.pad_brim_size) {
    return fail(
        ErrorCode::kBadSetting,
        "pad_wall_thickness is %g mm, more than half of support_base_diameter with pad_brim_size, %g mm: a raft's "
        "edge narrows towards the plate",
        settings.pad_wall_thickness, settings.base_diameter / 2 + settings.pad_brim_size);
  }
  if (settings.stand == SupportStand::kRaised && !(settings.object_elevation > 0)) {
    return fail(ErrorCode::kBadSetting, "support_stand is raised, but support_object_elevation is 0 mm");
  }
  return {};
}

}  // namespace plumbline::inline slicer
