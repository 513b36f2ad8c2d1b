#include "integrate/near_needs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "base/color.h"
#include "fiber/rough_fiber.h"
#include "integrate/light_sampler.h"
#include "integrate/local_directions.h"
#include "integrate/scattering.h"
#include "tress/base/random.h"
#include "tress/fiber/fiber_model.h"

namespace tress::integrate {
namespace {

constexpr std::uint64_t close_purpose = 0x636c6f7365ull, lost_purpose = 0x6c6f7374ull, even_purpose = 0x6576656eull;
constexpr std::size_t rays_that_decide = 1 << 14, rays_that_label = 1 << 10, most_rays = 2048, least_rays = 16;
/// Pairs of paths of all grooms whose loss is measured, and of one.
constexpr std::size_t pairs_in_all = 1 << 16, least_pairs = 2048;
constexpr std::size_t batches = 8;
constexpr std::uint32_t even_draws = 4096;
constexpr int hits_of_ray = 3;

glm::vec3 any_direction(RandomStream& random) {
  const float z = 2 * random.next() - 1, turn = 2 * std::numbers::pi_v<float> * random.next();
  const float radius = std::sqrt(std::max(1 - z * z, 0.0f));
  return {radius * std::cos(turn), radius * std::sin(turn), z};
}

/// A point of a groom, in the scene. i: selects one of its instances.
glm::vec3 any_point(const scene::Groom& groom, std::size_t i, RandomStream& random) {
  const auto at = static_cast<std::size_t>(random.next() * static_cast<float>(groom.points.size()));
  return groom.place(i).point(groom.points[std::min(at, groom.points.size() - 1)]);
}

/// Calls visit(ray, hit, random) for rays from outside towards points of a groom that meet a fiber of any groom.
template <class Visit>
void each_hit_from_outside(const scene::Scene& scene, const geometry::FiberScene& fibers, std::uint64_t purpose,
                           std::size_t in_groom, std::size_t rays, Visit&& visit) {
  const scene::Groom& groom = scene.grooms[in_groom];
  if (groom.points.empty()) return;
  glm::vec3 low = groom.points.front(), high = low;
  for (const glm::vec3& point : groom.points) low = glm::min(low, point), high = glm::max(high, point);
  const float far = glm::distance(low, high);
  for (std::size_t i = 0; i < rays; ++i) {
    RandomStream random(purpose, in_groom, static_cast<std::uint32_t>(i));
    const std::size_t instance = i * groom.times() / rays;
    const glm::vec3 at = any_point(groom, instance, random);
    geometry::Ray ray;
    ray.direction = any_direction(random);
    ray.origin = at - far * groom.place(instance).scale * ray.direction;
    ray.key = random.next_bits();
    const std::optional<geometry::Hit> hit = fibers.intersect(ray);
    if (hit && !hit->is_surface) visit(ray, *hit, random);
  }
}

/// Sums over the light that leaves fibers of one groom in any direction.
struct Leaving {
  std::uint32_t count = 0, met = 0;
  double escaped = 0, sent_back = 0;  ///< directions that meet nothing, and the albedo of surfaces that others meet
};

std::vector<Leaving> light_that_leaves(const scene::Scene& scene, const geometry::FiberScene& fibers,
                                       std::size_t in_all) {
  std::vector<Leaving> grooms(scene.grooms.size());
  const std::size_t rays = std::clamp(in_all / std::max<std::size_t>(grooms.size(), 1), least_rays, most_rays);
  const auto follow = [&](const geometry::Ray& /*ray*/, geometry::Hit hit, RandomStream& random) {
    for (int hits = 0; hits < hits_of_ray; ++hits) {
      const std::optional<geometry::Hit> next = fibers.intersect(ray_from(hit, any_direction(random)));
      Leaving& leaving = grooms[hit.groom];
      ++leaving.count;
      if (!next) {
        leaving.escaped += 1;
        return;
      }
      if (next->is_surface) {
        const scene::Mesh& mesh = scene.meshes[next->mesh];
        leaving.sent_back += luminance(mesh.texture ? mesh.texture->mean() : mesh.albedo);
        return;
      }
      if (next->distance_cm < close_widths * 2 * hit.semi_axis_cm) ++leaving.met;
      hit = *next;
    }
  };
  for (std::size_t i = 0; i < grooms.size(); ++i) each_hit_from_outside(scene, fibers, close_purpose, i, rays, follow);
  return grooms;
}

/// Sums light that a fiber reflects and that meets no other fiber, which is all that dark hair sends. The fiber
/// reflects it from where the ray met it, and, as a row does, from anywhere across its width.
class ReflectedOnce {
 public:
  ReflectedOnce(const scene::Scene& scene, const geometry::FiberScene& fibers) : scene_(scene), fibers_(fibers) {}

