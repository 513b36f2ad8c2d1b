#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "scene/groom_kinds.h"
#include "scene/groom_random.h"

namespace tress::scene {
namespace {

constexpr float two_pi = 2 * std::numbers::pi_v<float>;
constexpr int points_per_strand = 28;
constexpr std::uint32_t clump_count = 420;
const glm::vec3 head_cm(7.4f, 9.2f, 9.0f);  ///< semi-axes of the head

/// A point of the scalp as a unit vector before scaling by the head: everything above the neck but the face (+y).
glm::vec3 scalp_point(RandomStream& random) {
  for (;;) {
    const float z = uniform(random, -0.35f, 1.0f), angle = two_pi * random.next();
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    const glm::vec3 p(r * std::cos(angle), r * std::sin(angle), z);
    const float hairline = 0.55f * std::clamp((p.y + 0.1f) / 0.7f, 0.0f, 1.0f) - 0.35f;
    if (p.z > hairline + (p.y > 0.5f ? 0.2f : 0.0f)) return p;
  }
}

/// Moves p out of the head inflated by `clearance` cm.
glm::vec3 outside_head(const glm::vec3& p, float clearance) {
  const glm::vec3 scaled = p / (head_cm + clearance);
  const float r = glm::length(scaled);
  return r < 1 && r > 1e-4f ? p / r : p;
}

/// Falls from the scalp: out along the normal, away from the parting, then down along the head and free below it.
std::vector<glm::vec3> fall(const glm::vec3& on_scalp, float length_cm, float clearance, float stiffness) {
  const glm::vec3 normal = glm::normalize(on_scalp / head_cm);
  const float side = on_scalp.x < 0 ? -1.0f : 1.0f;
  // Parted at the front; at the back of the head (-y) the hair is combed straight down and covers the nape.
  const float parted = std::clamp(0.4f + 1.4f * on_scalp.y, 0.0f, 1.0f);
  const glm::vec3 comb =
      glm::vec3(0.9f * side * parted, -0.9f + 0.55f * parted, 0.0f) * std::clamp(on_scalp.z, 0.0f, 1.0f);
  glm::vec3 direction = glm::normalize(0.4f * normal + comb + glm::vec3(0, 0, -0.25f));
  glm::vec3 p = on_scalp * head_cm;
  std::vector<glm::vec3> points{p};
  constexpr int substeps = 4;
  const float step = length_cm / static_cast<float>((points_per_strand - 1) * substeps);
  for (int i = 1; i <= (points_per_strand - 1) * substeps; ++i) {
    direction = glm::normalize(direction + step / stiffness * glm::vec3(0, 0, -1));
    const glm::vec3 next = outside_head(p + step * direction, clearance * std::min(1.0f, 0.1f * static_cast<float>(i)));
    const glm::vec3 moved = next - p;
    direction = glm::length(moved) > 1e-6f ? glm::normalize(moved) : direction;
    p += step * direction;
    if (i % substeps == 0) points.push_back(p);
  }
  return points;
}

}  // namespace

Groom straight_groom(std::uint32_t strands, std::uint64_t seed, float length_cm, float radius_cm) {
  struct Clump {
    glm::vec3 root;
    float length;
    std::vector<glm::vec3> points;
  };
  std::vector<Clump> clumps;
  for (std::uint32_t c = 0; c < clump_count; ++c) {
    RandomStream random(seed, 3, c);
    const glm::vec3 root = scalp_point(random);
    const float length = length_cm * (1 + 0.035f * bell(random)) * (0.86f + 0.14f * std::clamp(root.z, 0.0f, 1.0f));
    const float clearance = 0.35f + 1.1f * std::max(root.z, 0.0f) + 0.12f * bell(random);
    clumps.push_back({root, length, fall(root, length, std::max(clearance, 0.15f), uniform(random, 2.5f, 4.0f))});
  }
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < strands; ++s) {
    RandomStream random(seed, 4, s);
    const glm::vec3 root = scalp_point(random);
    const Clump* clump = &clumps[0];
    float nearest = std::numeric_limits<float>::max();
    for (const auto& candidate : clumps) {
      const glm::vec3 d = candidate.root - root;
      // Hair of one side of the parting never joins the other.
      const float distance = glm::dot(d, d) + ((candidate.root.x < 0) != (root.x < 0) ? 1.0f : 0.0f);
      if (distance < nearest) nearest = distance, clump = &candidate;
    }
    const bool stray = random.next() < 0.03f;
    const float gather = stray ? 0.1f : uniform(random, 0.45f, 0.85f);
    const float length =
        clump->length * (stray ? uniform(random, 0.6f, 1.02f) : 1 - 0.07f * std::pow(random.next(), 2.0f));
    const float clearance = std::max(0.12f, 0.35f + 1.1f * std::max(root.z, 0.0f) + 0.25f * bell(random));
    auto points = fall(root, length, clearance + (stray ? 0.3f : 0.0f), uniform(random, 2.4f, 4.2f));
    const Wander wander(random);
    const float wave = stray ? 0.7f : 0.16f;
    for (int i = 0; i < points_per_strand; ++i) {
      const float t = static_cast<float>(i) / (points_per_strand - 1);
      const auto index = static_cast<std::size_t>(i);
      const float pull = gather * t * t * (3 - 2 * t);
      glm::vec3 p = points[index] + pull * (clump->points[index] - points[index]) + wave * t * wander.at(t);
      if (i > 0) p = outside_head(p, 0.1f);
      groom.points.push_back(p);
      groom.radius_cm.push_back(radius_cm * (1 - 0.667f * t * t));
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace tress::scene
