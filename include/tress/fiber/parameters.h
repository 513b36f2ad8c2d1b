// The parameters of a fiber. Their defaults are defined here only.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>

#include "tress/fiber/lobes.h"

namespace tress::inline v0_2::fiber {

/// Shape of the longitudinal lobes M in theta_h. All are truncated to the hemisphere and normalised there. lambda is
/// the logistic scale; the other shapes convert it to a width with the same half width at half maximum.
enum class LongitudinalShape { logistic, gaussian, cauchy };

/// Fresnel reflectance of R (the paper's figure 5). The other lobes always have the exact one, so that only `exact`
/// conserves energy.
enum class ReflectionFresnel {
  exact,         ///< by the angle of incidence in three dimensions: azimuth and inclination
  longitudinal,  ///< by the inclination only, as at azimuthally normal incidence
  bravais,       ///< Marschner et al. 2003: eta' and eta'' by the azimuthal angle of incidence
  none,          ///< reflectance 1
};

/// Widths of all lobes, radians, as in FiberParameters.
struct LobeWidthsGiven {
  std::array<float, 3> azimuthal_sigma;      ///< TT, TRT, TRRT
  std::array<float, 4> longitudinal_lambda;  ///< R, TT, TRT, TRRT

  friend bool operator==(const LobeWidthsGiven&, const LobeWidthsGiven&) = default;
};

/// Angles in radians. Lengths of the cross-section are in units of the major semi-axis.
struct FiberParameters {
  float eta = 1.55f;           ///< index of refraction, [1.05, 3]
  float eccentricity = 0.85f;  ///< minor over major semi-axis, [0.5, 1]
  /// alpha, Beckmann slope parameter, [0.01, 1]; down to 0.001 where all widths below are set. It determines the
  /// energies of the lobes, whatever their widths, and those widths that are not set below.
  float roughness = 0.2f;
  float tilt = 0.0523599f;  ///< cuticle tilt tau >= 0, scales rise towards the tip; 3 degrees
  glm::vec3 sigma_a{1.3f * 0.419f, 1.3f * 0.697f, 1.3f * 1.37f};  ///< absorption per major semi-axis, >= 0, RGB
  /// A concentric core, as in fur: an ellipse of this share, [0, 0.95], of the semi-axes; 0: no medulla. It has the
  /// cortex's index, so light enters it straight, and no pigment: sigma_a applies to the cortex alone. Only the models
  /// `rough` and `fiber3d` have a medulla, and a cortex that scatters.
  float medulla_radius = 0;
  float medulla_scattering = 0;  ///< coefficient, per major semi-axis, [0, 100]
  float medulla_asymmetry = 0;   ///< g of Henyey and Greenstein's phase function, [-0.95, 0.95]; > 0: forward
  float medulla_absorption = 0;  ///< coefficient, grey, per major semi-axis, [0, 100]
  /// The next two describe scattering in the cortex, which makes light of bleached or grey hair diffuse. The cortex has
  /// pigment too, so light is colored by the length of its bent way.
  float cortex_scattering = 0;  ///< coefficient, per major semi-axis, [0, 20]
  float cortex_asymmetry = 0;   ///< [-0.95, 0.95]
  /// Share of the surface that a thin film of water covers, [0, 1]. It follows the fiber, fills the gaps between the
  /// scales, and its outer surface is smoother. For the models `rough` and `fiber3d`.
  float wetness = 0;
  /// Overrides by lobe, TT, TRT, TRRT: blur of the exit azimuth (standard deviation), [0.5, 45] degrees ...
  std::array<std::optional<float>, 3> azimuthal_sigma{};
  /// ... and logistic scale in theta_h, R, TT, TRT, TRRT, [0.25, 45] degrees.
  std::array<std::optional<float>, 4> longitudinal_lambda{};
  /// The widths of the lobes of Chiang et al. 2016, for a fiber that is given by them (principled_hair.h). The model
  /// `chiang2016` uses them; all other models use the widths above instead.
  std::optional<LobeWidthsGiven> published_widths{};

