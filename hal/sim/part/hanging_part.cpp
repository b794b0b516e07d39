#include "hal/sim/part/hanging_part.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace plumbline::inline hal::inline sim {
namespace {

bool meet(ConstBitImage a, ConstBitImage b) {
  for (std::size_t i = 0; i < a.words().size(); ++i) {
    if ((a.words()[i] & b.words()[i]) != 0) return true;
  }
  return false;
}

}  // namespace

HangingPart::HangingPart(const Build& build)
    : build_(build),
      pixel_mm2_(build.pitch_x_mm * build.pitch_y_mm),
      film_(BitImage::words_needed(build.columns, build.rows), 0) {}

void HangingPart::begin(bool on_part) {
  first_ = true;
  on_part_ = on_part;
  loss_.clear();
}

void HangingPart::clean_film() {
  if (clean_) return;
  std::fill(film_.begin(), film_.end(), 0);
  clean_ = true;
  shadow_ = kNone;
}

void HangingPart::skip_layer(std::uint32_t layer) {
  changed_.clear();
  layers_.push_back(layer);
  remember();
}

void HangingPart::add_layer(std::uint32_t layer, double height_mm, double deep_mm, BitImage lit, ConstBitImage asked) {
  changed_.clear();
  layers_.push_back(layer);
  std::swap(here_, above_);
  std::swap(limb_, limb_above_);
  std::swap(asked_, asked_above_);
  std::swap(loss_, loss_above_);
  loss_.clear();
  here_.find(lit);
  const bool all_held = find_contacts();
  const bool shaded = !clean_ && meet(asked, film());
  if (!all_held || shaded || !loss_above_.empty()) drop_what_is_loose(height_mm, lit, asked);
  hang_up(height_mm, std::max(0.0, deep_mm - height_mm));
  cavities_.next_layer(above_, here_, first_, layer, pixel_mm2_ * height_mm);
  peel(lit, asked);
  remember();
  first_ = false;
}

// @returns whether all regions are held
bool HangingPart::find_contacts() {
  contacts_.clear();
  first_contact_.assign(here_.white().size(), kNone);
  if (first_) return true;
  below_.assign(above_.white().size(), {});
  for_each_contact(above_, here_, true, [&](std::uint32_t a, std::uint32_t b, std::uint32_t pixels) {
    if (limb_above_[a] == kNone) return;
    below_[a].pixels += pixels;
    std::uint32_t at = first_contact_[b];
    while (at != kNone && contacts_[at].above != a) at = contacts_[at].next;
    if (at != kNone) {
      contacts_[at].pixels += pixels;
      return;
    }
    contacts_.push_back({.above = a, .pixels = pixels, .next = first_contact_[b]});
    first_contact_[b] = static_cast<std::uint32_t>(contacts_.size() - 1);
    ++below_[a].joints;
  });
  return std::find(first_contact_.begin(), first_contact_.end(), kNone) == first_contact_.end();
}

void HangingPart::drop_what_is_loose(double height_mm, BitImage lit, ConstBitImage asked) {
  asked_.find(asked);
  const auto wanted = asked_.white();
  loss_.assign(wanted.size(), kNone);
  std::vector<std::uint32_t> stays(wanted.size(), 0);  // pixels
  const auto held = [&](std::uint32_t region) { return first_ || first_contact_[region] != kNone; };
  bool any_loose = false;
  for (const RegionShape& shape : here_.white()) {
    if (held(here_.number(shape.region))) {
      stays[asked_.number_at(shape.column, shape.row)] += here_.pixels(shape);
    } else {
      any_loose = true;
    }
  }
  if (!loss_above_.empty()) {
    for_each_contact(asked_above_, asked_, true, [&](std::uint32_t a, std::uint32_t b, std::uint32_t) {
      if (stays[b] == 0 && loss_above_[a] != kNone) loss_[b] = join(loss_[b], loss_above_[a]);
    });
  }
  for (std::uint32_t r = 0; r < wanted.size(); ++r) {
    const RegionShape& shape = wanted[r];
    const std::uint32_t pixels = asked_.pixels(shape);
    if (loss_[r] != kNone) loss_[r] = joined(loss_[r]);
    if (stays[r] == pixels) continue;
    if (stays[r] == 0) {
      if (loss_[r] == kNone) loss_[r] = new_loss(LossKind::kDropped, shape.column, shape.row, pixels);
      take(loss_[r], ml(pixels, height_mm));
    } else {
      if (shadow_ == kNone) shadow_ = new_loss(LossKind::kShadowed, shape.column, shape.row, pixels);
      take(shadow_, ml(pixels - stays[r], height_mm));
    }
  }
  if (!any_loose) return;
  lay_on_film(lit, [&](std::uint32_t region) { return !held(region); });
  here_.find(lit);
  find_contacts();
}

