#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "scene/generate/groom_kinds.h"

namespace tress::scene {
namespace {

const glm::vec3 head_cm(7.4f, 9.2f, 9.0f);
constexpr float longest_step_cm = 0.3f;

}  // namespace

glm::vec3 head_semi_axes_cm() { return head_cm; }

glm::vec3 scalp_point(RandomStream& random) {
  for (;;) {
    const float z = uniform(random, -0.35f, 1.0f), angle = 2 * std::numbers::pi_v<float> * random.next();
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    const glm::vec3 p(r * std::cos(angle), r * std::sin(angle), z);
    const float hairline = 0.55f * std::clamp((p.y + 0.1f) / 0.7f, 0.0f, 1.0f) - 0.35f;
    if (p.z > hairline + (p.y > 0.5f ? 0.2f : 0.0f)) return p;
  }
}

glm::vec3 outside_head(const glm::vec3& p, float clearance) {
  const glm::vec3 scaled = p / (head_cm + clearance);
  const float r = glm::length(scaled);
  return r < 1 && r > 1e-4f ? p / r : p;
}

std::vector<glm::vec3> fall_from_scalp(const glm::vec3& on_scalp, float length_cm, float clearance, float stiffness,
                                       std::uint32_t count) {
  const glm::vec3 normal = glm::normalize(on_scalp / head_cm);
  const float side = on_scalp.x < 0 ? -1.0f : 1.0f;
  // Hair is parted at the front; at the back of the head (-y) it is combed straight down and covers the nape.
  const float parted = std::clamp(0.4f + 1.4f * on_scalp.y, 0.0f, 1.0f);
  const glm::vec3 comb =
      glm::vec3(0.9f * side * parted, -0.9f + 0.55f * parted, 0.0f) * std::clamp(on_scalp.z, 0.0f, 1.0f);
  glm::vec3 direction = glm::normalize(0.4f * normal + comb + glm::vec3(0, 0, -0.25f));
  glm::vec3 p = on_scalp * head_cm;
  std::vector<glm::vec3> points{p};
  points.reserve(count);
  const float between = length_cm / static_cast<float>(count - 1);
  const int substeps = std::clamp(static_cast<int>(std::ceil(between / longest_step_cm)), 1, 64);
  const float step = between / static_cast<float>(substeps);
  float grown = 0;
  while (points.size() < count) {
    for (int i = 0; i < substeps; ++i) {
      grown += step;
      direction = glm::normalize(direction + step / stiffness * glm::vec3(0, 0, -1));
      const glm::vec3 next = outside_head(p + step * direction, clearance * std::min(1.0f, grown / 3.0f));
      const glm::vec3 moved = next - p;
      direction = glm::length(moved) > 1e-6f ? glm::normalize(moved) : direction;
      p += step * direction;
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace tress::scene
