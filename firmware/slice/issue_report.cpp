#include "firmware/slice/issue_report.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {
namespace {

/// What is smaller than a drop would need an exponent in millilitres.
FixedText<32> volume(double ml) {
  FixedText<32> text;
  const bool is_small = ml < 0.01;
  text.add("%s %s", three_digits(is_small ? 1000 * ml : ml).c_str(), is_small ? "mm3" : "ml");
  return text;
}

void add_size(Sentence& text, const Issue& issue, const IssueScale& scale) {
  switch (words_of(issue.kind).size) {
    case IssueSize::kArea:
      text.add("%s mm2 (%llu px)", three_digits(scale.mm2(issue.pixels)).c_str(), big(issue.pixels));
      break;
    case IssueSize::kVolume:
      text.add("%s", volume(scale.ml(issue.voxels)).c_str());
      if (issue.kind == IssueKind::kTear) {
        text.add(", pulled with %s N and held with %s N", three_digits(static_cast<double>(issue.asked_n)).c_str(),
                 three_digits(static_cast<double>(issue.held_n)).c_str());
      } else {
        text.add(", up to %s mm2 in area", three_digits(scale.mm2(issue.pixels)).c_str());
      }
      break;
    case IssueSize::kLayers: text.add("%u layer%s", issue.layers(), plural_s(issue.layers())); break;
    case IssueSize::kSlenderness:
      text.add("%s mm, %s times its width of %s mm", three_digits(scale.z_mm(issue.layers())).c_str(),
               three_digits(scale.slenderness(issue)).c_str(), three_digits(scale.width_mm(issue)).c_str());
      break;
  }
}

void add_place(Sentence& text, const Issue& issue, const IssueScale& scale) {
  const bool everywhere = words_of(issue.kind).size == IssueSize::kLayers;
  if (!everywhere) text.add(" at x %.1f, y %.1f mm", scale.x_mm(issue), scale.y_mm(issue));
  if (issue.layers() > 1) {
    text.add(" in layers %u to %u (%.2f to %.2f mm)", issue.first_layer, issue.last_layer,
             scale.z_mm(issue.first_layer), scale.z_mm(issue.last_layer + 1));
  } else {
    text.add(" in layer %u (%.2f mm)", issue.layer, scale.z_mm(issue.layer));
  }
}

/// Calls visit(kind, group) for each kind that was found and that a person is told of.
template <class Visit>
void for_each_found(const StackFindings& findings, Visit visit) {
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    if (findings.groups[i].told() > 0) visit(static_cast<IssueKind>(i), findings.groups[i]);
  }
}

/// Numbers of the kinds that were found and that matter, as far as there is room for them.
template <class Matters>
Sentence counts_of(const StackFindings& findings, Matters matters) {
  constexpr std::size_t kMost = 350;  // with one more kind and the layers too fine to check it fits
  Sentence text;
  bool all = true;
  for_each_found(findings, [&](IssueKind kind, const IssueGroup& group) {
    if (!matters(kind)) return;
    if (text.view().size() > kMost) {
      if (std::exchange(all, false)) text.add(", other issues");
      return;
    }
    const std::string_view name = group.told() == 1 ? words_of(kind).one : words_of(kind).many;
    text.add("%s%u %.*s", text.view().empty() ? "" : ", ", group.told(), static_cast<int>(name.size()), name.data());
  });
  return text;
}

void write_issue(JsonWriter& json, const Issue& issue, const IssueScale& scale) {
  json.begin_object(kOneLine);
  json.member("layer", issue.layer);
  json.member("first_layer", issue.first_layer);
  json.member("last_layer", issue.last_layer);
  json.member("column", issue.column);
  json.member("row", issue.row);
  json.member("place_mm", std::array{scale.x_mm(issue), scale.y_mm(issue), scale.z_mm(issue.layer)});
  json.member("pixels", issue.pixels);
  json.member("area_mm2", scale.mm2(issue.pixels));
  if (words_of(issue.kind).size == IssueSize::kVolume) json.member("volume_ml", scale.ml(issue.voxels));
  if (issue.kind == IssueKind::kNeedle) json.member("height_over_width", scale.slenderness(issue));
  if (issue.kind == IssueKind::kTear) {
    json.member("asked_n", static_cast<double>(issue.asked_n));
    json.member("held_n", static_cast<double>(issue.held_n));
  }
  json.end_object();
}

/// The largest layer, or the one with the largest growth.
void write_largest(JsonWriter& json, std::string_view name, std::uint32_t layer, double area_mm2) {
  json.begin_object(name, kOneLine);
  json.member("layer", layer);
  json.member("area_mm2", area_mm2);
  json.end_object();
}

}  // namespace

