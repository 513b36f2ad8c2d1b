#include "integrate/path_tracer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tress/base/random.h"

namespace tress::integrate {
namespace {

/// Stratified pairs of a path: what each is used for.
enum Dimension : std::uint32_t {
  pixel_position,
  grid_node,
  light_direction,
  lobe_and_theta,
  phi_and_spare,
  light_choice,
  lens_position
};

/// How often it is asked what rows have too much: for one in so many paths that bring the picture's mean by a light,
/// in proportion to what they bring, but for a share that is least so that what fits have left out is seen too; for
/// one in so many directions that go on, times what they are worth; before any brightness is known, for one in so many
/// that meet a light. Some 1 % of a render.
constexpr float paths_per_excess = 128, directions_per_excess = 32, blind_chance = 1 / 256.0f,
                least_light_chance = 1 / 4096.0f;

std::uint64_t hash_of(float a, float b, std::uint64_t before) {
  return mix_bits(before + ((std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32) | std::bit_cast<std::uint32_t>(b)));
}

constexpr float least_survival = 0.05f;
constexpr float surely_traced_share = 1.6f;  ///< of the picture's brightness (bench/README.md, steps)
constexpr float nowhere = std::numeric_limits<float>::infinity();

/// Without regard to sign.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

float signed_luminance(const glm::vec3& color) { return 0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z; }
float luminance_of(const glm::vec3& color) { return std::max(0.0f, signed_luminance(color)); }

float mean_of(const glm::vec3& color) { return (color.x + color.y + color.z) / 3; }

glm::vec3 total_of(const ScatteredLayers& layers) {
  glm::vec3 total(0.0f);
  for (const glm::vec3& layer : layers) total += layer;
  return total;
}

/// What the rows have too much at one direction of a vertex: traced at most once, where chance has it, for each use
/// that is made of it.
class ExcessAt {
 public:
  /// All references must outlive it.
  ExcessAt(const Scattering& scattering, const Vertex& vertex, const glm::vec3& direction)
      : scattering_(scattering), vertex_(vertex), direction_(direction) {
    if (!scattering.tells_excess() || vertex.hit.is_surface) return;
    // By the bits of the direction and of the event: no stream of numbers is used up.
    const fiber::FiberEvent& event = vertex.event;
    const std::uint64_t of_event = hash_of(event.xi1, event.xi2, hash_of(event.wr.theta, event.wr.phi, 0));
    const std::uint64_t hash = hash_of(direction.x, direction.y, of_event);
    u_ = static_cast<float>(hash >> 40) * 0x1p-24f;
    place_ = static_cast<float>(hash & 0xffffff) * 0x1p-24f;
  }
  /// In the mean over all chances, (0, 1], Scattering::excess().
  glm::vec3 by(float chance) {
    if (!(u_ < chance)) return glm::vec3(0.0f);
    if (!value_) value_ = scattering_.excess(vertex_, direction_, place_);
    return *value_ / chance;
  }

