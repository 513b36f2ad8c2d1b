// Frames along a strand: orthonormal, right-handed, smooth, turned as given.
#include "geometry/strand_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace tress::geometry {
namespace {

std::vector<glm::vec3> helix(int count) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < count; ++i) {
    const float t = 0.1f * static_cast<float>(i);
    points.emplace_back(std::cos(t), std::sin(t), 0.3f * t);
  }
  return points;
}

glm::vec3 knot_tangent(const std::vector<glm::vec3>& points, std::size_t i) {
  return glm::normalize(points[i + 1] - points[i - 1]);
}

void expect_orthonormal_right_handed(const FiberFrame& frame) {
  // Rounding of a handful of float operations on unit vectors: a few 1e-7.
  EXPECT_NEAR(glm::length(frame.v), 1, 2e-6);
  EXPECT_NEAR(glm::length(frame.w), 1, 2e-6);
  EXPECT_NEAR(glm::dot(frame.u, frame.v), 0, 2e-6);
  EXPECT_NEAR(glm::dot(frame.u, frame.w), 0, 2e-6);
  EXPECT_NEAR(glm::dot(frame.v, frame.w), 0, 2e-6);
  EXPECT_NEAR(glm::length(glm::cross(frame.u, frame.v) - frame.w), 0, 2e-6);
}

TEST(StrandFrames, are_orthonormal_and_right_handed_between_knots) {
  const std::vector<glm::vec3> points = helix(60);
  const std::vector<KnotFrame> frames = strand_frames(points, 0.7, 3.0);
  ASSERT_EQ(frames.size(), points.size());
  for (std::size_t i = 1; i + 2 < points.size(); ++i) {
    for (float t : {0.0f, 0.3f, 0.9f, 1.0f}) {
      const glm::vec3 tangent = glm::normalize((1 - t) * knot_tangent(points, i) + t * knot_tangent(points, i + 1));
      expect_orthonormal_right_handed(frame_between(frames[i], frames[i + 1], t, tangent));
    }
  }
}

/// Points that turn are rounded; what decides on an axis must not be. Strands that go straight down, or along a
/// diagonal, are as near to one axis as to another.
TEST(StrandFrames, turn_with_a_strand_that_turns_about_the_vertical) {
  const std::vector<std::vector<glm::vec3>> strands{
      helix(40),
      {{3.1f, -2.7f, 8}, {3.1f, -2.7f, 5}, {3.1f, -2.7f, 1}, {3.2f, -2.7f, -4}},
      {{0.3f, 0.7f, 2}, {1.3f, 1.7f, 2}, {2.3f, 2.7f, 2}, {3.3f, 3.7f, 2.5f}},
      {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4.1f}}};
  for (const std::vector<glm::vec3>& points : strands) {
    const std::vector<KnotFrame> still = strand_frames(points, 0.4, 0.3);
    for (int step = 1; step < 48; ++step) {
      const double turn = step * 0.1309, c = std::cos(turn), s = std::sin(turn);
      const auto turned = [&](const glm::vec3& p) {
        return glm::vec3(static_cast<float>(c * p.x - s * p.y), static_cast<float>(s * p.x + c * p.y), p.z);
      };
      std::vector<glm::vec3> there;
      for (const glm::vec3& point : points) there.push_back(turned(point));
      const std::vector<KnotFrame> frames = strand_frames(there, 0.4, 0.3, scene::StrandBasis::bspline, turn);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LT(glm::distance(frames[i].normal, turned(still[i].normal)), 2e-5f) << step;
        EXPECT_NEAR(frames[i].angle, still[i].angle, 1e-5);
      }
    }
  }
}

TEST(StrandFrames, do_not_turn_about_the_tangent_more_than_parallel_transport) {
  // A helix of radius 1 and pitch 0.3 per radian: parallel transport turns against the Frenet frame by the torsion
  // 0.3/(1 + 0.3^2) per unit of length, sqrt(1 + 0.3^2) of it per radian. The spline's knots lie on a helix of radius
  // (4 + 2 cos 0.1)/6 and the same pitch; double reflection is of fourth order in the step of 0.1 rad.
  const std::vector<glm::vec3> points = helix(101);
  const std::vector<KnotFrame> frames = strand_frames(points, 0, 0);
  const double radius = (4 + 2 * std::cos(0.1)) / 6;
  const double rate = 0.3 / std::sqrt(radius * radius + 0.09);
  const auto angle_to_frenet = [&](std::size_t i) {
    const double t = 0.1 * static_cast<double>(i);
    const glm::vec3 inwards(-std::cos(t), -std::sin(t), 0);
    const glm::vec3 binormal = glm::cross(knot_tangent(points, i), inwards);
    return std::atan2(glm::dot(frames[i].normal, binormal), glm::dot(frames[i].normal, inwards));
  };
  double turned = 0;
  for (std::size_t i = 2; i + 1 < points.size(); ++i) {
    double step = angle_to_frenet(i) - angle_to_frenet(i - 1);
    step -= 2 * M_PI * std::round(step / (2 * M_PI));
    turned += step;
  }
  // 98 steps of 0.1 rad; the tangent p+ - p- of a sampled helix is steeper than the curve's by less than 0.2 %.
  EXPECT_NEAR(turned, -9.8 * rate, 0.002 * 9.8 * rate);
}

