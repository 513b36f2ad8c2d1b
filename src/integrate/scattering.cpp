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

/// Lambert, about the shading normal w: albedo cos / pi, drawn by the cosine; nothing through the face. Where the face
/// is about to turn from the light the shading fades out before it (Chiang, Li and Burley 2019, "Taming the shadow
/// terminator"), so that facets do not show as an edge between light and shadow.
Scattered scattered_by_surface(const glm::vec3& albedo, const geometry::Hit& hit, const glm::vec3& direction) {
  Scattered scattered;
  const float cosine = glm::dot(hit.w, direction), of_face = glm::dot(hit.normal, direction);
  scattered.pdf = std::max(0.0f, cosine) / pi;
  if (!(cosine > 0 && of_face > 0)) return scattered;
  float fade = 1;
  if (hit.w != hit.normal) {
    const float share = std::min(1.0f, of_face / (cosine * glm::dot(hit.w, hit.normal)));
    fade = share * (1 + share * (1 - share));
  }
  scattered.layers[surface_layer] = albedo * (scattered.pdf * fade);
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
  vertex.evaluates = model_.evaluates(vertex.event) || model_.estimates(vertex.event);
  for (const glm::vec3& lobe : vertex.event.energy) vertex.albedo += lobe;
  return vertex;
}

Scattered Scattering::evaluate(const Vertex& vertex, const glm::vec3& direction, PathSums& sums) const {
  if (vertex.hit.is_surface) return scattered_by_surface(vertex.albedo, vertex.hit, direction);
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
      glm::normalize(sine * std::cos(azimuth) * hit.u + sine * std::sin(azimuth) * hit.v + cosine * hit.w);
  return {direction, scattered_by_surface(vertex.albedo, hit, direction)};
}

}  // namespace tress::integrate
