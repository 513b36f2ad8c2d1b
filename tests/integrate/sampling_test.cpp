// The parts of a path that can be checked alone: stratified pairs, camera rays, directions, denormals.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>

#include "base/denormals.h"
#include "geometry/straight_strands.h"
#include "integrate/camera_rays.h"
#include "integrate/local_directions.h"
#include "integrate/pixel_sampler.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

TEST(PixelSampler, any_power_of_two_of_pairs_has_one_in_every_elementary_box) {
  for (std::uint64_t pixel : {0ull, 1ull, 77777ull}) {
    const PixelSampler sampler(9, pixel, 0);
    for (std::uint32_t dimension = 0; dimension < 4; ++dimension) {
      for (int split = 0; split <= 4; ++split) {
        std::set<std::pair<int, int>> boxes;
        for (std::uint32_t i = 0; i < 16; ++i) {
          const auto [a, b] = sampler.pair(i, dimension);
          ASSERT_TRUE(a >= 0 && a < 1 && b >= 0 && b < 1);
          boxes.insert({static_cast<int>(a * static_cast<float>(1 << split)),
                        static_cast<int>(b * static_cast<float>(1 << (4 - split)))});
        }
        EXPECT_EQ(boxes.size(), 16u) << pixel << " " << dimension << " " << split;
      }
    }
  }
}

TEST(PixelSampler, pixels_and_dimensions_differ) {
  const PixelSampler sampler(1, 5, 0);
  EXPECT_NE(sampler.pair(0, 0), sampler.pair(0, 1));
  EXPECT_NE(sampler.pair(0, 0), PixelSampler(1, 6, 0).pair(0, 0));
  EXPECT_NE(sampler.pair(0, 0), PixelSampler(2, 5, 0).pair(0, 0));
  EXPECT_NE(sampler.pair(0, 0), PixelSampler(1, 5, 1).pair(0, 0));
  EXPECT_EQ(sampler.pair(3, 2), PixelSampler(1, 5, 0).pair(3, 2));
}

TEST(CameraRays, look_where_the_camera_looks) {
  scene::Camera camera;
  camera.eye = {0, -10, 0};
  camera.vertical_fov_deg = 90;
  scene::Image image;
  image.width = 200;
  image.height = 100;
  const CameraRays rays(camera, image);
  // The tent's centre: u = 1/2. Pixel (99.5, 49.5) would be the middle, half a pixel is 0.01 of the focal length.
  const glm::vec3 middle = rays.ray(99, 49, {0.5f, 0.5f}).direction;
  EXPECT_NEAR(middle.x, -0.01, 1e-4);
  EXPECT_NEAR(middle.z, 0.01, 1e-4);
  const glm::vec3 top = rays.ray(99, 0, {0.5f, 0.5f}).direction;
  EXPECT_NEAR(top.z / top.y, 0.99, 1e-5);  // up is z, the top row looks up
  const glm::vec3 right = rays.ray(199, 49, {0.5f, 0.5f}).direction;
  EXPECT_NEAR(right.x / right.y, 1.99, 1e-5);  // x to the right for a camera looking along +y
  // The filter reaches one pixel to either side and no further.
  const glm::vec3 left_end = rays.ray(100, 50, {0.0f, 0.5f}).direction;
  EXPECT_NEAR(left_end.x / left_end.y, 0.02 * -0.5, 1e-5);
  const glm::vec3 right_end = rays.ray(100, 50, {0x1.fffffep-1f, 0.5f}).direction;
  EXPECT_NEAR(right_end.x / right_end.y, 0.02 * 1.5, 1e-5);
}

TEST(CameraRays, exist_where_up_is_along_the_view) {
  scene::Camera camera;
  camera.eye = {0, 0, 10};
  const CameraRays rays(camera, scene::Image{});
  EXPECT_NEAR(glm::length(rays.ray(3, 4, {0.3f, 0.9f}).direction), 1, 1e-6);
}

