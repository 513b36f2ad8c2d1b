#include "integrate/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "base/color.h"
#include "integrate/cryptomatte.h"
#include "integrate/excess_at.h"
#include "scene/model/camera.h"
#include "scene/model/strand_fibers.h"
#include "tress/base/random.h"

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

/// The density over which a sample of density `own` is weighed against another that could find the same light: their
/// sum, or by their fourth powers where an event begins with FiberModel::begin_drawn_near() (Veach 1997, section 9.2).
float density_of_balance(float own, float other, NearHit near) {
  if (near != NearHit::drawn || !(own > 0)) return own + other;
  const float ratio = other / own;
  return own + other * (ratio * ratio * ratio);
}

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
  const float density = density_of_balance(static_cast<float>(vertex.light_samples) * light.density * value.solid_angle,
                                           static_cast<float>(vertex.bcsdf_samples) * value.pdf, vertex.near);
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
                  const glm::vec3 share =
                      light.radiance * (drawn / density_of_balance(drawn, per_light * light.density, vertex.near));
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
  const NearShares shares = near_.of_seen(*hit, camera_.pixel_cm(ray.direction, hit->distance_cm));
  Vertex vertex = scattering_.begin(*hit, ray.direction, stratified.pair(in_half, grid_node),
                                    1 / static_cast<float>(options_.bcsdf_samples),
                                    NearRule::chosen(shares, options_.seed, pixel, sample));
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

// A path after its first hit: at every later hit it ends, goes on or splits.
namespace {

constexpr float least_survival = 0.05f;
constexpr float nowhere = std::numeric_limits<float>::infinity();
/// Number of hits of a sample after which no path splits, so that every sample ends, whatever was learned.
constexpr std::uint32_t most_parting_hits = 256;

/// An answer is checked by following a path for one in copies_per_check copies that it replaces, and for at least this
/// share of hits. Answers are also learned from these paths alone, and fewer checks would be too few for pictures with
/// few paths (bench/README.md, what lies deeper).
constexpr float copies_per_check = 4, least_checks = 1 / 16.0f;

/// The excess of rows is evaluated for one in this many directions that go on, in proportion to their weight.
constexpr float directions_per_excess = 32;

/// The largest absolute value of a channel.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

/// The square root of the throughput, from early hits on. Variance times time is 0.78 to 0.91 of that with the
/// throughput itself from the sixth hit on (bench/README.md, chart 7). A path without losses always goes on: with a
/// survival of 0.95 a path of 60 hits in white hair would weigh 20 (bench/atlas/README.md, study 5).
float survival(float throughput) { return std::clamp(std::sqrt(throughput), least_survival, 1.0f); }

}  // namespace

/// The contribution to the picture of a unit of light from a vertex, and an estimate of its excess by the rows of the
/// vertices before it. The mean of a product of independent values is the product of their means, so successive errors
/// multiply as they do in the picture.
struct PathTracer::Worth {
  glm::vec3 whole{0.0f}, too_much{0.0f};
};

struct PathTracer::Departure {
  glm::vec3 weight{0.0f}, met{0.0f};  ///< weight: factor of light from there. met: light met on the way
  Worth worth;                        ///< worth of light from the hit
  std::optional<geometry::Hit> hit;
};

/// A hit after the first. Its light is the radiance that leaves it back along the path, without the path's weight.
struct PathTracer::Arrival {
  geometry::Hit hit;
  glm::vec3 direction;              ///< direction of the ray that met it
  int depth;                        ///< number of the hit, from 2
  Worth worth;                      ///< worth of light from each copy
  std::size_t place;                ///< place in DeeperLight
  std::optional<glm::vec3> answer;  ///< light that the picture takes from here; the copies then only measure its bias
  bool is_check;                    ///< whether this hit or one before it has an answer
  float per_copy = 1;               ///< 1 over the mean number of copies
  int copies = 1, copies_left = 1;
  glm::vec3 light{0.0f};  ///< light of the copies that have ended
  std::uint64_t hits = 0;
  glm::vec3 weight{0.0f}, copy_light{0.0f};  ///< of the current copy: factor of light from its next hit, and its light
  std::uint64_t copy_hits = 0;
};

