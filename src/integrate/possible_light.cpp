#include "integrate/possible_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "integrate/camera_rays.h"
#include "integrate/light_sampler.h"
#include "integrate/renderer.h"
#include "integrate/scattering.h"
#include "integrate/spread_pixels.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

constexpr std::size_t draws = 1024, most_hits = 128;

std::vector<geometry::Hit> seen_hits(const scene::Scene& scene, const geometry::FiberScene& fibers) {
  const CameraRays camera(scene.camera, scene.image);
  std::vector<geometry::Hit> hits;
  constexpr std::uint64_t most_rays = 2048;
  const std::uint64_t rays = std::min(
      most_rays, static_cast<std::uint64_t>(scene.image.width) * static_cast<std::uint64_t>(scene.image.height));
  for (std::uint64_t i = 0; i < rays && hits.size() < most_hits; ++i) {
    const glm::ivec2 pixel = spread_pixel(i, scene.image);
    if (const std::optional<geometry::Hit> hit = fibers.intersect(camera.ray(pixel.x, pixel.y, {0.5f, 0.5f})))
      hits.push_back(*hit);
  }
  return hits;
}

}  // namespace

void set_noise(const Film& film, const PossibleLight& possible, PassProgress& progress) {
  const Film::Seen seen = film.seen();
  progress.noise = film.relative_noise();
  progress.light_paths = seen.light_paths;
  progress.unmet_noise = 0;
  if (!(seen.samples > seen.pixels) || !(possible.mean > 0)) return;
  const double shown = std::max(seen.mean, possible.unmet(seen.paths));
  const double of_pixel = possible.unmet_variance(seen.paths) * seen.pixels / seen.samples;
  progress.unmet_noise = std::sqrt(of_pixel) / shown;
  progress.noise = std::hypot(progress.noise * seen.mean / shown, progress.unmet_noise);
}

PossibleLight possible_light(const scene::Scene& scene, const geometry::FiberScene& fibers,
                             const fiber::FiberModel& model, const std::vector<fiber::FiberId>& fiber_ids,
                             int light_samples) {
  constexpr double of_sphere = 1 / (4 * std::numbers::pi), of_surface = 1 / std::numbers::pi;
  PossibleLight found;
  const std::vector<geometry::Hit> hits = seen_hits(scene, fibers);
  if (hits.empty()) return found;
  const LightSampler lights(scene);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < draws; ++i) {
    const geometry::Hit& hit = hits[i % hits.size()];
    RandomStream random(0, i, 0);
    const float time = random.next(), u_light = random.next(), u1 = random.next(), u2 = random.next();
    const LightSampler::Arrival light = lights.sample(hit.axis, time, u_light, {u1, u2}, object_of(scene, hit));
    if (!(light.density > 0)) continue;
    if (hit.is_surface && !hit.faces(light.direction)) continue;
    const double balance =
        hit.is_surface ? of_surface : static_cast<double>(model.balance(fiber_ids[fiber_of(scene, hit)]));
    const double radiance = (static_cast<double>(light.radiance.x) + static_cast<double>(light.radiance.y) +
                             static_cast<double>(light.radiance.z)) /
                            3;
    const double density = light.density, sampled = std::isfinite(balance) ? light_samples * density : 0;
    const double share_met = sampled > 0 ? balance / (balance + sampled) : 1;
    sum += radiance * of_sphere / density;
    squares += radiance * radiance * of_sphere * share_met / density;
  }
  if (!(sum > 0) || !std::isfinite(squares)) return found;
  found.mean = sum / draws;
  found.spread = std::max(1.0, squares / draws / (found.mean * found.mean));
  return found;
}

}  // namespace tress::integrate