TEST(LocalDirections, go_to_the_world_and_back) {
  geometry::Hit hit{};
  hit.u = glm::normalize(glm::vec3(1, 2, 3));
  hit.v = glm::normalize(glm::vec3(2, -1, 0));
  hit.w = glm::cross(hit.u, hit.v);
  for (float theta = -1.5f; theta < 1.55f; theta += 0.1f) {
    for (float phi = -3.14f; phi < 3.14f; phi += 0.3f) {
      const glm::vec3 world = to_world(hit, {theta, phi});
      const LocalDirection local = to_local(hit, world);
      // asin loses digits towards the tangent: d theta = 1e-7 / cos theta.
      EXPECT_NEAR(local.direction.theta, theta, 4e-7 / std::cos(theta) + 1e-6);
      EXPECT_NEAR(local.direction.phi, phi, 1e-6 / std::cos(theta) + 1e-6);
      EXPECT_NEAR(local.cos_theta, std::cos(theta), 1e-6);
    }
  }
  EXPECT_NEAR(to_local(hit, hit.u).direction.theta, M_PI / 2, 1e-3);
  EXPECT_NEAR(to_local(hit, hit.v).direction.phi, 0, 1e-6);
  EXPECT_NEAR(to_local(hit, hit.w).direction.phi, M_PI / 2, 1e-6);
  const float behind = to_local(hit, -hit.v).direction.phi;
  EXPECT_TRUE(behind >= -std::numbers::pi_v<float> && behind < std::numbers::pi_v<float>);
}

// The point of a strand that a ray meets, from its axis towards rising azimuth, over the half width of the silhouette.
// The lateral coordinate is Embree's, of a float error of 2e-3 seen from 40 radii
// (tests/intersect/fiber_scene_test.cpp).
TEST(LocalDirections, offsets_are_towards_rising_azimuth) {
  constexpr float radius_cm = 0.05f, e = 0.6f;
  const scene::Scene scene = geometry::straight_scene({{{0, 0, -1}, {0, 0, 1}, radius_cm, radius_cm, e}}, false);
  const geometry::FiberScene fibers(scene);
  const auto a = static_cast<float>(fiber::major_semi_axis(double{radius_cm}, double{e}));
  RandomStream random(3);
  int met = 0, positive = 0;
  for (int i = 0; i < 2000; ++i) {
    const float azimuth = 6.2831853f * random.next(), height = random.next() - 0.5f;
    const glm::vec3 across(-std::sin(azimuth), std::cos(azimuth), 0);
    const glm::vec3 known = glm::normalize(glm::vec3(std::cos(azimuth), std::sin(azimuth), height));
    const glm::vec3 aim = (2 * random.next() - 1) * a * across;
    const auto hit = fibers.intersect({aim + 2.0f * known, -known});
    if (!hit) continue;
    ++met;
    const LocalDirection local = to_local(*hit, known);
    const float h = hit->share;
    positive += h > 0;
    const glm::vec3 rising = glm::normalize(glm::cross(hit->u, known));
    const float expected =
        glm::dot(hit->position - hit->axis, rising) / (a * fiber::projected_half_width(local.direction.phi, e));
    EXPECT_NEAR(h, expected, 5e-3f) << "azimuth " << azimuth;
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(positive, met / 3);
}

TEST(FlushDenormals, lasts_for_its_scope) {
  volatile float tiny = 1e-38f;
  const float before = tiny * 0.1f;
  EXPECT_GT(before, 0);
#if defined(__SSE2__)
  {
    const FlushDenormals flush;
    const volatile float inside = tiny * 0.1f;
    const int category = std::fpclassify(inside);
    EXPECT_EQ(category, FP_ZERO);
  }
#endif
  const float after = tiny * 0.1f;
  EXPECT_GT(after, 0);
}

}  // namespace
}  // namespace tress::integrate
