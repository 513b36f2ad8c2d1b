// States and directions where fiber models may fail: the exact corners of every coordinate, points near them on a
// logarithmic scale, and uniform ones. Pure functions of a seed. For tests and the atlas (bench/atlas) alike.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "fiber/row_axes.h"
#include "tress/base/random.h"
#include "tress/fiber/fiber_model.h"
#include "tress/fiber/parameters.h"

namespace tress::test {

inline constexpr float pole = 0.5f * std::numbers::pi_v<float>;
inline constexpr float degrees = std::numbers::pi_v<float> / 180;
inline constexpr float below_one = 0x1.fffffep-1f;
inline constexpr float denormal = 1e-42f;

inline float up(float x) { return std::nextafter(x, std::numeric_limits<float>::infinity()); }
inline float down(float x) { return std::nextafter(x, -std::numeric_limits<float>::infinity()); }

/// Half of all answers are corners, a quarter lie 2^-2 to 2^-26 of the range from one, a quarter are uniform.
inline float corner_or_near(RandomStream& random, std::span<const float> corners, float low, float high) {
  const std::uint64_t bits = random.next_bits();
  if ((bits & 3) == 3) return low + (high - low) * random.next();
  const float corner = corners[(bits >> 32) % corners.size()];
  if ((bits & 3) != 2) return corner;
  const float step = (high - low) * std::exp2(-26 + 24 * random.next());
  return std::clamp((bits & 4) != 0 ? corner + step : corner - step, low, high);
}

/// The largest sine of incidence that TT meets inside an ellipse, over the index: total reflection begins at 1.
inline double largest_inner_sine(double e, double eta_prime) {
  constexpr int steps = 48;
  double largest = 0;
  for (int i = 0; i <= steps; ++i) {  // point of entry, by the ellipse's parameter
    const double t = 0.5 * std::numbers::pi * i / steps, x = std::cos(t), y = e * std::sin(t);
    const double normal = std::hypot(x, y / (e * e)), nx = x / normal, ny = y / (e * e) / normal;
    for (const double side : {-1.0, 1.0}) {  // a grazing ray is bent furthest
      const double s = side / eta_prime, c = std::sqrt(std::max(1 - s * s, 0.0));
      const double dx = -c * nx - s * ny, dy = -c * ny + s * nx;
      const double chord = -2 * (x * dx + y * dy / (e * e)) / (dx * dx + dy * dy / (e * e));
      const double ex = x + chord * dx, ey = (y + chord * dy) / (e * e), length = std::hypot(ex, ey);
      largest = std::max(largest, std::abs(dx * ey - dy * ex) / length * eta_prime);
    }
  }
  return largest;
}

inline double bravais(double eta, double theta_d) {
  const double s = std::sin(theta_d);
  return std::sqrt((eta * eta - s * s) / (1 - s * s));
}

/// The |theta_d| from which on light is not totally reflected within the ellipse any more (TT); 0 if no
/// direction is such an edge.
inline float total_reflection_edge(double eta, double e) {
  double low = 0, high = 1.56;
  const auto total = [&](double theta_d) { return largest_inner_sine(e, bravais(eta, theta_d)) > 1 + 1e-9; };
  if (total(low) == total(high)) return 0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    (total(middle) == total(low) ? low : high) = middle;
  }
  return static_cast<float>(low);
}

/// The |theta_d| at which eta' = 2: the two caustics of TRT of a circle merge. 0 if no direction has it.
inline float caustic_merge(double eta) {
  const double s2 = (4 - eta * eta) / 3;
  return s2 > 0 && s2 < 1 ? static_cast<float>(std::asin(std::sqrt(s2))) : 0;
}

struct AdversarialFiber {
  fiber::FiberParameters parameters;
  std::vector<float> theta_d;  ///< >= 0: total reflection, merging caustics, nodes of the rows
  std::vector<float> phi_r;    ///< nodes of the rows, in [0, pi/2]
  /// Some blur is below that of the grid: every query is then traced.
  bool is_narrow = false;
};

inline void add_edges(AdversarialFiber& made) {
  const fiber::FiberParameters& p = made.parameters;
  for (const float edge : {total_reflection_edge(double{p.eta}, double{p.eccentricity}), caustic_merge(double{p.eta})})
    made.theta_d.push_back(edge);
  const std::vector<float> inclinations = fiber::inclination_axis();
  made.theta_d.insert(made.theta_d.end(), inclinations.begin(), inclinations.end());
  for (const float sigma : fiber::azimuthal_sigmas(p)) {
    made.is_narrow = made.is_narrow || sigma < fiber::smallest_grid_sigma * (1 - 1e-5f);
    const std::vector<float> nodes = fiber::azimuth_axis(p.eccentricity, std::max(sigma, fiber::smallest_grid_sigma));
    made.phi_r.insert(made.phi_r.end(), nodes.begin(), nodes.end());
  }
}

inline constexpr std::uint32_t corner_fibers = 48, first_dark_fiber = 56, dark_fibers = 8;

