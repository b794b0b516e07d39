#pragma once
/// What is said to people, as a code with its values. The English sentence goes beside it; whoever shows it in another language words the code.

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <type_traits>

namespace plumbline::inline slicer {

/// Why the slicer refuses a scan. The program around it numbers its own codes from kToldCodeCount: see Extends.
enum class ToldCode : std::uint16_t {
  kNone,
  kTooWide,
  kTooDeep,
  kTooHigh,
  kTooHighOnSupports,
  kTooManyPixels,
  kTooManySupports,
  kMemoryNeeded,
  kTooSmall,
  kOnePlace,
  kBelowFloor,
  kNoTriangles,
  kSurfaceNotFound,
  kPointsOff,
  kVolumeFilled,
  kMeshChanged,
  kNotPoints,
  kNoFaces,
  kFacesBroken,
  kLaz,
  kSplatsCompressed,
  kColumnsUnclear,
  kFileEmpty,
  // Files of other kinds, by name.
  kForeignPrint,
  kForeignFilament,
  kForeignProject,
  kForeignCad,
  kForeignModel,
  kForeignScan,
  kForeignSplats,
  kPacked,
  kPicture,
  kWebPage,
  kWideText,
  // Prints, scans and meshes under names of each other.
  kSlicedPrint,
  kNotSliced,
};
inline constexpr std::size_t kToldCodeCount = static_cast<std::size_t>(ToldCode::kNotSliced) + 1;

/// A number that is told, with its unit. The program around the slicer numbers its own from kFactCount.
enum class Fact : std::uint8_t {
  kCount,
  kOf,     ///< of how many
  kLayer,  ///< as numbered in reports, from 0
  kFirstLayer,
  kLastLayer,
  kLayers,
  kFromMm,  ///< height above the plate
  kXMm,
  kYMm,
  kAreaMm2,
  kVolumeMl,
  kPercent,
  kPoints,
  kLongestMm,
  kWidthMm,
  kDepthMm,
  kHeightMm,
  kLiftMm,
  kLimitMm,
  kExcessMm,
  kCellMm,
  kPixelMm,
  kFloor,  ///< in the scan's unit
  kTurnXDeg,
  kTurnYDeg,
  kNeededMib,
  kAvailableMib,
  kNoiseMm,
  kMostScale,  ///< what would fit, as is kMostMm
  kMostMm,
};
inline constexpr std::size_t kFactCount = static_cast<std::size_t>(Fact::kMostMm) + 1;

/// True for `Base` itself, ToldCode or Fact, and for an enum of a program that continues its numbers. Such an enum declares
/// `Base extends(Own);` beside it.
template <class Own, class Base>
concept Extends = std::is_same_v<Own, Base> || requires(Own own) {
  { extends(own) } -> std::same_as<Base>;
};

/// Plain numbers and characters, so that one process can pass it to another.
struct Told {
  static constexpr std::size_t kMostFacts = 8;
  struct Number {
    template <class What, class T>
    requires(Extends<What, Fact>&& std::is_arithmetic_v<T>) Number(What what, T number)
        : fact(static_cast<Fact>(what)), value(static_cast<double>(number)) {}
    Fact fact;
    double value;
  };

  ToldCode code = ToldCode::kNone;
  std::uint8_t count = 0;
  std::array<Fact, kMostFacts> facts{};
  std::array<double, kMostFacts> values{};
  std::array<char, 40> text{};  ///< a name, which has no language; ends with NUL

  Told() = default;
  // NOLINTBEGIN(google-explicit-constructor): many codes need no numbers
  template <class Code>
  requires Extends<Code, ToldCode> Told(Code what, std::initializer_list<Number> numbers = {},
                                        std::string_view name = {})
      : code(static_cast<ToldCode>(what)) {
    for (const Number& number : numbers) add(number.fact, number.value);
    set_name(name);
  }
  // NOLINTEND(google-explicit-constructor)

  /// Adds a number; there is room for kMostFacts.
  void add(Fact fact, double value);
  bool empty() const { return code == ToldCode::kNone; }
  std::string_view name() const { return text.data(); }

 private:
  void set_name(std::string_view name);
};

}  // namespace plumbline::inline slicer