TEST(StrandFrames, start_at_the_root_angle_and_turn_with_length) {
  // A straight strand along x of two points, 30 cm: many turns between two knots.
  const std::vector<glm::vec3> points{{0, 0, 0}, {30, 0, 0}};
  const double root_angle = 0.4, rate = 2 / 1.7;
  const std::vector<KnotFrame> frames = strand_frames(points, root_angle, rate);
  const glm::vec3 tangent(1, 0, 0);
  const glm::vec3 reference = root_normal(tangent);
  EXPECT_EQ(reference, glm::vec3(0, 1, 0));
  for (float t : {0.0f, 0.01f, 0.5f, 1.0f}) {
    const double angle = root_angle + rate * 30 * t;
    const glm::vec3 expected(0, std::cos(angle), std::sin(angle));
    // The turn reaches 35 rad: half a unit in the last place of float is 2e-6.
    EXPECT_NEAR(glm::length(frame_between(frames[0], frames[1], t, tangent).v - expected), 0, 1e-5);
  }
}

TEST(StrandFrames, change_in_proportion_to_the_step) {
  const std::vector<glm::vec3> coarse = helix(50);
  const std::vector<KnotFrame> frames = strand_frames(coarse, 0, 0);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    // The tangent turns by at most 0.1 rad a step, the normal no faster.
    EXPECT_LT(glm::length(frames[i].normal - frames[i - 1].normal), 0.101f);
  }
}

TEST(StrandFrames, exist_for_degenerate_strands) {
  const std::vector<std::vector<glm::vec3>> strands{{{1, 2, 3}, {1, 2, 3}},                         // all the same
                                                    {{0, 0, 0}, {0, 0, 0}, {0, 0, 1}},              // repeated root
                                                    {{0, 0, 0}, {0, 0, 1}, {0, 0, 0}},              // straight back
                                                    {{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}};  // repeated tip
  for (const std::vector<glm::vec3>& points : strands) {
    for (const KnotFrame& frame : strand_frames(points, 0, 1)) {
      EXPECT_NEAR(glm::length(frame.normal), 1, 1e-6);
      EXPECT_TRUE(std::isfinite(frame.angle));
    }
  }
  EXPECT_TRUE(strand_frames(std::vector<glm::vec3>{{0, 0, 0}}, 0, 0).empty());
  // Normals that cancel half way still give a frame.
  expect_orthonormal_right_handed(frame_between({{1, 0, 0}, 0}, {{-1, 0, 0}, 0}, 0.5f, {0, 0, 1}));
}

/// In a plane the rotation-minimising normal off the plane stays, however sharp and uneven the bends; the turn follows
/// the length from point to point.
TEST(StrandFrames, of_linear_strands_halve_the_bends) {
  const std::vector<glm::vec3> points{{0, 0, 0}, {0, 0, 1}, {0, 0.5f, 1}, {0, 0.5f, 1}, {0, 1, 3}, {0, 0.2f, 2.8f}};
  const std::vector<KnotFrame> frames = strand_frames(points, 0.4, 0.7, scene::StrandBasis::linear);
  ASSERT_EQ(frames.size(), points.size());
  double length = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // The least aligned axis with +z is x, normal to the plane.
    EXPECT_NEAR(glm::length(frames[i].normal - glm::vec3(1, 0, 0)), 0, 2e-6) << i;
    if (i > 0) length += glm::length(points[i] - points[i - 1]);
    EXPECT_NEAR(frames[i].angle, 0.4 + 0.7 * length, 2e-6) << i;
  }
  // Out of a plane: orthogonal to the direction that halves the bend.
  const std::vector<glm::vec3> bent{{0, 0, 0}, {0.1f, 0, 1}, {0.7f, 0.9f, 1.2f}, {0.5f, 1.5f, 3}};
  const std::vector<KnotFrame> knots = strand_frames(bent, 0, 0, scene::StrandBasis::linear);
  for (std::size_t i = 1; i + 1 < bent.size(); ++i) {
    const glm::vec3 half = glm::normalize(bent[i + 1] - bent[i]) + glm::normalize(bent[i] - bent[i - 1]);
    EXPECT_NEAR(glm::dot(knots[i].normal, half), 0, 2e-6) << i;
  }
  EXPECT_NEAR(glm::dot(knots[0].normal, bent[1] - bent[0]), 0, 2e-6);
}

}  // namespace
}  // namespace tress::geometry