PathTracer::Arrival PathTracer::arrive(const geometry::Hit& hit, const glm::vec3& direction, int depth,
                                       const Worth& worth, bool is_check) const {
  Arrival at{hit, direction, depth, worth, deeper_ ? deeper_->place(hit.position, -direction) : 0, {}, is_check};
  if (answers() && depth >= options_.deep_light_depth && !is_check) {
    at.answer = deeper_->answer(at.place);
    at.is_check = true;
  }
  return at;
}

bool PathTracer::go_on(Arrival at, RandomStream& random, PathSums& sums, Tree& tree) const {
  float mean_copies = 1;
  if (deeper_ && deeper_->is_ready()) {
    mean_copies = deeper_->copies(at.place, at.worth.whole);
    if (at.answer) mean_copies = std::clamp(mean_copies / copies_per_check, least_checks, 1.0f);
    if (sums.vertices >= most_parting_hits) mean_copies = std::min(mean_copies, 1.0f);
  } else if (at.depth >= options_.roulette_depth) {
    mean_copies = survival(largest_channel(at.worth.whole) * static_cast<float>(options_.bcsdf_samples));
  } else {
    tree.push_back(at);
    return true;
  }
  at.copies = static_cast<int>(mean_copies);
  if (random.next() < mean_copies - static_cast<float>(at.copies)) ++at.copies;
  if (at.copies == 0) return false;
  if (at.answer) {  // keeps the worth before roulette: with a larger one the path would split again and again
    ++sums.deep_light_checks;
  } else {
    at.worth = {at.worth.whole / mean_copies, at.worth.too_much / mean_copies};
  }
  at.per_copy = 1 / mean_copies;
  at.copies_left = at.copies;
  tree.push_back(at);
  return true;
}

/// Does not learn from light that may contain answers. Their errors would be passed on, and learning only from paths
/// without answers would favor short ones.
void PathTracer::end_copy(Arrival& hit) const {
  if (deeper_ && (hit.is_check || !answers())) {
    deeper_->note(hit.place, hit.copy_light, hit.copy_hits);
    if (options_.deep_light == DeepLight::learned && hit.depth == options_.deep_light_depth)
      deeper_->note_for_answers(hit.place, hit.copy_light, hit.worth.whole * (hit.answer ? hit.per_copy : 1.0f));
  }
  hit.light += hit.copy_light;
  hit.hits += hit.copy_hits;
}

PathTracer::Departure PathTracer::depart(const Vertex& vertex, const Scattering::Sample& sample, const Worth& worth,
                                         PathSums& sums) const {
  Departure way;
  way.weight = sample.value.total() / sample.value.pdf;
  way.worth.whole = worth.whole * way.weight;
  const float largest = largest_channel(way.worth.whole);
  if (!std::isfinite(largest)) {  // gains above 1 have overflowed: the film will drop the path
    way.met = glm::vec3(nowhere);
    return way;
  }
  if (!(largest > 0)) return way;
  way.hit = fibers_.intersect(ray_from(vertex.hit, sample.direction, sample.value.exit));
  way.met = met_light(vertex, sample, way.hit ? way.hit->distance_cm : nowhere, way.worth.whole, sums.groups);
  ExcessAt excess(scattering_, vertex, sample.direction);
  const auto too_much_after = [&](float chance) {
    return worth.too_much * way.weight + (worth.whole - worth.too_much) * (excess.by(chance) / sample.value.pdf);
  };
  if (way.met != glm::vec3(0.0f))
    sums.excess += luminance(too_much_after(chance_of_light(luminance_of(way.worth.whole * way.met))) * way.met);
  if (way.hit)
    way.worth.too_much = too_much_after(std::min(luminance_of(way.worth.whole) / directions_per_excess, 1.0f));
  return way;
}

