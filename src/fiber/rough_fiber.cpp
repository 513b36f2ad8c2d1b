#include "fiber/rough_fiber.h"

#include <algorithm>
#include <cmath>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "fiber/fresnel.h"

namespace tress::fiber {
namespace {

constexpr float least_cosine = 1e-6f;  // to the normal, of light that grazes a surface or was rounded past it

/// One Newton step onto the unit sphere: rounding cannot build up.
template <class Vector>
Vector onto_unit(const Vector& v) {
  return v * (1.5f - 0.5f * glm::dot(v, v));
}

float largest(const glm::vec3& color) { return std::max({color.r, color.g, color.b}); }

}  // namespace

FiberDirection RoughExit::angles() const {
  return {std::asin(std::clamp(direction.x, -1.0f, 1.0f)), std::atan2(direction.z, direction.y)};
}

RoughFiber::RoughFiber(const FiberParameters& parameters)
    : facets_(parameters.roughness),
      eta_(parameters.eta),
      eccentricity_(parameters.eccentricity),
      sin_tilt_(std::sin(parameters.tilt)),
      cos_tilt_(std::cos(parameters.tilt)),
      sigma_a_(parameters.sigma_a) {}

RoughEntry RoughFiber::entry(const FiberDirection& wr, float h) const {
  const float cosine = std::max(std::cos(wr.theta), 0.0f), cos_phi = std::cos(wr.phi), sin_phi = std::sin(wr.phi);
  const glm::vec2 middle = glm::normalize(glm::vec2(eccentricity_ * cos_phi, sin_phi));
  const float cos_h = std::sqrt(std::max(1 - h * h, 0.0f));
  return {{std::sin(wr.theta), cosine * cos_phi, cosine * sin_phi},
          {middle.x * cos_h - middle.y * h, middle.y * cos_h + middle.x * h}};
}

glm::vec3 RoughFiber::outward_normal(const glm::vec2& point) const {
  const glm::vec2 normal = glm::normalize(glm::vec2(eccentricity_ * point.x, point.y));
  return {0, normal.x, normal.y};
}

RoughFiber::Event RoughFiber::scatter(const glm::vec3& w, const glm::vec3& outward, bool from_inside,
                                      const std::array<float, 2>& u_facet, float u_choice, RandomStream& random) const {
  const glm::vec3 normal = from_inside ? -outward : outward;
  const glm::vec3 tilted = cos_tilt_ * outward - glm::vec3(sin_tilt_, 0, 0);
  glm::vec3 facing = from_inside ? -tilted : tilted, toward = w;
  float cosine = glm::dot(toward, facing);
  if (cosine < least_cosine) {
    facing = normal;
    cosine = glm::dot(toward, facing);
    if (cosine < least_cosine) toward = glm::normalize(toward + (least_cosine - cosine) * facing);
  }
  const glm::vec3 m = facets_.visible_normal(toward, facing, u_facet, random);
  const double cos_i = std::clamp(static_cast<double>(glm::dot(toward, m)), 0.0, 1.0), eta = eta_;
  double cos_t;
  const double reflected =
      from_inside ? fresnel_leaving(eta, eta, cos_i, &cos_t) : fresnel_entering(eta, eta, cos_i, &cos_t);
  Event event;
  event.refracted = static_cast<double>(u_choice) >= reflected;
  float side = 1;
  if (event.refracted) {
    const double ratio = from_inside ? eta : 1 / eta;
    event.direction = static_cast<float>(cos_i * ratio - cos_t) * m - static_cast<float>(ratio) * toward;
    side = -1;
  } else {
    event.direction = static_cast<float>(2 * cos_i) * m - toward;
  }
  event.direction = onto_unit(event.direction);
  event.weight =
      side * glm::dot(event.direction, normal) > 0 ? facets_.unmasked(side * glm::dot(event.direction, facing)) : 0;
  return event;
}

RoughExit RoughFiber::trace(const RoughEntry& entry, const std::array<float, 4>& u, RandomStream& random) const {
  RoughExit exit;
  glm::vec2 point = entry.point;
  Event event = scatter(entry.direction, outward_normal(point), false, {u[0], u[1]}, u[2], random);
  glm::vec3 throughput(event.weight);
  if (event.refracted) {
    for (float u_choice = u[3];; u_choice = random.next()) {
      ++exit.order;
      const glm::vec2 across(event.direction.y, event.direction.z / eccentricity_);
      const float length = std::max(-2 * glm::dot(point, across), 0.0f) / std::max(glm::dot(across, across), 1e-12f);
      point = onto_unit(point + length * across);
      throughput *= glm::exp(-sigma_a_ * length);
      const float kept = largest(throughput);
      if (!(kept > 0)) return exit;
      if (kept < roulette_below) {
        if ((1 - random.next()) * roulette_below > kept) return exit;
        throughput *= roulette_below / kept;
      }
      const std::array<float, 2> u_facet{random.next(), random.next()};
      event = scatter(-event.direction, outward_normal(point), true, u_facet, u_choice, random);
      throughput *= event.weight;
      if (event.refracted) break;
    }
  }
  if (!(largest(throughput) > 0)) return exit;
  exit.direction = event.direction;
  exit.throughput = throughput;
  return exit;
}

}  // namespace tress::fiber
