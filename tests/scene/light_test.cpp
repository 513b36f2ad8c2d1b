#include "scene/model/light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/ext/vector_double3.hpp>
#include <limits>
#include <numbers>

#include "scene/lights.h"
#include "support/quadrature.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

constexpr double pi = std::numbers::pi;

/// Integral of the density that light_along() returns, over the place on the rectangle (solid angle = cos dA / d^2) or
/// over the cone in which the light lies by elementary geometry.
double density_integral(const Light& light, const glm::vec3& point) {
  if (light.kind == Light::Kind::rectangle) {
    const glm::dvec3 normal = glm::normalize(glm::cross(glm::dvec3(light.edge_u), glm::dvec3(light.edge_v)));
    const double area = 4.0 * glm::length(light.edge_u) * glm::length(light.edge_v);
    return test::integrate_2d(
        [&](double a, double b) {
          const glm::dvec3 to = glm::dvec3(light.center) + a * glm::dvec3(light.edge_u) + b * glm::dvec3(light.edge_v) -
                                glm::dvec3(point);
          const double d = glm::length(to);
          return light_along(light, point, glm::vec3(to)).pdf_solid_angle * -glm::dot(to, normal) / (d * d * d) * area /
                 4;
        },
        -1, 1, -1, 1, 48, 48);
  }
  glm::dvec3 axis(light.direction);
  double half_angle = light.half_angle_rad;
  if (light.kind == Light::Kind::sphere) {
    const glm::dvec3 to = glm::dvec3(light.center) - glm::dvec3(point);
    axis = glm::normalize(to);
    half_angle = glm::length(to) > light.radius_cm ? std::asin(light.radius_cm / glm::length(to)) : pi;
  }
  const glm::dvec3 x = glm::normalize(glm::cross(axis, glm::dvec3(0.3, -0.5, 0.7))), y = glm::cross(axis, x);
  return test::integrate_2d(
      [&](double angle, double turn) {
        const glm::dvec3 d = std::cos(angle) * axis + std::sin(angle) * (std::cos(turn) * x + std::sin(turn) * y);
        return light_along(light, point, glm::vec3(d)).pdf_solid_angle * std::sin(angle);
      },
      0, half_angle, 0, 2 * pi, 8, 8);
}

/// The quadrature is exact to 1e-6 for these integrands (doubling the panels changes less); the densities are floats.
/// A direction in single precision is off by 6e-8, at most 2e-5 of the narrowest cone's radius: no node is so near to
/// an edge.
TEST(Light, DensityIntegratesToOne) {
  for (const auto& [name, light, point] : test::seen_lights())
    EXPECT_NEAR(density_integral(light, point), 1, 2e-6) << name;
}

/// Lambert's formula for a polygon above the horizon of `normal`, radiance 1.
double rectangle_irradiance(const Light& light, const glm::vec3& point, const glm::dvec3& normal) {
  constexpr int corners[4][2] = {{-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
  std::array<glm::dvec3, 4> to;
  for (std::size_t i = 0; i < 4; ++i)
    to[i] = glm::normalize(glm::dvec3(light.center) + double(corners[i][0]) * glm::dvec3(light.edge_u) +
                           double(corners[i][1]) * glm::dvec3(light.edge_v) - glm::dvec3(point));
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 across = glm::cross(to[i], to[(i + 1) % 4]);
    sum += std::atan2(glm::length(across), glm::dot(to[i], to[(i + 1) % 4])) * glm::dot(glm::normalize(across), normal);
  }
  return std::abs(sum) / 2;
}

/// Irradiance of a plane that faces the light's middle (parallel to a rectangle), by sample_light() on a midpoint grid
/// of u, against its closed form. Midpoints in 256 x 256 leave 1e-5 for integrands that are smooth in u, 4e-3 where the
/// horizon cuts them.
TEST(Light, GivesItsAnalyticIrradiance) {
  for (const auto& [name, light, point] : test::seen_lights()) {
    glm::dvec3 normal = glm::normalize(glm::dvec3(light.center) - glm::dvec3(point));
    double expected, tolerance = 2e-5;
    if (light.kind == Light::Kind::distant) {
      normal = light.direction;
      expected = pi * std::pow(std::sin(double(light.half_angle_rad)), 2);
    } else if (light.kind == Light::Kind::sphere) {
      const double d = glm::distance(glm::dvec3(light.center), glm::dvec3(point)), r = light.radius_cm;
      expected = d > r ? pi * r * r / (d * d) : pi;
      if (!(d > r)) tolerance = 4e-3;
    } else {
      normal = -glm::normalize(glm::cross(glm::dvec3(light.edge_u), glm::dvec3(light.edge_v)));
      expected = rectangle_irradiance(light, point, normal);
    }
    constexpr int n = 256;
    double sum = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const auto s = sample_light(light, point, (i + 0.5f) / n, (j + 0.5f) / n);
        ASSERT_GT(s.pdf_solid_angle, 0) << name;
        sum += std::max(0.0, glm::dot(normal, glm::dvec3(s.direction))) * s.radiance.g / s.pdf_solid_angle;
      }
    EXPECT_NEAR(sum / (n * n) / expected, 1, tolerance) << name;
  }
}