CheckLimits check_limits(const PlacementSettings& placement, const PeelSettings& peel, double overcure_mm,
                         OverhangRule overhangs) {
  CheckLimits limits;
  limits.overhangs = overhangs;
  limits.cured_gap_mm = overcure_mm;
  limits.peel = peel;
  if (const auto& printer = placement.printer) {
    limits.has_panel = true;
    limits.travel_mm = static_cast<double>(printer->travel_mm);
  }
  return limits;
}

CheckLimits coarse_limits(const PrintGrid& grid, const PeelSettings& peel) {
  constexpr double kUsualPitch = 0.05;  // mm
  CheckLimits limits;
  limits.peel = peel;
  const double pixels = kUsualPitch / std::max(kUsualPitch, IssueScale(grid).pitch_x_mm);
  const auto scaled = [](std::uint32_t limit, double factor) {
    return std::max(1U, static_cast<std::uint32_t>(std::lround(limit * factor)));
  };
  limits.island.held_pixels = scaled(limits.island.held_pixels, pixels * pixels);
  limits.overhang_reach = scaled(limits.overhang_reach, pixels);
  limits.drain_pixels = scaled(limits.drain_pixels, pixels * pixels);
  limits.suction_pixels = scaled(limits.suction_pixels, pixels * pixels);
  // trap_pixels stays UVtools' 17 (RequiredAreaToProcessCheck): a hollow of one coarse pixel is noise.
  return limits;
}

Sentence issue_sentence(IssueKind kind, const StackFindings& findings, const PrintGrid& grid) {
  const IssueGroup& group = findings.of(kind);
  const IssueScale scale(grid);
  const IssueWords& words = words_of(kind);
  const std::uint32_t count = group.told();
  const std::string_view name = count == 1 ? words.one : words.many;
  Sentence text;
  text.add("%u %.*s", count, static_cast<int>(name.size()), name.data());
  if (kind == IssueKind::kFreePiece) {
    const double percent = 100 * findings.fallen_share();
    text.add(", %.*g %% of the print", percent < 99.5 ? 2 : 3, percent);
  }
  if (count > 1 && words.size == IssueSize::kVolume) text.add(", %s", volume(scale.ml(group.voxels)).c_str());
  text.add("%s", count == 1 ? (kind == IssueKind::kFreePiece || kind == IssueKind::kTear ? ": " : " of ")
                            : ", the largest of ");
  add_size(text, group.kept[0], scale);
  add_place(text, group.kept[0], scale);
  if (kind == IssueKind::kFreePiece && findings.shadowed_voxels > 0) {
    text.add(", and %s above it then gets no light", volume(scale.ml(findings.shadowed_voxels)).c_str());
  }
  return text;
}

Told told_issue(IssueKind kind, const StackFindings& findings, const PrintGrid& grid) {
  const IssueGroup& group = findings.of(kind);
  const Issue& largest = group.kept[0];
  const IssueScale scale(grid);
  Told told(static_cast<ToldCode>(static_cast<std::size_t>(PrinterCode::kIsland) + static_cast<std::size_t>(kind)),
            {{Fact::kCount, group.told()}});
  if (kind == IssueKind::kFreePiece) told.add(Fact::kPercent, 100 * findings.fallen_share());
  switch (words_of(kind).size) {
    case IssueSize::kArea: told.add(Fact::kAreaMm2, scale.mm2(largest.pixels)); break;
    case IssueSize::kVolume: told.add(Fact::kVolumeMl, scale.ml(largest.voxels)); break;
    case IssueSize::kLayers: told.add(Fact::kLayers, largest.layers()); break;
    case IssueSize::kSlenderness:
      told.add(static_cast<Fact>(PrinterFact::kHeightOverWidth), scale.slenderness(largest));
      break;
  }
  if (words_of(kind).size != IssueSize::kLayers) {
    told.add(Fact::kXMm, scale.x_mm(largest));
    told.add(Fact::kYMm, scale.y_mm(largest));
  }
  if (largest.layers() > 1) {
    told.add(Fact::kFirstLayer, largest.first_layer);
    told.add(Fact::kLastLayer, largest.last_layer);
  } else {
    told.add(Fact::kLayer, largest.layer);
  }
  told.add(Fact::kFromMm, scale.z_mm(largest.first_layer));
  return told;
}

