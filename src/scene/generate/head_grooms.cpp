#include "scene/generate/head_grooms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "base/pi.h"

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

// Straight, wavy and curly hair on a head: clumps fall like single strands, and strands fall and are drawn to their
// clump.
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

// Long hair swept back and cut in layers: strands gather in wisps, and wisps in locks; locks wave together, and wisps
// may curl.
namespace {

constexpr std::uint32_t lock_count = 60, wisps_per_lock = 16, curls_per_lock = 5, strings_per_wisp = 9;

/// A center line around which strands gather: a lock, a wisp in it or a string in that.
struct Guide {
  glm::vec3 root{};  ///< on the unit sphere of the scalp
  std::vector<glm::vec3> points;
  float length_cm = 0;
  float phase = 0, amplitude_cm = 0, wavelength_cm = 1, roundness = 0;  ///< of its wave
  float opening_cm = 14;                                                ///< length over which it grows from the root
};

/// Spreads roots evenly over the scalp: returns the one of a few points that is farthest from earlier ones.
glm::vec3 spread_root(const std::vector<Guide>& others, RandomStream& random) {
  constexpr int tries = 12;
  glm::vec3 best{};
  float farthest = -1;
  for (int i = 0; i < tries; ++i) {
    const glm::vec3 p = scalp_point(random);
    float nearest = std::numeric_limits<float>::max();
    for (const Guide& other : others) nearest = std::min(nearest, glm::dot(other.root - p, other.root - p));
    if (nearest > farthest) farthest = nearest, best = p;
  }
  return best;
}

const Guide& nearest(const std::vector<Guide>& guides, const glm::vec3& root) {
  const auto far = [&](const Guide& guide) { return glm::dot(guide.root - root, guide.root - root); };
  return *std::ranges::min_element(guides, {}, far);
}

/// Distance above the neck, cm along the scalp: hair that grows higher is cut longer, so that the tips end near each
/// other.
float above_nape_cm(const glm::vec3& root) {
  const glm::vec3 nape = glm::normalize(glm::vec3(0, -0.94f, -0.35f));
  return 9 * std::acos(std::clamp(glm::dot(root, nape), -1.0f, 1.0f));
}

/// The direction of the comb along the scalp at n on the unit sphere: swept back from the face, and down at the back
/// and the sides, in strokes.
glm::vec3 comb(const glm::vec3& n) {
  const float stroke = 0.2f * std::sin(5.1f * n.x + 2.2f * n.z + 0.7f) + 0.1f * std::sin(11.3f * n.x - 4 * n.y);
  const float behind = smooth_step((0.5f - n.y) / 0.8f);
  const glm::vec3 stream(stroke + 0.4f * n.x, -1.0f, 0.3f * (1 - behind) - 1.1f * behind * (1 - std::max(n.z, 0.0f)));
  const glm::vec3 normal = glm::normalize(n / head_semi_axes_cm());
  return glm::normalize(stream - glm::dot(stream, normal) * normal);
}

/// Makes a strand without a wave: it is lifted from the scalp, held by the comb for a while, and falls over the layers
/// under it.
std::vector<glm::vec3> fall(const glm::vec3& root, float length_cm, float clearance_cm, std::uint32_t count) {
  constexpr float step_cm = 0.25f, stiffness_cm = 4.5f, held_cm = 14;
  const glm::vec3 semi_axes = head_semi_axes_cm(), normal = glm::normalize(root / semi_axes);
  glm::vec3 direction = glm::normalize(0.7f * normal + comb(root));
  glm::vec3 p = root * semi_axes;
  std::vector<glm::vec3> points{p};
  points.reserve(count);
  const float between = length_cm / static_cast<float>(count - 1);
  const int substeps = std::clamp(static_cast<int>(std::ceil(between / step_cm)), 1, 64);
  const float step = between / static_cast<float>(substeps);
  float grown = 0;
  while (points.size() < count) {
    for (int i = 0; i < substeps; ++i) {
      grown += step;
      glm::vec3 force(0, 0, -1);
      if (p.z > -2 && grown < held_cm) force += 1.8f * (1 - grown / held_cm) * comb(glm::normalize(p / semi_axes));
      // Below the head, hair draws in over the neck.
      if (p.z < -2) force += glm::vec3(-0.012f * p.x, -0.01f * (p.y + 7), 0) * std::min(1.0f, (-2 - p.z) / 6);
      direction = glm::normalize(direction + step / stiffness_cm * force);
      const glm::vec3 next = outside_head(p + step * direction, clearance_cm * smooth_step(grown / 4));
      if (glm::length(next - p) > 1e-6f) direction = glm::normalize(next - p);
      p += step * direction;
    }
    points.push_back(p);
  }
  return points;
}

/// The distance of a layer: hair rooted higher, or nearer to the face, is farther out.
float clearance_cm(const glm::vec3& root, float loose) {
  const float height = std::clamp((root.z + 0.35f) / 1.35f, 0.0f, 1.0f);
  return std::max(0.1f, 0.5f + 1.5f * height + 0.25f * std::max(0.0f, root.y) + loose);
}

/// Two directions across a curve at point i: away from the head, and sideways.
std::array<glm::vec3, 2> frame(const std::vector<glm::vec3>& points, std::size_t i) {
  const glm::vec3 chord = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
  const glm::vec3 tangent = chord / std::max(glm::length(chord), 1e-6f);
  glm::vec3 away = glm::vec3(points[i].x, points[i].y, 0.3f * points[i].z) / head_semi_axes_cm();
  away -= glm::dot(away, tangent) * tangent;
  const glm::vec3 out = away / std::max(glm::length(away), 1e-3f);
  return {out, glm::cross(tangent, out)};
}

/// Adds the guide's own wave, which opens below the crown.
void wave(const Guide& of, std::vector<glm::vec3>* points) {
  if (!(of.amplitude_cm > 0)) return;
  const std::vector<glm::vec3> straight = *points;
  for (std::size_t i = 1; i < straight.size(); ++i) {
    const float along = of.length_cm * static_cast<float>(i) / static_cast<float>(straight.size() - 1);
    const auto [out, aside] = frame(straight, i);
    const float angle = two_pi_f * along / of.wavelength_cm + of.phase;
    const float size = of.amplitude_cm * smooth_step(along / of.opening_cm);
    (*points)[i] += size * (of.roundness * std::cos(angle) * out + std::sin(angle) * aside);
  }
}

/// Moves the points towards those of the guide, from the root, where they are free, to the tip.
void gather(const Guide& around, float strength, float from, std::vector<glm::vec3>* points) {
  for (std::size_t i = 1; i < points->size(); ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(points->size() - 1);
    (*points)[i] += strength * smooth_step((t - from) / (1 - from)) * (around.points[i] - (*points)[i]);
  }
}

Guide make_lock(const GroomShape& shape, const std::vector<Guide>& others, std::uint32_t index) {
  RandomStream random(shape.seed, 5, index);
  Guide lock;
  lock.root = spread_root(others, random);
  lock.length_cm = (shape["length_cm"] + 0.7f * above_nape_cm(lock.root)) *
                   std::max(0.4f, 1 + 0.5f * shape["length_variation"] * kernel(random));
  lock.amplitude_cm = shape["wave_amplitude_cm"] * std::max(0.3f, 1 + 0.25f * kernel(random));
  lock.wavelength_cm = shape["wavelength_cm"] * std::max(0.5f, 1 + 0.12f * kernel(random));
  lock.roundness = uniform(random, 0.3f, 0.9f) * (random.next() < 0.5f ? -1.0f : 1.0f);
  lock.phase = 2.2f * std::sin(1.9f * lock.root.x + 1) + 1.5f * lock.root.z + 0.35f * kernel(random);
  lock.points = fall(lock.root, lock.length_cm, clearance_cm(lock.root, 0.3f * kernel(random)), shape.points);
  wave(lock, &lock.points);
  return lock;
}

/// Makes the wave of a wisp a curl: a helix of either hand, about as wide as it is tall; no two are alike.
void curl(const GroomShape& shape, RandomStream& random, Guide* wisp) {
  wisp->amplitude_cm = 0.5f * shape["curl_diameter_cm"] * std::max(0.35f, 1 + 0.25f * kernel(random));
  wisp->wavelength_cm = shape["wavelength_cm"] * std::max(0.5f, 1 + 0.18f * kernel(random));
  wisp->roundness = uniform(random, 0.75f, 1.0f) * (random.next() < 0.5f ? -1.0f : 1.0f);
  wisp->opening_cm = 5;
}

/// Makes a member of `of`, rooted near it.
Guide make_member(const GroomShape& shape, const Guide& of, float spread, float strength, float loose, bool curls,
                  RandomStream& random) {
  Guide member;
  const glm::vec3 aside(kernel(random), kernel(random), kernel(random));
  member.root = glm::normalize(of.root + spread * aside);
  member.length_cm = of.length_cm * std::max(0.4f, 1 + 0.15f * shape["length_variation"] * kernel(random));
  member.amplitude_cm = 0.08f * shape["wave_amplitude_cm"] * std::max(0.2f, 1 + 0.4f * kernel(random));
  member.wavelength_cm = shape["wavelength_cm"] * uniform(random, 0.45f, 0.8f);
  member.roundness = uniform(random, -1.0f, 1.0f);
  member.phase = two_pi_f * random.next();
  member.opening_cm = 10;
  if (curls) curl(shape, random, &member);
  member.points = fall(member.root, member.length_cm, clearance_cm(member.root, loose * kernel(random)), shape.points);
  wave(of, &member.points);
  gather(of, strength, 0.05f, &member.points);
  wave(member, &member.points);
  return member;
}

struct Locks {
  std::vector<Guide> locks;
  std::vector<std::vector<Guide>> wisps;    ///< of each lock
  std::vector<std::vector<Guide>> strings;  ///< of each wisp of all locks
};

Locks make_locks(const GroomShape& shape) {
  const bool curls = shape["curl_diameter_cm"] > 0;
  Locks all;
  for (std::uint32_t l = 0; l < lock_count; ++l) all.locks.push_back(make_lock(shape, all.locks, l));
  for (std::uint32_t l = 0; l < lock_count; ++l) {
    RandomStream random(shape.seed, 6, l);
    std::vector<Guide>& wisps = all.wisps.emplace_back();
    for (std::uint32_t w = 0; w < (curls ? curls_per_lock : wisps_per_lock); ++w) {
      wisps.push_back(make_member(shape, all.locks[l], 0.1f, 0.75f * shape["clump"], 0.15f, curls, random));
      std::vector<Guide>& strings = all.strings.emplace_back();
      for (std::uint32_t s = 0; s < strings_per_wisp; ++s)
        strings.push_back(make_member(shape, wisps.back(), 0.035f, 1.1f * shape["clump"], 0.08f, false, random));
    }
  }
  return all;
}

void add_strand(const GroomShape& shape, const Locks& all, std::uint32_t strand, Groom* groom) {
  RandomStream random(shape.seed, 7, strand);
  const glm::vec3 root = scalp_point(random);
  const float frizz = shape["frizz"];
  const bool stray = random.next() < 0.12f * frizz;
  const auto lock = static_cast<std::size_t>(&nearest(all.locks, root) - all.locks.data());
  const auto wisp = static_cast<std::size_t>(&nearest(all.wisps[lock], root) - all.wisps[lock].data());
  const Guide& string = nearest(all.strings[lock * all.wisps[lock].size() + wisp], root);
  const float shorter = stray ? uniform(random, 0.05f, 0.5f)
                              : shape["length_variation"] * std::pow(random.next(), 3.0f) + 0.02f * random.next();
  Guide own;
  own.length_cm = string.length_cm * (1 - shorter);
  std::vector<glm::vec3> points =
      fall(root, own.length_cm, clearance_cm(root, (stray ? 0.2f : 0.1f) * kernel(random)), shape.points);
  wave(all.locks[lock], &points);
  if (shape["curl_diameter_cm"] > 0) wave(all.wisps[lock][wisp], &points);
  gather(string, std::min(0.98f, shape["clump"] * (stray ? 0.5f : uniform(random, 1.2f, 1.6f))), 0, &points);
  const Wander wander(random);
  const float wandering = stray ? uniform(random, 0.4f, 1.3f) : frizz * uniform(random, 0.2f, 1.2f);
  for (std::uint32_t i = 0; i < shape.points; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(shape.points - 1);
    const glm::vec3 p = points[i] + wandering * t * wander.at(t);
    groom->points.push_back(i > 0 ? outside_head(p, 0.05f) : p);
    groom->radius_cm.push_back(shape.radius_cm);
  }
  groom->first_point.push_back(static_cast<std::uint32_t>(groom->points.size()));
}

}  // namespace

Groom layered_hair(const GroomShape& shape) {
  const Locks all = make_locks(shape);
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) add_strand(shape, all, s, &groom);
  return groom;
}

}  // namespace tress::scene
