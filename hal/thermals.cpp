#include "hal/thermals.hpp"

#include <algorithm>

namespace plumbline::inline hal {

Expected<Celsius> Thermals::temperature(TemperatureSite site) const {
  PLUMBLINE_TRY(interlock_.check_power());
  auto read = do_temperature(site);
  if (!read) return read;
  if (!(*read >= kColdestReading && *read <= kHottestReading)) {
    const auto where = to_string(site);
    return fail(ErrorCode::kSensorDead, "the %.*s temperature sensor reads %g degrees C:\tcheck its plug",
                static_cast<int>(where.size()), where.data(), read->value());
  }
  return read;
}

Status Thermals::set_fan(Fan fan, double duty) {
  PLUMBLINE_TRY(interlock_.check_power());
  return do_set_fan(fan, std::clamp(duty, 0.0, 1.0));
}

}  // namespace plumbline::inline hal
