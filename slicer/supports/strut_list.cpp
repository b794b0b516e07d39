#include "slicer/supports/strut_list.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::inline slicer {
namespace {

constexpr double kLeastPixels = 1.5;  ///< radius

std::uint16_t whole(double value, std::uint32_t most) {
  return static_cast<std::uint16_t>(std::clamp(std::floor(value + 0.5), 0.0, static_cast<double>(most)));
}

}  // namespace

Status StrutList::add(StrutKind kind, const Place& from, const Place& to, std::uint32_t first, std::uint32_t end,
                      double radius_from, double radius_to, bool lies) {
  if (strut_count_ == struts_.size()) {
    return telling(
        Told(ToldCode::kTooManySupports, {{Fact::kCount, struts_.size()}}),
        fail(ErrorCode::kOutOfMemory,
             "supports: more than %zu struts are needed.\tTurn the object, or allow a larger support_overhang_span",
             struts_.size()));
  }
  const auto px = static_cast<double>(grid_.pitch_x_mm);
  const auto py = static_cast<double>(grid_.pitch_y_mm);
  Strut& strut = struts_[strut_count_++];
  strut.column0 = whole(from.x / px, grid_.columns - 1);
  strut.row0 = whole(from.y / py, grid_.rows - 1);
  strut.column1 = whole(to.x / px, grid_.columns - 1);
  strut.row1 = whole(to.y / py, grid_.rows - 1);
  strut.first = static_cast<std::uint16_t>(std::min(first, grid_.layers));
  strut.end = static_cast<std::uint16_t>(std::clamp(end, first, std::max(first, grid_.layers)));
  // Sections of neighbouring layers overlap, also where coarse pixels round one to the left and the next to the right.
  const double aside = std::sqrt((to.x - from.x) * (to.x - from.x) + (to.y - from.y) * (to.y - from.y));
  const double step = lies ? 0 : aside / std::max(1, strut.end - strut.first);
  const double least = kLeastPixels * std::max(px, py) + step / 2;
  strut.radius0 = whole(1000 * std::max(radius_from, least), 0xFFFF);
  strut.radius1 = whole(1000 * std::max(radius_to, least), 0xFFFF);
  strut.kind = kind;
  strut.lies = lies ? 1 : 0;
  return {};
}

Status StrutList::add_pillar(const Pillar& pillar) {
  if (pillar_count_ == pillars_.size()) {
    return telling(
        Told(ToldCode::kTooManySupports, {{Fact::kCount, pillars_.size()}}),
        fail(ErrorCode::kOutOfMemory, "supports: more than %zu pillars are needed.\tTurn the object", pillars_.size()));
  }
  pillars_[pillar_count_++] = pillar;
  return {};
}

std::uint32_t StrutList::layer_at(double z) const {
  const double layer = std::floor(z / static_cast<double>(grid_.layer_height_mm) + 1e-6);
  return static_cast<std::uint32_t>(std::clamp(layer, 0.0, static_cast<double>(grid_.layers - 1)));
}

}  // namespace plumbline::inline slicer