 private:
  const Scattering& scattering_;
  const Vertex& vertex_;
  const glm::vec3& direction_;
  float u_ = 1, place_ = 0;
  std::optional<glm::vec3> value_;
};

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
      group_count_(scene::light_groups(scene).size()),
      scattering_(scene, model, fiber_ids) {}

PathTracer PathTracer::at_brightness(float brightness) const {
  PathTracer other = *this;
  other.surely_traced_ = std::isfinite(brightness) ? surely_traced_share * brightness : 0;
  return other;
}

float PathTracer::chance_of_light(float luminance) const {
  if (!(brightness_ > 0)) return blind_chance;
  return std::min(least_light_chance + luminance / (paths_per_excess * brightness_), 1.0f);
}

PathTracer::Lit PathTracer::light(const Vertex& vertex, float u_light, const std::array<float, 2>& u,
                                  const glm::vec3& weight, RandomStream& random, PathSums& sums) const {
  const Lit none;
  const LightSampler::Arrival light = lights_.sample(vertex.hit.axis, u_light, u);
  if (!(light.density > 0) || light.radiance == glm::vec3(0.0f)) return none;
  if (vertex.hit.is_surface && !(glm::dot(vertex.hit.normal, light.direction) > 0)) return none;
  // Evaluated first: most of what is drawn brings little, and a shadow ray costs as much as a look at the fiber.
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
  if (fibers_.occluded(ray_from(vertex.hit, light.shadow.direction), light.shadow.distance_cm)) return none;
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
  lights_.along(vertex.hit.axis, sample.direction, distance_cm, [&](const LightSampler::Arrival& light) {
    const glm::vec3 share = light.radiance * (drawn / (drawn + per_light * light.density));
    radiance += share;
    groups.add(light.group, throughput * share);
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
  GroupLight groups(group_count_);
  const int first_samples = vertex.bcsdf_samples;
  // What a unit of light from the vertex brings to the picture, what of that is too much by the rows of the vertices
  // before it, in the mean, and the same of all light of the path. The mean of a product of independent values is the
  // product of their means: errors that follow each other are multiplied as they are in the picture.
  glm::vec3 worth(1 / static_cast<float>(first_samples)), too_much(0.0f), excess_light(0.0f);
  for (int depth = 2;; ++depth) {  // of the hit that the ray may find
    const float largest = largest_channel(first_total * throughput);
    if (!std::isfinite(largest)) {  // gains above 1, again and again: whatever it meets, the film will drop it
      radiance = glm::vec3(nowhere);
      break;
    }
    if (!(largest > 0)) break;
    const geometry::Ray ray = ray_from(vertex.hit, sample.direction);
    const std::optional<geometry::Hit> hit = fibers_.intersect(ray);
    const glm::vec3 met = met_light(vertex, sample, hit ? hit->distance_cm : nowhere, throughput, groups);
    radiance += throughput * met;
    ExcessAt excess(scattering_, vertex, sample.direction);
    const glm::vec3 weight = sample.value.total() / sample.value.pdf;
    const auto too_much_after = [&](float chance) {
      return too_much * weight + (worth - too_much) * (excess.by(chance) / sample.value.pdf);
    };
    if (met != glm::vec3(0.0f))
      excess_light += too_much_after(chance_of_light(luminance_of(worth * weight * met))) * met;
    if (!hit || depth > options_.max_depth) break;
    too_much = too_much_after(std::min(luminance_of(worth * weight) / directions_per_excess, 1.0f));
    worth *= weight;
    if (depth >= options_.roulette_depth) {
      // The root of the throughput, from early on: variance times time is .78 to .91 of that of the throughput itself
      // from the sixth hit on (bench/README.md, chart 7). A path that has lost nothing goes on: at .95 a path of 60
      // hits in white hair would weigh 20 (bench/atlas/README.md, study 5).
      const float survival = std::clamp(std::sqrt(largest), least_survival, 1.0f);
      if (random.next() >= survival) break;
      throughput /= survival;
      worth /= survival;
      too_much /= survival;
    }
    const float xi1 = random.next(), xi2 = random.next();
    const float importance = luminance_of(first_total * throughput) / static_cast<float>(first_samples);
    vertex = scattering_.begin(*hit, ray.direction, {xi1, xi2}, importance);
    vertex.light_samples = vertex.evaluates ? std::min(1, options_.light_samples) : 0;
    ++sums.vertices;
    if (vertex.light_samples > 0) {
      const float u_light = random.next(), u1 = random.next(), u2 = random.next();
      const Lit lit = light(vertex, u_light, {u1, u2}, worth, random, sums);
      const glm::vec3 total = total_of(lit.layers);
      radiance += throughput * total;
      groups.add(lit.group, throughput * total);
      excess_light += too_much * total + (worth - too_much) * lit.excess;
    }
    std::array<float, 4> u;
    for (float& number : u) number = random.next();
    sample = scattering_.sample(vertex, u, sums);
    if (!(sample.value.pdf > 0)) break;
    throughput *= sample.value.total() / sample.value.pdf;
  }
  sums.excess += signed_luminance(excess_light);
  for (std::size_t layer = 0; layer < first_weight.size(); ++layer) {
    sums.layers[layer] += first_weight[layer] * radiance;
  }
  const glm::vec3 first = total_of(first_weight);
  for (std::size_t group = 0; group < groups.count; ++group) sums.groups.add(group, first * groups.light[group]);
}

PathSums PathTracer::trace(int x, int y, std::uint32_t sample) const {
  const std::uint64_t pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.image.width) + static_cast<std::uint64_t>(x);
  // Even samples and odd ones are stratified apart, so that they are two independent pictures (PixelSums::odd_beauty).
  const PixelSampler stratified(options_.seed, pixel, sample & 1);
  const std::uint32_t in_half = sample >> 1;
  RandomStream random(options_.seed, pixel, sample);
  PathSums sums(group_count_);
  const geometry::Ray ray = camera_.has_lens() ? camera_.ray(x, y, stratified.pair(in_half, pixel_position),
                                                             stratified.pair(in_half, lens_position))
                                               : camera_.ray(x, y, stratified.pair(in_half, pixel_position));
  const std::optional<geometry::Hit> hit = fibers_.intersect(ray);
  const LightSampler::Arrival seen = lights_.seen(ray.origin, ray.direction, hit ? hit->distance_cm : nowhere);
  if (seen.density > 0) {
    sums.sees_light = true;
    sums.layers[emission_layer] = seen.radiance;
    sums.groups.add(seen.group, seen.radiance);
    if (scene_.next) {
      const bool near = seen.distance_cm < scene::distant_cm;
      sums.motion =
          near ? motion_.of_light(ray.origin + seen.distance_cm * ray.direction) : motion_.of_backdrop(ray.direction);
    }
    return sums;
  }
  if (hit && hit->is_surface && scene_.meshes[hit->mesh].holdout) {
    sums.held_out = true;
    return sums;
  }
  if (!hit) {
    if (scene_.next) sums.motion = motion_.of_backdrop(ray.direction);
    if (scene_.environment_visible)
      sums.layers[background_layer] = scene_.environment.backdrop(ray.direction, camera_.pixel_rad(ray.direction));
    return sums;
  }
  Vertex vertex = scattering_.begin(*hit, ray.direction, stratified.pair(in_half, grid_node),
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
    const std::uint32_t index = in_half * light_samples + i;
    const float u_light = lights_.has_choice() ? stratified.pair(index, light_choice)[0] : 0;
    const Lit lit = light(vertex, u_light, stratified.pair(index, light_direction), glm::vec3(1.0f), random, sums);
    for (std::size_t layer = 0; layer < lit.layers.size(); ++layer) sums.layers[layer] += lit.layers[layer];
    sums.excess += signed_luminance(lit.excess);
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