Sentence issue_counts(const StackFindings& findings) {
  auto text = counts_of(findings, [](IssueKind) { return true; });
  if (findings.unchecked_layers > 0) {
    text.add("%s%u layer%s too fine to check", text.view().empty() ? "" : ", ", findings.unchecked_layers,
             plural_s(findings.unchecked_layers));
  }
  if (text.view().empty()) text.add("no issues");
  return text;
}

Sentence issue_counts(const StackFindings& findings, const CheckPolicy& policy, CheckAction action) {
  return counts_of(findings, [&](IssueKind kind) { return policy.of(kind) == action; });
}

void for_each_issue(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy, IssueVisit visit) {
  for_each_found(findings, [&](IssueKind kind, const IssueGroup&) {
    if (policy.of(kind) == CheckAction::kIgnore) return;
    auto text = issue_sentence(kind, findings, grid);
    const std::string_view advice = words_of(kind).advice;
    text.add(": %.*s", static_cast<int>(advice.size()), advice.data());
    visit(kind, policy.of(kind), text.view());
  });
}

CheckAction verdict(const StackFindings& findings, const CheckPolicy& policy) {
  CheckAction strictest = CheckAction::kIgnore;
  for_each_found(findings,
                 [&](IssueKind kind, const IssueGroup&) { strictest = std::max(strictest, policy.of(kind)); });
  return strictest;
}

Status judge(const StackFindings& findings, const PrintGrid& grid, const CheckPolicy& policy, bool at_terminal) {
  const CheckAction action = verdict(findings, policy);
  if (action < CheckAction::kAsk) return {};
  std::optional<IssueKind> first;
  for_each_found(findings, [&](IssueKind kind, const IssueGroup&) {
    if (!first && policy.of(kind) == action) first = kind;
  });
  auto found = issue_sentence(*first, findings, grid);
  const auto others = counts_of(findings, [&](IssueKind kind) { return kind != *first && policy.of(kind) == action; });
  // An error has no more room, and what was found comes first.
  constexpr std::size_t kMostOthers = 80;
  const bool all = others.view().size() <= kMostOthers;
  if (!others.view().empty()) found.add("; also %s", all ? others.c_str() : "other issues");
  const std::string_view advice = words_of(*first).advice;
  const std::string_view key = words_of(*first).key;
  const int capital = std::toupper(static_cast<unsigned char>(advice[0]));
  const Told told = told_issue(*first, findings, grid);
  if (action == CheckAction::kAsk) {
    return telling(told,
                   fail(ErrorCode::kBadSetting, "%s.\t%c%.*s, or accept it%s", found.c_str(), capital,
                        static_cast<int>(advice.size()) - 1, advice.data() + 1, at_terminal ? " with --accept" : ""));
  }
  return telling(told, fail(ErrorCode::kBadSetting, "%s, which the profile refuses.\t%c%.*s, or set %.*s in [checks]",
                            found.c_str(), capital, static_cast<int>(advice.size()) - 1, advice.data() + 1,
                            static_cast<int>(key.size()), key.data()));
}

void write_issues(JsonWriter& json, const std::optional<StackFindings>& findings, const PrintGrid& grid,
                  const CheckPolicy& policy) {
  const IssueScale scale(grid);
  json.key("issues");
  if (!findings) return json.null();
  json.begin_object();
  json.member("layers", findings->layers);
  json.member("unchecked_layers", findings->unchecked_layers);
  json.member("first_layer_mm2", scale.mm2(findings->first_layer_pixels));
  write_largest(json, "largest_layer", findings->peel_layer, scale.mm2(findings->peel_pixels));
  write_largest(json, "largest_jump", findings->jump_layer, scale.mm2(findings->jump_pixels));
  json.member("falls_share", findings->fallen_share());
  json.member("falls_ml", scale.ml(findings->of(IssueKind::kFreePiece).voxels));
  json.member("torn_ml", scale.ml(findings->of(IssueKind::kTear).voxels));
  json.member("shadowed_ml", scale.ml(findings->shadowed_voxels));
  json.begin_object("kinds");
  for (std::size_t i = 0; i < kIssueKindCount; ++i) {
    const auto kind = static_cast<IssueKind>(i);
    const IssueGroup& group = findings->groups[i];
    if (group.count == 0) continue;
    json.begin_object(words_of(kind).key);
    json.member("count", group.count);
    json.member("minor", group.minor);
    json.member("action", kCheckActionWords[static_cast<std::size_t>(policy.of(kind))]);
    json.begin_array("largest");
    for (const Issue& issue : group.all_kept()) write_issue(json, issue, scale);
    json.end_array();
    json.end_object();
  }
  json.end_object();
  json.end_object();
}

}  // namespace plumbline::firmware