TEST(Light, DistantRadianceGivesTheIrradianceAskedFor) {
  for (const double half_angle : {1e-4, 0.0046, 0.3, pi / 2}) {
    const double radiance = distant_radiance(glm::vec3(2.5f), half_angle).g;
    const double irradiance =
        test::integrate([&](double t) { return 2 * pi * radiance * std::sin(t) * std::cos(t); }, 0, half_angle);
    EXPECT_NEAR(irradiance / 2.5, 1, 1e-6);
  }
}

/// What was drawn is met again along its own direction, with the same density, distance and radiance. u keeps off the
/// edges by 1 %: there a direction in single precision may miss.
TEST(Light, IsMetAlongTheDirectionsThatItDraws) {
  RandomStream random(5);
  for (const auto& [name, light, point] : test::seen_lights())
    for (int i = 0; i < 1000; ++i) {
      const float u1 = 0.01f + 0.98f * random.next(), u2 = 0.01f + 0.98f * random.next();
      const auto drawn = sample_light(light, point, u1, u2);
      const auto met = light_along(light, point, 7.0f * drawn.direction);
      ASSERT_GT(drawn.pdf_solid_angle, 0) << name;
      // By area, at grazing, the density goes as the third power of a distance that 1e-7 of a direction moves by 1e-5.
      EXPECT_NEAR(met.pdf_solid_angle / drawn.pdf_solid_angle, 1, 1e-4) << name;
      EXPECT_NEAR(met.distance / drawn.distance, 1, name == "sphere, touching" ? 1e-2 : 1e-4) << name;
      EXPECT_EQ(met.radiance, drawn.radiance);
      EXPECT_NEAR(glm::length(drawn.direction), 1, 1e-6);
    }
}

TEST(Light, EndsAtWhateverLiesBeforeIt) {
  const Light sphere = test::sphere_light({0, 0, 10}, 2), sun = test::distant_light({0, 0, 1}, 0.01f);
  const Light rectangle = test::rectangle_light({0, 0, 10}, {0, 1, 0}, {1, 0, 0});
  const glm::vec3 origin(0.0f), up(0, 0, 1);
  EXPECT_NEAR(light_along(sphere, origin, up).distance, 8, 1e-6);
  EXPECT_GT(light_along(sphere, origin, up, 8.01f).pdf_solid_angle, 0);
  EXPECT_EQ(light_along(sphere, origin, up, 7.99f).pdf_solid_angle, 0);
  EXPECT_EQ(light_along(sphere, origin, -up).pdf_solid_angle, 0);
  EXPECT_NEAR(light_along(sphere, {0, 0, 9}, up).distance, 3, 1e-6);  // from inside
  EXPECT_EQ(light_along(rectangle, origin, up, 9.99f).pdf_solid_angle, 0);
  EXPECT_NEAR(light_along(rectangle, origin, up, 10.01f).distance, 10, 1e-5);
  EXPECT_EQ(light_along(rectangle, {0, 0, 20}, -up).pdf_solid_angle, 0);  // its dark side
  EXPECT_EQ(sample_light(rectangle, {0, 0, 20}, 0.5f, 0.5f).pdf_solid_angle, 0);
  EXPECT_EQ(sample_light(rectangle, {9, 9, 10}, 0.5f, 0.5f).pdf_solid_angle, 0);  // in its plane
  EXPECT_GT(light_along(sun, origin, up).pdf_solid_angle, 0);
  EXPECT_EQ(light_along(sun, origin, up, 1e6f).pdf_solid_angle, 0);
}

TEST(Light, AzimuthStartsAtTheFrontAndTurnsCounterClockwise) {
  const auto near = [](const glm::vec3& a, const glm::vec3& b) { return glm::distance(a, b) < 1e-6f; };
  EXPECT_TRUE(near(direction_towards(0, 0), {0, -1, 0}));
  EXPECT_TRUE(near(direction_towards(pi / 2, 0), {1, 0, 0}));
  EXPECT_TRUE(near(direction_towards(1, pi / 2), {0, 0, 1}));
}

