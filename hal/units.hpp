#pragma once
/// Unit types that can't be mixed in sums. Positions and distances are different types, as are speeds and accelerations.
/// Times are std::chrono's.

#include <chrono>
#include <compare>
#include <cstdint>

namespace plumbline::inline hal {

/// A length along Z in whole nanometres, so that any number of layer heights adds up without rounding.
class Distance {
 public:
  constexpr Distance() = default;
  static constexpr Distance nanometres(std::int64_t count) {
    Distance distance;
    distance.nanometres_ = count;
    return distance;
  }
  /// Rounded to the nearest nanometre, halves away from zero. |value| is below 9e12 um.
  static constexpr Distance micrometres(double value) {
    return nanometres(static_cast<std::int64_t>(value * 1e3 + (value < 0 ? -0.5 : 0.5)));
  }
  /// Rounded like micrometres().
  static constexpr Distance millimetres(double value) { return micrometres(value * 1e3); }

  constexpr std::int64_t nanometres() const { return nanometres_; }
  constexpr double micrometres() const { return static_cast<double>(nanometres_) / 1e3; }
  constexpr double millimetres() const { return static_cast<double>(nanometres_) / 1e6; }

  constexpr auto operator<=>(const Distance&) const =
      default;  // NOLINT(modernize-use-nullptr): compares with literal 0
  constexpr Distance operator-() const { return nanometres(-nanometres_); }
  constexpr Distance operator+(Distance other) const { return nanometres(nanometres_ + other.nanometres_); }
  constexpr Distance operator-(Distance other) const { return nanometres(nanometres_ - other.nanometres_); }
  constexpr Distance operator*(std::int64_t times) const { return nanometres(nanometres_ * times); }

 private:
  std::int64_t nanometres_ = 0;
};

/// Height of the build plate's face above the film (the bottom of the tank): 0 where they touch, up is positive. Layer k of height
/// h is cured at (k + 1) h.
class ZPosition {
 public:
  constexpr ZPosition() = default;
  constexpr explicit ZPosition(Distance above_film) : above_film_(above_film) {}

  constexpr Distance above_film() const { return above_film_; }

  constexpr auto operator<=>(const ZPosition&) const =
      default;  // NOLINT(modernize-use-nullptr): compares with literal 0
  constexpr Distance operator-(ZPosition other) const { return above_film_ - other.above_film_; }
  constexpr ZPosition operator+(Distance up) const { return ZPosition(above_film_ + up); }
  constexpr ZPosition operator-(Distance down) const { return ZPosition(above_film_ - down); }

 private:
  Distance above_film_;
};

/// A real number whose tag names the unit.
template <class Unit>
class Quantity {
 public:
  constexpr Quantity() = default;
  constexpr explicit Quantity(double value) : value_(value) {}

  constexpr double value() const { return value_; }  ///< in the unit

  constexpr auto operator<=>(const Quantity&) const =
      default;  // NOLINT(modernize-use-nullptr): compares with literal 0
  constexpr Quantity operator+(Quantity other) const { return Quantity(value_ + other.value_); }
  constexpr Quantity operator-(Quantity other) const { return Quantity(value_ - other.value_); }
  constexpr Quantity operator*(double factor) const { return Quantity(value_ * factor); }
  constexpr double operator/(Quantity other) const { return value_ / other.value_; }

 private:
  double value_ = 0;
};

using Speed = Quantity<struct MillimetresPerSecond>;
using Acceleration = Quantity<struct MillimetresPerSecondSquared>;
using Irradiance = Quantity<struct MilliwattsPerSquareCentimetre>;
using Dose = Quantity<struct MillijoulesPerSquareCentimetre>;
using Celsius = Quantity<struct DegreesCelsius>;

/// Resin profiles give speeds in mm/min.
constexpr Speed mm_per_min(double value) { return Speed(value / 60.0); }

/// Dose of constant light: irradiance * time.
constexpr Dose dose_of(Irradiance irradiance, std::chrono::duration<double> lit) {
  return Dose(irradiance.value() * lit.count());
}

/// `using namespace plumbline::literals;` gives 50_um and 1.5_mm.
inline namespace literals {
constexpr Distance operator""_um(unsigned long long value) {
  return Distance::nanometres(static_cast<std::int64_t>(value) * 1000);
}
constexpr Distance operator""_um(long double value) { return Distance::micrometres(static_cast<double>(value)); }
constexpr Distance operator""_mm(unsigned long long value) {
  return Distance::nanometres(static_cast<std::int64_t>(value) * 1'000'000);
}
constexpr Distance operator""_mm(long double value) { return Distance::millimetres(static_cast<double>(value)); }
}  // namespace literals

}  // namespace plumbline::inline hal
