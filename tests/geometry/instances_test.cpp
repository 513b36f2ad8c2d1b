// Instances of a groom against the same strands written out: every hit, for camera and shadow rays, at rest and moving.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "scene/model/groom_bounds.h"
#include "straight_strands.h"

namespace tress::geometry {
namespace {

using scene::Instance;
using scene::Similarity;
using scene::StrandBasis;

constexpr std::uint32_t strands = 12, points = 5;

/// A rotation by an angle about a direction (Rodrigues).
glm::mat3 rotation(const glm::vec3& axis, float angle) {
  glm::mat3 turn;
  for (int column = 0; column < 3; ++column) {
    glm::vec3 unit(0.0f);
    unit[column] = 1;
    turn[column] = std::cos(angle) * unit + std::sin(angle) * glm::cross(axis, unit) +
                   (1 - std::cos(angle)) * glm::dot(axis, unit) * axis;
  }
  return turn;
}

/// Wandering strands about the origin with minor axes of their own, so that no axis depends on the vertical of the
/// scene, of eccentricity 0.6. Polygons are round: between knots their axes depend on the root's normal a little, as
/// tangents jump at each knot.
scene::Scene tuft(StrandBasis basis) {
  scene::Scene scene;
  scene.materials.resize(1);
  scene.materials[0].fiber.eccentricity = basis == StrandBasis::linear ? 1 : 0.6f;
  scene.image.curve_error_px = 1e-4f;  // as many pieces for all instances
  scene::Groom groom;
  groom.basis = basis;
  groom.first_point = {0};
  RandomStream random(2026, 1);
  for (std::uint32_t s = 0; s < strands; ++s) {
    glm::vec3 at = random_point(random, 1), step = random_direction(random);
    for (std::uint32_t i = 0; i < points; ++i) {
      groom.points.push_back(at);
      groom.radius_cm.push_back(0.03f + 0.05f * random.next());
      groom.minor_axis.push_back(glm::normalize(glm::cross(step, random_direction(random))));
      step = glm::normalize(step + 0.4f * random_direction(random));
      at += 0.5f * step;
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  scene.grooms.push_back(std::move(groom));
  scene::assign_fibers(&scene);
  return scene;
}

Similarity random_place(RandomStream& random) {
  const float angle = 6.2831853f * random.next();
  return {rotation(random_direction(random), angle), 0.5f + random.next(), random_point(random, 3)};
}

/// The scene with one groom for each instance.
scene::Scene written_out(const scene::Scene& scene) {
  scene::Scene all = scene;
  all.grooms.clear();
  for (const Instance& instance : scene.grooms[0].instances) {
    scene::Groom groom = scene.grooms[0];
    groom.instances.clear();
    const std::vector<glm::vec3> own = groom.points;
    const auto place = [&](const Similarity& where, std::vector<glm::vec3>& placed) {
      for (std::size_t i = 0; i < own.size(); ++i) placed[i] = where.point(own[i]);
    };
    place(instance.first, groom.points);
    for (float& radius : groom.radius_cm) radius *= instance.first.scale;
    for (glm::vec3& axis : groom.minor_axis) axis = instance.first.turn * axis;
    for (const Similarity& later : instance.later) {
      groom.later.push_back({own, glm::dmat3(later.turn * glm::transpose(instance.first.turn))});
      place(later, groom.later.back().points);
      for (const float radius : scene.grooms[0].radius_cm) groom.later.back().radius_cm.push_back(later.scale * radius);
    }
    all.grooms.push_back(std::move(groom));
  }
  return all;
}

struct Compared {
  int hits = 0, differ = 0;
};

/// Compares hits of rays, and those of rays that leave them. within: tolerance of positions and directions.
Compared compare(const scene::Scene& scene, float within, float last_time) {
  const scene::Scene all = written_out(scene);
  const FiberScene fibers(scene), written(all);
  RandomStream random(2026, 2);
  Compared compared;
  for (int i = 0; i < 40000; ++i) {
    Ray ray;
    ray.direction = random_direction(random);
    ray.origin = random_point(random, 4) - 8.0f * ray.direction;
    ray.time = last_time * random.next();
    for (int bounce = 0; bounce < 2; ++bounce) {
      const std::optional<Hit> a = fibers.intersect(ray);
      Ray other = ray;
      if (other.start_instance != no_index) {
        other.start_groom = other.start_instance;
        other.start_instance = no_index;
      }
      const std::optional<Hit> b = written.intersect(other);
      EXPECT_EQ(fibers.occluded(ray), a.has_value());
      const bool same = a.has_value() == b.has_value() &&
                        (!a || (a->instance == b->groom && a->strand == b->strand && a->groom == 0));
      if (!same) ++compared.differ;
      if (!same || !a) break;
      ++compared.hits;
      EXPECT_NEAR(a->distance_cm, b->distance_cm, within);
      EXPECT_NEAR(glm::distance(a->position, b->position), 0, within);
      EXPECT_NEAR(glm::distance(a->axis, b->axis), 0, within);
      // At the bend of a polygon either of two pieces may be met.
      if (scene.grooms[0].basis == StrandBasis::linear && std::abs(a->place - std::round(a->place)) < 1e-3f) break;
      EXPECT_NEAR(glm::distance(a->u, b->u), 0, within);
      if (a->eccentricity < 1) {
        EXPECT_NEAR(std::abs(glm::dot(a->v, b->v)), 1, within);
      }
      EXPECT_NEAR(glm::distance(glm::cross(a->u, a->v), a->w), 0, 1e-5f);
      EXPECT_NEAR(a->semi_axis_cm, b->semi_axis_cm, within);
      EXPECT_NEAR(a->lateral, b->lateral, 20 * within);
      EXPECT_NEAR(a->place, b->place, 10 * within);
      EXPECT_NEAR(glm::distance(a->way, b->way), 0, within);
      EXPECT_NEAR(glm::distance(a->came_by, b->came_by), 0, 10 * within);
      if (testing::Test::HasFailure()) return compared;
      ray = ray_from(*a, random_direction(random));
      ray.came_by.reset();  // of meshes, which the scene has none of
    }
  }
  return compared;
}

class Instances : public testing::TestWithParam<StrandBasis> {};

TEST_P(Instances, AreHitAsTheSameStrandsWrittenOut) {
  scene::Scene scene = tuft(GetParam());
  RandomStream random(2026, 3);
  for (int i = 0; i < 5; ++i) scene.grooms[0].instances.push_back({random_place(random)});
  // Floats of a few centimetres are rounded to 5e-7 cm: 1e-5 of a strand's radius, of 0.03 cm and more. So rounding
  // decides at the edge of a strand for some 1e-4 of the hits: more than five of 4,000 have a probability of 1e-5.
  const Compared compared = compare(scene, 1e-3f, 0);
  EXPECT_GT(compared.hits, 3000);
  EXPECT_LE(compared.differ, 5);
}

TEST_P(Instances, ThatMoveAreHitWhereTheyAre) {
  scene::Scene scene = tuft(GetParam());
  RandomStream random(2026, 4);
  for (int i = 0; i < 5; ++i) {
    const Similarity first = random_place(random);
    Similarity later = first;
    later.offset += random_point(random, 1);  // without a turn, they are what points make of them, at any time
    scene.grooms[0].instances.push_back({first, {later}});
  }
  const Compared compared = compare(scene, 1e-3f, 1);
  EXPECT_GT(compared.hits, 3000);
  EXPECT_LE(compared.differ, 5);
}

INSTANTIATE_TEST_SUITE_P(AllBases, Instances,
                         testing::Values(StrandBasis::bspline, StrandBasis::linear, StrandBasis::open_bspline));

TEST(InstancesInMemory, TakeThatOfOneAndOfTheirPlaces) {
  scene::Scene scene = tuft(StrandBasis::bspline);
  RandomStream random(2026, 5);
  scene.grooms[0].instances.assign(1, {random_place(random)});
  const std::size_t one = FiberScene(scene).bytes();
  for (int i = 0; i < 9999; ++i) scene.grooms[0].instances.push_back({random_place(random)});
  const std::size_t all = FiberScene(scene).bytes();
  // Embree keeps for an instance its matrix both ways, its bounds and an entry of the tree; the strands take 12 * 4 *
  // 200 bytes and more.
  EXPECT_LT((all - one) / 9999, 1500u);
  EXPECT_LT(sizeof(Instance), 100u);
}

TEST(InstancesWithPresence, AreMetIndependently) {
  // Two instances one behind the other, each there with a half: a quarter of the rays pass both. 4,000 rays have a
  // standard deviation of 0.007; equal draws in both would let a half pass.
  scene::Scene scene = straight_scene({{{-5, 0, 0}, {5, 0, 0}, 1, 1, 1}}, true, 2);
  scene.grooms[0].presence = {0.5f};
  scene.grooms[0].instances = {{Similarity{}}, {Similarity{glm::mat3(1.0f), 1, {0, 20, 0}}}};
  const FiberScene fibers(scene);
  int passed = 0;
  constexpr int rays = 4000;
  for (int i = 0; i < rays; ++i) {
    Ray ray;
    ray.origin = {0, -10, 0};
    ray.direction = {0, 1, 0};
    ray.key = static_cast<std::uint64_t>(i);
    passed += fibers.intersect(ray) ? 0 : 1;
  }
  EXPECT_NEAR(static_cast<double>(passed) / rays, 0.25, 4 * 0.007);
}

TEST(InstanceBounds, HoldEveryPoint) {
  scene::Scene scene = tuft(StrandBasis::linear);
  RandomStream random(2026, 6);
  for (int i = 0; i < 3; ++i) scene.grooms[0].instances.push_back({random_place(random)});
  std::optional<scene::Box> box;
  scene::for_each_bounding_point(scene.grooms[0], [&](const glm::vec3& point) {
    if (!box) box = scene::Box{point, point};
    box->include(point);
  });
  ASSERT_TRUE(box);
  for (const Instance& instance : scene.grooms[0].instances)
    for (const glm::vec3& own : scene.grooms[0].points)
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(instance.first.point(own)[axis], box->low[axis] - 1e-5f);
        EXPECT_LE(instance.first.point(own)[axis], box->high[axis] + 1e-5f);
      }
}

}  // namespace
}  // namespace tress::geometry