  LongitudinalShape longitudinal_shape = LongitudinalShape::logistic;
  ReflectionFresnel reflection_fresnel = ReflectionFresnel::exact;
  /// Artistic factor on E_p (the paper's A_p): gain kappa times tint, per lobe and channel, >= 0. A fiber with a gain
  /// above 1 may return more light than it receives.
  LobeColors gain = [] {
    LobeColors ones;
    ones.fill(glm::vec3(1.0f));
    return ones;
  }();
  bool split_glint = false;  ///< whether GLINT is a separate lobe beside the rest of TRT; else it is part of TRT
  /// Share, [0.01, 1], of the usual number of paths that trace the energies. Their noise grows by the root of it, and
  /// start-up time shrinks by it. For a host with many fibers that are variations of one and are seen together: their
  /// noise is independent. tress gives a material whose strands have n shapes 8/n, but at least 1/8.
  float energy_path_share = 1;

  friend bool operator==(const FiberParameters&, const FiberParameters&) = default;
};

/// Azimuthal sigma of TT, TRT, TRRT, radians: as set, else from the roughness alpha: 0.5, 1.8 and 3 alpha, at most 45
/// degrees.
std::array<float, 3> azimuthal_sigmas(const FiberParameters& fiber);

/// Logistic scale lambda of lobe p = 0 (R), 1, 2, 3 for the known inclination theta_r, radians; R's is without the
/// factor |cos(d/2)|. It is the value that is set, else it follows from the roughness as 0.390, 0.196/cos theta_r,
/// 0.66, 0.9 alpha, within [0.25, 45] degrees.
float longitudinal_lambda(const FiberParameters& fiber, int p, float theta_r);

/// Tilt of lobe p in theta_h: -tau, tau/2, 3 tau/2, 5 tau/2. The model `elliptical` has no tilt for p = 3 and the
/// residual if their lambda follows the roughness; lambda is larger by tau there.
float lobe_tilt(const FiberParameters& fiber, int p);

/// The tilt that roughness adds to TT, TRT and TRRT, whose lobe the residual has (0 for R, and if the lobe's lambda is
/// set): light that enters a rough fiber at an inclination leaves it nearer to the normal plane. It has the sign of
/// theta_r and is at most t/k. With t = |theta_r|, radians, it is
///  x = 0.3 alpha^2 tan t / cos^2 t (TT), 3 alpha^2 tan t (others),  shift = x/(1 + k x/t), k = 10 (TT), 4 (others).
/// It is fitted to fibers traced in three dimensions (bench/README.md, fiber3d; bench/atlas/README.md, maps).
float roughness_shift(const FiberParameters& fiber, int p, float theta_r);

/// sigma_a that gives fibers of multiple scattering albedo `color` and azimuthal roughness beta_N (Chiang et al. 2016).
/// color: linear RGB, clamped to [1e-6, 1].
glm::vec3 sigma_a_from_color(const glm::vec3& color, double radial_roughness = 0.3);
/// sigma_a of melanin concentrations >= 0: (0.419, 0.697, 1.37) per unit of eumelanin and (0.187, 0.4, 1.05) per unit
/// of pheomelanin.
glm::vec3 sigma_a_from_melanin(float eumelanin, float pheomelanin);

/// T(e) of the paper's section 9.2, a^-1 = 1/e, clamped to [1, 8].
double curl_type(double eccentricity);
/// Curl diameter in cm, table 4, linear in T between its entries.
double curl_diameter_cm(double eccentricity);
/// Rotation of the major axis at length l from the root, radians in [0, 2 pi): 2 l / CD mod 2 pi.
double major_axis_rotation(double length_cm, double curl_diameter_cm);

/// Major semi-axis of the ellipse whose mean projected width is that of a circle of this radius:
/// a = radius pi / (2 E(1 - e^2)), E the complete elliptic integral of the second kind of parameter m.
double major_semi_axis(double radius, double eccentricity);
/// w(phi) = sqrt(sin^2 phi + e^2 cos^2 phi): projected half width over the major semi-axis.
float projected_half_width(float phi, float eccentricity);

}  // namespace tress::inline v0_2::fiber
