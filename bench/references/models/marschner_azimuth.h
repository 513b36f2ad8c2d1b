// Azimuthal scattering of Marschner, Jensen, Cammarano, Worley, Hanrahan 2003, "Light Scattering from Human Hair
// Fibers", sections 5.1 to 5.2 and table 1: R, TT, TRT without its caustics, and the caustics (GLINT).
//
// phi is the azimuth of the sampled direction relative to the known one. Lengths are in radii of a circular fiber.
// As in the paper, and kept with its faults since this is a reference:
// - phi(h) is a cubic in the angle of incidence; where light of order p leaves at phi is found from its roots.
// - Fresnel by two indices in two dimensions, eta' and eta'' (Bravais), exact for one polarisation only.
// - The ellipse is known to TRT alone, by an index eta*(phi_h) with a = e. Its axes are swapped: for e = 0.85 and the
//   known direction along the major axis it puts the caustic at 57 degrees, along the minor axis at 0.2; of the traced
//   ellipse the second is the wide one.
// - Nothing is normalised: caustics are taken out and put back with another energy.
// Where the printed reading is not finite it is bounded: eta* is at least smallest_index, the rate of the cubic at
// least smallest_rate. The caustic is taken out where the cubic has it (the exact caustic stands up to 3 degrees off,
// and would leave a singularity); its attenuation is that at the exact one. The fade beyond eta' = 2 is 1 at 2 and 0 at
// 2 + fade_range (printed as a smoothstep that rises). The path inside is 2 cos gamma_t (printed as its square).
#pragma once

#include <array>
#include <cstddef>

namespace tress::inline v0_2::fiber {

/// eta* >= this, where the printed formula falls to 0.73 at e = 0.5.
constexpr double smallest_index = 1.01;
/// Least |dphi/dgamma|: the printed TT has a caustic that no fiber has where eta' < 1.155.
constexpr double smallest_rate = 0.02;

/// What table 1 lets the user choose of the caustics. Radians, but for fade_range (of eta').
struct MarschnerCaustics {
  double width = 0.26;         ///< w_c, table 1: 10 to 25 degrees
  double fade_range = 0.3;     ///< Delta eta', 0.2 to 0.4
  double largest_share = 0.5;  ///< Delta h_M
};

/// One path of order p that leaves at the asked azimuth.
struct MarschnerPath {
  double density = 0;      ///< |2 dphi/dh|^-1, 1/rad
  double attenuation = 0;  ///< A(p, h) of clear hair, in [0, 1]
  double length = 0;       ///< inside, in radii, in three dimensions
  double cos_gamma = 1;    ///< of the angle of incidence
};

/// The paths of one azimuth.
struct MarschnerPaths {
  std::array<MarschnerPath, 9> path;
  std::size_t count = 0;
};

/// The two caustics of TRT, at +-azimuth.
struct MarschnerGlint {
  double azimuth = 0;      ///< phi_c of the cubic, radians, in [0, pi); 0 where they have merged
  double strength = 0;     ///< t, 1 for eta' < 2, falling to 0 at 2 + fade_range
  double share = 0;        ///< Delta h of each
  double attenuation = 0;  ///< A(2, h_c) at the exact h_c
  double length = 0;       ///< of that path

  /// Density of both at phi in [-pi, pi] without k_G and attenuation, 1/rad: of mass 2 share strength.
  double density(double phi, double width) const;
  /// What TRT is multiplied with at phi: 0 at a caustic of strength 1. In [0, 1].
  double removal(double phi, double width) const;
};

/// The circular cross-section seen at one inclination. Immutable; any thread.
class MarschnerCircle {
 public:
  /// eta: index that bends the projected rays, at least smallest_index; fiber_eta: of the fiber, for the inclination
  /// inside. theta_d within +-pi/2.
  MarschnerCircle(double eta, double fiber_eta, double theta_d);

  /// phi(p, gamma) - p pi by the cubic, by its derivative, and exactly. gamma in [-pi/2, pi/2].
  double cubic(int p, double gamma) const;
  double cubic_rate(int p, double gamma) const;
  double exact(int p, double gamma) const;

  /// All paths of order p in {0, 1, 2} that leave at phi in [-pi, pi].
  MarschnerPaths paths(int p, double phi) const;
  MarschnerGlint glint(const MarschnerCaustics& caustics) const;

  /// A(p, h) of clear hair at |gamma| <= pi/2.
  double attenuation(int p, double gamma) const;
  /// Length inside of order p, in radii.
  double length(int p, double gamma) const;
  double eta_prime() const { return eta_prime_; }
  /// h_c^2 = (4 - eta'^2)/3 of TRT, 0 where eta' >= 2.
  double caustic_offset() const;

 private:
  double eta_prime_, eta_other_;  ///< eta' and eta''
  double c_;                      ///< asin(1/eta')
  double inverse_cos_theta_t_;
};

/// eta*(phi_h) with a = e, as printed (axes swapped), at least smallest_index. phi_h in radians.
double marschner_index(double eta, double eccentricity, double phi_h);

/// TRT of a fiber of any eccentricity about the known azimuth phi_r (absolute): its circle of index eta*(phi_r +
/// phi/2).
MarschnerCircle marschner_trt_circle(double eta, double eccentricity, double phi_r, double theta_d, double phi);

}  // namespace tress::inline v0_2::fiber
