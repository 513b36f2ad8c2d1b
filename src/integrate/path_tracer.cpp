#include "integrate/path_tracer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "integrate/local_directions.h"

namespace tress::integrate {
namespace {

/// Stratified pairs of a path: what each is used for.
enum Dimension : std::uint32_t { pixel_position, grid_node, light_direction, lobe_and_theta, phi_and_spare };

constexpr float least_survival = 0.05f, greatest_survival = 0.95f;

[[maybe_unused]] bool is_finite(const PathSums& sums) {
  const glm::vec3 total = sums.beauty();
  return std::isfinite(total.x) && std::isfinite(total.y) && std::isfinite(total.z);
}

void count_queries(const fiber::FiberValue& value, PathSums& sums) {
  sums.queries += value.queries;
  sums.exact_queries += value.exact_queries;
  sums.objective += value.objective;
}

glm::vec3 total_of(const fiber::LobeColors& lobes) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& lobe : lobes) total += lobe;
  return total;
}

/// Without regard to sign.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

}  // namespace

PathTracer::PathTracer(const scene::Scene& scene, const intersect::FiberScene& fibers, const fiber::FiberModel& model,
                       const std::vector<fiber::FiberId>& fiber_ids, const RenderOptions& options)
    : scene_(scene),
      fibers_(fibers),
      model_(model),
      fiber_ids_(fiber_ids),
      options_(options),
      camera_(scene.camera, scene.image) {}

PathTracer::Vertex PathTracer::begin(const intersect::Hit& hit, const glm::vec3& ray_direction, float xi1, float xi2,
                                     bool first) const {
  const fiber::FiberId fiber = fiber_ids_[scene_.grooms[hit.groom].fiber[hit.strand]];
  return {hit, model_.begin(fiber, to_local(hit, -ray_direction).direction, xi1, xi2),
          first ? options_.light_samples : std::min(1, options_.light_samples), first ? options_.bcsdf_samples : 1};
}

fiber::LobeColors PathTracer::light(const Vertex& vertex, const std::array<float, 2>& u, PathSums& sums) const {
  fiber::LobeColors scattered{};
  const scene::Environment::Sample light = scene_.environment.sample(u[0], u[1]);
  if (!(light.pdf_solid_angle > 0) || light.radiance == glm::vec3(0.0f)) return scattered;
  if (fibers_.occluded(ray_from(vertex.hit, light.direction))) return scattered;
  const LocalDirection local = to_local(vertex.hit, light.direction);
  const fiber::FiberValue value = model_.evaluate(vertex.event, local.direction);
  count_queries(value, sums);
  const float density = static_cast<float>(vertex.light_samples) * light.pdf_solid_angle * local.cos_theta +
                        static_cast<float>(vertex.bcsdf_samples) * value.pdf;
  if (!(density > 0)) return scattered;
  const glm::vec3 scale = light.radiance / density;
  for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) scattered[lobe] = value.s[lobe] * scale;
  return scattered;
}

void PathTracer::follow(Vertex vertex, fiber::FiberSample sample, RandomStream& random, PathSums& sums) const {
  count_queries(sample.value, sums);
  if (!(sample.value.pdf > 0)) return;
  // The first vertex's weight, by lobe; everything later scales all lobes alike.
  fiber::LobeColors first_weight = sample.value.s;
  for (glm::vec3& lobe : first_weight) lobe /= sample.value.pdf * static_cast<float>(vertex.bcsdf_samples);
  const glm::vec3 first_total = sample.value.total() / sample.value.pdf;
  glm::vec3 throughput(1.0f), radiance(0.0f);
  for (int depth = 2;; ++depth) {  // of the hit that the ray may find
    const intersect::Ray ray = ray_from(vertex.hit, to_world(vertex.hit, sample.wi));
    const std::optional<intersect::Hit> hit = fibers_.intersect(ray);
    if (!hit) {
      const float light = static_cast<float>(vertex.light_samples) * scene_.environment.pdf_solid_angle(ray.direction) *
                          cos_theta(sample.wi);
      const float drawn = static_cast<float>(vertex.bcsdf_samples) * sample.value.pdf;
      radiance += throughput * scene_.environment.radiance(ray.direction) * (drawn / (drawn + light));
      break;
    }
    if (depth > options_.max_depth) break;
    const float largest = largest_channel(first_total * throughput);
    if (!(largest > 0)) break;
    if (depth >= options_.roulette_depth) {
      const float survival = std::clamp(largest, least_survival, greatest_survival);
      if (random.next() >= survival) break;
      throughput /= survival;
    }
    const float xi1 = random.next(), xi2 = random.next();
    vertex = begin(*hit, ray.direction, xi1, xi2, false);
    if (vertex.light_samples > 0) {
      const float u1 = random.next(), u2 = random.next();
      radiance += throughput * total_of(light(vertex, {u1, u2}, sums));
    }
    std::array<float, 4> u;
    for (float& number : u) number = random.next();
    sample = model_.sample(vertex.event, u);
    count_queries(sample.value, sums);
    if (!(sample.value.pdf > 0)) break;
    throughput *= sample.value.total() / sample.value.pdf;
  }
  for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) sums.layers[lobe] += first_weight[lobe] * radiance;
}

PathSums PathTracer::trace(int x, int y, std::uint32_t sample) const {
  const std::uint64_t pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.image.width) + static_cast<std::uint64_t>(x);
  const PixelSampler stratified(options_.seed, pixel);
  RandomStream random(options_.seed, pixel, sample);
  PathSums sums;
  const intersect::Ray ray = camera_.ray(x, y, stratified.pair(sample, pixel_position));
  const std::optional<intersect::Hit> hit = fibers_.intersect(ray);
  if (!hit) {
    if (scene_.environment_visible) sums.layers[background_layer] = scene_.environment.radiance(ray.direction);
    return sums;
  }
  const std::array<float, 2> xi = stratified.pair(sample, grid_node);
  const Vertex vertex = begin(*hit, ray.direction, xi[0], xi[1], true);
  sums.coverage = 1;
  sums.albedo = total_of(vertex.event.energy);
  sums.normal = hit->u;
  sums.distance_cm = hit->distance_cm;
  const auto light_samples = static_cast<std::uint32_t>(options_.light_samples);
  for (std::uint32_t i = 0; i < light_samples; ++i) {
    const fiber::LobeColors lobes = light(vertex, stratified.pair(sample * light_samples + i, light_direction), sums);
    for (std::size_t lobe = 0; lobe < fiber::lobe_count; ++lobe) sums.layers[lobe] += lobes[lobe];
  }
  const auto bcsdf_samples = static_cast<std::uint32_t>(options_.bcsdf_samples);
  for (std::uint32_t i = 0; i < bcsdf_samples; ++i) {
    const std::uint32_t index = sample * bcsdf_samples + i;
    const std::array<float, 2> first = stratified.pair(index, lobe_and_theta);
    const std::array<float, 2> second = stratified.pair(index, phi_and_spare);
    follow(vertex, model_.sample(vertex.event, {first[0], first[1], second[0], second[1]}), random, sums);
  }
  assert(is_finite(sums));
  return sums;
}

}  // namespace tress::integrate
