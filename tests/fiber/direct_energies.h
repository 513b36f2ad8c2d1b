// Energies of the lobes traced ray by ray under their very absorption: what the energy table is held against.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "fiber/cross_section.h"
#include "fiber/energy_table.h"

namespace tress::test {

/// At any direction, radians, with `rays` midpoints, each followed until 1e-7 of it is left or through `last_order`;
/// what then is left counts as leaving there.
inline fiber::LobeEnergies direct_energies(double eta, double eccentricity, const glm::vec3& sigma_a, double phi_r,
                                           double theta, int rays, int last_order) {
  const fiber::CrossSection section(eta, eccentricity, phi_r, theta);
  std::array<double, fiber::lobe_count> clear{};
  std::array<std::array<double, 3>, fiber::lobe_count> colored{};
  for (int i = 0; i < rays; ++i) {
    const auto add = [&](int order, double weight, double path) {
      const auto lobe = static_cast<std::size_t>(order < fiber::traced_orders ? order : int(fiber::Lobe::residual));
      clear[lobe] += weight / rays;
      for (std::size_t c = 0; c < 3; ++c) {
        colored[lobe][c] += weight / rays * std::exp(-double(sigma_a[int(c)]) * path);
      }
    };
    double path;
    const double left =
        section.follow((2 * i + 1.0) / rays - 1, last_order, 1e-7, &path,
                       [&](int order, double weight, double, double, double length) { add(order, weight, length); });
    add(fiber::traced_orders, left, path);
  }
  fiber::LobeEnergies energies;
  for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
    energies.clear[p] = float(clear[p]);
    energies.colored[p] = glm::vec3(colored[p][0], colored[p][1], colored[p][2]);
  }
  return energies;
}

}  // namespace tress::test
