// near_hits SCENE|GROOM.hair [RAYS]: of the rays that leave strands and meet another, the share that meets it within
// two radii, where Embree alone does not see flat curves. See bench/dead_ends.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "geometry/fiber_scene.h"
#include "scene/read/load_scene.h"
#include "tress/base/random.h"
#include "tress/fiber/parameters.h"

using namespace tress;

namespace {

glm::vec3 random_direction(RandomStream& random) {
  const float z = 2 * random.next() - 1, phi = 6.2831853f * random.next(), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count < 2) return 2;
  const Result<scene::Scene> scene = scene::load_scene(arguments[1]);
  if (!scene) return 1;
  const int rays = argument_count > 2 ? std::atoi(arguments[2]) : 200000;
  const geometry::FiberScene intersector(*scene);
  const scene::Groom& groom = scene->grooms[0];
  RandomStream random(1);
  int leaving = 0, met = 0, near = 0;
  for (int i = 0; i < rays; ++i) {
    // From far away to a point of a strand: the first hit is what a camera sees, the later ones what light does.
    const auto point = static_cast<std::size_t>(random.next() * static_cast<float>(groom.points.size()));
    const glm::vec3 target = groom.points[std::min(point, groom.points.size() - 1)];
    const glm::vec3 direction = random_direction(random);
    std::optional<geometry::Hit> hit = intersector.intersect({target - 100.0f * direction, direction});
    for (int bounce = 0; hit && bounce < 4; ++bounce) {
      ++leaving;
      hit = intersector.intersect(ray_from(*hit, random_direction(random)));
      if (!hit || hit->is_surface) break;
      ++met;
      const scene::Groom& other = scene->grooms[hit->groom];
      const double axis =
          fiber::major_semi_axis(other.radius_cm[other.first_point[hit->strand]],
                                 scene->fibers[other.fiber[other.station_at(hit->strand, 0, 1)]].eccentricity);
      near += hit->distance_cm < 2 * axis;
    }
  }
  fmt::print("{}: {} leave, {} meet a strand, {:.4f} of these within two radii\n", arguments[1], leaving, met,
             static_cast<double>(near) / std::max(1, met));
}
