#include "firmware/settings/print_profile.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "firmware/settings/settings_file.hpp"
#include "firmware/settings/settings_folders.hpp"
#include "firmware/settings/support_choice.hpp"

namespace plumbline::firmware::inline settings {
namespace {

std::vector<SettingRule> rules_for(PrintProfile& p, SupportChoice& supports) {
  constexpr auto kOptional = Presence::kOptional;
  std::vector<SettingRule> rules = {
      {"profile", "name", TextSetting{&p.name}, 1, 63},
      {"resin", "penetration_depth", &p.penetration_depth, 0.01, 2, " mm"},
      {"resin", "critical_energy", &p.critical_energy, 0.1, 500, " mJ/cm2"},
      {"resin", "exchange", &p.exchange, 0, 1, "", kOptional},
      {"resin", "blur", &p.blur, 0, 2, " px", kOptional},
      {"resin", "material_correction_x", &p.material_correction[0], kLeastCorrection, kMostCorrection, "", kOptional},
      {"resin", "material_correction_y", &p.material_correction[1], kLeastCorrection, kMostCorrection, "", kOptional},
      {"resin", "material_correction_z", &p.material_correction[2], kLeastCorrection, kMostCorrection, "", kOptional},
      {"resin", "green_strength", &p.peel.green_strength_mpa, 0.01, 100, " MPa", kOptional},
      {"resin", "plate_adhesion", &p.peel.plate_adhesion_mpa, 0.001, 100, " MPa", kOptional},
      {"resin", "peel_traction", &p.peel.traction_kpa, 0, 1000, " kPa", kOptional},
      {"resin", "peel_line_force", &p.peel.line_force_n_mm, 0, 10, " N/mm", kOptional},
      {"resin", "peel_suction", &p.peel.suction_kpa, 0, 101, " kPa", kOptional},
      {"resin", "bottle_cost", &p.bottle_cost, 0, 100000, "", kOptional},
      {"resin", "bottle_volume", &p.bottle_volume, 1, 100000, " ml", kOptional},
      {"print", "absolute_correction", &p.absolute_correction, -kMostMoved, kMostMoved, " mm", kOptional},
      {"print", "min_layer_height", &p.min_layer_height, 0.005, 1, " mm", kOptional},
      {"print", "max_layer_height", &p.max_layer_height, 0.005, 1, " mm", kOptional},
      {"print", "grey", choice(std::span(kGreyWords), p.grey), 0, 0, "", kOptional},
      {"supports", "supports_enable", &p.supports_enable, 0, 0, "", kOptional},
  };
  for (const PrintField& field : kPrintFields) {
    if (!field.in_profile) continue;
    SettingRule rule{"print", field.name, &p.layer_height, field.low, field.high, field.unit};
    std::visit([&](auto member) { rule.value = &(p.*member); }, field.member);
    rules.insert(rules.end() - 1, rule);  // rules of a table stand together
  }
  add_support_rules(rules, supports);
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    rules.push_back(
        {"checks", kIssueWords[i].key, choice(std::span(kCheckActionWords), p.checks.actions[i]), 0, 0, "", kOptional});
  }
  return rules;
}

}  // namespace

Expected<PrintProfile> parse_print_profile(std::string_view text, std::string_view path) {
  PrintProfile profile;
  SupportChoice choice;
  choice.stand = profile.supports.stand;  // so that an elevation leaves it to the underside
  const auto rules = rules_for(profile, choice);
  const auto check = [&](const SettingRule& rule) -> std::string {
    if (rule.key == "grey" && profile.grey != Grey::kOff && !profile.exchange) {
      return "allowed without exchange in [resin] is off: it says what light cures";
    }
    if (rule.key == "max_layer_height") {
      const double times = profile.max_layer_height / profile.min_layer_height;
      if (times < 3 || times >= LayerSteps::kMostStep + 2) return "allowed is 3 to 16 times min_layer_height";
    }
    if (rule.key == "retract_height2" && profile.retract_height2 > profile.lift_height + profile.lift_height2) {
      return "allowed is at most the whole lift, lift_height + lift_height2";
    }
    const SupportSettings supports = choice.put_into({});
    if (rule.key == "support_stand" && supports.stand == SupportStand::kRaised && !(supports.object_elevation > 0)) {
      return "which needs a support_object_elevation";
    }
    if (rule.key == "support_head_front_diameter" && supports.head_front_diameter > supports.pillar_diameter) {
      return "allowed is at most support_pillar_diameter";
    }
    if (rule.key == "support_pillar_diameter" && supports.pillar_diameter > supports.base_diameter) {
      return "allowed is at most support_base_diameter";
    }
    if (rule.key == "pad_wall_thickness" &&
        supports.pad_wall_thickness > supports.base_diameter / 2 + supports.pad_brim_size) {
      return "allowed is at most support_base_diameter / 2 + pad_brim_size";
    }
    return {};
  };
  PLUMBLINE_TRY(parse_settings(text, path, {"a profile", rules, nullptr, check}));
  profile.supports = choice.put_into({});
  return profile;
}

