// What a ray costs: camera rays at random and the diffuse rays that leave their hits, on a generated groom or, with
// TRESS_GROOM=FILE, on that file's. TRESS_BASIS=linear: strands straight from point to point.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <string_view>
#include <vector>

#include "geometry/fiber_scene.h"
#include "scene/generate/generated_grooms.h"
#include "scene/model/strand_fibers.h"
#include "scene/read/load_scene.h"
#include "tress/base/random.h"

namespace tress {
namespace {

enum class Section { round, elliptical };

scene::Scene groom(Section section) {
  scene::Scene scene;
  if (const char* file = std::getenv("TRESS_GROOM")) {
    Result<scene::Scene> loaded = scene::load_scene(file);
    if (!loaded) std::abort();
    scene = *loaded;
  } else {
    scene.materials.resize(1);
    scene::GroomRecipe recipe;
    recipe.kind = "straight";
    recipe.strands = 10000;
    scene.grooms.push_back(scene::generate_groom(recipe));
  }
  for (scene::Material& material : scene.materials) {
    material.fiber.eccentricity = section == Section::round ? 1.0f : 0.85f;
  }
  const char* basis = std::getenv("TRESS_BASIS");
  for (scene::Groom& groom : scene.grooms)
    groom.basis =
        basis && std::string_view(basis) == "linear" ? scene::StrandBasis::linear : scene::StrandBasis::bspline;
  scene::assign_fibers(&scene);
  return scene;
}

glm::vec3 random_direction(RandomStream& random) {
  const float z = 2 * random.next() - 1, phi = 6.2831853f * random.next(), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

struct Rays {
  std::vector<geometry::Ray> camera, leaving;
};

/// Parallel to nothing: from points of a sphere around the groom to points of its strands.
Rays rays_at(const scene::Scene& scene, const geometry::FiberScene& intersector) {
  const std::vector<glm::vec3>& points = scene.grooms[0].points;
  glm::vec3 least = points[0], most = points[0];
  for (const glm::vec3& p : points) {
    least = glm::min(least, p);
    most = glm::max(most, p);
  }
  RandomStream random(1);
  Rays rays;
  while (rays.leaving.size() < 20000) {
    const auto index = static_cast<std::size_t>(random.next() * static_cast<float>(points.size()));
    const glm::vec3 eye = 0.5f * (least + most) + 2 * glm::length(most - least) * random_direction(random);
    rays.camera.push_back({eye, glm::normalize(points[std::min(index, points.size() - 1)] - eye)});
    if (const auto hit = intersector.intersect(rays.camera.back())) {
      rays.leaving.push_back(ray_from(*hit, random_direction(random)));
    }
  }
  return rays;
}

enum class Kind { camera, leaving, shadow };

void cast(benchmark::State& state, Section section, Kind kind) {
  const scene::Scene scene = groom(section);
  const geometry::FiberScene intersector(scene);
  const Rays rays = rays_at(scene, intersector);
  const std::vector<geometry::Ray>& cast = kind == Kind::camera ? rays.camera : rays.leaving;
  std::size_t i = 0, met = 0;
  for (auto _ : state) {
    const geometry::Ray& ray = cast[i++ % cast.size()];
    met += kind == Kind::shadow ? intersector.occluded(ray) : intersector.intersect(ray).has_value();
  }
  state.counters["met"] = static_cast<double>(met) / static_cast<double>(i);
}

BENCHMARK_CAPTURE(cast, camera_round, Section::round, Kind::camera);
BENCHMARK_CAPTURE(cast, camera_elliptical, Section::elliptical, Kind::camera);
BENCHMARK_CAPTURE(cast, leaving_round, Section::round, Kind::leaving);
BENCHMARK_CAPTURE(cast, leaving_elliptical, Section::elliptical, Kind::leaving);
BENCHMARK_CAPTURE(cast, shadow_round, Section::round, Kind::shadow);
BENCHMARK_CAPTURE(cast, shadow_elliptical, Section::elliptical, Kind::shadow);

}  // namespace
}  // namespace tress

BENCHMARK_MAIN();
