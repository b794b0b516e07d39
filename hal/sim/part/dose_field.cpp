#include "hal/sim/part/dose_field.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace plumbline::inline hal::inline sim {
namespace {

// The normal distribution, between whose places the linear interpolation is off by at most 2e-7.
constexpr double kMostSigma = 4;
constexpr int kStepsOfSigma = 400;

double below(double sigmas) {
  static const auto table = [] {
    std::array<double, static_cast<std::size_t>(2 * kMostSigma) * kStepsOfSigma + 2> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double t = static_cast<double>(i) / kStepsOfSigma - kMostSigma;
      values[i] = std::erfc(-t / std::numbers::sqrt2) / 2;
    }
    return values;
  }();
  const double place = (std::clamp(sigmas, -kMostSigma, kMostSigma) + kMostSigma) * kStepsOfSigma;
  const auto i = static_cast<std::size_t>(place);
  return table[i] + (place - static_cast<double>(i)) * (table[i + 1] - table[i]);
}

}  // namespace

double DoseModel::reach_mm(Dose dose) const {
  return resin.penetration_mm * std::log(std::max(1.0, dose / resin.critical / kFaintest));
}

DoseField::DoseField(const DoseModel& model) : model_(model) {
  assert(model_.resin.blur_px >= 0 && model_.resin.blur_px <= kMostBlur);
}

DoseField::DoseField(const DoseModel& model, const CuredPart& part) : DoseField(model) {
  part.for_each_lit_layer(
      [&](const CuredLayer& layer, ConstBitImage mask, std::span<const GreyRun> greys) { add(layer, mask, greys); });
}

void DoseField::add(const CuredLayer& cured, ConstBitImage mask, std::span<const GreyRun> greys) {
  Layer layer{.z_mm = cured.z.above_film().millimetres(), .dose = cured.dose.value(), .words = {}, .greys = {}};
  layer.columns = mask.columns();
  layer.greys.assign(greys.begin(), greys.end());
  std::int64_t end_row = 0, end_word = 0;
  for (std::uint32_t row = 0; row < mask.rows(); ++row) {
    const auto words = mask.row(row);
    if (is_blank(words)) continue;
    const auto lit = [](std::uint64_t word) { return word != 0; };
    const std::int64_t first = std::find_if(words.begin(), words.end(), lit) - words.begin();
    const std::int64_t end = words.rend() - std::find_if(words.rbegin(), words.rend(), lit);
    const bool is_first = end_row == 0;
    if (is_first) layer.first_row = row;
    layer.first_word = is_first ? first : std::min(layer.first_word, first);
    end_word = std::max(end_word, end);
    end_row = row + 1;
  }
  layer.rows = end_row - layer.first_row;
  layer.stride = end_word - layer.first_word;
  layer.words.reserve(static_cast<std::size_t>(layer.rows * layer.stride));
  for (std::int64_t row = layer.first_row; row < end_row; ++row) {
    const auto words = mask.row(static_cast<std::uint32_t>(row))
                           .subspan(static_cast<std::size_t>(layer.first_word), static_cast<std::size_t>(layer.stride));
    layer.words.insert(layer.words.end(), words.begin(), words.end());
  }
  reach_mm_ = std::max(reach_mm_, model_.reach_mm(cured.dose));
  // A stage that has lost steps cures a layer below another.
  const auto above =
      std::find_if(layers_.rbegin(), layers_.rend(), [&](const Layer& l) { return l.z_mm <= layer.z_mm; });
  auto at = layers_.insert(above.base(), std::move(layer));
  for (int both = 0; both < 2 && at != layers_.end(); ++both, ++at) {
    if (at != layers_.begin()) at->fade = std::exp(-(at->z_mm - std::prev(at)->z_mm) / model_.resin.penetration_mm);
  }
}

void DoseField::drop_below(double z_mm) {
  while (!layers_.empty() && layers_.front().z_mm < z_mm) layers_.pop_front();
}

DoseField::Weights DoseField::weights(double pixels) const {
  const double sigma = model_.resin.blur_px;
  Weights weights;
  weights.first = static_cast<std::int64_t>(std::floor(pixels - kMostSigma * sigma));
  weights.count =
      static_cast<unsigned>(static_cast<std::int64_t>(std::floor(pixels + kMostSigma * sigma)) - weights.first) + 1;
  double before = 0;
  for (unsigned i = 0; i < weights.count; ++i) {
    const bool is_last = i + 1 == weights.count;
    const double up_to = is_last ? 1 : below((static_cast<double>(weights.first + i + 1) - pixels) / sigma);
    weights.of[i] = up_to - before;
    before = up_to;
  }
  return weights;
}

