#include <cmath>

#include "base/pi.h"
#include "scene/generate/groom_kinds.h"

namespace tress::scene {
namespace {

constexpr std::uint32_t clump_count = 22;
constexpr float root_disc_cm = 1.5f;

/// A wisp of the lock: one helix that many strands follow.
struct CurlClump {
  float root_x, root_y, phase, turns, radius, length;
};

}  // namespace

Groom curly_lock(const GroomShape& shape) {
  const float length_cm = shape["length_cm"], length_variation = shape["length_variation"];
  const float clump_strength = shape["clump"], frizz = shape["frizz"] / 0.15f;
  std::vector<CurlClump> clumps;
  for (std::uint32_t c = 0; c < clump_count; ++c) {
    RandomStream random(shape.seed, 1, c);
    const float r = root_disc_cm * std::sqrt(random.next()), angle = two_pi_f * random.next();
    // Most wisps turn together, as in a real lock; some have their own phase.
    const float phase = c % 4 == 3 ? two_pi_f * random.next() : 0.7f * kernel(random) + (c % 2 ? 2.6f : 0.0f);
    clumps.push_back({r * std::cos(angle), r * std::sin(angle), phase,
                      length_cm / shape["wavelength_cm"] * (1 + 0.07f * kernel(random)),
                      0.5f * shape["curl_diameter_cm"] * uniform(random, .7f, 1.2f),
                      length_cm * (1 - length_variation * random.next())});
  }
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) {
    RandomStream random(shape.seed, 2, s);
    const CurlClump& clump = clumps[random.next_bits() % clump_count];
    const bool stray = random.next() < 0.05f * frizz;
    const float in_r = 0.34f * std::sqrt(random.next()), in_angle = two_pi_f * random.next();
    const float phase = clump.phase + (stray ? 0.5f : 0.12f * frizz) * kernel(random);
    const float length =
        clump.length * (stray ? uniform(random, 0.5f, 0.98f) : 1 - length_variation * std::pow(random.next(), 2.0f));
    const float helix = clump.radius * (1 + (stray ? 0.35f : 0.09f * frizz) * kernel(random));
    const float stretch = 1 + (stray ? 0.04f : 0.008f) * kernel(random);
    const Wander wander(random);
    for (std::uint32_t i = 0; i < shape.points; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(shape.points - 1);
      const float along = t * length / clump.length;
      // The curl opens from the root and tightens towards the tip, where the wisp gathers.
      const float opening = smooth_step(t / 0.25f), gathering = 1 - clump_strength * smooth_step((along - 0.3f) / 0.7f);
      const float turn = phase + two_pi_f * clump.turns * stretch * (0.8f * along + 0.2f * along * along);
      const float r = helix * opening * (1 - 0.35f * along);
      const float lock = 1 - 0.72f * smooth_step(along / 0.9f);
      const float offset = in_r * gathering * (1 + 0.7f * opening * (1 - along));
      const glm::vec3 noise = (stray ? 0.16f : 0.035f) * frizz * t * wander.at(t);
      groom.points.emplace_back(clump.root_x * lock + r * std::cos(turn) + offset * std::cos(in_angle + turn) + noise.x,
                                clump.root_y * lock + r * std::sin(turn) + offset * std::sin(in_angle + turn) + noise.y,
                                -length * t + noise.z + 0.3f * in_r);
      groom.radius_cm.push_back(shape.radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

}  // namespace tress::scene
