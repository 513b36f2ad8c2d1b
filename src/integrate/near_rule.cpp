#include "integrate/near_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "tress/base/random.h"

namespace tress::integrate {
namespace {

constexpr std::uint64_t purpose = 0x636c6f7365ull;
constexpr std::size_t rays_that_decide = 1 << 14, rays_that_label = 1 << 10, most_rays = 2048, least_rays = 16;
constexpr int hits_of_ray = 3;

glm::vec3 any_direction(RandomStream& random) {
  const float z = 2 * random.next() - 1, turn = 2 * std::numbers::pi_v<float> * random.next();
  const float radius = std::sqrt(std::max(1 - z * z, 0.0f));
  return {radius * std::cos(turn), radius * std::sin(turn), z};
}

float width_of(const geometry::Hit& hit) { return 2 * hit.semi_axis_cm; }

}  // namespace

void measure_closeness(NearOptions& options, const scene::Scene& scene, const geometry::FiberScene& fibers) {
  using Where = NearOptions::Where;
  options.closeness.clear();
  if (options.where == Where::nowhere || options.where == Where::everywhere) return;
  const std::size_t in_all = options.where == Where::seen ? rays_that_label : rays_that_decide;
  struct Count {
    std::uint32_t left = 0, met = 0;
  };
  std::vector<Count> counts(scene.grooms.size());
  const std::size_t rays = std::clamp(in_all / std::max<std::size_t>(counts.size(), 1), least_rays, most_rays);
  for (std::size_t groom = 0; groom < counts.size(); ++groom) {
    const std::vector<glm::vec3>& points = scene.grooms[groom].points;
    if (points.empty()) continue;
    glm::vec3 low = points.front(), high = low;
    for (const glm::vec3& point : points) low = glm::min(low, point), high = glm::max(high, point);
    const float far = glm::distance(low, high);
    for (std::size_t i = 0; i < rays; ++i) {
      RandomStream random(purpose, groom, static_cast<std::uint32_t>(i));
      const auto at = static_cast<std::size_t>(random.next() * static_cast<float>(points.size()));
      geometry::Ray ray;
      ray.direction = any_direction(random);
      const scene::Similarity place = scene.grooms[groom].place(i * scene.grooms[groom].times() / rays);
      ray.origin = place.point(points[std::min(at, points.size() - 1)]) - far * place.scale * ray.direction;
      ray.key = random.next_bits();
      std::optional<geometry::Hit> hit = fibers.intersect(ray);
      for (int hits = 0; hits < hits_of_ray && hit && !hit->is_surface; ++hits) {
        const geometry::Hit from = *hit;
        hit = fibers.intersect(ray_from(from, any_direction(random)));
        Count& count = counts[from.groom];
        ++count.left;
        if (hit && !hit->is_surface && hit->distance_cm < close_widths * width_of(from)) ++count.met;
      }
    }
  }
  for (const Count& count : counts)
    options.closeness.push_back(static_cast<float>(count.met) / static_cast<float>(std::max(count.left, 1u)));
}

float share_of(float closeness) { return std::clamp((closeness - loose) / (dense - loose), 0.0f, 1.0f); }

void set_asked(const scene::Integrator& asked, NearOptions* near) {
  using Where = NearOptions::Where;
  near->pixels = asked.near_pixels.value_or(near->pixels);
  if (asked.near == "nowhere" || !(near->pixels > 0)) near->where = Where::nowhere;
  if (asked.near == "seen") near->where = Where::seen;
  if (asked.near == "touching") near->where = Where::touching;
  if (asked.near == "everywhere") near->where = Where::everywhere;
}

std::string words_of(const NearOptions& options) {
  if (options.where == NearOptions::Where::nowhere) return "near nowhere: rows answer every hit";
  if (options.where == NearOptions::Where::everywhere) return "near everywhere: every hit is traced from where it is";
  std::string words = fmt::format("near where fibers are wider than {:.4g} pixels", options.pixels);
  float most = 0, share = 0;
  for (const float close : options.closeness) most = std::max(most, close), share = std::max(share, share_of(close));
  if (share > 0 && options.where == NearOptions::Where::seen)
    words += "; fibers touch, where rows are too dark, unless \"near\" is left out or \"touching\"";
  else if (share > 0)
    words += fmt::format(", and {} {:.0f} % of the hits where they touch",
                         options.where == NearOptions::Where::touching ? "at" : "but for small lights at", 100 * share);
  if (share > 0 && options.where == NearOptions::Where::usual)
    words += "; dark fur under lamps needs \"near\": \"touching\"";
  if (!options.closeness.empty())
    words += fmt::format(" ({:.3g} % of the light that leaves one meets another within {:.4g} widths; {:.0f} count)",
                         100 * most, close_widths, 100 * loose);
  return words;
}

NearRule::NearRule(const NearOptions& options) : where_(options.where), pixels_(options.pixels) {
  if (options.where != NearOptions::Where::usual && options.where != NearOptions::Where::touching) return;
  for (const float close : options.closeness) by_groom_.push_back(share_of(close));
  if (std::ranges::all_of(by_groom_, [](float share) { return share == 0; })) by_groom_.clear();
}

NearShares NearRule::of_touching(float share) const {
  return {where_ == NearOptions::Where::touching ? share : 0, share};
}

NearShares NearRule::of_seen(const geometry::Hit& hit, float pixel_cm) const {
  if (hit.is_surface || where_ == NearOptions::Where::nowhere) return {};
  if (where_ == NearOptions::Where::everywhere) return {1, 1};
  NearShares shares = of_touching(by_groom_.empty() ? 0 : by_groom_[hit.groom]);
  shares.all = std::max(shares.all, std::clamp(width_of(hit) / (pixel_cm * pixels_) - 1, 0.0f, 1.0f));
  return shares;
}

NearShares NearRule::of_later(const geometry::Hit& hit) const {
  if (hit.is_surface || where_ == NearOptions::Where::nowhere) return {};
  if (where_ == NearOptions::Where::everywhere) return {1, 1};
  if (by_groom_.empty()) return {};
  return of_touching(by_groom_[hit.groom] *
                     std::clamp(2 - hit.distance_cm / (near_widths * width_of(hit)), 0.0f, 1.0f));
}

}  // namespace tress::integrate
