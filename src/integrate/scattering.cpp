#include "integrate/scattering.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>

#include "integrate/local_directions.h"

namespace tress::integrate {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

Scattered scattered_by_fiber(const fiber::FiberValue& value, float cos_theta, PathSums& sums) {
  sums.queries += value.queries;
  sums.exact_queries += value.exact_queries;
  sums.objective += value.objective;
  Scattered scattered;
  std::copy(value.s.begin(), value.s.end(), scattered.layers.begin());
  scattered.pdf = value.pdf;
  scattered.solid_angle = cos_theta;
  return scattered;
}

/// Lambert, to the side of the normal: albedo cos / pi, drawn by the cosine.
Scattered scattered_by_surface(const glm::vec3& albedo, float cosine) {
  Scattered scattered;
  scattered.pdf = std::max(0.0f, cosine) / pi;
  scattered.layers[surface_layer] = albedo * scattered.pdf;
  return scattered;
}

}  // namespace

Vertex Scattering::begin(const geometry::Hit& hit, const glm::vec3& ray_direction, const std::array<float, 2>& xi,
                         float importance) const {
  Vertex vertex;
  vertex.hit = hit;
  if (hit.is_surface) {
    vertex.albedo = scene_.meshes[hit.mesh].albedo;
    return vertex;
  }
  const std::uint32_t fiber = scene_.grooms[hit.groom].fiber[hit.strand];
  const LocalDirection known = to_local(hit, -ray_direction);
  const float h = offset_of(hit, known, scene_.fibers[fiber].eccentricity);
  vertex.event = model_.begin(fiber_ids_[fiber], known.direction, xi[0], xi[1], h, importance);
  vertex.evaluates = model_.evaluates(vertex.event);
  for (const glm::vec3& lobe : vertex.event.energy) vertex.albedo += lobe;
  return vertex;
}

Scattered Scattering::evaluate(const Vertex& vertex, const glm::vec3& direction, PathSums& sums) const {
  if (vertex.hit.is_surface) return scattered_by_surface(vertex.albedo, glm::dot(vertex.hit.normal, direction));
  const LocalDirection local = to_local(vertex.hit, direction);
  return scattered_by_fiber(model_.evaluate(vertex.event, local.direction), local.cos_theta, sums);
}

Scattering::Sample Scattering::sample(const Vertex& vertex, const std::array<float, 4>& u, PathSums& sums) const {
  if (!vertex.hit.is_surface) {
    const fiber::FiberSample drawn = model_.sample(vertex.event, u);
    return {to_world(vertex.hit, drawn.wi), scattered_by_fiber(drawn.value, cos_theta(drawn.wi), sums)};
  }
  const float sine = std::sqrt(u[0]), cosine = std::sqrt(std::max(0.0f, 1 - u[0])), azimuth = 2 * pi * u[1];
  const geometry::Hit& hit = vertex.hit;
  const glm::vec3 direction =
      glm::normalize(sine * std::cos(azimuth) * hit.u + sine * std::sin(azimuth) * hit.v + cosine * hit.normal);
  return {direction, scattered_by_surface(vertex.albedo, glm::dot(hit.normal, direction))};
}

}  // namespace tress::integrate
