// A ball of fur: guard hairs in tufts over a shorter, finer undercoat, combed down and around.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "scene/generate/groom_kinds.h"

namespace tress::scene {
namespace {

constexpr float strands_per_tuft = 40;
constexpr std::uint32_t most_tufts = 3000;
constexpr float undercoat_share = 0.4f;

/// Unit vector i of `count` that are spread evenly over the sphere (Fibonacci lattice), moved by about half their
/// distance.
glm::vec3 sphere_point(std::uint32_t i, std::uint32_t count, RandomStream& random) {
  const auto n = static_cast<double>(count);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  const double z = std::clamp(1 - (2.0 * i + 1 + 0.8 * kernel(random)) / n, -1.0, 1.0);
  const double r = std::sqrt(1 - z * z), angle = golden * i;
  const glm::vec3 p(static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
                    static_cast<float>(z));
  const float apart = std::sqrt(4 * std::numbers::pi_v<float> / static_cast<float>(count));
  const glm::vec3 moved = p + 0.4f * apart * glm::vec3(kernel(random), kernel(random), kernel(random));
  return glm::normalize(moved);
}

/// The direction of the comb at the unit normal n: down and around, with whorls; tangential, shorter at the poles.
glm::vec3 comb_of_fur(const glm::vec3& n) {
  const glm::vec3 whorls(std::sin(3.1f * n.y + 0.7f), std::sin(2.7f * n.z + 2.1f), std::sin(3.3f * n.x + 4.0f));
  const glm::vec3 flow = glm::vec3(0, 0, -1) + 0.45f * glm::cross(glm::vec3(0, 0, 1), n) + 0.4f * whorls;
  return flow - glm::dot(flow, n) * n;
}

/// Makes a strand that leaves along the normal and bends along the comb; `lean` is how far, about 0 to 1.
glm::vec3 along(const glm::vec3& root, const glm::vec3& n, const glm::vec3& combed, float length_cm, float lean,
                float t) {
  const float bend = lean * t;
  return root + length_cm * t * glm::normalize(n + bend * combed) * (1 - 0.08f * bend);
}

struct Tuft {
  glm::vec3 normal;
  float length_cm, lean;
};

}  // namespace

Groom fur_ball(const GroomShape& shape) {
  const float ball_cm = shape["ball_radius_cm"], frizz = shape["frizz"];
  std::vector<Tuft> tufts;
  const auto tuft_count = std::clamp(static_cast<std::uint32_t>(static_cast<float>(shape.strands) / strands_per_tuft),
                                     std::uint32_t{1}, most_tufts);
  for (std::uint32_t c = 0; c < tuft_count; ++c) {
    RandomStream random(shape.seed, 5, c);
    const glm::vec3 normal = sphere_point(c, tuft_count, random);
    const float length = shape["length_cm"] * std::max(0.3f, 1 + 0.4f * shape["length_variation"] * kernel(random));
    tufts.push_back({normal, length, std::max(0.3f, 1.7f + 0.35f * kernel(random))});
  }
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) {
    RandomStream random(shape.seed, 6, s);
    const glm::vec3 n = sphere_point(s, shape.strands, random);
    const auto nearest = std::max_element(tufts.begin(), tufts.end(), [&](const Tuft& a, const Tuft& b) {
      return glm::dot(a.normal, n) < glm::dot(b.normal, n);
    });
    const bool undercoat = random.next() < undercoat_share, stray = random.next() < 0.15f * frizz;
    const float shorter = shape["length_variation"] * random.next();
    const float length = nearest->length_cm * (1 - shorter) * (undercoat ? 0.55f : stray ? 1.2f : 1.0f);
    const float lean = nearest->lean * (1 + 0.15f * kernel(random)) * (stray ? 0.4f : 1.0f);
    const float gather = std::min(shape["clump"] * uniform(random, 0.7f, 1.2f) * (stray ? 0.1f : 1.0f), 0.95f);
    const float radius = shape.radius_cm * (undercoat ? 0.6f : uniform(random, 0.85f, 1.15f));
    const Wander wander(random);
    const float wandering = frizz * length * (stray ? 0.4f : 0.2f);
    const glm::vec3 combed = comb_of_fur(n), tuft_comb = comb_of_fur(nearest->normal);
    for (std::uint32_t i = 0; i < shape.points; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(shape.points - 1);
      const glm::vec3 own = along(ball_cm * n, n, combed, length, lean, t);
      const glm::vec3 tuft = along(ball_cm * nearest->normal, nearest->normal, tuft_comb, length, nearest->lean, t);
      const float pull = gather * t * std::sqrt(t);
      groom.points.push_back(own + pull * (tuft - own) + wandering * t * wander.at(t));
      groom.radius_cm.push_back(radius);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace tress::scene
