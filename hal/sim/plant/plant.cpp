#include "hal/sim/plant/plant.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace plumbline::inline hal::inline sim {
namespace {

constexpr auto kCoverBound = std::chrono::milliseconds(10);  ///< after which UvLamp promises darkness
/// The film yields this far. Less would object to rounding by steps, more would miss a plate pressed in by a thin layer.
constexpr Distance kGentlePress = 20_um;
/// With the plate this high a hand and a scraper reach the film.
constexpr Distance kRoomToClean = 20_mm;

[[gnu::format(printf, 1, 2)]] std::string text(const char* pattern, ...) {
  std::array<char, 192> line{};
  va_list args;
  va_start(args, pattern);
  std::vsnprintf(line.data(), line.size(), pattern, args);
  va_end(args);
  return line.data();
}

CuredPart empty_plate(const PlantSettings& settings) {
  const PanelModel::Build& panel = settings.panel;
  return {panel.columns, panel.rows, panel.pitch_x_mm, panel.pitch_y_mm, settings.peel, settings.keep_part};
}

}  // namespace

Plant::Plant(const PlantSettings& settings)
    : settings_(settings),
      timeline_(settings.pace),
      panel_(timeline_, settings.panel),
      stage_(timeline_, settings.stage),
      lamp_(settings.lamp.irradiance, settings.lamp_rise, settings.lamp_fall),
      thermals_(settings.room),
      part_(empty_plate(settings)),
      stick_(settings.stick),
      last_stick_(settings.stick) {
  panel_.on_change = [this] {
    if (!light_) return;
    raise(ObjectionKind::kMaskChangedUnderLight, "");
    cure();
  };
  stage_.on_leg = [this](const StageModel::Leg& leg) { on_leg(leg); };
  for (const Fault& fault : settings.faults) inject(fault);
  trigger_faults(FaultMoment::kBeforeLayer, settings.layers_on_plate);
}

Status Plant::check_power() const {
  if (!powered_) return fail(ErrorCode::kPowerLost, "the power failed:\tresume the job when it is back");
  return {};
}

bool Plant::wait(nanoseconds time) {
  return wait_until(now() + time, [] { return false; }).has_value();
}

void Plant::raise(ObjectionKind kind, std::string detail) {
  objections_.push_back(
      {.kind = kind, .at = now(), .z = z(), .layer = layer(), .detail = std::move(detail), .loss = {}});
}

void Plant::open_cover() {
  if (cover_open_) return;
  cover_open_ = true;
  push_event(EventKind::kCoverOpened);
  if (on_cover_opened) on_cover_opened();
  const ZPosition lowest = part_.layers().empty() ? ZPosition() : part_.layers().back().z;
  if (z() - lowest >= kRoomToClean) clean_film();
  timeline_.at(now() + kCoverBound, [this] {
    if (light_ && cover_open_) raise(ObjectionKind::kLightWithCoverOpen, "still lit 10 ms after it opened");
  });
}

void Plant::clean_film() { part_.hanging().clean_film(); }

void Plant::take_part_off() {
  part_ = empty_plate(settings_);
  lights_.clear();
  settings_.layers_on_plate = 0;
  judged_ = 0;
  objection_of_loss_.clear();
  uncured_layer_ = 1;
}

void Plant::close_cover() {
  if (!cover_open_ || has_fault(FaultKind::kCoverSwitchDead)) return;
  cover_open_ = false;
  push_event(EventKind::kCoverClosed);
}

void Plant::plug_stick(const std::string& folder) {
  stick_ = folder;
  last_stick_ = folder;
  ++sticks_plugged_;
  push_event(EventKind::kStickArrived);
}

void Plant::pull_stick() {
  if (stick_.empty()) return;
  stick_.clear();
  push_event(EventKind::kStickDeparted);
}

void Plant::cut_power() {
  if (!powered_) return;
  powered_ = false;
  line_ = false;
  latched_ = false;
  drive_lamp();
  stage_.cut();
  panel_.cut();
  if (on_power_lost) on_power_lost();
}

void Plant::restore_power() {
  // Let everything that was pending end: the lamp is dark and the stage at rest.
  timeline_.advance_until(now() + std::chrono::seconds(5), [] { return false; });
  powered_ = true;
  supply_ = true;
  died_ = false;
  events_.clear();
  drive_lamp();
}

