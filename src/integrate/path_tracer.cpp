#include "integrate/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/color.h"
#include "integrate/cryptomatte.h"
#include "integrate/excess_at.h"
#include "scene/model/camera.h"
#include "scene/model/strand_fibers.h"

namespace tress::integrate {
namespace {

/// The uses of the stratified pairs of a path.
enum Dimension : std::uint32_t {
  pixel_position,
  grid_node,
  light_direction,
  lobe_and_theta,
  phi_and_spare,
  light_choice,
  lens_position,
  shutter_time,
  presence
};

/// How often the excess of rows is evaluated, which costs about 1 % of a render. It is done for one light in
/// paths_per_excess that brings the picture's mean, in proportion to what a light brings, plus a least chance so that
/// light which fits leave out is seen, too. Before the brightness is known, the chance is blind_chance.
constexpr float paths_per_excess = 128, blind_chance = 1 / 256.0f, least_light_chance = 1 / 4096.0f;
constexpr float surely_traced_share = 1.6f;  ///< in units of the picture's brightness (bench/README.md, steps)

float luminance_of(const glm::vec3& color) { return std::max(0.0f, luminance(color)); }

float mean_of(const glm::vec3& color) { return (color.x + color.y + color.z) / 3; }

/// Unit normal of a fiber: across its axis, towards the start of the ray; the minor axis if the ray is along the fiber.
glm::vec3 normal_towards(const geometry::Hit& hit, const glm::vec3& ray_direction) {
  const glm::vec3 across = glm::dot(ray_direction, hit.u) * hit.u - ray_direction;
  const float length = glm::length(across);
  return length > 1e-4f ? across / length : hit.w;
}

DataHit data_of(const scene::Scene& scene, const geometry::Hit& hit, const DataLayers& asked) {
  DataHit data;
  data.position = glm::vec3(glm::dvec3(hit.position) + scene.origin);
  if (hit.is_surface) return data;
  const scene::Groom& groom = scene.grooms[hit.groom];
  data.on_strand = true;
  data.has_uv = !groom.root_uv.empty();
  if (data.has_uv) data.root_uv = groom.root_uv[hit.strand];
  if (asked.has(DataLayer::strand_place)) data.place = scene::length_share(groom, hit.strand, hit.place);
  data.strand = groom.strand_id(hit.strand);
  if (asked.has(DataLayer::strand_mattes)) data.matte_bits = strand_matte_bits(groom, hit.instance, hit.strand);
  return data;
}

}  // namespace

PathTracer::PathTracer(const scene::Scene& scene, const geometry::FiberScene& fibers, const fiber::FiberModel& model,
                       const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options,
                       const DeeperLight* deeper)
    : scene_(scene),
      fibers_(fibers),
      options_(options),
      camera_(scene.camera, scene.image),
      motion_(scene),
      lights_(scene),
      group_count_(scene::light_groups(scene).size()),
      scattering_(scene, model, fiber_ids),
      near_(options.near),
      deeper_(deeper) {}

PathTracer PathTracer::at_brightness(float brightness) const {
  PathTracer other = *this;
  other.surely_traced_ = std::isfinite(brightness) ? surely_traced_share * brightness : 0;
  return other;
}

float PathTracer::chance_of_light(float luminance) const {
  if (!(brightness_ > 0)) return blind_chance;
  return std::min(least_light_chance + luminance / (paths_per_excess * brightness_), 1.0f);
}

bool PathTracer::is_shadowed(const geometry::Hit& hit, const LightSampler::Arrival& light,
                             const fiber::FiberExit& exit) const {
  geometry::Ray ray = ray_from(hit, light.shadow.direction, exit);
  float distance_cm = light.shadow.distance_cm;
  if (distance_cm < scene::distant_cm && ray.origin != hit.axis) {  // aims at the drawn point of the light
    const glm::vec3 way = hit.axis + distance_cm * light.shadow.direction - ray.origin;
    distance_cm = glm::length(way);
    if (distance_cm > 0) ray.direction = way / distance_cm;
  }
  ray.passed = light.passed;
  return fibers_.occluded(ray, distance_cm);
}

PathTracer::Lit PathTracer::light(const Vertex& vertex, float u_light, const std::array<float, 2>& u,
                                  const glm::vec3& weight, RandomStream& random, PathSums& sums) const {
  const Lit none;
  const LightSampler::Arrival light =
      lights_.sample(vertex.hit.axis, vertex.hit.time, u_light, u, object_of(scene_, vertex.hit));
  if (!(light.density > 0) || light.radiance == glm::vec3(0.0f)) return none;
  if (vertex.hit.is_surface && !vertex.hit.faces(light.direction)) return none;
  // The fiber is evaluated before the shadow ray, which costs as much: most light samples bring little and end here.
  const Scattered value = scattering_.evaluate(vertex, light.direction, sums);
  const float density = static_cast<float>(vertex.light_samples) * light.density * value.solid_angle +
                        static_cast<float>(vertex.bcsdf_samples) * value.pdf;
  if (!(density > 0)) return none;
  glm::vec3 scale = light.radiance / density;
  Lit scattered{value.layers};
  scattered.group = light.group;
  const float brought = std::abs(mean_of(weight * scale * total_of(scattered.layers)));
  if (brought == 0) return none;
  if (brought < surely_traced_) {
    const float survival = brought / surely_traced_;
    if (random.next() >= survival) return none;
    scale /= survival;
  }
  if (is_shadowed(vertex.hit, light, value.exit)) return none;
  for (glm::vec3& layer : scattered.layers) layer *= scale;
  const float chance = chance_of_light(luminance_of(weight * total_of(scattered.layers)));
  scattered.excess = ExcessAt(scattering_, vertex, light.direction).by(chance) * scale;
  return scattered;
}

glm::vec3 PathTracer::met_light(const Vertex& vertex, const Scattering::Sample& sample, float distance_cm,
                                const glm::vec3& throughput, GroupLight& groups) const {
  glm::vec3 radiance(0.0f);
  const float drawn = static_cast<float>(vertex.bcsdf_samples) * sample.value.pdf;
  const float per_light = static_cast<float>(vertex.light_samples) * sample.value.solid_angle;
  geometry::Ray ray = ray_from(vertex.hit, sample.direction, sample.value.exit);
  lights_.along(ray.origin, sample.direction, vertex.hit.time, distance_cm, object_of(scene_, vertex.hit),
                [&](const LightSampler::Arrival& light) {
                  if (light.needs_shadow_ray) {
                    ray.direction = light.shadow.direction;
                    ray.passed = light.passed;
                    if (fibers_.occluded(ray, light.shadow.distance_cm)) return;
                  }
                  const glm::vec3 share = light.radiance * (drawn / (drawn + per_light * light.density));
                  radiance += share;
                  groups.add(light.group, throughput * share);
                });
  return radiance;
}

geometry::Ray PathTracer::camera_ray(int x, int y, const PixelSampler& stratified, std::uint32_t in_half,
                                     float time) const {
  const auto from = [&](const CameraRays& camera) {
    const std::array<float, 2> position = stratified.pair(in_half, pixel_position);
    return camera.has_lens() ? camera.ray(x, y, position, stratified.pair(in_half, lens_position))
                             : camera.ray(x, y, position);
  };
  geometry::Ray ray = scene_.camera_moments.empty()
                          ? from(camera_)
                          : from(CameraRays(scene::camera_during(scene_.camera_moments, time), scene_.image));
  ray.time = time;
  return ray;
}

glm::vec2 PathTracer::motion_of(const geometry::Ray& ray, const geometry::Hit* hit,
                                const LightSampler::Arrival& seen) const {
  const auto by = [&](const FrameMotion& motion) {
    if (seen.density > 0 && seen.distance_cm < scene::distant_cm)
      return motion.of_light(ray.origin + seen.distance_cm * ray.direction, seen.way);
    if (seen.density > 0) return motion.of_infinity(ray.direction);
    if (hit == nullptr) return motion.of_backdrop(ray.direction);
    return motion.of_point(hit->position, hit->way);
  };
  return scene_.camera_moments.empty() ? by(motion_) : by(FrameMotion(scene_, ray.time));
}

PathSums PathTracer::carried(int x, int y, std::uint32_t sample) const {
  const std::uint64_t pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.image.width) + static_cast<std::uint64_t>(x);
  // Even and odd samples are stratified separately, so that they are two independent pictures (PixelSums::odd_beauty).
  const PixelSampler stratified(options_.seed, pixel, sample & 1);
  const std::uint32_t in_half = sample >> 1;
  RandomStream random(options_.seed, pixel, sample);
  PathSums sums(group_count_);
  const float time = scene_.shutter.is_open() ? stratified.pair(in_half, shutter_time)[0] : 0;
  constexpr std::uint64_t presence_purpose = 0x70726573656e6365ull;
  geometry::Ray ray = camera_ray(x, y, stratified, in_half, time);
  if (fibers_.has_presence()) {
    ray.key = RandomStream(options_.seed ^ presence_purpose, pixel, sample).next_bits();
    ray.drawn = stratified.pair(in_half, presence)[0];
  }
  const std::optional<geometry::Hit> hit = fibers_.intersect(ray);
  const LightSampler::Arrival seen =
      lights_.seen(ray.origin, ray.direction, time, hit ? hit->distance_cm : std::numeric_limits<float>::infinity());
  if (seen.density > 0) {
    sums.sees_light = true;
    sums.light_cm = seen.distance_cm;
    sums.layers[emission_layer] = seen.radiance;
    sums.groups.add(seen.group, seen.radiance);
    if (scene_.next) sums.motion = motion_of(ray, nullptr, seen);
    return sums;
  }
  if (hit && hit->is_surface && scene_.meshes[hit->mesh].holdout) {
    sums.held_out = true;
    return sums;
  }
  if (!hit) {
    if (scene_.next) sums.motion = motion_of(ray, nullptr, seen);
    if (scene_.environment_visible)
      sums.layers[background_layer] = scene_.environment.backdrop(
          scene::turned_to_environment(scene_, ray.direction, time), camera_.pixel_rad(ray.direction));
    return sums;
  }
  const float share = near_.of_seen(*hit, camera_.pixel_cm(ray.direction, hit->distance_cm));
  const bool is_near = near_.is_traced(share, options_.seed, pixel, sample);
  Vertex vertex = scattering_.begin(*hit, ray.direction, stratified.pair(in_half, grid_node),
                                    1 / static_cast<float>(options_.bcsdf_samples), is_near);
  vertex.light_samples = vertex.evaluates ? options_.light_samples : 0;
  vertex.bcsdf_samples = options_.bcsdf_samples;
  sums.vertices = 1;
  sums.coverage = 1;
  sums.albedo = vertex.albedo;
  sums.normal = hit->is_surface ? hit->w : normal_towards(*hit, ray.direction);
  if (!hit->is_surface) sums.tangent = hit->u;
  sums.distance_cm = hit->distance_cm;
  if (scene_.next) sums.motion = motion_of(ray, &*hit, seen);
  if (options_.data.has_any()) sums.data = data_of(scene_, *hit, options_.data);
  sums.object = object_of(scene_, *hit);
  const auto light_samples = static_cast<std::uint32_t>(vertex.light_samples);
  for (std::uint32_t i = 0; i < light_samples; ++i) {
    const std::uint32_t index = in_half * light_samples + i;
    const float u_light = lights_.has_choice() ? stratified.pair(index, light_choice)[0] : 0;
    const Lit lit = light(vertex, u_light, stratified.pair(index, light_direction), glm::vec3(1.0f), random, sums);
    for (std::size_t layer = 0; layer < lit.layers.size(); ++layer) sums.layers[layer] += lit.layers[layer];
    sums.excess += luminance(lit.excess);
    sums.groups.add(lit.group, total_of(lit.layers));
  }
  const auto bcsdf_samples = static_cast<std::uint32_t>(options_.bcsdf_samples);
  for (std::uint32_t i = 0; i < bcsdf_samples; ++i) {
    const std::uint32_t index = in_half * bcsdf_samples + i;
    const std::array<float, 2> first = stratified.pair(index, lobe_and_theta);
    const std::array<float, 2> second = stratified.pair(index, phi_and_spare);
    follow(vertex, scattering_.sample(vertex, {first[0], first[1], second[0], second[1]}, sums), random, sums);
  }
  return sums;
}

}  // namespace tress::integrate