/// Seed 3: 2e5 lights, points and directions of arbitrary bits, small numbers, zeros, infinities and NaN.
TEST(Light, IsFiniteForEveryInput) {
  RandomStream random(3);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr std::array<float, 12> special{0.0f, -0.0f,  1.0f,    -1.0f,    infinity, -infinity,
                                          nan,  1e-45f, 3.4e38f, -3.4e38f, 1e-20f,   1e20f};
  const auto any = [&] {
    const auto bits = random.next_bits();
    if (bits % 3 == 0) return special[random.next_bits() % special.size()];
    if (bits % 3 == 1) return 20 * random.next() - 10;
    return std::bit_cast<float>(static_cast<std::uint32_t>(random.next_bits()));
  };
  const auto any_vec = [&] {
    const float x = any(), y = any(), z = any();
    return glm::vec3(x, y, z);
  };
  const auto finite = [](const LightSample& s) {
    bool all = std::isfinite(s.distance) && std::isfinite(s.pdf_solid_angle) && s.pdf_solid_angle >= 0;
    for (int c = 0; c < 3; ++c) all = all && std::isfinite(s.direction[c]) && std::isfinite(s.radiance[c]);
    return all && s.distance >= 0;
  };
  int seen = 0;
  for (int i = 0; i < 200000; ++i) {
    Light light;
    light.kind = static_cast<Light::Kind>(i % 3);
    light.direction = any_vec();
    light.half_angle_rad = any();
    light.center = any_vec();
    light.radius_cm = any();
    light.edge_u = any_vec();
    light.edge_v = any_vec();
    if (i % 2) light.radiance = any_vec();
    const glm::vec3 point = any_vec(), direction = any_vec();
    const float u1 = any(), u2 = any();
    const auto drawn = sample_light(light, point, u1, u2), met = light_along(light, point, direction, any());
    ASSERT_TRUE(finite(drawn) && finite(met)) << i;
    seen += drawn.pdf_solid_angle > 0;
  }
  EXPECT_GT(seen, 1000);  // else nothing was tested
}

/// Moments at 0, 1/2 and 1: half of the way from the second to the third is at 3/4.
TEST(Light, IsBetweenItsMomentsWhileTheShutterIsOpen) {
  Light light;
  light.kind = Light::Kind::rectangle;
  light.center = {1, 2, 3};
  light.edge_u = {2, 0, 0};
  light.edge_v = {0, 1, 0};
  EXPECT_EQ(light_during(light, 0.4f).center, light.center) << "it rests";
  light.later.assign(2, light);
  light.later[1].center = {5, 2, 3};
  light.later[1].radiance = {3, 1, 0};
  light.later[1].edge_u = {0, 0, 4};
  EXPECT_EQ(light_during(light, 0.3f).edge_u, light.edge_u);
  EXPECT_EQ(light_during(light, 0.3f).center, light.center);
  const LightShape now = light_during(light, 0.75f);
  EXPECT_EQ(now.center, glm::vec3(3, 2, 3));
  EXPECT_EQ(now.radiance, glm::vec3(2, 1, 0.5f));
  EXPECT_LT(glm::distance(now.edge_u, 3.0f * glm::normalize(glm::vec3(1, 0, 2))), 1e-6);
  EXPECT_LT(glm::distance(now.edge_v, light.edge_v), 1e-6);
  EXPECT_EQ(light_during(light, 1).center, light.later[1].center);
}

TEST(Light, ThatTurnsStaysARectangleWithADirection) {
  RandomStream random(41);
  const auto vector = [&] { return glm::vec3(2 * random.next() - 1, 2 * random.next() - 1, 2 * random.next() - 1); };
  for (int i = 0; i < 2000; ++i) {
    Light light;
    light.kind = Light::Kind::rectangle;
    light.direction = glm::normalize(vector());
    light.edge_u = vector();
    light.edge_v = 3.0f * glm::cross(light.edge_u, vector());
    light.later.assign(1, light);
    LightShape& then = light.later[0];
    const bool half_turn = i % 10 == 0;
    then.direction = half_turn ? -light.direction : glm::normalize(vector());
    then.edge_u = half_turn ? -light.edge_u : vector();
    then.edge_v = half_turn ? -light.edge_v : glm::cross(then.edge_u, vector());
    const LightShape now = light_during(light, half_turn ? 0.5f : random.next());
    const float u = glm::length(now.edge_u), v = glm::length(now.edge_v);
    EXPECT_NEAR(glm::length(now.direction), 1, 1e-5);
    EXPECT_LE(std::abs(glm::dot(now.edge_u, now.edge_v)), 1e-4f * u * v);
    EXPECT_LE(u, 1.0001f * std::max(glm::length(light.edge_u), glm::length(then.edge_u)));
    EXPECT_GE(v, 0.9999f * std::min(glm::length(light.edge_v), glm::length(then.edge_v)));
  }
}

/// There and back, about the vertical: a quarter counter-clockwise at the closing brings +x to +y.
TEST(EnvironmentTurn, GoesThereAndBack) {
  Scene scene;
  const glm::vec3 direction = glm::normalize(glm::vec3(1, -2, 0.5f));
  EXPECT_EQ(turned_to_environment(scene, direction, 0.5f), direction);
  scene.environment_turns_rad = {0, static_cast<float>(pi / 2)};
  EXPECT_LT(glm::distance(turned_with_environment(scene, {1, 0, 0}, 1), glm::vec3(0, 1, 0)), 1e-6);
  const glm::vec3 there = turned_with_environment(scene, direction, 0.3f);
  EXPECT_LT(glm::distance(turned_to_environment(scene, there, 0.3f), direction), 1e-6);
}

}  // namespace
}  // namespace tress::scene
