#include "references/lock_ways.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/pi.h"
#include "fiber/rough_fiber.h"
#include "tress/base/random.h"

namespace tress::references {
namespace {

constexpr int most_fibers = 4096;
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

/// Where a path is between fibers.
struct BetweenFibers {
  fiber::FiberDirection back{0, 0};  ///< its theta: of the direction towards where the path is from
  double psi = 0;                    ///< that direction's azimuth from the slab's normal
  double place = 0;                  ///< depth, mean free paths

  BetweenFibers(const LockRequest& request, RandomStream& random)
      : back{static_cast<float>(angle_within(request.widest_theta, random)), 0},
        psi(angle_within(request.widest_azimuth, random)) {}

  /// To the next fiber; false: out of the slab.
  bool meets_fiber(double depth, RandomStream& random) {
    place -= std::log1p(-static_cast<double>(random.next())) * std::cos(psi);
    return place >= 0 && place <= depth;
  }
  /// phi: the azimuth that the fiber showed to `back`.
  void leaves(const fiber::FiberDirection& wi, float phi) {
    psi = std::remainder(psi + static_cast<double>(wi.phi - phi) + pi, 2 * pi);
    back.theta = -wi.theta;
  }

 private:
  /// Sines uniform.
  static double angle_within(double widest, RandomStream& random) {
    return std::asin(std::sin(widest) * (2 * static_cast<double>(random.next()) - 1));
  }
};

float way_of_path(const fiber::RoughFiber& fiber, float eccentricity, const LockRequest& request, std::uint64_t path) {
  RandomStream random(request.seed, 0, path);
  std::vector<fiber::SplitExit> exits;
  BetweenFibers at(request, random);
  double way = 0;
  for (int met = 0; met < most_fibers && at.meets_fiber(request.depth, random); ++met) {
    const float phi = shown_azimuth(eccentricity, random);
    const float h = 2 * random.next() - 1;
    fiber::RoughFiber::FacetNumbers u;
    for (auto& facet : u) {
      for (float& number : facet) number = random.next();
    }
    exits.clear();
    fiber.trace_split(fiber.entry({at.back.theta, phi}, h), u, random, exits);
    if (exits.empty()) break;
    const fiber::SplitExit& exit = choose(exits, random.next());
    way += static_cast<double>(exit.path);
    fiber::RoughExit left;
    left.direction = exit.direction;
    at.leaves(left.angles(), phi);
  }
  return static_cast<float>(way);
}

}  // namespace

LockRequest seen_as_color(const fiber::FiberParameters& fiber, LockRequest request) {
  constexpr double degree = pi / 180, along = 15, across = 40, tilted_along = 45, tilted_from = 1.5;
  const double share = std::min(static_cast<double>(fiber.tilt) / degree / tilted_from, 1.0);
  request.widest_theta = (along + share * (tilted_along - along)) * degree;
  request.widest_azimuth = (1 - share) * across * degree;
  return request;
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