Expected<PrintProfile> read_print_profile(const std::string& path) {
  const auto text = read_settings_text(path, "a profile");
  PLUMBLINE_TRY(text);
  return parse_print_profile(*text, path);
}

Expected<PrintProfile> read_print_profile(const std::string& name_or_path, const std::string& board_path) {
  const auto path = find_profile(name_or_path, board_path);
  PLUMBLINE_TRY(path);
  return read_print_profile(*path);
}

namespace {

/// The nearest odd number of the least height, at most `most`.
std::uint32_t odd_step(double height_mm, double least_mm, std::uint32_t most) {
  constexpr double kRounding = 1e-6;
  const double half = std::floor((height_mm / least_mm + kRounding) / 2);
  return std::min(most, 2 * static_cast<std::uint32_t>(half) + 1);
}

AdaptiveLayers adaptive_layers(const PrintProfile& profile) {
  AdaptiveLayers layers;
  const double least = profile.min_layer_height;
  // The highest that is not above the most.
  layers.most = odd_step(profile.max_layer_height - least, least, LayerSteps::kMostStep);
  layers.first = odd_step(profile.layer_height, least, layers.most);
  layers.first_layers = profile.bottom_layer_count + profile.faded_layers;
  return layers;
}

}  // namespace

PrintProfile profile_or_defaults(const std::optional<BoardFile>& board) {
  if (!board || !board->machine) return {};
  return read_print_profile(board->machine->profile, board->path).value_or(PrintProfile());
}

CheckPolicy checks_of(const std::optional<BoardFile>& board) { return profile_or_defaults(board).checks; }

PeelSettings peel_of(const std::optional<BoardFile>& board) { return profile_or_defaults(board).peel; }

double cure_depth_mm(const PrintProfile& profile, double dose_mj_cm2) {
  return profile.penetration_depth * std::log(dose_mj_cm2 / profile.critical_energy);
}

CureModel cure_model(const PrintProfile& profile, const MachineFile& machine) {
  if (!profile.exchange) return {};
  return {.penetration_mm = profile.penetration_depth,
          .critical_dose = profile.critical_energy,
          .exchange = *profile.exchange,
          .dose = machine.power_mw_cm2 * profile.exposure_time,
          .bottom_dose = machine.power_mw_cm2 * profile.initial_exposure_time,
          .bottom_layers = profile.bottom_layer_count,
          .faded_layers = profile.faded_layers};
}

Grey shown_grey(const PrintProfile& profile, const MachineFile& machine) {
  return machine.panel.grey.has_grey() ? profile.grey : Grey::kOff;
}

CureModel grey_model(const PrintProfile& profile, const MachineFile& machine) {
  return shown_grey(profile, machine) == Grey::kOff ? CureModel() : cure_model(profile, machine);
}

void correct_sizes(const PrintProfile& profile, const BoardFile& board, SliceSettings& settings) {
  Vec3d by;
  for (std::size_t i = 0; i < 3; ++i) {
    by[static_cast<int>(i)] = board.relative_correction[i] * profile.material_correction[i];
  }
  settings.placement.correct(by);
  settings.absolute_correction_mm = profile.absolute_correction;
}

double finest_layer_mm(const PrintProfile& profile) {
  return profile.adaptive ? profile.min_layer_height : profile.layer_height;
}

void tell_checks(const PrintProfile& profile, const MachineFile& machine, SliceSettings& settings) {
  settings.peel = profile.peel;
  const double shrinks = settings.placement.correction[2];  // light goes as deep as the machine measures
  const double height = profile.layer_height / shrinks;
  settings.adaptive = profile.adaptive ? adaptive_layers(profile) : AdaptiveLayers();
  // The dose of a normal layer; bottom and faded layers get more.
  const double dose = machine.power_mw_cm2 * profile.exposure_time;
  settings.cure = {};
  if (dose <= 0 || profile.critical_energy <= 0) return;
  settings.cure = cure_model(profile, machine);
  settings.cure.penetration_mm /= shrinks;
  settings.cure.layer_height_mm = height;
  const double depth = cure_depth_mm(profile, dose) / shrinks;
  // All layers of an adaptive print cure as far beyond themselves as one of the profile's height.
  const double layer = profile.adaptive ? height : static_cast<double>(settings.placement.layer_height_mm);
  settings.overcure_mm = std::max(0.0, depth - layer);
}
}  // namespace plumbline::firmware::inline settings
