// Strands and meshes that move while the shutter is open: coverage on paper, and stills of the same places.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/camera.h"
#include "straight_strands.h"

namespace tress::geometry {
namespace {

using scene::Groom;
using scene::Scene;
using scene::StrandBasis;

/// Adds a later moment at which all strands are `way` further.
void move_by(const glm::vec3& way, Groom* groom) {
  scene::StrandMoment moment{groom->later.empty() ? groom->points : groom->later.back().points};
  for (glm::vec3& point : moment.points) point += way;
  groom->later.push_back(moment);
}

class Moving : public testing::TestWithParam<StrandBasis> {};

INSTANTIATE_TEST_SUITE_P(Bases, Moving, testing::Values(StrandBasis::bspline, StrandBasis::linear),
                         [](const auto& basis) { return basis.param == StrandBasis::linear ? "linear" : "bspline"; });

/// A fiber moves by its own width. At x, from its middle at the opening and in half widths, it is there while
/// |x - 2 t| < 1: for (x + 1) / 2 of the time where x < 1, for (3 - x) / 2 where x > 1. By 4,096 even times, which
/// miss a share by 1 / 4096 at the most; places are rounded to 2e-7 cm, a 40,000th of the width.
TEST_P(Moving, AFiberThatMovesOneWidthIsSeenForTheShareOfTheTimeOnPaper) {
  for (const float eccentricity : {1.0f, 0.6f}) {
    Scene scene =
        straight_scene({{{0, 0, -1}, {0, 0, 1}, 0.004f, 0.004f, eccentricity}}, GetParam() == StrandBasis::linear);
    scene.materials[0].twist = false;
    scene.materials[0].root_angle_rad = 0.4;
    // root_normal() of a strand along z is x: rays along y see the ellipse from 0.4 - pi/2.
    const double half =
        fiber::major_semi_axis(0.004, eccentricity) *
        double{fiber::projected_half_width(static_cast<float>(std::numbers::pi / 2 - 0.4), eccentricity)};
    move_by({static_cast<float>(2 * half), 0, 0}, &scene.grooms[0]);
    const FiberScene fibers(scene);
    constexpr int places = 40, times = 4096;
    double worst = 0, whole = 0;
    for (int i = 0; i < places; ++i) {
      const double x = -1 + 4 * (i + 0.5) / places;
      int seen = 0, blocked = 0;
      for (int k = 0; k < times; ++k) {
        Ray ray{{static_cast<float>(x * half), -1, 0.1f}, {0, 1, 0}};
        ray.time = (static_cast<float>(k) + 0.5f) / times;
        seen += fibers.intersect(ray).has_value();
        blocked += fibers.occluded(ray, 2);
      }
      EXPECT_EQ(seen, blocked);
      const double share = static_cast<double>(seen) / times;
      worst = std::max(worst, std::abs(share - (x < 1 ? (x + 1) / 2 : (3 - x) / 2)));
      whole += share / places;
    }
    EXPECT_LT(worst, 1e-3) << "e " << eccentricity;
    EXPECT_NEAR(whole, 0.5, 1e-3) << "e " << eccentricity;
  }
}

/// Curved strands of three moments, which go different ways.
Scene curved_scene(StrandBasis basis) {
  RandomStream random(31);
  Scene scene;
  scene.materials.resize(1);
  scene.grooms.resize(1);
  Groom& groom = scene.grooms[0];
  groom.basis = basis;
  groom.first_point = {0};
  groom.later.resize(2);
  for (int strand = 0; strand < 60; ++strand) {
    const glm::vec3 root = random_point(random, 1), along = 0.3f * random_direction(random);
    for (int i = 0; i < 7; ++i) {
      const glm::vec3 point = root + static_cast<float>(i) * along;
      groom.points.push_back(point + random_point(random, 0.08f));
      groom.radius_cm.push_back(0.02f);
      for (scene::StrandMoment& moment : groom.later)
        moment.points.push_back(groom.points.back() + random_point(random, 0.15f));
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  scene.image.curve_error_px = 100;  // as many pieces, the fewest, in every scene
  scene::assign_fibers(&scene);
  return scene;
}

/// The still of a time in [0, 1].
Scene still_of(const Scene& moving, float time) {
  Scene still = moving;
  Groom& groom = still.grooms[0];
  const bool late = time >= 0.5f;
  const std::vector<glm::vec3>& a = late ? moving.grooms[0].later[0].points : moving.grooms[0].points;
  const std::vector<glm::vec3>& b = moving.grooms[0].later[late ? 1 : 0].points;
  const float share = 2 * time - (late ? 1 : 0);
  for (std::size_t i = 0; i < a.size(); ++i) groom.points[i] = (1 - share) * a[i] + share * b[i];
  groom.later.clear();
  return still;
}

/// Round fibers, so that only places decide. Rounding turns the answer of a ray that grazes a fiber, or that passes
/// a bend where two straight pieces are as near: 4 of 4,000 are allowed to differ.
TEST_P(Moving, ARayMeetsWhatAStillOfItsTimeShows) {
  Scene scene = curved_scene(GetParam());
  for (fiber::FiberParameters& fiber : scene.fibers) fiber.eccentricity = 1;
  const FiberScene moving(scene);
  RandomStream random(32);
  int differ = 0, met = 0;
  for (const float time : {0.0f, 0.2f, 0.5f, 0.85f, 1.0f}) {
    const Scene of_time = still_of(scene, time);
    const FiberScene still(of_time);
    for (int i = 0; i < 800; ++i) {
      Ray ray{3.0f * random_direction(random), {}};
      ray.direction = glm::normalize(random_point(random, 1) - ray.origin);
      ray.time = time;
      const auto a = moving.intersect(ray), b = still.intersect(ray);
      EXPECT_EQ(a.has_value(), moving.occluded(ray));
      met += b.has_value();
      const bool same_strand = a.has_value() == b.has_value() && (!a || a->strand == b->strand);
      if (!same_strand || (a && glm::dot(a->u, b->u) < 0.9999f)) {
        ++differ;
        continue;
      }
      if (!a) continue;
      EXPECT_NEAR(a->distance_cm, b->distance_cm, 1e-4);
      EXPECT_LT(glm::distance(a->axis, b->axis), 1e-4);
      EXPECT_LT(std::abs(glm::dot(a->u, a->v)) + std::abs(glm::dot(a->u, a->w)) + std::abs(glm::dot(a->v, a->w)), 1e-5);
      EXPECT_EQ(a->time, time);
      EXPECT_EQ(ray_from(*a, {0, 0, 1}).time, time);
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_LE(differ, 4);
}

/// Radii that grow and shrink, each at its own point: what is met, and where across the fiber, are those of the still.
TEST_P(Moving, RadiiGoFromMomentToMoment) {
  Scene scene = curved_scene(GetParam());
  for (fiber::FiberParameters& fiber : scene.fibers) fiber.eccentricity = 1;
  Groom& groom = scene.grooms[0];
  RandomStream random(35);
  for (scene::StrandMoment& moment : groom.later)
    for (std::size_t i = 0; i < groom.points.size(); ++i) moment.radius_cm.push_back(0.01f + 0.03f * random.next());
  const FiberScene moving(scene);
  int differ = 0, met = 0;
  for (const float time : {0.0f, 0.2f, 0.5f, 0.85f, 1.0f}) {
    Scene of_time = still_of(scene, time);
    const bool late = time >= 0.5f;
    const std::vector<float>& a = late ? groom.later[0].radius_cm : groom.radius_cm;
    const std::vector<float>& b = groom.later[late ? 1 : 0].radius_cm;
    const float share = 2 * time - (late ? 1 : 0);
    for (std::size_t i = 0; i < a.size(); ++i) of_time.grooms[0].radius_cm[i] = (1 - share) * a[i] + share * b[i];
    const FiberScene still(of_time);
    for (int i = 0; i < 800; ++i) {
      Ray ray{3.0f * random_direction(random), {}};
      ray.direction = glm::normalize(random_point(random, 1) - ray.origin);
      ray.time = time;
      const auto one = moving.intersect(ray), other = still.intersect(ray);
      const bool same = one.has_value() == other.has_value() && (!one || one->strand == other->strand);
      if (!same || (one && (glm::dot(one->u, other->u) < 0.9999f || std::abs(one->lateral - other->lateral) > 1e-2f))) {
        ++differ;
        continue;
      }
      met += one.has_value();
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_LE(differ, 8) << "of 4,000: rounding decides where a ray grazes a fiber";
}

/// The way that a hit has is that of the place on the strand, from the opening to the closing.
TEST_P(Moving, AHitKnowsItsWay) {
  Scene scene = curved_scene(GetParam());
  scene.grooms[0].later.clear();
  move_by({0.1f, -0.2f, 0.3f}, &scene.grooms[0]);
  move_by({0.1f, 0.2f, 0}, &scene.grooms[0]);
  const FiberScene fibers(scene);
  RandomStream random(33);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    Ray ray{3.0f * random_direction(random), {}};
    ray.direction = glm::normalize(random_point(random, 1) - ray.origin);
    ray.time = random.next();
    const auto hit = fibers.intersect(ray);
    if (!hit) continue;
    ++met;
    EXPECT_LT(glm::distance(hit->way, glm::vec3(0.2f, 0, 0.3f)), 1e-5);
  }
  EXPECT_GT(met, 100);
}

/// A strand along the axis of the turn keeps its place, and its major axis turns with the whole: by a quarter at the
/// end, by half of that in between.
TEST(MovingFrames, MajorAxesTurnWithAGroomThatTurns) {
  constexpr double quarter = std::numbers::pi / 2;
  Scene scene = straight_scene({{{0, 0, -1}, {0, 0, 1}, 0.05f, 0.05f, 0.9f}}, false);
  scene.materials[0].twist = false;
  scene.materials[0].root_angle_rad = 0;
  const glm::vec3 pivot(0);
  scene::turn_objects(std::array{scene::ObjectTurn{0, pivot}, scene::ObjectTurn{quarter, pivot}}, &scene.grooms,
                      &scene.meshes);
  const FiberScene fibers(scene);
  for (const float time : {0.0f, 0.5f, 1.0f}) {
    Ray ray{{0, -1, 0}, {0, 1, 0}};
    ray.time = time;
    const auto hit = fibers.intersect(ray);
    ASSERT_TRUE(hit);
    const double angle = quarter * double{time};
    EXPECT_NEAR(hit->v.x, std::cos(angle), 1e-5) << time;
    EXPECT_NEAR(hit->v.y, std::sin(angle), 1e-5) << time;
  }
}

/// Where a strand bends over, so that the world axis that its root normal is made of would be another one, frames do
/// not jump: the major axis stays the one that was carried along, across the plane of the bend.
TEST(MovingFrames, AMajorAxisFollowsAStrandThatTipsOver) {
  Scene scene = straight_scene({{{0, 0, -1}, {0, 0, 1}, 0.05f, 0.05f, 0.9f}}, false);
  scene.materials[0].twist = false;
  scene.materials[0].root_angle_rad = std::numbers::pi / 2;  // along y: x is the root normal of a strand along z
  scene::StrandMoment tipped{scene.grooms[0].points};
  for (glm::vec3& point : tipped.points) point = {point.z, point.y, -point.x};
  scene.grooms[0].later = {tipped};
  const FiberScene fibers(scene);
  for (const float time : {0.0f, 0.3f, 0.5f, 0.8f, 1.0f}) {
    Ray ray{{0.01f, -1, 0.02f}, {0, 1, 0}};  // not through a point where two pieces of the ribbon meet
    ray.time = time;
    const auto hit = fibers.intersect(ray);
    ASSERT_TRUE(hit) << time;
    EXPECT_NEAR(std::abs(hit->v.y), 1, 1e-5) << time;
  }
}

/// A square that moves, far from the origin: rays meet it where it is, and those that leave it do not meet it again.
TEST(MovingMesh, IsMetWhereItIsAndNotByTheRaysThatLeaveIt) {
  Scene scene;
  scene::Mesh mesh;
  mesh.positions = {{900, 900, 0}, {910, 900, 0}, {910, 910, 0}, {900, 910, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene::MeshMoment later{mesh.positions, {}};
  const glm::vec3 way(3, 1, 7);
  for (glm::vec3& p : later.positions) p += way;
  mesh.later = {later};
  scene.meshes = {mesh};
  const FiberScene surfaces(scene);
  RandomStream random(34);
  for (int i = 0; i < 3000; ++i) {
    Ray ray{glm::vec3(905, 905, 3) + 30.0f * random_direction(random), {}};
    ray.time = random.next();
    const float a = 10 * random.next(), b = 10 * random.next();
    const glm::vec3 target = glm::vec3(900 + a, 900 + b, 0) + ray.time * way;
    ray.direction = glm::normalize(target - ray.origin);
    if (std::abs(ray.direction.z) < 0.05f) continue;
    const auto hit = surfaces.intersect(ray);
    ASSERT_TRUE(hit);
    EXPECT_LT(glm::distance(hit->position, target), 3e-3) << "24 units in the last place at 900 cm, seen at 3 degrees";
    EXPECT_LT(glm::distance(hit->way, way), 1e-4);
    glm::vec3 leaving = random_direction(random);
    if (glm::dot(leaving, hit->normal) < 0) leaving = -leaving;
    EXPECT_FALSE(surfaces.intersect(ray_from(*hit, leaving)));
    EXPECT_FALSE(surfaces.occluded(ray_from(*hit, leaving)));
  }
}

}  // namespace
}  // namespace tress::geometry
