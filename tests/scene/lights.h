// Lights and points that stress them.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scene/model/light.h"

namespace tress::test {

using scene::Light;

struct SeenLight {
  std::string name;
  Light light;
  glm::vec3 point;
};

inline Light distant_light(const glm::vec3& towards, float half_angle_rad) {
  Light light;
  light.kind = Light::Kind::distant;
  light.direction = glm::normalize(towards);
  light.half_angle_rad = half_angle_rad;
  return light;
}

inline Light sphere_light(const glm::vec3& center, float radius_cm) {
  Light light;
  light.kind = Light::Kind::sphere;
  light.center = center;
  light.radius_cm = radius_cm;
  return light;
}

inline Light rectangle_light(const glm::vec3& center, const glm::vec3& half_u, const glm::vec3& half_v) {
  Light light;
  light.kind = Light::Kind::rectangle;
  light.center = center;
  light.edge_u = half_u;
  light.edge_v = half_v;
  return light;
}

inline std::vector<SeenLight> seen_lights() {
  const Light down = rectangle_light({1, 2, 30}, {0, 4, 0}, {6, 0, 0});
  const Light tilted =
      rectangle_light({10, -20, 15}, 5.0f * glm::vec3(.8f, .6f, 0), 3.0f * glm::vec3(.36f, -.48f, .8f));
  return {{"distant, .53 degrees", distant_light({1, -2, 3}, 0.0046f), {3, 4, 5}},
          {"distant, 2 degrees, straight up", distant_light({0, 0, 1}, 0.0175f), {0, 0, 0}},
          {"distant, a hemisphere", distant_light({-1, 0, 0}, 1.5707f), {0, 0, 0}},
          {"sphere, far", sphere_light({300, -400, 1000}, 2), {1, 2, 3}},
          {"sphere, near", sphere_light({0, 0, 10}, 4), {1, 2, 3}},
          {"sphere, touching", sphere_light({0, 0, 10}, 9.999f), {0, 0, 0}},
          {"sphere, from inside", sphere_light({0, 0, 10}, 20), {3, -4, 5}},
          {"rectangle, under its middle", down, {1, 2, 0}},
          {"rectangle, close", down, {3, 4, 29}},
          {"rectangle, past its edge, grazing", down, {30, 2, 29.9f}},
          {"rectangle, tilted", tilted, {12, -22, 10}},
          {"rectangle, far", tilted, {-3000, 50, -10000}}};
}

}  // namespace tress::test
