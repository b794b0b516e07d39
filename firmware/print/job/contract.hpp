#pragma once
/// What a print will do, and who has said each value. Made once, when the masks are known and before any light: people are shown it and
/// asked about it, the print is carried out from its plan, the stored job and the report hold it.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/print/job/print_plan.hpp"
#include "firmware/settings/print_fields.hpp"
#include "firmware/slice/size_corrections.hpp"
#include "hal/units.hpp"
#include "slicer/core/print_grid.hpp"
#include "slicer/core/words/told.hpp"
#include "slicer/rrep/point_proof.hpp"

namespace plumbline::firmware {

class JsonWriter;

/// Why a print is asked about before it begins. Bits of Contract::doubts.
enum class Doubt : std::uint8_t {
  kLayerHeight,  ///< the archive does not say how high its layers are
  kExposure,     ///< nor how long they are exposed
  kPoints,       ///< more than PointProof::kMostUsual of the scan's points lie off what its masks show
  kGrey,         ///< more than kMostGrey of its pixels are grey, and the panel makes them white or black
};
inline constexpr std::size_t kDoubtCount = 4;
/// Share of an archive's pixels that may be grey without a question.
inline constexpr double kMostGrey = 0.01;

/// Stored byte for byte, so it holds no pointers.
struct Contract {
  PrintPlan plan;
  std::array<ValueSource, kPrintKeyCount> sources{};  ///< of the plan's values, by PrintKey
  bool is_archive = false;                            ///< another slicer has made the masks
  bool shows_grey = false;                            ///< the panel does
  std::uint8_t doubts = 0;                            ///< bits by Doubt
  double width_mm = 0, depth_mm = 0, height_mm = 0;   ///< of what is printed, with what holds it up
  std::array<double, 3> rotation_deg{};               ///< about x, then y, then z: as it was asked for
  bool best_way_up = false;                           ///< the printer has looked for the rotation
  SizeCorrections sizes;                              ///< of a scan; the plan's lengths are the machine's
  Grey kind = Grey::kOff;                             ///< of the grey pixels of a scan's masks
  double grey = 0;                                    ///< share of an archive's pixels above black that are not white,
  double grey_lost = 0;                               ///< and of those that become black; 0 if the panel shows grey
  PointProof proof;                                   ///< of a scan
  double resin_ml = 0;
  std::chrono::seconds time{};
  Distance cure_depth;        ///< at a normal layer's exposure, the shortest of a test
  Distance first_cure_depth;  ///< at the first layer's

  bool doubts_about(Doubt doubt) const { return (doubts >> static_cast<unsigned>(doubt) & 1U) != 0; }
};

/// @retval ErrorCode::kBadSetting  an exposure test on a panel that shows grey by several exposures
[[nodiscard]] Status check_test(const PrintPlan& plan);

/// What a contract is about, beside its profile.
struct ContractSubject {
  PrintGrid grid;
  LayerSteps steps{};                    ///< heights of the print's layers, in layers of the grid
  std::uint32_t columns = 0, rows = 0;   ///< pixels, of what is printed
  std::uint32_t left = 0;                ///< its first column
  std::uint64_t cured_pixels = 0;        ///< of all masks together
  std::uint64_t first_layer_pixels = 0;  ///< of the first one
  bool is_archive = false;
  double grey = 0, grey_lost = 0;  ///< as Contract has them for a panel without grey
  PointProof proof{};
  std::array<double, 3> rotation_deg{};
  bool best_way_up = false;
  SizeCorrections sizes{};  ///< the grid's lengths are the object's
};

/// @retval the errors of plan_print()
/// @retval ErrorCode::kBadSetting  what is printed has fewer columns than an exposure test has strips
/// @retval the errors of check_test()
[[nodiscard]] Expected<Contract> make_contract(const PrintProfile& profile, const MachineFile& machine,
                                               const ContractSubject& subject);

/// A value of the plan, in its field's unit: what is shown is read from what is carried out.
double value_of(const PrintPlan& plan, PrintKey key);

/// Writes the contract as members of the object that is open, for state and report alike. Its `values` are an array of objects: key, value,
/// unit, source, and whether a person may change it when the masks are made.
void write_contract(JsonWriter& json, const Contract& contract);

/// Says each doubt as a sentence and as a code.
/// @param name  of the archive or scan
void for_each_doubt(const Contract& contract, std::string_view name,
                    const std::function<void(const Told&, std::string_view)>& say);

/// A few lines for a log or a terminal, each value with its source: size, layers, exposures, lifts and waits.
void for_each_contract_line(const Contract& contract, const std::function<void(std::string_view)>& say);

/// "30.0 x 20.1 x 59.5 mm, 1190 layers, 12.3 ml, 185 min"
FixedText<160> size_line(const Contract& contract);

}  // namespace plumbline::firmware