void HangingPart::hang_up(double height_mm, double bleed_mm) {
  const auto regions = here_.white();
  limb_.assign(regions.size(), kNone);
  std::vector<HoldGraph::Joint> joints;
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    const std::uint32_t pixels = here_.pixels(regions[r]);
    const HoldGraph::Place place{nth(), regions[r].column, regions[r].row};
    const double mm3 = pixels * pixel_mm2_ * height_mm;
    if (first_) {
      const double holds = on_part_ ? HoldGraph::kUnbreakable : build_.peel.plate_n(pixels * pixel_mm2_);
      const HoldGraph::Joint to_plate{.limb = HoldGraph::kPlate, .newtons = holds};
      limb_[r] = graph_.begin_limb({&to_plate, 1}, place, mm3);
      continue;
    }
    std::uint32_t new_pixels = pixels;
    joints.clear();
    for (std::uint32_t at = first_contact_[r]; at != kNone; at = contacts_[at].next) {
      const Contact& contact = contacts_[at];
      new_pixels -= contact.pixels;
      joints.push_back({.limb = limb_above_[contact.above],
                        .newtons = build_.peel.joint_n(contact.pixels * pixel_mm2_),
                        .share = static_cast<double>(contact.pixels) / below_[contact.above].pixels});
    }
    bleed_mm3_ += new_pixels * pixel_mm2_ * bleed_mm;
    const bool goes_on = joints.size() == 1 && below_[contacts_[first_contact_[r]].above].joints == 1;
    if (goes_on) {
      limb_[r] = joints.front().limb;
      graph_.extend(limb_[r], joints.front().newtons, place, mm3);
    } else {
      limb_[r] = graph_.begin_limb(joints, place, mm3);
    }
  }
}

void HangingPart::peel(BitImage lit, ConstBitImage asked) {
  const auto regions = here_.white();
  suction_mm2_ = 0;
  double plate_mm2 = 0;  // of mouths whose suction the plate carries
  sealed_mm2_.assign(regions.size(), 0);
  const auto gaps = here_.black();
  for (std::uint32_t gap = 1; cavities_.any() && gap < gaps.size(); ++gap) {
    if (!cavities_.sealed(gap)) continue;
    const double mouth = here_.runs().area(gaps[gap]) * pixel_mm2_;
    // Where the plate is the ceiling, it is pulled at and no joint. Of a part that is hung on, the ceiling is unknown.
    const double carried = on_part_ ? mouth : mouth * cavities_.share_of_part(gap);
    // The white run to the left of its first run belongs to the region around it: whatever stands inside has a row of the gap above it.
    sealed_mm2_[here_.number(here_.runs().region(gaps[gap] - 1))] += carried;
    suction_mm2_ += mouth;
    plate_mm2 += mouth - carried;
  }
  peel_n_ = build_.peel.force(0, 0, plate_mm2);
  loads_.clear();
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    const double outline =
        PeelSettings::outline_mm(regions[r].sides_x * build_.pitch_x_mm, regions[r].sides_y * build_.pitch_y_mm);
    const double newtons = build_.peel.force(here_.pixels(regions[r]) * pixel_mm2_, outline, sealed_mm2_[r]);
    peel_n_ += newtons;
    loads_.push_back({.limb = limb_[r], .newtons = newtons});
  }
  largest_peel_n_ = std::max(largest_peel_n_, peel_n_);
  largest_suction_mm2_ = std::max(largest_suction_mm2_, suction_mm2_);
  for (const HoldGraph::Tear& tear : graph_.pull(loads_)) tear_off(tear, lit, asked);
}

