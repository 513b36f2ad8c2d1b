// Straight, wavy and curly hair on a head: clumps fall like single strands, and strands fall and are drawn to their
// clump.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/pi.h"
#include "scene/generate/groom_kinds.h"

namespace tress::scene {
namespace {

constexpr std::uint32_t straight_clumps = 420, wavy_clumps = 190, curly_clumps = 120;

/// A wave across the fall: an ellipse around the strand, flat for waves and round for curls.
struct Wave {
  float amplitude_cm = 0, wavelength_cm = 1;
  float roundness = 0;      ///< 0: in one plane, outwards; +-1: a helix, right- or left-handed
  float straight_root = 0;  ///< length in cm over which it opens
};

struct Clump {
  glm::vec3 root;
  float length_cm = 0, phase = 0;
  Wave wave;
  std::vector<glm::vec3> points;
};

/// The direction across the strand at point i: away from the head, without its part along the strand.
glm::vec3 outward(const std::vector<glm::vec3>& points, std::size_t i, const glm::vec3& tangent) {
  glm::vec3 away = points[i] / head_semi_axes_cm();
  away -= glm::dot(away, tangent) * tangent;
  const float size = glm::length(away);
  return size > 1e-3f ? away / size : glm::vec3(0);
}

glm::vec3 wave_offset(const Wave& wave, const std::vector<glm::vec3>& points, std::size_t i, float along_cm,
                      float phase) {
  if (!(wave.amplitude_cm > 0)) return glm::vec3(0);
  const std::size_t last = points.size() - 1;
  const glm::vec3 chord = points[std::min(i + 1, last)] - points[i > 0 ? i - 1 : 0];
  const float length = glm::length(chord);
  if (!(length > 0)) return glm::vec3(0);
  const glm::vec3 out = outward(points, i, chord / length), aside = glm::cross(chord / length, out);
  const float angle = two_pi_f * along_cm / wave.wavelength_cm + phase;
  const float opening = smooth_step(along_cm / wave.straight_root);
  return opening * wave.amplitude_cm * (std::cos(angle) * out + wave.roundness * std::sin(angle) * aside);
}

Clump make_clump(const GroomShape& shape, std::uint32_t index) {
  RandomStream random(shape.seed, 3, index);
  Clump clump;
  clump.root = scalp_point(random);
  const float height = std::clamp(clump.root.z, 0.0f, 1.0f);
  clump.length_cm =
      shape["length_cm"] * (1 + 0.35f * shape["length_variation"] * kernel(random)) * (0.86f + 0.14f * height);
  clump.length_cm = std::max(clump.length_cm, 0.05f * shape["length_cm"]);
  const float clearance = 0.35f + 1.1f * height + 0.12f * kernel(random);
  const float stiffness = uniform(random, 2.5f, 4.0f);
  const bool curly = shape["curl_diameter_cm"] > 0;
  if (curly || shape["wave_amplitude_cm"] > 0) {
    Wave& wave = clump.wave;
    wave.amplitude_cm = curly ? shape["curl_diameter_cm"] / 2 : shape["wave_amplitude_cm"];
    wave.amplitude_cm *= std::max(0.3f, 1 + 0.18f * kernel(random));
    wave.wavelength_cm = shape["wavelength_cm"] * std::max(0.5f, 1 + (curly ? 0.15f : 0.06f) * kernel(random));
    wave.roundness = curly ? (random.next() < 0.5f ? -1.0f : 1.0f) : uniform(random, -0.5f, 0.5f);
    wave.straight_root = curly ? 1.2f * wave.wavelength_cm : wave.wavelength_cm;
    // Neighbouring wisps wave together; curls do not.
    clump.phase = curly ? two_pi_f * random.next()
                        : 2.5f * std::sin(2.3f * clump.root.x + 1) + 2 * clump.root.y + 0.45f * kernel(random);
  }
  const float clear_of_wave = 0.6f * clump.wave.amplitude_cm;
  clump.points =
      fall_from_scalp(clump.root, clump.length_cm, std::max(clearance, 0.15f) + clear_of_wave, stiffness, shape.points);
  return clump;
}

const Clump& nearest_clump(const std::vector<Clump>& clumps, const glm::vec3& root) {
  const Clump* best = &clumps[0];
  float nearest = std::numeric_limits<float>::max();
  for (const Clump& candidate : clumps) {
    const glm::vec3 d = candidate.root - root;
    // Hair on one side of the parting never joins the other side.
    const float distance = glm::dot(d, d) + ((candidate.root.x < 0) != (root.x < 0) ? 1.0f : 0.0f);
    if (distance < nearest) nearest = distance, best = &candidate;
  }
  return *best;
}

void add_strand(const GroomShape& shape, const std::vector<Clump>& clumps, std::uint32_t strand, Groom* groom) {
  RandomStream random(shape.seed, 4, strand);
  const float frizz = shape["frizz"];
  const glm::vec3 root = scalp_point(random);
  const Clump& clump = nearest_clump(clumps, root);
  const bool stray = random.next() < 0.2f * frizz;
  const float gather = shape["clump"] * (stray ? 0.15f : uniform(random, 0.7f, 1.3f));
  const float shorter =
      stray ? uniform(random, -0.02f, 0.4f) : shape["length_variation"] * std::pow(random.next(), 2.0f);
  const float length_cm = clump.length_cm * (1 - shorter);
  const float clearance = std::max(0.12f, 0.35f + 1.1f * std::max(root.z, 0.0f) + 0.25f * kernel(random)) +
                          0.6f * clump.wave.amplitude_cm + (stray ? 0.3f : 0.0f);
  const auto fall = fall_from_scalp(root, length_cm, clearance, uniform(random, 2.4f, 4.2f), shape.points);
  const Wander wander(random);
  const float wandering = stray ? 0.7f : frizz * (clump.wave.amplitude_cm > 0 ? 0.5f : 1.07f);
  const float phase = clump.phase + (stray ? 1.6f : 0.1f + 0.6f * frizz) * kernel(random);
  Wave wave = clump.wave;
  wave.amplitude_cm *= std::max(0.0f, 1 + (0.08f + 0.35f * frizz) * kernel(random));
  wave.wavelength_cm *= 1 + (0.004f + 0.02f * frizz) * kernel(random);
  for (std::uint32_t i = 0; i < shape.points; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(shape.points - 1);
    const float pull = std::min(gather, 0.97f) * smooth_step(t / 0.8f);
    glm::vec3 p = fall[i] + pull * (clump.points[i] - fall[i]);
    p += wave_offset(wave, clump.points, i, t * length_cm, phase) + wandering * t * wander.at(t);
    groom->points.push_back(i > 0 ? outside_head(p, 0.1f) : p);
    groom->radius_cm.push_back(shape.radius_cm);
  }
  groom->first_point.push_back(static_cast<std::uint32_t>(groom->points.size()));
}

}  // namespace

Groom head_groom(const GroomShape& shape) {
  std::vector<Clump> clumps;
  const std::uint32_t count = shape["curl_diameter_cm"] > 0    ? curly_clumps
                              : shape["wave_amplitude_cm"] > 0 ? wavy_clumps
                                                               : straight_clumps;
  for (std::uint32_t c = 0; c < count; ++c) clumps.push_back(make_clump(shape, c));
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) add_strand(shape, clumps, s, &groom);
  return groom;
}

}  // namespace tress::scene