/// What grey pixels of a row let through more or less than their bits say.
/// @param bits  of the row, the lowest that of the first weight
double DoseField::grey_share(const Layer& layer, std::int64_t row, const Weights& across, std::uint64_t bits) {
  const std::int64_t begin = std::max<std::int64_t>(across.first, 0);
  const std::int64_t end = std::min(across.first + across.count, layer.columns);
  if (row < 0 || begin >= end) return 0;
  const std::int64_t first = row * layer.columns;
  auto run = std::partition_point(layer.greys.begin(), layer.greys.end(),
                                  [&](const GreyRun& one) { return one.end() <= first + begin; });
  double more = 0;
  for (; run != layer.greys.end() && run->pixel < first + end; ++run) {
    const double share = run->level / double{kFullLevel};
    const std::int64_t last = std::min<std::int64_t>(run->end() - first, end);
    for (std::int64_t column = std::max<std::int64_t>(run->pixel - first, begin); column < last; ++column) {
      const auto i = static_cast<unsigned>(column - across.first);
      more += across.of[i] * (share - static_cast<double>(bits >> i & 1U));
    }
  }
  return more;
}

/// The light of the mask at a place: the one function that reads a pixel's share.
double DoseField::share(const Layer& layer, const Weights& across, const Weights& along) const {
  const std::int64_t w = across.first >> 6;
  const auto shift = static_cast<unsigned>(across.first & 63);
  const std::uint64_t white = (std::uint64_t{1} << across.count) - 1;
  double sum = 0;
  for (unsigned r = 0; r < along.count; ++r) {
    const std::int64_t row = along.first + r;
    std::uint64_t bits = layer.word(row, w) >> shift;
    if (shift + across.count > 64) bits |= layer.word(row, w + 1) << (64 - shift);
    bits &= white;
    double lit = bits == white ? 1 : 0;
    if (lit == 0) {
      for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
        lit += across.of[static_cast<unsigned>(std::countr_zero(rest))];
      }
    }
    if (!layer.greys.empty()) lit += grey_share(layer, row, across, bits);
    sum += along.of[r] * lit;
  }
  return sum;
}

double DoseField::at(double x_mm, double y_mm, double z_mm) const {
  auto layer =
      std::lower_bound(layers_.begin(), layers_.end(), z_mm, [](const Layer& l, double z) { return l.z_mm < z; });
  if (z_mm < 0 || layer == layers_.end()) return 0;
  const Weights across = weights(x_mm / model_.pitch_x_mm), along = weights(y_mm / model_.pitch_y_mm);
  const double faintest = DoseModel::kFaintest * model_.resin.critical.value();
  double largest = 0, sum = 0;
  for (double left = std::exp(-(layer->z_mm - z_mm) / model_.resin.penetration_mm);;) {
    if (layer->dose * left >= faintest) {
      const double term = layer->dose * left * share(*layer, across, along);
      largest = std::max(largest, term);
      sum += term;
    }
    if (++layer == layers_.end() || layer->z_mm - z_mm > reach_mm_) break;
    left *= layer->fade;
  }
  return model_.lamp_at(x_mm, y_mm) * combined(largest, sum);
}

std::vector<double> DoseField::cured_depths(std::uint32_t column, std::uint32_t row) const {
  const Weights across = weights(column + 0.5), along = weights(row + 0.5);
  const double lamp = model_.lamp_at((column + 0.5) * model_.pitch_x_mm, (row + 0.5) * model_.pitch_y_mm);
  std::vector<double> depths;  // from the top
  double largest = 0, sum = 0;
  bool cured = false;
  const auto turn = [&](bool to, double z) {
    if (to != cured) depths.push_back(z);
    cured = to;
  };
  for (std::size_t i = layers_.size(); i-- > 0;) {
    const Layer& layer = layers_[i];
    const double term = lamp * layer.dose * share(layer, across, along);
    largest = std::max(largest, term);
    sum += term;
    const double times = combined(largest, sum) / model_.resin.critical.value();
    turn(times >= 1, layer.z_mm);
    const double below = i > 0 ? layers_[i - 1].z_mm : 0;
    const double depth = cured ? layer.z_mm - model_.resin.penetration_mm * std::log(times) : below;
    if (depth > below) turn(false, depth);
    largest *= layer.fade;
    sum *= layer.fade;
  }
  turn(false, 0);
  std::reverse(depths.begin(), depths.end());
  return depths;
}

}  // namespace plumbline::inline hal::inline sim
