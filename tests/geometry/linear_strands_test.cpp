// Linear strands that bend: ribbons from point to point, joined, against an exact answer.
#include <gtest/gtest.h>

#include <optional>

#include "straight_strands.h"

namespace tress::geometry {
namespace {

constexpr float radius_cm = 0.02f;

scene::Scene bent_scene(const std::vector<glm::vec3>& points, float eccentricity, bool linear) {
  scene::Scene scene;
  scene.materials.resize(1);
  scene.materials[0].fiber.eccentricity = eccentricity;
  scene.materials[0].curl_diameter_cm = 0.9;
  scene.materials[0].root_angle_rad = 0.3;
  scene::Groom groom;
  groom.basis = linear ? scene::StrandBasis::linear : scene::StrandBasis::bspline;
  groom.first_point = {0, static_cast<std::uint32_t>(points.size())};
  groom.points = points;
  groom.radius_cm.assign(points.size(), radius_cm);
  scene.grooms.push_back(groom);
  scene::assign_fibers(&scene);
  return scene;
}

/// Eight segments of 0.2 to 0.5 cm that bend by up to 100 degrees.
std::vector<glm::vec3> zigzag(std::uint64_t seed) {
  RandomStream random(51, seed);
  std::vector<glm::vec3> points{glm::vec3(0)};
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 step = glm::normalize(glm::vec3(0, 0, 1.2f) + random_direction(random));
    points.push_back(points.back() + (0.2f + 0.3f * random.next()) * step);
  }
  return points;
}

/// Where a line passes nearest to the axis of a segment: cm along the line, cm along the axis, cm between them.
struct Passing {
  double distance, along, offset;
};

Passing passing(const glm::dvec3& a, const glm::dvec3& b, const Ray& ray) {
  const glm::dvec3 u = glm::normalize(b - a), d = glm::normalize(glm::dvec3(ray.direction));
  const glm::dvec3 from = glm::dvec3(ray.origin) - a;
  const double cosine = glm::dot(d, u), sine2 = std::max(1e-12, 1 - cosine * cosine);
  const double distance = (cosine * glm::dot(from, u) - glm::dot(from, d)) / sine2;
  const double along = glm::dot(from, u) + distance * cosine;
  return {distance, along, glm::length(from + distance * d - along * u)};
}

struct Answer {
  double distance = std::numeric_limits<double>::infinity();
  double margin = std::numeric_limits<double>::infinity();  ///< cm by which every decision on the way is clear
  bool is_joint = false;                                    ///< whether it is the circle about a joint
};

/// Round fibers: a ribbon along every segment and, where the ray passes beyond the end of a segment and before the
/// start of the next, the circle about their joint.
Answer exact_answer(const std::vector<glm::vec3>& points, const Ray& ray) {
  Answer answer;
  const auto meet = [&](double distance, double inside, bool is_joint) {
    inside = std::min(inside, distance);
    answer.margin = std::min(answer.margin, std::abs(inside));
    if (!(inside > 0 && distance < answer.distance)) return;
    answer.distance = distance;
    answer.is_joint = is_joint;
  };
  const glm::dvec3 d = glm::normalize(glm::dvec3(ray.direction));
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Passing here = passing(points[i], points[i + 1], ray);
    const double length = glm::distance(glm::dvec3(points[i]), glm::dvec3(points[i + 1]));
    meet(here.distance, std::min({radius_cm - here.offset, here.along, length - here.along}), false);
    if (i + 2 == points.size()) break;
    const Passing next = passing(points[i + 1], points[i + 2], ray);
    const glm::dvec3 joint = points[i + 1];
    const double distance = glm::dot(joint - glm::dvec3(ray.origin), d);
    const double offset = glm::distance(glm::dvec3(ray.origin) + distance * d, joint);
    meet(distance, std::min({radius_cm - offset, here.along - length, -next.along}), true);
  }
  return answer;
}

double distance_to(const std::vector<glm::vec3>& points, const glm::dvec3& x) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const glm::dvec3 a = points[i], step = glm::dvec3(points[i + 1]) - a;
    const double t = std::clamp(glm::dot(x - a, step) / glm::dot(step, step), 0.0, 1.0);
    nearest = std::min(nearest, glm::distance(x, a + t * step));
  }
  return nearest;
}

/// A ray at the strand: towards a point of it or of a joint, 1 to 2 cm before.
Ray ray_at(const std::vector<glm::vec3>& points, RandomStream& random) {
  const auto segment =
      std::min(static_cast<std::size_t>(random.next() * static_cast<float>(points.size() - 1)), points.size() - 2);
  const float part = random.next() < 0.5f ? 0.0f : random.next();
  const glm::vec3 target = (1 - part) * points[segment] + part * points[segment + 1] + random_point(random, 0.03f);
  const glm::vec3 direction = random_direction(random);
  return {target - (1 + random.next()) * direction, direction};
}

