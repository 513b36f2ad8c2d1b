// Long hair swept back and cut in layers: strands gather in wisps, and wisps in locks; locks wave together, and wisps
// may curl.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "base/pi.h"
#include "scene/generate/groom_kinds.h"

namespace tress::scene {
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
