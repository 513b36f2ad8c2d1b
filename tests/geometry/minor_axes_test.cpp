// Minor axes that a file gives, against axes that are written down: straight strands, on which nothing else turns.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/model/camera.h"
#include "straight_strands.h"

namespace tress::geometry {
namespace {

using scene::StrandBasis;

constexpr double degree = std::numbers::pi / 180;

/// Minor axes along x of a strand that goes along z, turned about it from x towards y.
glm::vec3 axis_at(double degrees) {
  return {static_cast<float>(std::cos(degrees * degree)), static_cast<float>(std::sin(degrees * degree)), 0};
}

struct Turned {
  bool any = false;
  StrandKnots knots;
  std::vector<KnotFrame> frames;
};

/// A strand from the origin along z, 1 cm from point to point, with frames that turn until axes are given.
Turned turned(const std::vector<glm::vec3>& axes, StrandBasis basis = StrandBasis::linear) {
  std::vector<glm::vec3> points;
  for (std::size_t i = 0; i < axes.size(); ++i) points.emplace_back(0, 0, static_cast<float>(i));
  Turned strand;
  strand.knots = strand_knots(points, basis);
  strand.frames = strand_frames(strand.knots, 0.4, 3);
  strand.any = turn_to_minor_axes(strand.knots, axes, basis, &strand.frames);
  return strand;
}

/// Degrees from x of the minor axis between two knots, within half a turn, since it has no sign.
double minor_degrees(const Turned& strand, std::size_t knot, float t) {
  const FiberFrame frame = frame_between(strand.frames[knot], strand.frames[knot + 1], t, {0, 0, 1});
  EXPECT_NEAR(glm::length(glm::cross(frame.u, frame.v) - frame.w), 0, 2e-6);
  return std::atan2(frame.w.y, frame.w.x) / degree;
}

/// Angles are floats of a few radians: 1e-4 degrees are 7 units in their last place.
void expect_axis(const Turned& strand, std::size_t knot, float t, double degrees) {
  EXPECT_NEAR(std::remainder(minor_degrees(strand, knot, t) - degrees, 180), 0, 1e-4) << knot << " " << t;
}

TEST(MinorAxes, AreThoseGivenAtThePointsOfAPolygonAndTurnEvenlyInBetween) {
  const Turned strand = turned({axis_at(10), axis_at(70), axis_at(100), axis_at(100)});
  ASSERT_TRUE(strand.any);
  for (const float t : {0.0f, 0.25f, 1.0f}) {
    expect_axis(strand, 0, t, 10 + 60 * double{t});
    expect_axis(strand, 1, t, 70 + 30 * double{t});
    expect_axis(strand, 2, t, 100);
  }
}

TEST(MinorAxes, OfEvenTurnsAreTheSameInEveryBasis) {
  std::vector<glm::vec3> axes;
  for (int i = 0; i < 7; ++i) axes.push_back(axis_at(5 + 50 * i));
  // The mean of axes at -50, 0 and 50 degrees is at 0: blended control values keep an even turn. At the ends B-splines
  // have the first and the last one.
  const Turned bspline = turned(axes, StrandBasis::bspline), open = turned(axes, StrandBasis::open_bspline),
               bezier = turned(axes, StrandBasis::bezier);
  ASSERT_TRUE(bspline.any && open.any && bezier.any);
  ASSERT_EQ(bspline.frames.size(), 7u);
  ASSERT_EQ(open.frames.size(), 5u);
  ASSERT_EQ(bezier.frames.size(), 3u);
  for (std::size_t i = 0; i < 6; ++i) expect_axis(bspline, i, 0, 5 + 50 * static_cast<double>(i));
  for (std::size_t i = 0; i < 4; ++i) expect_axis(open, i, 0, 55 + 50 * static_cast<double>(i));
  expect_axis(bezier, 0, 0, 5);
  expect_axis(bezier, 1, 0, 155);  // three points on: from 5 to 155 degrees, the shorter way by -30
  expect_axis(bezier, 0, 0.5f, -10);
}

TEST(MinorAxes, AndTheirOppositesAreTheSame) {
  const std::vector<glm::vec3> axes{axis_at(0), axis_at(30), axis_at(60), axis_at(90), axis_at(120)};
  std::vector<glm::vec3> flipped = axes;
  for (const std::size_t i : {1u, 2u, 4u}) flipped[i] = -flipped[i];
  for (const StrandBasis basis : {StrandBasis::linear, StrandBasis::bspline, StrandBasis::open_bspline}) {
    const Turned a = turned(axes, basis), b = turned(flipped, basis);
    ASSERT_TRUE(a.any && b.any);
    for (std::size_t i = 0; i + 1 < a.frames.size(); ++i)
      for (const float t : {0.0f, 0.5f}) expect_axis(b, i, t, minor_degrees(a, i, t));
  }
}

TEST(MinorAxes, WhereThereIsNoneComeEvenlyFromThoseAround) {
  // None, along the strand, and almost along it.
  const Turned strand = turned({glm::vec3(0), axis_at(20), {0, 0, 1}, glm::vec3(0), axis_at(80), {1e-4f, 0, -1}});
  ASSERT_TRUE(strand.any);
  expect_axis(strand, 0, 0, 20);
  expect_axis(strand, 1, 0, 20);
  expect_axis(strand, 2, 0, 40);
  expect_axis(strand, 3, 0, 60);
  expect_axis(strand, 4, 0, 80);
  expect_axis(strand, 4, 1, 80);
  expect_axis(turned({axis_at(20), glm::vec3(0), glm::vec3(0), axis_at(80)}, StrandBasis::bspline), 1, 0, 20);
}

TEST(MinorAxes, OfAStrandThatHasNoneAreTheMaterials) {
  const Turned strand = turned({glm::vec3(0), {0, 0, 1}, {0, 0, -1}});
  EXPECT_FALSE(strand.any);
  EXPECT_FLOAT_EQ(strand.frames[0].angle, 0.4f);
  EXPECT_FLOAT_EQ(strand.frames[2].angle, 6.4f);
}

/// A strand along z with minor axes that turn by 30 degrees a point, from x on.
scene::Scene given_scene(bool linear) {
  scene::Scene scene = straight_scene({{{0, 0, 0}, {0, 0, 4}, 0.01f, 0.01f, 0.5f}}, linear);
  for (int i = 0; i < 5; ++i) scene.grooms[0].minor_axis.push_back(axis_at(30 * i));
  return scene;
}

Ray across(float z, double degrees, double off) {
  const glm::vec3 direction = axis_at(degrees);
  const glm::vec3 aside(-direction.y, direction.x, 0);
  return {-1.0f * direction + static_cast<float>(off) * aside + glm::vec3(0, 0, z), direction};
}

TEST(MinorAxes, MakeFibersAsWideAsTheirEllipseFromEverySide) {
  for (const bool linear : {false, true}) {
    const scene::Scene scene = given_scene(linear);
    const FiberScene fibers(scene);
    const double major = fiber::major_semi_axis(0.01, 0.5), minor = 0.5 * major;
    for (const int z : {1, 2, 3}) {
      const double along_minor = 30 * z;
      const auto height = static_cast<float>(z) + 1e-4f;
      EXPECT_TRUE(fibers.intersect(across(height, along_minor, 0.98 * major))) << linear << z;
      EXPECT_FALSE(fibers.intersect(across(height, along_minor, 1.02 * major))) << linear << z;
      EXPECT_TRUE(fibers.intersect(across(height, along_minor + 90, 0.98 * minor))) << linear << z;
      EXPECT_FALSE(fibers.intersect(across(height, along_minor + 90, 1.02 * minor))) << linear << z;
      const auto hit = fibers.intersect(across(height, 17, 0));
      ASSERT_TRUE(hit);
      EXPECT_NEAR(std::abs(glm::dot(hit->w, axis_at(along_minor))), 1, 1e-5) << linear << z;
    }
  }
}

TEST(MinorAxes, TurnWithTheGroomWhileTheShutterIsOpenAndOnATurntable) {
  scene::Scene scene = given_scene(false);
  const double quarter = std::numbers::pi / 2;
  scene::turn_objects(std::vector<scene::ObjectTurn>{{quarter}, {2 * quarter}}, &scene.grooms, &scene.meshes);
  ASSERT_EQ(scene.grooms[0].later.size(), 1u);
  const FiberScene fibers(scene);
  for (const float time : {0.0f, 1.0f}) {
    Ray ray = across(2.0001f, 17, 0);
    ray.time = time;
    const auto hit = fibers.intersect(ray);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(std::abs(glm::dot(hit->w, axis_at(60 + 90 * (1 + double{time})))), 1, 1e-4) << time;
  }
}

}  // namespace
}  // namespace tress::geometry
