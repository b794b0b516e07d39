#include "hal/thermals.hpp"

#include <algorithm>

namespace plumbline {

Expected<Celsius> Thermals::temperature(TemperatureSite site) const {
  constexpr Celsius kColdest(-30);
  constexpr Celsius kHottest(150);
  PLUMBLINE_TRY(interlock_.power());
  auto read = do_temperature(site);
  if (!read) return read;
  if (!(*read >= kColdest && *read <= kHottest)) {
    const auto where = to_string(site);
    return fail(ErrorCode::kSensorDead, "the %.*s's temperature sensor says %g degrees: check its plug",
                static_cast<int>(where.size()), where.data(), read->value());
  }
  return read;
}

Status Thermals::set_fan(Fan fan, double duty) {
  PLUMBLINE_TRY(interlock_.power());
  return do_set_fan(fan, std::clamp(duty, 0.0, 1.0));
}

}  // namespace plumbline
