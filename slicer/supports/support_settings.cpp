#include "slicer/supports/support_settings.hpp"

namespace plumbline {

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
  return {};
}

}  // namespace plumbline
