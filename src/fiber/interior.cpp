#include "fiber/interior.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace tress::inline v0_2::fiber {
namespace {

constexpr int most_scatterings = 1 << 16;  // light that scatters more often counts as absorbed
constexpr float least_across = 1e-12f;     // least squared length of a direction's part across the fiber

/// A ray in the circle that represents the cross-section (x, y/e).
struct Line {
  glm::vec2 across;
  float across2;

  Line(const glm::vec3& direction, float eccentricity)
      : across(direction.y, direction.z / eccentricity), across2(std::max(glm::dot(across, across), least_across)) {}

  /// The distance from a point within the circle of that radius to where the line leaves it.
  float way_out(const glm::vec2& point, float radius) const {
    const float b = glm::dot(point, across) / across2;
    const float c = std::max(radius * radius - glm::dot(point, point), 0.0f) / across2;
    return std::max(std::sqrt(b * b + c) - b, 0.0f);
  }
};

/// The cosine to the incoming direction, drawn from Henyey and Greenstein's law.
float cosine_of_scattering(float g, float u) {
  if (std::abs(g) < 1e-3f) return 1 - 2 * u;
  const float share = (1 - g * g) / (1 - g + 2 * g * u);
  return std::clamp((1 + g * g - share * share) / (2 * g), -1.0f, 1.0f);
}

glm::vec3 scattered(const glm::vec3& direction, float g, RandomStream& random) {
  const float cosine = cosine_of_scattering(g, random.next()), sine = std::sqrt(1 - cosine * cosine);
  const float turn = 2 * std::numbers::pi_v<float> * random.next();
  const glm::vec3 axis = std::abs(direction.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 side = glm::normalize(glm::cross(direction, axis)), other = glm::cross(direction, side);
  return glm::normalize(cosine * direction + sine * (std::cos(turn) * side + std::sin(turn) * other));
}

}  // namespace

InnerWay cross_interior(const TracedParts& parts, float eccentricity, InnerRay& ray, RandomStream& random) {
  InnerWay way;
  Line line(ray.direction, eccentricity);
  const auto flight = [&random](float scattering) {
    return scattering > 0 ? -std::log(1 - random.next()) / scattering : std::numeric_limits<float>::infinity();
  };
  const auto fly = [&](float length) {
    ray.point += length * line.across;
    way.along += length * ray.direction.x;
  };
  const auto scatter = [&](float asymmetry) {
    ray.direction = scattered(ray.direction, asymmetry, random);
    line = Line(ray.direction, eccentricity);
  };
  int met = 0;
  float in_core = 0;  // the way through the core from here, if `within`
  bool within = false, was_within = false;
  for (;;) {
    if (within) {
      const float flies = flight(parts.scattering), flown = std::min(flies, in_core);
      way.kept *= std::exp(-parts.absorption * flown);
      fly(flown);
      if (flies < in_core) {
        if (met++ == most_scatterings || !(way.kept > 0)) return {way.cortex, 0};
        scatter(parts.asymmetry);
        in_core = line.way_out(ray.point, parts.radius);
      } else {
        within = false;
        was_within = true;
      }
      continue;
    }
    const float middle = -glm::dot(ray.point, line.across) / line.across2;
    const glm::vec2 nearest = ray.point + middle * line.across;
    const float half2 = (parts.radius * parts.radius - glm::dot(nearest, nearest)) / line.across2;
    const bool meets = half2 > 0 && middle > 0 && !was_within;
    const float half = meets ? std::sqrt(half2) : 0;
    const float left = meets ? std::max(middle - half, 0.0f) : line.way_out(ray.point, 1);
    const float flies = flight(parts.cortex_scattering), flown = std::min(flies, left);
    way.cortex += flown;
    fly(flown);
    if (flies < left) {
      if (met++ == most_scatterings) return {way.cortex, 0};
      scatter(parts.cortex_asymmetry);
      was_within = false;
    } else if (meets) {
      within = true;
      in_core = 2 * half;
    } else {
      break;
    }
  }
  const float size = glm::length(ray.point);
  ray.point = size > 0 ? ray.point / size : glm::vec2(1, 0);
  return way;
}

}  // namespace tress::inline v0_2::fiber
