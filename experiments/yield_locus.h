#pragma once

#include <span>
#include <string>
#include <vector>

namespace powdercal {

// From a shear test to strength figures, in the plane of normal stress sigma and shear stress tau.
// A test shears the powder to steady state under a normal stress (preshear), then to failure under
// smaller ones. Stresses in Pa, compression positive, angles in rad.
//
// Construction: Jenike (1964), Storage and flow of solids, Utah Eng. Exp. Station Bulletin 123;
// Schulze (2008), Powders and Bulk Solids, ch. 3; carried out by ASTM D6128 (Jenike cell), D6773
// (ring shear tester) and D7891 (rotational cell). The locus is a straight line here; formulas and
// their derivation: docs/physics.md, "Shear strength".

/// One measured pair of stresses. A standard deviation of 0 means that it is not given.
struct ShearPoint {
  double normal = 0;     ///< [Pa]
  double shear = 0;      ///< [Pa]
  double normal_sd = 0;  ///< [Pa] ≥ 0
  double shear_sd = 0;   ///< [Pa] ≥ 0
};

/// The line tau = c + sigma tan(phi) through measured points.
struct LinearLocus {
  double cohesion = 0;  ///< [Pa] c, as fitted: noise may make it negative
  double tan_phi = 0;   ///< [-]
  /// Of c [Pa²], of tan(phi) [-], of both together [Pa]. NaN if unknown: two points without sds.
  double cohesion_variance = 0;
  double tan_phi_variance = 0;
  double covariance = 0;
  double residual_sd = 0;  ///< [Pa] sqrt(sum of squared residuals in tau/(n − 2)); NaN for n = 2
  double r_squared = 0;    ///< [-] weighted like the fit; 0 if all shear stresses are equal
  double chi_squared = 0;  ///< [-] weighted sum of squares; 0 without sds
  int points = 0;
  bool weighted = false;  ///< every point had a shear_sd

  double ShearAt(double normal) const { return cohesion + tan_phi * normal; }
};

/// Least squares. If every point has a shear_sd, points are weighted, allowing for errors in both
/// coordinates (York et al. 2004, Am. J. Phys. 72:367; with normal_sd = 0 ordinary weighted least
/// squares), and the covariance follows from the sds, times chi²/(n − 2) where that exceeds 1.
/// Otherwise all sds are ignored and the scatter about the line takes their place. Throws
/// InputError if there are fewer than two distinct normal stresses or a value is not finite.
LinearLocus FitLocus(std::span<const ShearPoint> points);

struct ShearWarning {
  enum class Kind {
    too_few_points,            ///< fewer than three distinct normal stresses
    sds_ignored,               ///< some points have a sd, but not all have a shear_sd
    cohesion_not_positive,     ///< c ≤ 0: sigma_c = 0, ffc infinite
    cohesion_not_significant,  ///< 0 < c < 2 standard errors: ffc is little more than a lower bound
    friction_not_positive,     ///< tan(phi) ≤ 0: no yield locus of a powder
    preshear_above_locus,      ///< tau on the locus was taken instead of the preshear point's
    tension,                   ///< sigma_3 < 0; delta, not defined then, is given as 90°
    locus_not_concave,         ///< curves upwards significantly, which no yield locus does
    locus_curved,              ///< curves downwards significantly: a line overestimates c
    beyond_preshear,           ///< points with a larger normal stress than the preshear
    below_unconfined_circle,   ///< points left of where the circle of sigma_c touches
  };
  Kind kind;
  std::string text;  ///< a sentence with the numbers
};

/// sd: standard deviation. Infinite if the value is, or may well be; NaN if unknown.
struct Estimate {
  double value = 0;
  double sd = 0;
};

struct StrengthFigures {
  Estimate cohesion;                   ///< [Pa] c of the locus, as fitted
  Estimate tan_phi;                    ///< [-] of the locus
  Estimate phi;                        ///< [rad] angle of internal friction
  Estimate unconfined_yield_strength;  ///< [Pa] sigma_c ≥ 0
  /// Of the Mohr circle of steady state: through the preshear point and tangent to the locus, where
  /// it touches at a normal stress up to that of the preshear.
  Estimate major_principal_stress;       ///< [Pa] sigma_1
  Estimate minor_principal_stress;       ///< [Pa] sigma_3
  Estimate flow_function_coefficient;    ///< [-] ffc = sigma_1/sigma_c; infinite if sigma_c = 0
  Estimate inverse_flow_function;        ///< [-] 1/ffc, with a finite sd also for c near 0
  Estimate effective_friction_angle;     ///< [rad] delta: sin = (s1 − s3)/(s1 + s3)
  Estimate steady_state_angle;           ///< [rad] atan(tau/sigma) of the preshear, as measured
  double steady_tangent_stress = 0;      ///< [Pa] normal stress where the steady circle touches
  double unconfined_tangent_stress = 0;  ///< [Pa] where the circle of sigma_c does, c cos(phi)
  std::vector<ShearWarning> warnings;

  bool Has(ShearWarning::Kind kind) const;
};

/// The figures of a locus with its preshear point. Requires finite values, preshear.normal > 0,
/// shear ≥ 0; sds of 0 count as exact here. A preshear point above the locus has no circle; it is
/// moved down onto it.
///
/// The sds follow from the covariance of the fit and the sds of the preshear point, which must not
/// be among the fitted points: the joint normal distribution is taken apart into independent
/// directions, and the figures are evaluated at 32 equally likely values along each. For small sds
/// that is the delta method. It still holds for a preshear point close to the locus, where the
/// derivatives of the circle grow without bound.
StrengthFigures EvaluateStrength(const LinearLocus& locus, const ShearPoint& preshear);

/// Fit and figures, with the warnings on the points too. Throws like FitLocus().
StrengthFigures EvaluateStrength(std::span<const ShearPoint> points, const ShearPoint& preshear);

/// A shear test as measured, points in the order of the file.
struct ShearTest {
  std::vector<ShearPoint> points;
  std::vector<ShearPoint> preshears;  ///< any number
};

/// Reads a CSV file (core/table.h) with the columns
///   normal_stress [kPa], shear_stress [kPa]
/// (any unit of pressure) and, optional, shear_stress_sd, normal_stress_sd [kPa], 0 where unknown,
/// and preshear, 1 in the rows of preshear points and 0 elsewhere. Without it all rows are points
/// of the locus. Throws InputError with file and line for what Table refuses, for other columns,
/// negative stresses or sds, a preshear mark that is not 0 or 1, a preshear without normal stress,
/// and for fewer than two distinct normal stresses among the points.
ShearTest ReadYieldLocus(const std::string& path);
ShearTest ParseYieldLocus(const std::string& text, const std::string& file);

/// The mean of repeated preshears. Its sds: from the sds given or from the scatter of the points,
/// whichever is larger. Requires at least one.
ShearPoint MeanPoint(std::span<const ShearPoint> points);

}  // namespace powdercal
