// Where rays leave fibers, in a dense bundle: ribbons with FiberScene's starts against circles of glass, which are
// traced by refraction at their surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "geometry/straight_strands.h"
#include "support/chi_square.h"
#include "support/scale.h"

namespace tress::geometry {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double eta = 1.55, radius = 0.05;
constexpr int fibers = 160;  // 0.4 of a disk of radius 1

/// Axes of fibers that do not overlap, within the unit disk.
std::vector<glm::dvec2> bundle() {
  RandomStream random(31);
  std::vector<glm::dvec2> axes;
  while (axes.size() < fibers) {
    const float x = random.next(), y = random.next();
    const glm::dvec2 candidate(2 * x - 1, 2 * y - 1);
    bool is_free = glm::length(candidate) < 1;
    for (const glm::dvec2& other : axes) is_free = is_free && glm::distance(candidate, other) > 2.01 * radius;
    if (is_free) axes.push_back(candidate);
  }
  return axes;
}

double reflectance(double cosine) {
  const double refracted = std::sqrt(1 - (1 - cosine * cosine) / (eta * eta));
  const double s = (cosine - eta * refracted) / (cosine + eta * refracted);
  const double p = (eta * cosine - refracted) / (eta * cosine + refracted);
  return 0.5 * (s * s + p * p);
}

/// Angle from the way back to the light, in bins of 10 degrees; both sides of the light are one.
using Counts = std::vector<double>;
void count(const glm::dvec2& direction, Counts& counts) {
  const double angle = std::abs(std::atan2(direction.x, -direction.y));
  counts[std::min(counts.size() - 1, static_cast<std::size_t>(angle / (pi / 18)))] += 1;
}

/// Where rays that come up along y leave, of those that met something.
Counts traced_through_glass(const std::vector<glm::dvec2>& axes, int rays) {
  Counts counts(18);
  for (int i = 0; i < rays; ++i) {
    RandomStream random(5, static_cast<std::uint64_t>(i));
    glm::dvec2 at(random.next() - 0.5, -2), way(0, 1);
    bool has_met = false;
    for (;;) {
      std::optional<std::size_t> nearest;
      double distance = 1e9;
      for (std::size_t k = 0; k < axes.size(); ++k) {
        const glm::dvec2 to = axes[k] - at;
        const double along = glm::dot(to, way), off2 = glm::dot(to, to) - along * along;
        if (off2 >= radius * radius) continue;
        const double here = along - std::sqrt(radius * radius - off2);
        if (here > 1e-9 && here < distance) nearest = k, distance = here;
      }
      if (!nearest) break;
      has_met = true;
      at += distance * way;
      glm::dvec2 normal = (at - axes[*nearest]) / radius;
      const double cosine = -glm::dot(way, normal), share = reflectance(cosine);
      if (random.next() < share) {
        way += 2 * cosine * normal;
        continue;
      }
      way = way / eta + (cosine / eta - std::sqrt(1 - (1 - cosine * cosine) / (eta * eta))) * normal;
      for (bool is_inside = true; is_inside;) {  // along chords; of one circle every reflectance is the same
        at += -2.0 * glm::dot(way, at - axes[*nearest]) * way;
        normal = (at - axes[*nearest]) / radius;
        const double inner = glm::dot(way, normal);
        if (random.next() < share) {
          way -= 2 * inner * normal;
        } else {
          way = eta * way + (std::sqrt(std::max(0.0, 1 - eta * eta * (1 - inner * inner))) - eta * inner) * normal;
          is_inside = false;
        }
      }
    }
    if (has_met) count(way, counts);
  }
  return counts;
}

/// The same by ribbons: the way out by the azimuth that a smooth circle turns by, the start by ray_from.
Counts through_ribbons(const std::vector<glm::dvec2>& axes, int rays) {
  std::vector<StraightStrand> strands;
  for (const glm::dvec2& axis : axes) strands.push_back({{axis.x, axis.y, -1}, {axis.x, axis.y, 1}, radius, radius, 1});
  const scene::Scene scene = straight_scene(strands, true, 2);
  const FiberScene fiber_scene(scene);
  Counts counts(18);
  for (int i = 0; i < rays; ++i) {
    RandomStream random(6, static_cast<std::uint64_t>(i));
    Ray ray{{random.next() - 0.5f, -2, 0}, {0, 1, 0}};
    std::optional<Hit> hit;
    bool has_met = false;
    while ((hit = fiber_scene.intersect(ray))) {
      has_met = true;
      const double offset = std::clamp<double>(hit->share, -1, 1);
      const double gamma = std::asin(offset), inner = std::asin(offset / eta);
      const double share = reflectance(std::cos(gamma));
      int order = 0;
      if (random.next() >= share) {
        order = 1;
        while (random.next() < share) ++order;
      }
      const double clockwise = 2 * order * inner - 2 * gamma + (1 - order) * pi;
      const double azimuth = std::atan2(double{ray.direction.y}, double{ray.direction.x}) - clockwise;
      ray = ray_from(*hit, {static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth)), 0});
    }
    if (has_met) count({ray.direction.x, ray.direction.y}, counts);
  }
  return counts;
}

/// Two samples of one law: chi-square over 18 bins. Seeds 5 and 6, false-alarm rate 1e-4. Starts on the axes are found
/// out (p = 8e-94).
TEST(Bundle, LightLeavesItAsItLeavesCirclesOfGlass) {
  const std::vector<glm::dvec2> axes = bundle();
  const int rays = 60000 / test::scale();
  const Counts truth = traced_through_glass(axes, rays), ours = through_ribbons(axes, rays);
  double of_truth = 0, of_ours = 0, statistic = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) of_truth += truth[k], of_ours += ours[k];
  EXPECT_GT(test::z_test(of_ours, of_truth, std::sqrt(2 * of_truth)), 1e-4);  // how many met something
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double difference = truth[k] * std::sqrt(of_ours / of_truth) - ours[k] * std::sqrt(of_truth / of_ours);
    if (truth[k] + ours[k] > 0) statistic += difference * difference / (truth[k] + ours[k]);
  }
  EXPECT_GT(test::upper_gamma(0.5 * 17, 0.5 * statistic), 1e-4);
}

}  // namespace
}  // namespace tress::geometry
