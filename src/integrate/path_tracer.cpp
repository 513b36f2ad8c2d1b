#include "integrate/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tress::integrate {
namespace {

/// Stratified pairs of a path: what each is used for.
enum Dimension : std::uint32_t {
  pixel_position,
  grid_node,
  light_direction,
  lobe_and_theta,
  phi_and_spare,
  light_choice
};

constexpr float least_survival = 0.05f;
constexpr float surely_traced_share = 1.6f;  ///< of the picture's brightness (bench/README.md, steps)
constexpr float nowhere = std::numeric_limits<float>::infinity();

/// Without regard to sign.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

float luminance_of(const glm::vec3& color) {
  return std::max(0.0f, 0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z);
}

float mean_of(const glm::vec3& color) { return (color.x + color.y + color.z) / 3; }

glm::vec3 total_of(const ScatteredLayers& layers) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& layer : layers) total += layer;
  return total;
}

/// Of a fiber, unit: across its axis, towards where the ray comes from; the minor axis where that is along the fiber.
glm::vec3 normal_towards(const geometry::Hit& hit, const glm::vec3& ray_direction) {
  const glm::vec3 across = glm::dot(ray_direction, hit.u) * hit.u - ray_direction;
  const float length = glm::length(across);
  return length > 1e-4f ? across / length : hit.w;
}

}  // namespace

PathTracer::PathTracer(const scene::Scene& scene, const geometry::FiberScene& fibers, const fiber::FiberModel& model,
                       const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options)
    : scene_(scene),
      fibers_(fibers),
      options_(options),
      camera_(scene.camera, scene.image),
      motion_(scene),
      lights_(scene),
      scattering_(scene, model, fiber_ids) {}

PathTracer PathTracer::at_brightness(float brightness) const {
  PathTracer other = *this;
  other.surely_traced_ = std::isfinite(brightness) ? surely_traced_share * brightness : 0;
  return other;
}

ScatteredLayers PathTracer::light(const Vertex& vertex, float u_light, const std::array<float, 2>& u,
                                  const glm::vec3& weight, RandomStream& random, PathSums& sums) const {
  const ScatteredLayers none{};
  const LightSampler::Arrival light = lights_.sample(vertex.hit.axis, u_light, u);
  if (!(light.density > 0) || light.radiance == glm::vec3(0.0f)) return none;
  if (vertex.hit.is_surface && !(glm::dot(vertex.hit.normal, light.direction) > 0)) return none;
  // Evaluated first: most of what is drawn brings little, and a shadow ray costs as much as a look at the fiber.
  const Scattered value = scattering_.evaluate(vertex, light.direction, sums);
  const float density = static_cast<float>(vertex.light_samples) * light.density * value.solid_angle +
                        static_cast<float>(vertex.bcsdf_samples) * value.pdf;
  if (!(density > 0)) return none;
  glm::vec3 scale = light.radiance / density;
  ScatteredLayers scattered = value.layers;
  const float brought = std::abs(mean_of(weight * scale * total_of(scattered)));
  if (brought == 0) return none;
  if (brought < surely_traced_) {
    const float survival = brought / surely_traced_;
    if (random.next() >= survival) return none;
    scale /= survival;
  }
  if (fibers_.occluded(ray_from(vertex.hit, light.shadow.direction), light.shadow.distance_cm)) return none;
  for (glm::vec3& layer : scattered) layer *= scale;
  return scattered;
}

glm::vec3 PathTracer::met_light(const Vertex& vertex, const Scattering::Sample& sample, float distance_cm) const {
  glm::vec3 radiance(0.0f);
  const float drawn = static_cast<float>(vertex.bcsdf_samples) * sample.value.pdf;
  const float per_light = static_cast<float>(vertex.light_samples) * sample.value.solid_angle;
  lights_.along(vertex.hit.axis, sample.direction, distance_cm, [&](const LightSampler::Arrival& light) {
    radiance += light.radiance * (drawn / (drawn + per_light * light.density));
  });
  return radiance;
}