void HangingPart::tear_off(const HoldGraph::Tear& tear, BitImage lit, ConstBitImage asked) {
  if (loss_.empty()) {  // all stayed until now
    asked_.find(asked);
    loss_.assign(asked_.white().size(), kNone);
  }
  const auto regions = here_.white();
  std::uint64_t pixels = 0;
  for (const std::uint32_t r : tear.loads) {
    limb_[r] = kNone;
    pixels += here_.pixels(regions[r]);
  }
  const std::uint32_t loss = new_loss(LossKind::kTorn, tear.place.column, tear.place.row, pixels);
  losses_[loss].layer = layers_[tear.place.layer];
  losses_[loss].asked_n = tear.asked_n;
  losses_[loss].held_n = tear.held_n;
  take(loss, tear.mm3 / 1000);
  // A region of the masks is lost with the last of its regions that were held.
  const auto home = [&](std::uint32_t r) { return asked_.number_at(regions[r].column, regions[r].row); };
  for (const std::uint32_t r : tear.loads) loss_[home(r)] = loss;
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    if (limb_[r] != kNone && loss_[home(r)] == loss) loss_[home(r)] = kNone;
  }
  lay_on_film(lit, [&](std::uint32_t region) { return std::ranges::binary_search(tear.loads, region); });
}

template <class Which>
void HangingPart::lay_on_film(BitImage lit, Which which) {
  here_.fill(lit, false, which);
  here_.fill(BitImage(film_, build_.columns, build_.rows), true, which);
  clean_ = false;
}

std::uint32_t HangingPart::joined(std::uint32_t loss) const {
  while (losses_[loss].joined != Loss::kNone) loss = losses_[loss].joined;
  return loss;
}

/// Two losses that a region belongs to: what drops and grows together is one piece. @param a  kNone: there is one only
std::uint32_t HangingPart::join(std::uint32_t a, std::uint32_t b) {
  b = joined(b);
  if (a == kNone || joined(a) == b) return b;
  a = joined(a);
  if (a > b) std::swap(a, b);
  if (losses_[a].kind != LossKind::kDropped || losses_[b].kind != LossKind::kDropped) return a;
  take(a, losses_[b].ml);
  take(b, -losses_[b].ml);
  losses_[b].joined = a;
  return a;
}

std::uint32_t HangingPart::new_loss(LossKind kind, std::uint32_t column, std::uint32_t row, std::uint64_t pixels) {
  losses_.push_back({.kind = kind,
                     .layer = layers_.back(),
                     .last_layer = layers_.back(),
                     .x_mm = (column + 0.5) * build_.pitch_x_mm,
                     .y_mm = (row + 0.5) * build_.pitch_y_mm,
                     .pixels = pixels});
  return static_cast<std::uint32_t>(losses_.size() - 1);
}

void HangingPart::take(std::uint32_t loss, double ml) {
  losses_[loss].ml += ml;
  losses_[loss].last_layer = layers_.back();
  if (std::find(changed_.begin(), changed_.end(), loss) == changed_.end()) changed_.push_back(loss);
}

void HangingPart::remember() {
  if (!build_.remember) return;
  remembered_at_.push_back(remembered_.size());
  for (const std::uint32_t limb : limb_) {
    if (limb != kNone) remembered_.push_back(limb);
  }
}

void HangingPart::remove_lost(std::size_t nth, BitImage stayed) const {
  assert(build_.remember);
  if (nth >= remembered_at_.size()) return;  // not judged
  const std::uint32_t* limbs = remembered_.data() + remembered_at_[nth];
  PartRegions regions;
  regions.find(stayed);
  regions.fill(stayed, false,
               [&](std::uint32_t region) { return graph_.lost(limbs[region], static_cast<std::uint32_t>(nth)); });
}

}  // namespace plumbline::inline hal::inline sim