void Plant::start_leg(Distance distance, Speed speed, StageSwitch until,
                      std::function<void(const LegResult&)> on_rest) {
  if (light_) raise(ObjectionKind::kMotionUnderLight, text("%.3f mm", distance.millimetres()));
  stage_.start(distance, speed, settings_.travel.acceleration, until, std::move(on_rest));
}

void Plant::on_leg(const StageModel::Leg& leg) {
  if (leg.to < -kGentlePress) {
    raise(ObjectionKind::kTravelPastEnd, text("the plate was pressed %.3f mm into the film", -leg.to.millimetres()));
  } else if (!part_.layers().empty() && leg.to < part_.layers().back().z.above_film() - kGentlePress) {
    raise(ObjectionKind::kTravelPastEnd, text("the part was pressed %.3f mm into the film",
                                              (part_.layers().back().z - ZPosition(leg.to)).millimetres()));
  } else if (leg.to >= settings_.stage.upper_end && leg.end == LegEnd::kStalled && leg.until == StageSwitch::kNone) {
    raise(ObjectionKind::kTravelPastEnd, "the carriage ran into its upper end");
  }
  if (!stuck_at_) return;
  const Distance free = stuck_at_->above_film() + settings_.resin.film_stretch;
  if (leg.to >= free && leg.from < free) stretched_since_ = leg.passes(free);
  if (leg.from >= free && leg.to < free) {
    peel(leg.passes(free));
    stretched_since_.reset();
  }
}

void Plant::peel(TimePoint time) {
  if (!stuck_at_ || !stretched_since_) return;
  const double times = has_fault(FaultKind::kResinSticks) ? amount(FaultKind::kResinSticks) : 1;
  const auto needed = std::chrono::duration<double>(settings_.resin.time_to_peel(stuck_cm2_)) * times;
  if (time - *stretched_since_ >= needed) stuck_at_.reset();
}

void Plant::expect_light(nanoseconds asked) {
  asked_ = asked;
  monitored_ = Dose(0);
}

void Plant::lamp_line(bool on) {
  line_ = on;
  if (!on) died_ = false;
  drive_lamp();
}

void Plant::lamp_supply(bool on) {
  supply_ = on;
  drive_lamp();
}

void Plant::drive_lamp() {
  const bool stuck = has_fault(FaultKind::kLampStuckOn) || has_fault(FaultKind::kLampRunaway);
  if (!stuck || !powered_) latched_ = false;
  if (stuck && line_ && powered_) latched_ = true;
  const bool supplied = supply_ || (latched_ && has_fault(FaultKind::kLampRunaway));
  const bool on = powered_ && supplied && (line_ || latched_) && !died_ && !has_fault(FaultKind::kLampDead);
  double level = on ? 1 : 0;
  if (has_fault(FaultKind::kLampWeak)) level *= amount(FaultKind::kLampWeak);
  if (dimmed_ && has_fault(FaultKind::kLampFlickers)) level *= amount(FaultKind::kLampFlickers);
  if (level == lamp_.driven()) return;
  lamp_.set_rise(has_fault(FaultKind::kLampSlowRise)
                     ? nanoseconds(static_cast<nanoseconds::rep>(amount(FaultKind::kLampSlowRise) * 1e9))
                     : settings_.lamp_rise);
  lamp_.drive(now(), level);
  timeline_.cancel(dark_due_);
  if (level == 0) dark_due_ = timeline_.at(lamp_.settles_at(), [this] { end_light(); });
  if (level > 0 && !light_) begin_light();
}

void Plant::flicker() {
  if (!light_ || !has_fault(FaultKind::kLampFlickers)) return;
  dimmed_ = !dimmed_;
  drive_lamp();
  timeline_.at(now() + std::chrono::milliseconds(20), [this] { flicker(); });
}

