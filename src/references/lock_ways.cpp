#include "references/lock_ways.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "fiber/rough_fiber.h"
#include "tress/base/random.h"

namespace tress::references {
namespace {

constexpr int most_fibers = 4096;
constexpr double pi = std::numbers::pi;
constexpr double least_log = -16, most_log = 6.9;  // of an absorption
constexpr int bisections = 60;

/// The azimuth that a fiber shows to the light: with a probability in proportion to its width there.
float shown_azimuth(float eccentricity, RandomStream& random) {
  while (true) {
    const float phi = static_cast<float>(2 * pi) * (random.next() - 0.5f);
    if (random.next() < fiber::projected_half_width(phi, eccentricity)) return phi;
  }
}

const fiber::SplitExit& choose(const std::vector<fiber::SplitExit>& exits, float u) {
  float total = 0;
  for (const fiber::SplitExit& exit : exits) total += exit.weight;
  float left = u * total;
  std::size_t chosen = 0;
  while (chosen + 1 < exits.size() && left >= exits[chosen].weight) left -= exits[chosen++].weight;
  return exits[chosen];
}

float way_of_path(const fiber::RoughFiber& fiber, float eccentricity, const LockRequest& request, std::uint64_t path) {
  RandomStream random(request.seed, 0, path);
  std::vector<fiber::SplitExit> exits;
  const double sine = std::sin(request.widest_theta) * (2 * static_cast<double>(random.next()) - 1);
  fiber::FiberDirection back{static_cast<float>(std::asin(sine)), 0};  // towards where the path is from
  double psi = 0, place = 0, way = 0;                                  // its azimuth from the slab's normal; depth
  for (int met = 0; met < most_fibers; ++met) {
    place -= std::log1p(-static_cast<double>(random.next())) * std::cos(psi);
    if (place < 0 || place > request.depth) break;
    const float phi = shown_azimuth(eccentricity, random);
    const float h = 2 * random.next() - 1;
    fiber::RoughFiber::FacetNumbers u;
    for (auto& facet : u) {
      for (float& number : facet) number = random.next();
    }
    exits.clear();
    fiber.trace_split(fiber.entry({back.theta, phi}, h), u, random, exits);
    if (exits.empty()) break;
    const fiber::SplitExit& exit = choose(exits, random.next());
    way += static_cast<double>(exit.path);
    fiber::RoughExit left;
    left.direction = exit.direction;
    const fiber::FiberDirection wi = left.angles();
    psi = std::remainder(psi + static_cast<double>(wi.phi - phi) + pi, 2 * pi);
    back.theta = -wi.theta;
  }
  return static_cast<float>(way);
}

}  // namespace

double widest_theta_of_color(const fiber::FiberParameters& fiber) {
  constexpr double untilted_deg = 15, tilted_deg = 45, tilted_from_deg = 1.5;
  const double share = std::min(double{fiber.tilt} * 180 / pi / tilted_from_deg, 1.0);
  return (untilted_deg + share * (tilted_deg - untilted_deg)) * pi / 180;
}

std::vector<float> lock_ways(const fiber::FiberParameters& fiber, const LockRequest& request) {
  fiber::FiberParameters clear = fiber;
  clear.sigma_a = glm::vec3(0.0f);
  clear.medulla_radius = 0;
  const fiber::RoughFiber rough(clear);
  std::vector<float> ways(request.paths);
  tbb::parallel_for(std::size_t{0}, ways.size(),
                    [&](std::size_t path) { ways[path] = way_of_path(rough, fiber.eccentricity, request, path); });
  return ways;
}

double lock_radiance(std::span<const float> ways, double sigma_a) {
  double sum = 0;
  for (const float way : ways) sum += std::exp(-sigma_a * static_cast<double>(way));
  return sum / static_cast<double>(ways.size());
}

double lock_absorption(std::span<const float> ways, double radiance) {
  double low = least_log, high = most_log;
  for (int i = 0; i < bisections; ++i) {
    const double middle = 0.5 * (low + high);
    (lock_radiance(ways, std::exp(middle)) > radiance ? low : high) = middle;
  }
  return std::exp(low);
}

}  // namespace tress::references