/// Fiber `index` of a seed: all corners of (eta, e, sigma, sigma_a, lambda) up to corner_fibers, then mixes of corners,
/// near and uniform values of everything, but for some that are all but black; one in eight has gains, other shapes of
/// M, other Fresnel terms, or a glint.
inline AdversarialFiber adversarial_fiber(std::uint64_t seed, std::uint32_t index) {
  RandomStream random(seed, 0xf1be5, index);
  AdversarialFiber made;
  fiber::FiberParameters& p = made.parameters;
  const auto set_widths = [&p](float sigma, float lambda) {
    p.azimuthal_sigma.fill(sigma);
    p.longitudinal_lambda.fill(lambda);
  };
  const float widest = 45 * degrees, narrowest = 0.5f * degrees, least_lambda = 0.25f * degrees;
  if (index < corner_fibers) {
    p.eta = (index & 1) != 0 ? 2.0f : 1.2f;
    p.eccentricity = (index & 2) != 0 ? 1.0f : 0.5f;
    p.sigma_a = glm::vec3((index & 4) != 0 ? 100.0f : 0.0f);
    set_widths(std::array{narrowest, fiber::smallest_grid_sigma, widest}[index / 16],
               (index & 8) != 0 ? widest : least_lambda);
    p.roughness = (index & 1) != 0 ? 0.01f : 1.0f;
    p.tilt = (index & 2) != 0 ? 0.0f : 15 * degrees;
    add_edges(made);
    return made;
  }
  if (index >= first_dark_fiber && index < first_dark_fiber + dark_fibers) {
    // Next to no light or none: R hidden, absorption up to what a scene may say, gains of nothing.
    set_widths(widest, 10 * degrees);
    p.eccentricity = 1;
    const std::uint32_t kind = index - first_dark_fiber;
    p.gain[0] = glm::vec3(0.0f);
    p.sigma_a = std::array{glm::vec3(1e4f), glm::vec3(1e4f, 0, 1e4f), glm::vec3(100.0f), glm::vec3(1.0f)}[kind & 3];
    if (kind >= 2) p.gain.fill(glm::vec3(std::array{1e-40f, 1e-38f, 1e-30f, 0.0f, denormal, 1e-36f}[kind - 2]));
    add_edges(made);
    return made;
  }
  constexpr std::array etas{1.2f, 2.0f, 1.05f, 3.0f, 1.9999999f, 2.0000002f, 1.55f, 1.1547005f};
  p.eta = std::clamp(corner_or_near(random, etas, 1.2f, 2.0f), 1.05f, 3.0f);
  constexpr std::array es{0.5f, 0.50000006f, 1.0f, 0.99999994f, 0.85f, 0.70710678f};
  p.eccentricity = corner_or_near(random, es, 0.5f, 1.0f);
  constexpr std::array alphas{0.01f, 1.0f, 0.2f}, tilts{0.0f, 15 * degrees, 0.0523599f};
  p.roughness = corner_or_near(random, alphas, 0.01f, 1.0f);
  p.tilt = corner_or_near(random, tilts, 0.0f, 15 * degrees);
  constexpr std::array absorptions{0.0f, denormal, 1e-20f, 100.0f, 1.0f, 20.0f};
  for (int c = 0; c < 3; ++c) p.sigma_a[c] = corner_or_near(random, absorptions, 0.0f, 100.0f);
  const std::array sigmas{fiber::smallest_grid_sigma, up(fiber::smallest_grid_sigma), down(fiber::smallest_grid_sigma),
                          widest, 4.0f * degrees};
  const std::array lambdas{least_lambda, widest, 3 * degrees};
  // Narrow blurs are slow everywhere, and grids of 4 degrees have many rows: one fiber in eight and in four.
  const float kind = random.next();
  const float least_sigma = kind < 0.125f ? narrowest : (kind < 0.375f ? 4.01f : 10.0f) * degrees;
  for (auto& sigma : p.azimuthal_sigma) {
    if (random.next() < 0.8f) sigma = std::max(corner_or_near(random, sigmas, least_sigma, widest), least_sigma);
  }
  for (auto& lambda : p.longitudinal_lambda) {
    if (random.next() < 0.8f) lambda = corner_or_near(random, lambdas, least_lambda, widest);
  }
  if (random.next() < 0.2f) {
    p.longitudinal_shape = random.next() < 0.5f ? fiber::LongitudinalShape::gaussian : fiber::LongitudinalShape::cauchy;
  }
  if (random.next() < 0.125f) {
    p.reflection_fresnel = static_cast<fiber::ReflectionFresnel>(1 + static_cast<int>(3 * random.next()));
  }
  p.split_glint = random.next() < 0.25f;
  if (random.next() < 0.125f) {
    constexpr std::array gains{0.0f, 1.0f, 100.0f, denormal, 1e-6f};
    for (glm::vec3& gain : p.gain) {
      for (int c = 0; c < 3; ++c) gain[c] = corner_or_near(random, gains, 0.0f, 2.0f);
    }
  }
  add_edges(made);
  return made;
}