void Plant::begin_light() {
  light_ = true;
  lit_at_ = now();
  lit_layer_ = layer();
  thermals_.set_lit(now(), true);
  if (lit_layer_ > first_layer() + judged_) judge_last_layer(true);
  if (cover_open_) raise(ObjectionKind::kLightWithCoverOpen, "the lamp was lit while it was open");
  if (stage_.moving()) raise(ObjectionKind::kMotionUnderLight, "lit while the stage moved");
  if (panel_.changing()) {
    raise(ObjectionKind::kMaskTornUnderLight, "lit before the scan-out was over");
  } else if (!panel_.matches_mask()) {
    raise(ObjectionKind::kMaskTornUnderLight, "not all rows were those of the presented mask");
  } else if (panel_.black()) {
    raise(ObjectionKind::kExposureWithoutMask, "");
  }
  peel(now());
  if (stuck_at_ && (z() - *stuck_at_ > 1_um || *stuck_at_ - z() > 1_um)) {
    raise(ObjectionKind::kLiftSkipped,
          text("%.1f cm2 still stuck to the film since %.3f mm", stuck_cm2_, stuck_at_->above_film().millimetres()));
  }
  trigger_faults(FaultMoment::kInExposure, lit_layer_);
  if (has_fault(FaultKind::kLampFlickers)) flicker();
  if (has_fault(FaultKind::kLampDies)) {
    const auto after = std::chrono::duration<double>(amount(FaultKind::kLampDies));
    timeline_.at(now() + std::chrono::duration_cast<nanoseconds>(after), [this, lit_at = lit_at_] {
      if (!light_ || lit_at != lit_at_) return;
      died_ = true;
      drive_lamp();
    });
  }
}

void Plant::end_light() {
  light_ = false;
  dimmed_ = false;
  thermals_.set_lit(now(), false);
  cure();
  asked_ = nanoseconds::zero();
  for (; uncured_layer_ <= lit_layer_ + 1; ++uncured_layer_) trigger_faults(FaultMoment::kBeforeLayer, uncured_layer_);
}

void Plant::cure() {
  const Dose dose = lamp_.take_dose(now());
  monitored_ = monitored_ + dose;
  const ZPosition here = z();
  lights_.push_back({.layer = layer(), .z = here, .began = lit_at_, .ended = now(), .asked = asked_, .dose = dose});
  if (panel_.black() && panel_.matches_mask() && !panel_.changing()) return;
  Resin resin = settings_.resin;
  if (has_fault(FaultKind::kResinWeak)) resin.critical = resin.critical * amount(FaultKind::kResinWeak);
  part_.expose(here, panel_.visible(), lit_at_, now(), dose_of(settings_.lamp.irradiance, asked_), dose, resin,
               panel_.visible_greys());
  const CuredLayer& layer = part_.layers().back();
  if (layer.depth_mm <= 0 || layer.pixels == 0) return;
  stuck_at_ = here;
  stuck_cm2_ = static_cast<double>(layer.pixels) * settings_.panel.pitch_x_mm * settings_.panel.pitch_y_mm / 100;
  stretched_since_.reset();
}

void Plant::judge_last_layer(bool whole) {
  const auto layers = part_.layers();
  if (layers.empty() || judged_ >= layers.size()) return;
  judged_ = static_cast<std::uint32_t>(layers.size());
  judge_dose(whole);
  hang_last_layer();
}

ZPosition Plant::above_last_layer() const {
  const auto layers = part_.layers();
  if (!part_.begins_a_part()) return layers[layers.size() - 2].z;
  return first_layer() > 0 ? settings_.height_on_plate : ZPosition();
}

void Plant::judge_dose(bool whole) {
  const CuredLayer& last = part_.layers().back();
  const auto raise_for_layer = [&](ObjectionKind kind, std::string detail) {
    objections_.push_back({.kind = kind,
                           .at = last.ended,
                           .z = last.z,
                           .layer = first_layer() + judged_ - 1,
                           .detail = std::move(detail),
                           .loss = {}});
  };
  const double ratio = last.asked.value() > 0 ? last.dose / last.asked : 1;
  if (ratio > 1.01 || (whole && ratio < 0.99)) {
    raise_for_layer(ObjectionKind::kDoseOff,
                    text("%.3f of %.3f mJ/cm2, %+.1f %%", last.dose.value(), last.asked.value(), 100 * (ratio - 1)));
  }
  if (!whole || last.pixels == 0) return;
  const double gap = (last.z - above_last_layer()).millimetres();
  if (last.depth_mm < gap) {
    raise_for_layer(ObjectionKind::kNotBonded, text("cured %.4f mm deep, the gap is %.4f mm", last.depth_mm, gap));
  }
}

void Plant::conclude(JobEnd end) { judge_last_layer(end == JobEnd::kFinished); }

}  // namespace plumbline::inline hal::inline sim
