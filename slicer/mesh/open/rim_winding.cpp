#include "slicer/mesh/open/rim_winding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slicer/core/numbers/lanes.hpp"
#include "slicer/mesh/triangle_rays.hpp"

namespace plumbline::inline slicer {
namespace {

/// Columns of numbers, one a corner or the edge from it.
enum Column : std::size_t {
  kHeight,     ///< of the corner, mm
  kDistance2,  ///< of the corner from the ray, mm^2
  kLifted,     ///< p_a of the corner at the height of the place, mm
  kProduct,    ///< <a, b>, mm^2
  kCross,      ///< -(a_x b_y - a_y b_x), mm^2
  // Of the edge's middle
  kMiddleX,  ///< from the ray, mm
  kMiddleY,
  kMiddleZ,  ///< mm
  kOutwardX,
  kOutwardY,
  kOutwardZ,
  kLength,  ///< mm; 0: leads to another loop
  // At the place
  kShare,   ///< kLength / r
  kLean,    ///< kShare * s (1 - s^4)
  kWeight,  ///< kLength / r^3
  kColumns
};

constexpr double kMoved = 1.0 / 1024;  // steps
/// Of the terms of a side in double precision: a sum that is larger is good to 2^-26.
constexpr double kSure = 1.0 / (1 << 26);

/// mm a step, and mm^2 of kCross for a side.
struct RimSteps {
  double x, y, cross;
};

/// What one factor adds to the full turns of a product.
PLUMBLINE_INLINE std::int32_t turn(float im_a, float im_b, float im_of_product) {
  if (im_a >= 0 && im_b >= 0) return im_of_product < 0 ? 1 : 0;
  return im_a < 0 && im_b < 0 && im_of_product >= 0 ? -1 : 0;
}

/// @param column  Column, `stride` numbers each: kLanes more than there are edges, so that the last edge has a second corner
PLUMBLINE_WIDE void add_up(float* column, std::size_t stride, float z, WindingTurn& sum_of_all) {
  for (std::size_t i = 0; i < stride; i += kLanes) {
    Lanes height, distance2, distance;
    load(height, column + kHeight * stride + i);
    load(distance2, column + kDistance2 * stride + i);
    height -= z;
    square_root(distance, distance2 + height * height);
    // Above the place the difference would cancel.
    const Lanes zero{};
    Lanes up;
    choose(up, height > zero, height, -height);
    const Lanes far = distance + up;
    Lanes lifted;
    choose(lifted, height > zero, distance2 / far, far);
    store(column + kLifted * stride + i, lifted);
  }
  Lanes re = Lanes{} + 1.0F;
  Lanes im{};
  IntLanes whole{};
  for (std::size_t i = 0; i + kLanes < stride; i += kLanes) {
    const Lanes zero{};
    Lanes from, to, product, cross;
    load(from, column + kLifted * stride + i);
    load(to, column + kLifted * stride + i + 1);
    load(product, column + kProduct * stride + i);
    load(cross, column + kCross * stride + i);
    product += from * to;
    // About of length one, or the product would grow or vanish: .97 to 1.07 times the length of the number is taken away. A division of
    // the product itself would wait for the one before it.
    Lanes size, other;
    choose(size, product < zero, -product, product);
    choose(other, cross < zero, -cross, cross);
    const IntLanes steep = size < other;
    Lanes larger, smaller;
    choose(larger, steep, other, size);
    choose(smaller, steep, size, other);
    const Lanes shrink = 1.0F / (larger + smaller * 0.375F);
    product *= shrink;
    cross *= shrink;
    const Lanes re_of_both = re * product - im * cross;
    const Lanes im_of_both = re * cross + im * product;
    // -1 for each that holds
    whole -= (im >= zero) & (cross >= zero) & (im_of_both < zero);
    whole += (im < zero) & (cross < zero) & (im_of_both >= zero);
    re = re_of_both;
    im = im_of_both;
  }
  float re_of[kLanes];
  float im_of[kLanes];
  store(re_of, re);
  store(im_of, im);
  sum_of_all = {1, 0, sum(whole)};
  for (std::size_t k = 0; k < kLanes; ++k) sum_of_all.add({re_of[k], im_of[k], 0});
}

/// Sets kShare and kLean for a place.
PLUMBLINE_WIDE void see_edges(float* column, std::size_t stride, float z) {
  for (std::size_t i = 0; i < stride; i += kLanes) {
    Lanes x, y, height, outward_x, outward_y, outward_z, length, r;
    load(x, column + kMiddleX * stride + i);
    load(y, column + kMiddleY * stride + i);
    load(height, column + kMiddleZ * stride + i);
    load(outward_x, column + kOutwardX * stride + i);
    load(outward_y, column + kOutwardY * stride + i);
    load(outward_z, column + kOutwardZ * stride + i);
    load(length, column + kLength * stride + i);
    height -= z;
    const Lanes r2 = x * x + y * y + height * height + length * length * 0.25F;
    square_root(r, r2);
    const Lanes nearness = 1.0F / r;
    const Lanes towards = (outward_x * x + outward_y * y + outward_z * height) * nearness;
    const Lanes squared = towards * towards;
    const Lanes share = length * nearness;
    store(column + kShare * stride + i, share);
    store(column + kLean * stride + i, share * towards * (1.0F - squared * squared));
    store(column + kWeight * stride + i, share * nearness * nearness);
  }
}

/// Sets the columns of a ray, but leaves kCross at 0 where it is too small for its sign to be sure.
/// @param x, y  of stride + 1 corners, steps
/// @param at_x, at_y  of the ray, steps
PLUMBLINE_WIDE void place_ray(const double* x, const double* y, std::size_t stride, double at_x, double at_y,
                              const RimSteps& rim, float* column) {
  // Off the pixel's centre in the direction that EdgeFunction breaks ties in, just far enough that a float shows it.
  const double off_x = at_x + kMoved;
  const double off_y = at_y + kMoved * kMoved;
  for (std::size_t i = 0; i < stride; ++i) {
    const double from_x = rim.x * (x[i] - off_x);
    const double from_y = rim.y * (y[i] - off_y);
    const double to_x = rim.x * (x[i + 1] - off_x);
    const double to_y = rim.y * (y[i + 1] - off_y);
    const double left = (x[i + 1] - x[i]) * (at_y - y[i]);
    const double right = (y[i + 1] - y[i]) * (at_x - x[i]);
    const double side = left - right;
    const bool sure = std::abs(side) > kSure * (std::abs(left) + std::abs(right));
    column[kDistance2 * stride + i] = static_cast<float>(from_x * from_x + from_y * from_y);
    column[kProduct * stride + i] = static_cast<float>(from_x * to_x + from_y * to_y);
    column[kCross * stride + i] = static_cast<float>(sure ? rim.cross * side : 0);
    column[kMiddleX * stride + i] = static_cast<float>(0.5 * (from_x + to_x));
    column[kMiddleY * stride + i] = static_cast<float>(0.5 * (from_y + to_y));
  }
}

/// Adds up what see_edges() has set, loop by loop.
/// @param ends  of each loop: behind its last edge, one corner that leads to the next loop
PLUMBLINE_WIDE void add_loops(const float* column, std::size_t stride, const std::uint32_t* ends, std::size_t loops,
                              RimLean& lean) {
  const float* const share_of = column + kShare * stride;
  const float* const lean_of = column + kLean * stride;
  const float* const weight_of = column + kWeight * stride;
  std::size_t i = 0;
  for (std::size_t loop = 0; loop < loops; ++loop) {
    const std::size_t end = ends[loop];
    float shares = 0, leans = 0, weights = 0;
    if (i + kLanes <= end) {
      Lanes share_lanes{}, lean_lanes{}, weight_lanes{};
      for (; i + kLanes <= end; i += kLanes) {
        Lanes share, leaning, weight;
        load(share, share_of + i);
        load(leaning, lean_of + i);
        load(weight, weight_of + i);
        share_lanes += share;
        lean_lanes += leaning;
        weight_lanes += weight;
      }
      shares = sum(share_lanes);
      leans = sum(lean_lanes);
      weights = sum(weight_lanes);
    }
    for (; i < end; ++i) {
      shares += share_of[i];
      leans += lean_of[i];
      weights += weight_of[i];
    }
    i = end + std::size_t{1};
    if (!(shares > 0)) continue;
    lean.outwards += weights * (leans / shares);
    lean.weight += weights;
  }
}

}  // namespace

void WindingTurn::add(const WindingTurn& other) {
  const float re_of_both = re * other.re - im * other.im;
  const float im_of_both = re * other.im + im * other.re;
  whole += other.whole + turn(im, other.im, im_of_both);
  re = re_of_both;
  im = im_of_both;
}

bool WindingTurn::above_tenth() const {
  // A tenth of a full turn is 36 degrees.
  constexpr float kSine = 0.587785252F;
  constexpr float kCosine = 0.809016994F;
  return whole > 0 || (whole == 0 && im > 0 && im * kCosine > re * kSine);
}

bool WindingTurn::above_half(const RimLean& lean) const {
  if (!is_near_half() || !(lean.weight > 0)) return whole > 0;
  // The angle beyond half a turn, by its sine and cosine: exact to a fortieth.
  const float size = std::sqrt(re * re + im * im);
  const float rise = 1 + re / size;
  const float angle = -im / size * (1 + rise * (1.0F / 3) + rise * rise * 0.2F);
  constexpr float kTurn = 2 * std::numbers::pi_v<float>;
  constexpr float kRounding = 0.5F;
  return angle * lean.weight + kRounding * kTurn * lean.outwards > 0;
}

std::size_t RimWinding::stride_of(std::size_t corners) { return ((corners + kLanes - 1) / kLanes + 1) * kLanes; }

std::size_t RimWinding::bytes_needed(std::size_t corners) {
  const std::size_t stride = stride_of(corners);
  return Arena::rounded(kColumns * stride * sizeof(float)) + Arena::rounded(2 * (stride + 1) * sizeof(double)) +
         Arena::rounded(corners * sizeof(std::uint32_t));
}

Expected<RimWinding> RimWinding::create(const MeshRim& rim, Arena& arena) {
  RimWinding winding;
  winding.rim_ = &rim;
  winding.stride_ = stride_of(rim.corners.size());
  const auto room = arena.take_top<float>(kColumns * winding.stride_, "mesh");
  PLUMBLINE_TRY(room);
  winding.room_ = *room;
  const auto places = arena.take_top<double>(2 * (winding.stride_ + 1), "mesh");
  PLUMBLINE_TRY(places);
  winding.places_ = *places;
  const auto ends = arena.take_top<std::uint32_t>(rim.corners.size(), "mesh");
  PLUMBLINE_TRY(ends);
  std::size_t loops = 0;
  for (std::size_t i = 0; i < rim.corners.size(); ++i) {
    if (rim.corners[i].joins || i + 1 == rim.corners.size()) (*ends)[loops++] = static_cast<std::uint32_t>(i);
  }
  winding.ends_ = ends->first(loops);
  winding.place_edges();
  return winding;
}

/// The edge from a corner. Behind the last one, edges without a length.
RimWinding::Edge RimWinding::edge(std::size_t i) const {
  const auto corners = rim_->corners;
  return {corners[std::min(i, corners.size() - 1)].place, corners[std::min(i + 1, corners.size() - 1)].place};
}

/// Sets the columns that are the same for all rays.
void RimWinding::place_edges() {
  const auto corners = rim_->corners;
  const Vec3d& step = rim_->step;
  for (std::size_t i = 0; i <= stride_; ++i) {
    places_[i] = edge(i).from.x;
    places_[stride_ + 1 + i] = edge(i).from.y;
  }
  for (std::size_t i = 0; i < stride_; ++i) {
    const auto [from, to] = edge(i);
    const Vec3d d(step[0] * (double{1} * to.x - from.x), step[1] * (double{1} * to.y - from.y),
                  step[2] * (double{1} * to.z - from.z));
    const bool joins = i >= corners.size() || corners[i].joins;
    const Vec3f outward = joins ? Vec3f::Zero() : corners[i].outward;
    column(kHeight)[i] = static_cast<float>(step[2] * from.z);
    column(kMiddleZ)[i] = static_cast<float>(step[2] * from.z + 0.5 * d[2]);
    column(kLength)[i] = joins ? 0 : static_cast<float>(std::sqrt(d.dot(d)));
    column(kOutwardX)[i] = outward[0];
    column(kOutwardY)[i] = outward[1];
    column(kOutwardZ)[i] = outward[2];
  }
}

void RimWinding::begin(std::uint32_t pixel_column, std::uint32_t pixel_row) {
  const Vec3d& step = rim_->step;
  const RimSteps steps{step[0], step[1], -step[0] * step[1]};
  place_ray(places_.data(), places_.data() + stride_ + 1, stride_,
            static_cast<double>(EdgeFunction::centre(pixel_column)),
            static_cast<double>(EdgeFunction::centre(pixel_row)), steps, room_.data());
  const auto cross = column(kCross);
  for (std::size_t i = 0; i < stride_; ++i) {
    if (cross[i] != 0) continue;
    const auto [from, to] = edge(i);
    const std::int64_t side = EdgeFunction(from, to).at(pixel_column, pixel_row);
    const double moved = kMoved * (kMoved * (double{1} * to.x - from.x) - (double{1} * to.y - from.y));
    cross[i] = static_cast<float>(steps.cross * (side != 0 ? static_cast<double>(side) : moved));
  }
}

WindingTurn RimWinding::at(float z, int above) const {
  WindingTurn turn;
  add_up(room_.data(), stride_, z, turn);
  turn.whole += above;
  return turn;
}

void RimWinding::add_lean(float z, RimLean& lean) const {
  see_edges(room_.data(), stride_, z);
  add_loops(room_.data(), stride_, ends_.data(), ends_.size(), lean);
}

}  // namespace plumbline::inline slicer
