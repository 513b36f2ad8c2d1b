#include "tress/fiber/lock_color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "fiber/lock_color_table.h"

namespace tress::inline v0_2::fiber {
namespace {

/// The range of colors for which the table was fitted; beyond it ln(sigma_a) continues along its tangent.
constexpr double darkest = 0.045, lightest = 0.98;
constexpr double most_absorption = 20;

/// The position of x between the nodes of an axis, which ascend.
struct Place {
  std::size_t node;
  double share;  ///< weight of the next node
};

Place place_on(std::span<const double> axis, double x) {
  const double inside = std::fmin(std::fmax(x, axis.front()), axis.back());
  std::size_t node = 0;
  while (node + 2 < axis.size() && axis[node + 1] <= inside) ++node;
  return {node, (inside - axis[node]) / (axis[node + 1] - axis[node])};
}

/// Coefficients of ln(sigma_a / y), a polynomial in the root of y = -ln(color).
using Coefficients = std::array<double, lock_color_terms>;

Coefficients coefficients_of(const FiberParameters& fiber) {
  const std::array<Place, 4> places{place_on(lock_color_etas, fiber.eta), place_on(lock_color_tilts, fiber.tilt),
                                    place_on(lock_color_eccentricities, fiber.eccentricity),
                                    place_on(lock_color_log_roughnesses, std::log(fiber.roughness))};
  constexpr std::array sizes{lock_color_etas.size(), lock_color_tilts.size(), lock_color_eccentricities.size(),
                             lock_color_log_roughnesses.size()};
  Coefficients sum{};
  for (unsigned corner = 0; corner < 16; ++corner) {
    double weight = 1;
    std::size_t row = 0;
    for (std::size_t axis = 0; axis < places.size(); ++axis) {
      const bool next = (corner >> axis & 1) != 0;
      weight *= next ? places[axis].share : 1 - places[axis].share;
      row = row * sizes[axis] + places[axis].node + (next ? 1 : 0);
    }
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * lock_color_table[row][k];
  }
  return sum;
}

double polynomial(const Coefficients& a, double u) {
  double sum = 0;
  for (std::size_t k = a.size(); k-- > 0;) sum = sum * u + a[k];
  return sum;
}

double absorption(const Coefficients& a, double color) {
  const double y = -std::log(std::fmin(std::fmax(color, 0.001), 0.999)), least = -std::log(lightest),
               most = -std::log(darkest);
  if (y <= least) return y * std::exp(polynomial(a, std::sqrt(least)));
  if (y <= most) return y * std::exp(polynomial(a, std::sqrt(y)));
  constexpr double step = 1e-3;
  const double end = std::log(most) + polynomial(a, std::sqrt(most));
  const double before = std::log(most - step) + polynomial(a, std::sqrt(most - step));
  return std::min(std::exp(end + (y - most) * std::max((end - before) / step, 0.0)), most_absorption);
}

}  // namespace

glm::vec3 sigma_a_of_lock(const glm::vec3& color, const FiberParameters& fiber) {
  const Coefficients a = coefficients_of(fiber);
  glm::vec3 sigma_a(0.0f);
  for (int c = 0; c < 3; ++c) sigma_a[c] = static_cast<float>(absorption(a, static_cast<double>(color[c])));
  return sigma_a;
}

}  // namespace tress::inline v0_2::fiber