bool PathTracer::step(Tree& tree, RandomStream& random, PathSums& sums) const {
  Arrival& at = tree.back();
  --at.copies_left;
  at.copy_light = glm::vec3(0.0f);
  at.copy_hits = 1;
  const float xi1 = random.next(), xi2 = random.next();
  Vertex vertex = scattering_.begin(at.hit, at.direction, {xi1, xi2}, luminance_of(at.worth.whole),
                                    NearRule::chosen(near_.of_later(at.hit), options_.seed, bits_of(xi1, xi2), 0));
  vertex.light_samples = vertex.evaluates ? std::min(1, options_.light_samples) : 0;
  ++sums.vertices;
  if (vertex.light_samples > 0) {
    const float u_light = random.next(), u1 = random.next(), u2 = random.next();
    const Lit lit = light(vertex, u_light, {u1, u2}, at.worth.whole, random, sums);
    const glm::vec3 total = total_of(lit.layers);
    at.copy_light += total;
    sums.groups.add(lit.group, at.worth.whole * total);
    sums.excess += luminance(at.worth.too_much * total + (at.worth.whole - at.worth.too_much) * lit.excess);
  }
  std::array<float, 4> u;
  for (float& number : u) number = random.next();
  const Scattering::Sample sample = scattering_.sample(vertex, u, sums);
  if (!(sample.value.pdf > 0)) return false;
  const Departure way = depart(vertex, sample, at.worth, sums);
  at.weight = way.weight;
  at.copy_light += way.weight * way.met;
  if (!way.hit || at.depth >= options_.max_depth) return false;
  const Arrival next = arrive(*way.hit, sample.direction, at.depth + 1, way.worth, at.is_check);
  if (next.answer) {
    at.copy_light += way.weight * *next.answer;
    sums.excess += luminance(way.worth.too_much * *next.answer);
  }
  return go_on(next, random, sums, tree);
}

void PathTracer::follow(const Vertex& vertex, const Scattering::Sample& sample, RandomStream& random,
                        PathSums& sums) const {
  if (!(sample.value.pdf > 0)) return;
  const float share = 1 / static_cast<float>(vertex.bcsdf_samples);
  const Departure way = depart(vertex, sample, {glm::vec3(share)}, sums);
  glm::vec3 radiance = way.met;
  Tree tree;
  if (way.hit && options_.max_depth >= 2) {
    const Arrival next = arrive(*way.hit, sample.direction, 2, way.worth, false);
    if (next.answer) {
      radiance += *next.answer;
      sums.excess += luminance(way.worth.too_much * *next.answer);
    }
    go_on(next, random, sums, tree);
  }
  while (!tree.empty()) {
    if (tree.back().copies_left > 0) {
      const float excess = sums.excess;
      const bool is_check = tree.back().is_check;
      if (!step(tree, random, sums)) end_copy(tree.back());
      if (is_check) sums.excess = excess;
      if (std::isfinite(largest_channel(tree.back().light))) continue;
      radiance = glm::vec3(nowhere);
      break;
    }
    const Arrival ended = tree.back();
    tree.pop_back();
    glm::vec3 brought = ended.light * ended.per_copy;
    if (ended.answer) {
      const glm::vec3 answered = *ended.answer * static_cast<float>(ended.copies);
      sums.deep_light_excess += luminance(ended.worth.whole * ended.per_copy * (answered - ended.light));
      brought = glm::vec3(0.0f);  // the path has already taken the answer
    }
    if (tree.empty()) {
      radiance += brought;
      break;
    }
    Arrival& before = tree.back();
    before.copy_light += before.weight * brought;
    before.copy_hits += ended.hits;
    end_copy(before);
  }
  // All light after the first vertex scales its layers by the same factor.
  for (std::size_t layer = 0; layer < sample.value.layers.size(); ++layer) {
    sums.layers[layer] += sample.value.layers[layer] * (share / sample.value.pdf) * radiance;
  }
}

}  // namespace tress::integrate
