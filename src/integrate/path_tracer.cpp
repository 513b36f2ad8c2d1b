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
  glm::vec3 total = sums.background;
  for (const glm::vec3& lobe : sums.lobes) total += lobe;
  return std::isfinite(total.x) && std::isfinite(total.y) && std::isfinite(total.z);
}

void count_queries(const fiber::FiberValue& value, PathSums& sums) {
  sums.queries += value.queries;
  sums.exact_queries += value.exact_queries;
}

/// Largest channel of the throughput over all lobes, without regard to sign.
float largest_channel(const fiber::LobeColors& beta) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& lobe : beta) total += lobe;
  return std::max({std::abs(total.x), std::abs(total.y), std::abs(total.z)});
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

void PathTracer::add_light(const Vertex& vertex, const std::array<float, 2>& u, const fiber::LobeColors* beta,
                           PathSums& sums) const {
  const scene::Environment::Sample light = scene_.environment.sample(u[0], u[1]);
  if (!(light.pdf_solid_angle > 0) || light.radiance == glm::vec3(0.0f)) return;
  if (fibers_.occluded(ray_from(vertex.hit, light.direction))) return;
  const LocalDirection local = to_local(vertex.hit, light.direction);
  const fiber::FiberValue value = model_.evaluate(vertex.event, local.direction);
  count_queries(value, sums);
  const float density = static_cast<float>(vertex.light_samples) * light.pdf_solid_angle * local.cos_theta +
                        static_cast<float>(vertex.bcsdf_samples) * value.pdf;
  if (!(density > 0)) return;
  const glm::vec3 scale = light.radiance / density;
  const glm::vec3 scattered = beta ? value.total() * scale : scale;
  const fiber::LobeColors& factors = beta ? *beta : value.s;
  for (int lobe = 0; lobe < fiber::lobe_count; ++lobe) sums.lobes[lobe] += factors[lobe] * scattered;
}

void PathTracer::follow(Vertex vertex, fiber::FiberSample sample, RandomStream& random, PathSums& sums) const {
  fiber::LobeColors beta;
  beta.fill(glm::vec3(0.0f));
  for (int depth = 1;; ++depth) {
    count_queries(sample.value, sums);
    if (!(sample.value.pdf > 0)) return;
    if (depth == 1) {
      const float share = sample.value.pdf * static_cast<float>(vertex.bcsdf_samples);
      for (int lobe = 0; lobe < fiber::lobe_count; ++lobe) beta[lobe] = sample.value.s[lobe] / share;
    } else {
      const glm::vec3 weight = sample.value.total() / sample.value.pdf;
      for (glm::vec3& lobe : beta) lobe *= weight;
    }
    const intersect::Ray ray = ray_from(vertex.hit, to_world(vertex.hit, sample.wi));
    const std::optional<intersect::Hit> hit = fibers_.intersect(ray);
    if (!hit) {
      const float light = static_cast<float>(vertex.light_samples) * scene_.environment.pdf_solid_angle(ray.direction) *
                          cos_theta(sample.wi);
      const float drawn = static_cast<float>(vertex.bcsdf_samples) * sample.value.pdf;
      const glm::vec3 scale = scene_.environment.radiance(ray.direction) * (drawn / (drawn + light));
      for (int lobe = 0; lobe < fiber::lobe_count; ++lobe) sums.lobes[lobe] += beta[lobe] * scale;
      return;
    }
    const int next_depth = depth + 1;
    if (next_depth > options_.max_depth) return;
    const float largest = largest_channel(beta) * static_cast<float>(options_.bcsdf_samples);
    if (!(largest > 0)) return;
    if (next_depth >= options_.roulette_depth) {
      const float survival = std::clamp(largest, least_survival, greatest_survival);
      if (random.next() >= survival) return;
      for (glm::vec3& lobe : beta) lobe /= survival;
    }
    const float xi1 = random.next(), xi2 = random.next();
    vertex = begin(*hit, ray.direction, xi1, xi2, false);
    if (vertex.light_samples > 0) {
      const float u1 = random.next(), u2 = random.next();
      add_light(vertex, {u1, u2}, &beta, sums);
    }
    std::array<float, 4> u;
    for (float& number : u) number = random.next();
    sample = model_.sample(vertex.event, u);
  }
}

PathSums PathTracer::trace(int x, int y, std::uint32_t sample) const {
  const std::uint64_t pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.image.width) + static_cast<std::uint64_t>(x);
  const PixelSampler stratified(options_.seed, pixel);
  RandomStream random(options_.seed, pixel, sample);
  PathSums sums;
  sums.samples = 1;
  const intersect::Ray ray = camera_.ray(x, y, stratified.pair(sample, pixel_position));
  const std::optional<intersect::Hit> hit = fibers_.intersect(ray);
  if (!hit) {
    if (scene_.environment_visible) sums.background = scene_.environment.radiance(ray.direction);
    return sums;
  }
  sums.coverage = 1;
  const std::array<float, 2> xi = stratified.pair(sample, grid_node);
  const Vertex vertex = begin(*hit, ray.direction, xi[0], xi[1], true);
  const auto light_samples = static_cast<std::uint32_t>(options_.light_samples);
  for (std::uint32_t i = 0; i < light_samples; ++i) {
    add_light(vertex, stratified.pair(sample * light_samples + i, light_direction), nullptr, sums);
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
