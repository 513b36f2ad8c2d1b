#include "fiber/reflection.h"

#include <algorithm>
#include <cmath>

namespace tress::inline v0_2::fiber {

float reflected_energy(ReflectionFresnel fresnel, float eta, float eccentricity, float theta_r, float phi_r) {
  const ReflectionLobe lobe(eta, eccentricity, theta_r, phi_r, 0, 0, smallest_lambda, fresnel);
  if (fresnel == ReflectionFresnel::none || fresnel == ReflectionFresnel::longitudinal) return lobe.fresnel()(1);
  // Integrates over half angles, in panels between the kinks of F. With x = u^3 (10 - 15 u + 6 u^2), integrands and
  // their slopes vanish at both ends of a panel, whatever roots F has there, so midpoints converge with the fourth
  // power.
  constexpr int nodes = 64;
  const float kink = std::asin(std::min(lobe.fresnel().total_reflection(), 1.0f));
  double sum = 0;
  const auto add_panel = [&](float from, float to) {
    if (!(to > from)) return;
    for (int i = 0; i < nodes; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / nodes, rest = 1 - u;
      const float half = from + (to - from) * u * u * u * (10 + u * (6 * u - 15));
      const float width = 30 * u * u * rest * rest * (to - from) / nodes;
      sum += static_cast<double>(lobe.energy_density(phi_r + 2 * half) * 2 * width);
    }
  };
  add_panel(-half_pi, -kink);
  add_panel(-kink, kink);
  add_panel(kink, half_pi);
  return static_cast<float>(sum);
}

}  // namespace tress::inline v0_2::fiber