TEST(LinearStrands, rays_meet_the_ribbons_and_their_joints) {
  int rays = 0, met = 0, wrong = 0, split = 0;
  for (std::uint64_t layout = 0; layout < 10; ++layout) {
    const std::vector<glm::vec3> points = zigzag(layout);
    const scene::Scene scene = bent_scene(points, 1, true);
    const FiberScene fibers(scene);
    RandomStream random(52, layout);
    for (int i = 0; i < 5000; ++i) {
      const Ray ray = ray_at(points, random);
      const Answer answer = exact_answer(points, ray);
      // Rounding of coordinates below 4 cm in some ten operations, and the seam that is closed by 0.001 of the radius.
      if (answer.margin < 2e-5 + 2e-6) continue;
      const std::optional<Hit> hit = fibers.intersect(ray);
      ++rays;
      met += hit.has_value();
      wrong += hit.has_value() != (answer.distance < 1e9) ||
               (hit && std::abs(static_cast<double>(hit->distance_cm) - answer.distance) > 1e-4);
      split += hit.has_value() != fibers.occluded(ray);
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(split, 0);
  EXPECT_GT(rays, 45000);
  EXPECT_GT(met, rays / 4);
  EXPECT_LT(met, rays * 3 / 4);
}

/// The polygon as straight Bezier segments.
std::vector<glm::vec3> as_bezier(const std::vector<glm::vec3>& points) {
  std::vector<glm::vec3> controls{points[0]};
  for (std::size_t i = 1; i < points.size(); ++i)
    for (const float share : {1 / 3.0f, 2 / 3.0f, 1.0f}) controls.push_back(glm::mix(points[i - 1], points[i], share));
  return controls;
}

/// The polygon as a B-spline, which passes straight from point to point where each is there three times or more.
std::vector<glm::vec3> as_bspline(const std::vector<glm::vec3>& points, int times) {
  std::vector<glm::vec3> controls;
  for (const glm::vec3& point : points) controls.insert(controls.end(), static_cast<std::size_t>(times), point);
  return controls;
}

/// Rays at a strand.
struct Rays {
  int wrong = 0;    ///< they do not meet what they should
  int wedge = 0;    ///< the first thing that they meet is a joint
  int counted = 0;  ///< all but those nearer than 0.1 radii to an edge
};

/// A joint of four straight pieces lies within 0.08 radii of the circle where its turn looks even, and ends within 0.1
/// radii of the corner, so that a ray meets it within a radius of the right distance. Of rays that look nearly along a
/// strand at a corner, some see the turn in one piece and miss it.
void try_rays(const std::vector<glm::vec3>& points, const scene::Scene& scene, std::uint64_t layout, Rays* rays) {
  const FiberScene fibers(scene);
  RandomStream random(52, layout);
  const double tolerance = 0.1 * static_cast<double>(radius_cm);
  for (int i = 0; i < 5000; ++i) {
    const Ray ray = ray_at(points, random);
    const Answer answer = exact_answer(points, ray);
    if (answer.margin < tolerance) continue;
    const std::optional<Hit> hit = fibers.intersect(ray);
    ++rays->counted;
    rays->wedge += answer.is_joint;
    rays->wrong +=
        hit.has_value() != (answer.distance < 1e9) || hit.has_value() != fibers.occluded(ray) ||
        (hit && std::abs(static_cast<double>(hit->distance_cm) - answer.distance) > static_cast<double>(radius_cm));
  }
}

TEST(CornersOfCurves, HaveJointsAsPolygonsHave) {
  Rays bezier, bspline, repeats;
  for (std::uint64_t layout = 0; layout < 10; ++layout) {
    const std::vector<glm::vec3> points = zigzag(layout);
    scene::Scene scene = bent_scene(as_bezier(points), 1, false);
    scene.grooms[0].basis = scene::StrandBasis::bezier;
    try_rays(points, scene, layout, &bezier);
    try_rays(points, bent_scene(as_bspline(points, 3), 1, false), layout, &bspline);
    try_rays(points, bent_scene(as_bspline(points, 5), 1, false), layout, &repeats);
  }
  for (const Rays& rays : {bezier, bspline, repeats}) {
    EXPECT_GT(rays.counted, 30000);
    EXPECT_GT(rays.wedge, 800);
    EXPECT_LT(rays.wrong, rays.wedge / 10);
  }
}

TEST(CornersOfCurves, KeepPlacesAndMoveWithTheStrand) {
  const std::vector<glm::vec3> points = zigzag(3);
  scene::Scene scene = bent_scene(as_bezier(points), 1, false);
  scene.grooms[0].basis = scene::StrandBasis::bezier;
  std::vector<glm::vec3> moved = points;
  for (glm::vec3& point : moved) point = glm::vec3(-point.y, point.x, point.z + 0.1f);
  scene.grooms[0].later.resize(1);
  scene.grooms[0].later[0].points = as_bezier(moved);
  const FiberScene fibers(scene);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    // Beyond the corner, at the outer side of the bend, where only the joint is.
    for (const bool at_end : {false, true}) {
      const std::vector<glm::vec3>& of = at_end ? moved : points;
      const glm::vec3 in = glm::normalize(of[i] - of[i - 1]), out = glm::normalize(of[i + 1] - of[i]);
      if (glm::dot(in, out) > 0.5f) continue;
      const glm::vec3 direction = glm::normalize(glm::cross(in, out));
      const glm::vec3 target = of[i] + 0.8f * radius_cm * glm::normalize(in - out);
      Ray ray{target - direction, direction};
      ray.time = at_end ? 1.0f : 0.0f;
      const std::optional<Hit> hit = fibers.intersect(ray);
      ASSERT_TRUE(hit) << i << at_end;
      EXPECT_EQ(hit->place, static_cast<float>(i));
      ray.time = 1 - ray.time;
      const std::optional<Hit> then = fibers.intersect(ray);
      EXPECT_FALSE(then && then->place == static_cast<float>(i));
    }
  }
}

TEST(LinearStrands, hits_lie_on_the_polygon_and_have_the_frame_of_its_segment) {
  for (const float eccentricity : {1.0f, 0.7f}) {
    const std::vector<glm::vec3> points = zigzag(11);
    const scene::Scene scene = bent_scene(points, eccentricity, true);
    const FiberScene fibers(scene);
    RandomStream random(53);
    int met = 0;
    for (int i = 0; i < 5000; ++i) {
      const Ray ray = ray_at(points, random);
      const std::optional<Hit> hit = fibers.intersect(ray);
      if (!hit) continue;
      ++met;
      // Interpolated in float from coordinates below 4 cm: two roundings of 2.4e-7.
      EXPECT_LT(distance_to(points, hit->axis), 1e-6);
      // The position is as far from the axis as the lateral offset says, or farther in the round joint of a bend.
      const double a = fiber::major_semi_axis(radius_cm, eccentricity);
      const double offset = glm::distance(hit->position, hit->axis);
      EXPECT_LE(std::abs(hit->lateral) * a, offset + 1e-5);
      EXPECT_LE(offset, a + 1e-5);
      double turn = 1;
      for (std::size_t k = 0; k + 1 < points.size(); ++k)
        if (distance_to({points[k], points[k + 1]}, hit->axis) < 1e-6)
          turn = std::min<double>(turn, glm::distance(hit->u, glm::normalize(points[k + 1] - points[k])));
      EXPECT_LT(turn, 1e-5);
      EXPECT_NEAR(glm::length(hit->v), 1, 2e-6);
      EXPECT_NEAR(glm::dot(hit->u, hit->v), 0, 2e-6);
      EXPECT_NEAR(glm::length(glm::cross(hit->u, hit->v) - hit->w), 0, 2e-6);
    }
    EXPECT_GT(met, 1000);
  }
}

/// A right angle. The spline's knot at the corner is (p- + 4 p + p+)/6, here 0.236 cm inside.
TEST(LinearStrands, a_corner_is_reached_where_a_spline_cuts_it) {
  const std::vector<glm::vec3> corner{{-2, 0, 0}, {-1, 0, 0}, {0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
  const scene::Scene lines = bent_scene(corner, 1, true), splines = bent_scene(corner, 1, false);
  const FiberScene linear(lines), bspline(splines);
  for (const glm::vec3& at : {glm::vec3(-0.001f, 0, 0.001f), glm::vec3(-0.1f, 0, 0.001f), glm::vec3(0.001f, 0, 0.1f)}) {
    const Ray ray{at - glm::vec3(0, 3, 0), {0, 1, 0}};
    EXPECT_TRUE(linear.occluded(ray)) << at.x << " " << at.z;
    EXPECT_FALSE(bspline.occluded(ray)) << at.x << " " << at.z;
  }
  const Ray inside{{-1.0f / 6, -3, 1.0f / 6}, {0, 1, 0}};
  EXPECT_FALSE(linear.occluded(inside));
  EXPECT_TRUE(bspline.occluded(inside));
  // The joint is round: a radius of 0.02 cm around the corner on the outside, no further.
  EXPECT_TRUE(linear.occluded({{0.013f, -3, -0.013f}, {0, 1, 0}}));
  EXPECT_FALSE(linear.occluded({{0.016f, -3, -0.016f}, {0, 1, 0}}));
  // Root and tip are flat.
  EXPECT_TRUE(linear.occluded({{-1.999f, -3, 0}, {0, 1, 0}}));
  EXPECT_FALSE(linear.occluded({{-2.001f, -3, 0}, {0, 1, 0}}));
  EXPECT_TRUE(linear.occluded({{0, -3, 1.999f}, {0, 1, 0}}));
  EXPECT_FALSE(linear.occluded({{0, -3, 2.001f}, {0, 1, 0}}));
}

}  // namespace
}  // namespace tress::geometry
