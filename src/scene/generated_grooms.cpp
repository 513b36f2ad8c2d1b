#include "scene/generated_grooms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/groom_kinds.h"
#include "scene/groom_random.h"

namespace tress::scene {
namespace {

constexpr float two_pi = 2 * std::numbers::pi_v<float>;

glm::vec3 in_box(RandomStream& random, float half) {
  const float x = uniform(random, -half, half), y = uniform(random, -half, half), z = uniform(random, -half, half);
  return {x, y, z};
}

Groom single_fiber(std::uint32_t strands, float length_cm, float radius_cm) {
  constexpr int points_per_strand = 16;
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < strands; ++s) {
    const float x = 0.1f * (static_cast<float>(s) - 0.5f * static_cast<float>(strands - 1));
    for (int i = 0; i < points_per_strand; ++i) {
      groom.points.emplace_back(x, 0.0f, -length_cm * static_cast<float>(i) / (points_per_strand - 1));
      groom.radius_cm.push_back(radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace

Wander::Wander(RandomStream& random)
    : slow_(in_box(random, 1.0f)),
      fast_(in_box(random, 0.35f)),
      slow_phase_(in_box(random, two_pi)),
      fast_phase_(in_box(random, two_pi)) {}

glm::vec3 Wander::at(float t) const {
  glm::vec3 p;
  for (int c = 0; c < 3; ++c)
    p[c] = slow_[c] * std::sin(5.0f * t + slow_phase_[c]) + fast_[c] * std::sin(14.0f * t + fast_phase_[c]);
  return p;
}

const std::vector<std::string>& generated_groom_kinds() {
  static const std::vector<std::string> kinds{"curly_lock", "straight", "single_fiber"};
  return kinds;
}

Groom generate_groom(const GroomRecipe& recipe) {
  const auto length = [&](double usual) { return static_cast<float>(recipe.length_cm.value_or(usual)); };
  const auto radius = static_cast<float>(recipe.radius_cm);
  Groom groom =
      recipe.kind == "straight"     ? straight_groom(recipe.strands.value_or(19226), recipe.seed, length(32), radius)
      : recipe.kind == "curly_lock" ? curly_lock(recipe.strands.value_or(5513), recipe.seed, length(24), radius)
                                    : single_fiber(recipe.strands.value_or(1), length(10), radius);
  groom.name = recipe.kind;
  return groom;
}

}  // namespace tress::scene
