#pragma once
/// The force that pulls a cured layer off the film, and what the part holds against it. The simulated printer and the checks of the
/// masks reckon with it.

#include <cstdint>

namespace plumbline::inline slicer {

/// Force of a layer at its peel, N:
///
///     F = s A + g P + p C
///
/// A is the layer's area (mm2), P the length of its outline (mm), C the area of the sealed cavities that open to the film (mm2).
///   s A  Layer and film are joined by a cohesive zone: a traction that rises to its largest value s while they part, and then falls to
///        nothing (F. Liravi, S. Das, C. Zhou, Computer-Aided Design 69, 2015, doi 10.1016/j.cad.2015.05.002; H. Ye,
///        A. Venketeswaran, S. Das, C. Zhou, Rapid Prototyping Journal 23, 2017, doi 10.1108/RPJ-06-2016-0091; both fit it to
///        measured forces). Of a layer that is narrower than the zone is long, all of it parts at once: the force is s A. Below a
///        rigid window it would be Stefan adhesion instead, 3 pi mu v R^4 / (2 h^3) for a disc, which grows faster than the area
///        (J. Stefan 1874; Y. Pan, H. He, J. Xu, A. Feinerman, Rapid Prototyping Journal 23, 2017, 353,
///        doi 10.1108/RPJ-12-2015-0188). A film that bends lets the resin in.
///   g P  Of a wider layer the film peels from the outline inwards. Per unit of its width a front at a right angle needs the work of the
///        cohesive zone per area, g (K. Kendall, Journal of Physics D 8, 1975, 1449, equation of peeling without stretching).
///   p C  No resin can follow into a cavity that is closed by the part or the plate: the film is sucked up into it. The ceiling of the
///        cavity is pulled down as hard. Where that is the plate, such as in the hole of a raft, the motor feels it but no joint does.
/// The cohesive models above give the smaller of the first two; their sum is never less, and at most twice as much.
///
/// Each layer's force passes through every cross-section up to the plate. A joint between two layers holds green_strength times the
/// area in which they overlap, the plate holds plate_adhesion times the area of the first layer. Leverage is left out: joints
/// share a load as their strengths allow (HoldGraph).
///
/// The constants are ours: none was found published for a free film of FEP, with which the largest force was 48 % less than with
/// one that bends less (Flexible film separation analysis of LCD based mask stereolithography, 2020, abstract). They are of the usual
/// order of magnitude at 60 mm/min: a solid square of 10 cm2 needs 9 N. To measure them, weigh the lift of two squares on a load cell,
/// of a few mm and of a few cm, and solve for s and g. A profile sets all five in its [resin].
struct PeelSettings {
  double traction_kpa = 5;          ///< s; 1 kPa is 0.001 N/mm2
  double line_force_n_mm = 0.03;    ///< g
  double suction_kpa = 20;          ///< p; 101 would be vacuum
  double green_strength_mpa = 5;    ///< of a joint between layers before post-curing; 1 MPa is 1 N/mm2
  double plate_adhesion_mpa = 0.5;  ///< of the first layer to the plate

  /// @returns N
  double force(double area_mm2, double outline_mm, double sealed_mm2) const {
    return 1e-3 * traction_kpa * area_mm2 + line_force_n_mm * outline_mm + 1e-3 * suction_kpa * sealed_mm2;
  }
  /// What two layers hold where they overlap, N.
  double joint_n(double overlap_mm2) const { return green_strength_mpa * overlap_mm2; }
  /// What the plate holds of a region of the first layer, N.
  double plate_n(double area_mm2) const { return plate_adhesion_mpa * area_mm2; }

  /// Length of an outline, holes included, from the sides of its pixels, mm. Lengths measured along two axes are 4 / pi times too long on
  /// average over all directions, and for a circle (Cauchy and Crofton).
  static double outline_mm(double sides_x_mm, double sides_y_mm) {
    constexpr double kPiQuarter = 0.7853981633974483;
    return kPiQuarter * (sides_x_mm + sides_y_mm);
  }
  /// Of what sucks in a cavity, the share that its ceiling hands to the part. The rest pulls at the plate and at no joint.
  /// @param plate_pixels  of the ceiling that are plate
  /// @param mouth_pixels  that open to the film
  static double share_of_part(std::uint64_t plate_pixels, std::uint64_t mouth_pixels) {
    return plate_pixels < mouth_pixels ? 1 - static_cast<double>(plate_pixels) / static_cast<double>(mouth_pixels) : 0;
  }
};

}  // namespace plumbline::inline slicer
