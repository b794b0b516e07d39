#pragma once
/// The force that pulls a cured layer off the film, and what the part holds against it.

namespace plumbline {

/// Force of a layer at its peel, N:
///
///     F = s A + g P + p C
///
/// A is the layer's area (mm2), P the length of its outline (mm), C the area of the sealed cavities that open to the film (mm2).
///   s A  The resin between layer and film must flow in from the rim, so the film first pulls on the whole layer: a cohesive zone
///        with a largest traction s (F. Liravi, S. Das, C. Zhou, Computer-Aided Design 69, 2015, doi 10.1016/j.cad.2015.05.002; H. Ye, A. Venketeswaran, S. Das,
///        C. Zhou, Rapid Prototyping Journal 23, 2017, doi 10.1108/RPJ-06-2016-0091). With a rigid window this would be Stefan
///        adhesion, which grows faster than the area (Y. Pan, H. He, J. Xu, A. Feinerman, Study of separation force in constrained
///        surface projection stereolithography, Rapid Prototyping Journal 23, 2017); a film that bends bounds it.
///   g P  Then a peel front moves inwards from the outline. A front of unit width needs the force g at a right angle (K. Kendall,
///        Journal of Physics D 8, 1975, 1449).
///   p C  No resin can follow into a cavity that is closed by the part or the plate: the film is sucked up into it. The ceiling of the
///        cavity is pulled down as hard. Where that is the plate, such as in the hole of a raft, the motor feels it but no joint does.
///
/// Each layer's force passes through every cross-section up to the plate. A joint between two layers holds green_strength times the
/// area in which they overlap, the plate holds plate_adhesion times the area of the first layer. Leverage is left out: joints
/// share a load as their strengths allow (HoldGraph).
///
/// The defaults are of the usual order of magnitude at 60 mm/min, with a film of FEP and a standard resin, not of one product:
/// a lift of 10 cm2 of solid square needs some 9 N.
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
};

}  // namespace plumbline
