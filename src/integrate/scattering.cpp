#include "integrate/scattering.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>

#include "base/bands.h"
#include "integrate/local_directions.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

Scattered scattered_by_fiber(const fiber::FiberValue& value, float cos_theta, PathSums& sums) {
  sums.queries += value.queries;
  sums.exact_queries += value.exact_queries;
  sums.objective += value.objective;
  Scattered scattered;
  std::copy(value.s.begin(), value.s.end(), scattered.layers.begin());
  scattered.pdf = value.pdf;
  scattered.solid_angle = cos_theta;
  scattered.exit = value.exit;
  return scattered;
}

glm::vec3 to_frame(const geometry::Hit& hit, const glm::vec3& world) {
  return {glm::dot(world, hit.u), glm::dot(world, hit.v), glm::dot(world, hit.w)};
}

/// Scattering about the shading normal w. Where rays can start from the smooth surface (Hit::lift), light is let in
/// that comes from below the triangle. Elsewhere the shading fades out before the triangle turns from the light
/// (Chiang, Li and Burley 2019, "Taming the shadow terminator"), so that facets do not show at the edge between light
/// and shadow.
Scattered scattered_by_surface(const SurfaceMaterial& material, const geometry::Hit& hit, const glm::vec3& direction) {
  Scattered scattered;
  const glm::vec3 in = to_frame(hit, direction);
  scattered.pdf = material.pdf(in);
  if (!(in.z > 0 && hit.faces(direction))) return scattered;
  float fade = 1;
  if (hit.w != hit.normal && hit.lift == glm::vec3(0.0f)) {
    const float share = std::min(1.0f, glm::dot(hit.normal, direction) / (in.z * glm::dot(hit.w, hit.normal)));
    fade = share * (1 + share * (1 - share));
  }
  scattered.layers[surface_layer] = material.value(in) * fade;
  return scattered;
}

/// Diffuse albedo of a mesh at a hit: from its texture, or its one color.
glm::vec3 diffuse_at(const scene::Mesh& mesh, const geometry::Hit& hit) {
  if (!mesh.texture) return mesh.albedo;
  const glm::uvec3& corner = mesh.corner_uvs[hit.triangle];
  if (corner.x == scene::no_uv || corner.y == scene::no_uv || corner.z == scene::no_uv) return mesh.texture->mean();
  const glm::vec2 &a = mesh.uvs[corner.x], &b = mesh.uvs[corner.y], &c = mesh.uvs[corner.z];
  return mesh.texture->at((1 - hit.second - hit.third) * a + hit.second * b + hit.third * c);
}

}  // namespace

std::uint32_t fiber_of(const scene::Scene& scene, const geometry::Hit& hit) {
  const scene::Groom& groom = scene.grooms[hit.groom];
  if (groom.choices_a_station == 0) return groom.choices.front().fiber;
  RandomStream of_hit(bits_of(hit.position.x, hit.position.y), bits_of(hit.position.z, hit.lateral));
  const std::size_t station = groom.station_at(hit.strand, hit.place, of_hit.next());
  return groom.fiber_at(station, of_hit.next());
}

Scattering::Scattering(const scene::Scene& scene, const fiber::FiberModel& model,
                       const std::vector<fiber::FiberId>& fiber_ids)
    : scene_(scene),
      model_(model),
      fiber_ids_(fiber_ids),
      coats_(scene.meshes.size()),
      tells_excess_(model.tells_excess()) {
  for (std::size_t mesh = 0; mesh < coats_.size(); ++mesh) {
    if (const auto& coat = scene.meshes[mesh].coat) coats_[mesh].emplace(coat->roughness, coat->eta);
  }
}

SurfaceMaterial Scattering::surface_at(const geometry::Hit& hit, const glm::vec3& ray_direction) const {
  const std::optional<Coat>& coat = coats_[hit.mesh];
  const glm::vec3 diffuse = diffuse_at(scene_.meshes[hit.mesh], hit);
  return {scene_.integrator.spectral ? bands_of_rgb(diffuse) : diffuse, coat ? &*coat : nullptr,
          to_frame(hit, -ray_direction)};
}

Vertex Scattering::begin(const geometry::Hit& hit, const glm::vec3& ray_direction, const std::array<float, 2>& xi,
                         float importance, NearHit near) const {
  Vertex vertex;
  vertex.hit = hit;
  if (hit.is_surface) {
    vertex.surface = surface_at(hit, ray_direction);
    vertex.albedo = vertex.surface.albedo();
    return vertex;
  }
  const LocalDirection known = to_local(hit, -ray_direction);
  const fiber::FiberId fiber = fiber_ids_[fiber_of(scene_, hit)];
  vertex.near = near;
  const auto begun = [&](auto begin) {
    return (model_.*begin)(fiber, known.direction, xi[0], xi[1], hit.share, importance);
  };
  vertex.event = near == NearHit::no      ? begun(&fiber::FiberModel::begin)
                 : near == NearHit::drawn ? begun(&fiber::FiberModel::begin_drawn_near)
                                          : begun(&fiber::FiberModel::begin_near);
  vertex.evaluates = model_.evaluates(vertex.event) || model_.estimates(vertex.event);
  for (const glm::vec3& lobe : vertex.event.energy) vertex.albedo += lobe;
  return vertex;
}

Scattered Scattering::evaluate(const Vertex& vertex, const glm::vec3& direction, PathSums& sums) const {
  if (vertex.hit.is_surface) return scattered_by_surface(vertex.surface, vertex.hit, direction);
  const LocalDirection local = to_local(vertex.hit, direction);
  return scattered_by_fiber(model_.evaluate(vertex.event, local.direction), local.cos_theta, sums);
}

glm::vec3 Scattering::excess(const Vertex& vertex, const glm::vec3& direction, float place) const {
  if (vertex.hit.is_surface) return glm::vec3(0.0f);
  return model_.excess(vertex.event, to_local(vertex.hit, direction).direction, place);
}

Scattering::Sample Scattering::sample(const Vertex& vertex, const std::array<float, 4>& u, PathSums& sums) const {
  if (!vertex.hit.is_surface) {
    const fiber::FiberSample drawn = model_.sample(vertex.event, u);
    return {to_world(vertex.hit, drawn.wi), scattered_by_fiber(drawn.value, cos_theta(drawn.wi), sums)};
  }
  const geometry::Hit& hit = vertex.hit;
  const glm::vec3 in = vertex.surface.sample(u);
  const glm::vec3 direction = glm::normalize(in.x * hit.u + in.y * hit.v + in.z * hit.w);
  return {direction, scattered_by_surface(vertex.surface, hit, direction)};
}

}  // namespace tress::integrate