  void add(const geometry::Ray& ray, const geometry::Hit& hit, RandomStream& random) {
    const fiber::FiberParameters& fiber = scene_.fibers[fiber_of(scene_, hit)];
    const fiber::RoughFiber rough(fiber);
    const fiber::FiberDirection wr = to_local(hit, -ray.direction).direction;
    const auto path = [&](float h) {
      const std::array<float, 4> u{random.next(), random.next(), random.next(), random.next()};
      return rough.trace(rough.entry(wr, h), u, random, kept_inside);
    };
    const fiber::RoughExit from_here = path(hit.share), from_anywhere = path(2 * random.next() - 1);
    const auto light = [&](const fiber::RoughExit& exit) {
      const auto lobe = std::min<std::size_t>(static_cast<std::size_t>(exit.order), fiber::lobe_count - 1);
      return static_cast<double>(luminance(exit.throughput * fiber.gain[lobe]));
    };
    const auto is_met = [&](const fiber::RoughExit& exit, const fiber::FiberExit& place) {
      const std::optional<geometry::Hit> next = fibers_.intersect(ray_from(hit, to_world(hit, exit.angles()), place));
      return next && !next->is_surface;
    };
    returned_ += light(from_here);
    double known = 0, by_row = 0;
    if (from_here.order == 0) {
      reflected_ += light(from_here);
      if (!is_met(from_here, from_here.place)) known = light(from_here);
    }
    if (from_anywhere.order == 0 && !is_met(from_anywhere, {})) by_row = light(from_anywhere);
    known_ += known, by_rows_ += by_row;
    squares_ += (known - by_row) * (known - by_row), known_squares_ += known * known;
    products_ += (known - by_row) * known;
  }
  /// NearNeeds::lost, before it is clamped, and its standard error, that of a ratio of means.
  double lost() const { return known_ > 0 ? reflected() * (1 - by_rows_ / known_) : 0; }
  double error() const {
    if (!(known_ > 0)) return 0;
    const double share = 1 - by_rows_ / known_;
    return reflected() * std::sqrt(std::max(squares_ - 2 * share * products_ + share * share * known_squares_, 0.0)) /
           known_;
  }

 private:
  /// Favors reflection, of whatever color the fiber is.
  static constexpr float kept_inside = 0.02f;

  double reflected() const { return reflected_ / returned_; }

  const scene::Scene& scene_;
  const geometry::FiberScene& fibers_;
  double returned_ = 0, reflected_ = 0, known_ = 0, by_rows_ = 0, squares_ = 0, known_squares_ = 0, products_ = 0;
};

/// Measures batches of pairs until three standard errors decide on which side of the asked gains the groom is, or are
/// less than half of the way between the two.
float measured_loss(const scene::Scene& scene, const geometry::FiberScene& fibers, std::size_t groom, float even,
                    std::size_t pairs, const AskedNeeds& asked) {
  ReflectedOnce light(scene, fibers);
  const auto add = [&](const geometry::Ray& ray, const geometry::Hit& hit, RandomStream& random) {
    light.add(ray, hit, random);
  };
  for (std::size_t batch = 0; batch < batches; ++batch) {
    each_hit_from_outside(scene, fibers, mix_bits(lost_purpose + batch), groom, pairs / batches, add);
    const double gain = even * light.lost(), error = 3 * even * light.error();
    if (gain + error < asked.least_gain || gain - error > asked.sure_gain ||
        error < (asked.sure_gain - asked.least_gain) / 2)
      break;
  }
  return static_cast<float>(std::clamp(light.lost(), 0.0, 1.0));
}

/// The share of the light of lamps and environment from directions in which it is sampled rarely. Both parts are
/// sampled where their terms are bounded.
double even_of_lights(const scene::Scene& scene) {
  std::vector<const scene::Groom*> grooms;
  for (const scene::Groom& groom : scene.grooms) {
    if (!groom.points.empty()) grooms.push_back(&groom);
  }
  if (grooms.empty()) return 1;
  const LightSampler lights(scene);
  // The mean of the channels serves radiance in bands too.
  const auto bright = [](const glm::vec3& radiance) { return (radiance.r + radiance.g + radiance.b) / 3; };
  double even = 0, small = 0;
  for (std::uint32_t i = 0; i < even_draws; ++i) {
    RandomStream random(even_purpose, 0, i);
    const scene::Groom& groom = *grooms[i % grooms.size()];
    const glm::vec3 point = any_point(groom, i / grooms.size() % groom.times(), random);
    const float time = random.next(), u_light = random.next();
    const LightSampler::Arrival drawn =
        lights.sample(point, time, u_light, {random.next(), random.next()}, scene::no_object);
    if (drawn.density >= fiber::FiberModel::drawn_near_density) small += bright(drawn.radiance) / drawn.density;
    lights.along(point, any_direction(random), time, std::numeric_limits<float>::infinity(), scene::no_object,
                 [&](const LightSampler::Arrival& seen) {
                   if (seen.density < fiber::FiberModel::drawn_near_density)
                     even += 4 * std::numbers::pi * bright(seen.radiance);
                 });
  }
  return even + small > 0 ? even / (even + small) : 1;
}

}  // namespace

NearNeeds measured_needs(const scene::Scene& scene, const geometry::FiberScene& fibers, const AskedNeeds& asked) {
  NearNeeds needs;
  double escaped = 0, sent_back = 0;
  for (const Leaving& leaving : light_that_leaves(scene, fibers, asked.roughly ? rays_that_label : rays_that_decide)) {
    needs.closeness.push_back(static_cast<float>(leaving.met) / static_cast<float>(std::max(leaving.count, 1u)));
    escaped += leaving.escaped, sent_back += leaving.sent_back;
  }
  needs.lost.resize(needs.closeness.size());
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(needs.closeness, [&](float close) { return close > asked.close; }));
  if (asked.roughly || count == 0) return needs;
  const double even = even_of_lights(scene);
  needs.even = static_cast<float>(even + (1 - even) * (sent_back > 0 ? sent_back / (sent_back + escaped) : 0));
  for (std::size_t groom = 0; groom < needs.lost.size(); ++groom) {
    if (needs.closeness[groom] > asked.close)
      needs.lost[groom] =
          measured_loss(scene, fibers, groom, needs.even, std::max(pairs_in_all / count, least_pairs), asked);
  }
  return needs;
}

}  // namespace tress::integrate