/// The known direction and the random numbers of one event.
struct AdversarialEvent {
  fiber::FiberDirection wr;
  float xi1 = 0, xi2 = 0, h = 0;
  std::array<float, 4> u{};
};

inline float adversarial_uniform(RandomStream& random) {
  static constexpr std::array corners{0.0f, below_one, 0x1p-24f, denormal, 0.5f, 0x1.fffffep-2f};
  return std::min(corner_or_near(random, corners, 0.0f, 1.0f), below_one);
}

inline float adversarial_theta(RandomStream& random) {
  static const std::array corners{pole,  -pole,           down(pole),       up(-pole), up(pole),         0.0f,
                                  -0.0f, 89.9f * degrees, -89.9f * degrees, denormal,  -89.95f * degrees};
  return corner_or_near(random, corners, -pole, pole);
}

inline float adversarial_phi(RandomStream& random) {
  constexpr float pi = std::numbers::pi_v<float>;
  static const std::array corners{0.0f,        -0.0f,       pole, -pole,    up(pole), down(pole), up(-pole),
                                  down(-pole), pi,          -pi,  down(pi), up(-pi),  up(pi),     denormal,
                                  7.0f,        -12345.678f, 1e7f, -3e38f,   3e10f};
  return corner_or_near(random, corners, -pi, pi);
}

inline AdversarialEvent adversarial_event(RandomStream& random, const AdversarialFiber& fiber) {
  constexpr float pi = std::numbers::pi_v<float>;
  AdversarialEvent event;
  event.wr = {adversarial_theta(random), adversarial_phi(random)};
  const std::uint64_t bits = random.next_bits();
  if ((bits & 3) == 0 && !fiber.phi_r.empty()) {  // a row's node, folded any way
    const float node = fiber.phi_r[(bits >> 32) % fiber.phi_r.size()];
    const std::array folded{node, -node, pi - node, node - pi};
    event.wr.phi = folded[(bits >> 2) & 3];
    if ((bits & 16) != 0) event.wr.phi = (bits & 32) != 0 ? up(event.wr.phi) : down(event.wr.phi);
  }
  event.xi1 = adversarial_uniform(random);
  event.xi2 = adversarial_uniform(random);
  static constexpr std::array offsets{-1.0f, 1.0f, -below_one, below_one, 0.0f, 0.5f};
  event.h = corner_or_near(random, offsets, -1.0f, 1.0f);
  for (float& u : event.u) u = adversarial_uniform(random);
  return event;
}

/// u[0] at the ends of the lobes' shares, which only begin() knows: one event in four.
inline void to_edge_of_lobes(RandomStream& random, const fiber::FiberEvent& event, std::array<float, 4>& u) {
  const std::uint64_t bits = random.next_bits();
  if ((bits & 3) != 0) return;
  float below = 0;
  for (std::size_t p = 0; p <= (bits >> 8) % fiber::lobe_count; ++p) below += event.selection[p];
  u[0] = std::clamp(std::array{below, up(below), down(below), below}[(bits >> 2) & 3], 0.0f, below_one);
}

/// A direction to be asked about: a corner of its own, or one by the known direction (specular, back, opposite, at an
/// edge or node of |theta_d|), each exactly or one float beside.
inline fiber::FiberDirection adversarial_direction(RandomStream& random, const AdversarialFiber& fiber,
                                                   const fiber::FiberDirection& wr) {
  constexpr float pi = std::numbers::pi_v<float>;
  fiber::FiberDirection wi{adversarial_theta(random), adversarial_phi(random)};
  const std::uint64_t bits = random.next_bits();
  const auto beside = [](float x, std::uint64_t choice) {
    return (choice & 2) != 0 ? x : (choice & 1) != 0 ? up(x) : down(x);
  };
  const float edge = fiber.theta_d[(bits >> 32) % fiber.theta_d.size()];
  const float merge = fiber.theta_d[(bits >> 31) & 1];
  switch (bits & 7) {
    case 0:
      wi.theta = -wr.theta;
      break;
    case 1:
      wi.theta = wr.theta;
      break;
    case 2:
      wi.theta = wr.theta > 0 ? wr.theta - 2 * edge : wr.theta + 2 * edge;
      break;
    case 3:
      wi.theta = wr.theta > 0 ? wr.theta - 2 * merge : wr.theta + 2 * merge;
      break;
    case 4:
      wi.theta = -wr.theta + 2 * fiber.parameters.tilt * (static_cast<float>((bits >> 20) & 7) - 2);
      break;
    default:
      break;
  }
  wi.theta = beside(wi.theta, bits >> 3);
  switch ((bits >> 5) & 7) {
    case 0:
      wi.phi = wr.phi;
      break;
    case 1:
      wi.phi = wr.phi + pi;
      break;
    case 2:
      wi.phi = wr.phi - pi;
      break;
    case 3:
      wi.phi = -wr.phi;
      break;
    default:
      break;
  }
  wi.phi = beside(wi.phi, bits >> 8);
  return wi;
}

}  // namespace tress::test