void PathTracer::follow(Vertex vertex, Scattering::Sample sample, RandomStream& random, PathSums& sums) const {
  if (!(sample.value.pdf > 0)) return;
  // The first vertex's weight, by layer; everything later scales all layers alike.
  ScatteredLayers first_weight = sample.value.layers;
  for (glm::vec3& layer : first_weight) layer /= sample.value.pdf * static_cast<float>(vertex.bcsdf_samples);
  const glm::vec3 first_total = sample.value.total() / sample.value.pdf;
  glm::vec3 throughput(1.0f), radiance(0.0f);
  const int first_samples = vertex.bcsdf_samples;
  for (int depth = 2;; ++depth) {  // of the hit that the ray may find
    const float largest = largest_channel(first_total * throughput);
    if (!std::isfinite(largest)) {  // gains above 1, again and again: whatever it meets, the film will drop it
      radiance = glm::vec3(nowhere);
      break;
    }
    if (!(largest > 0)) break;
    const geometry::Ray ray = ray_from(vertex.hit, sample.direction);
    const std::optional<geometry::Hit> hit = fibers_.intersect(ray);
    radiance += throughput * met_light(vertex, sample, hit ? hit->distance_cm : nowhere);
    if (!hit || depth > options_.max_depth) break;
    if (depth >= options_.roulette_depth) {
      // The root of the throughput, from early on: variance times time is .78 to .91 of that of the throughput itself
      // from the sixth hit on (bench/README.md, chart 7). A path that has lost nothing goes on: at .95 a path of 60
      // hits in white hair would weigh 20 (bench/atlas/README.md, study 5).
      const float survival = std::clamp(std::sqrt(largest), least_survival, 1.0f);
      if (random.next() >= survival) break;
      throughput /= survival;
    }
    const float xi1 = random.next(), xi2 = random.next();
    const float importance = luminance_of(first_total * throughput) / static_cast<float>(first_samples);
    vertex = scattering_.begin(*hit, ray.direction, {xi1, xi2}, importance);
    vertex.light_samples = vertex.evaluates ? std::min(1, options_.light_samples) : 0;
    ++sums.vertices;
    if (vertex.light_samples > 0) {
      const glm::vec3 weight = first_total * throughput / static_cast<float>(first_samples);
      const float u_light = random.next(), u1 = random.next(), u2 = random.next();
      radiance += throughput * total_of(light(vertex, u_light, {u1, u2}, weight, random, sums));
    }
    std::array<float, 4> u;
    for (float& number : u) number = random.next();
    sample = scattering_.sample(vertex, u, sums);
    if (!(sample.value.pdf > 0)) break;
    throughput *= sample.value.total() / sample.value.pdf;
  }
  for (std::size_t layer = 0; layer < first_weight.size(); ++layer) {
    sums.layers[layer] += first_weight[layer] * radiance;
  }
}

PathSums PathTracer::trace(int x, int y, std::uint32_t sample) const {
  const std::uint64_t pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.image.width) + static_cast<std::uint64_t>(x);
  const PixelSampler stratified(options_.seed, pixel);
  RandomStream random(options_.seed, pixel, sample);
  PathSums sums;
  const geometry::Ray ray = camera_.ray(x, y, stratified.pair(sample, pixel_position));
  const std::optional<geometry::Hit> hit = fibers_.intersect(ray);
  if (!hit) {
    if (scene_.next) sums.motion = motion_.of_backdrop(ray.direction);
    if (scene_.environment_visible)
      sums.layers[background_layer] = scene_.environment.backdrop(ray.direction, camera_.pixel_rad(ray.direction));
    return sums;
  }
  Vertex vertex = scattering_.begin(*hit, ray.direction, stratified.pair(sample, grid_node),
                                    1 / static_cast<float>(options_.bcsdf_samples));
  vertex.light_samples = vertex.evaluates ? options_.light_samples : 0;
  vertex.bcsdf_samples = options_.bcsdf_samples;
  sums.vertices = 1;
  sums.coverage = 1;
  sums.albedo = vertex.albedo;
  sums.normal = hit->is_surface ? hit->w : normal_towards(*hit, ray.direction);
  if (!hit->is_surface) sums.tangent = hit->u;
  sums.distance_cm = hit->distance_cm;
  if (scene_.next) sums.motion = motion_.of_point(hit->position);
  sums.object = hit->is_surface ? static_cast<std::uint32_t>(scene_.grooms.size()) + hit->mesh : hit->groom;
  const auto light_samples = static_cast<std::uint32_t>(vertex.light_samples);
  for (std::uint32_t i = 0; i < light_samples; ++i) {
    const std::uint32_t index = sample * light_samples + i;
    const float u_light = lights_.has_choice() ? stratified.pair(index, light_choice)[0] : 0;
    const ScatteredLayers layers =
        light(vertex, u_light, stratified.pair(index, light_direction), glm::vec3(1.0f), random, sums);
    for (std::size_t layer = 0; layer < layers.size(); ++layer) sums.layers[layer] += layers[layer];
  }
  const auto bcsdf_samples = static_cast<std::uint32_t>(options_.bcsdf_samples);
  for (std::uint32_t i = 0; i < bcsdf_samples; ++i) {
    const std::uint32_t index = sample * bcsdf_samples + i;
    const std::array<float, 2> first = stratified.pair(index, lobe_and_theta);
    const std::array<float, 2> second = stratified.pair(index, phi_and_spare);
    follow(vertex, scattering_.sample(vertex, {first[0], first[1], second[0], second[1]}, sums), random, sums);
  }
  return sums;
}

}  // namespace tress::integrate
