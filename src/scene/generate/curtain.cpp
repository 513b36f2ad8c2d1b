// A curtain of hair that fills a picture: strands form strings, strings form wisps, and wisps form locks that wave
// together or are curls; a few strands fly. It has no head, because its roots should be out of the frame.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "base/pi.h"
#include "scene/generate/groom_kinds.h"

namespace tress::scene {
namespace {

constexpr std::uint32_t wisps_per_curl = 9, strings_per_curl_wisp = 7;
constexpr float lock_area_cm2 = 1.5f, curl_area = 0.5f;  // for a curl: times the square of its diameter

/// A wave across the fall, or a turn around it; cm, radians.
struct Sway {
  float amplitude_cm = 0, wavelength_cm = 1, phase = 0, roundness = 0;

  float turn(float s) const { return two_pi_f * s / wavelength_cm + phase; }
  glm::vec2 at(float s) const { return amplitude_cm * glm::vec2(std::sin(turn(s)), roundness * std::cos(turn(s))); }
};

/// A center line around which other strands gather.
struct Bundle {
  glm::vec2 root{};  ///< its start, in the plane of the roots
  float length_cm = 0;
  Sway sway;
};

struct Curtain {
  std::vector<Bundle> locks, wisps, strings;  ///< the wisps of all locks and the strings of all wisps, in a row
};

glm::vec2 in_disc(RandomStream& random) {
  const float r = std::sqrt(random.next()), angle = two_pi_f * random.next();
  return r * glm::vec2(std::cos(angle), std::sin(angle));
}

glm::vec2 extent_cm(const GroomShape& shape) {
  const float width = shape["width_cm"];
  return {width, std::clamp(0.25f * width, 0.5f, 3.0f)};
}

/// Neighbouring waves are similar: their phase drifts slowly over the curtain. Curls are independent.
Sway lock_sway(const GroomShape& shape, const glm::vec2& root, RandomStream& random) {
  Sway sway;
  const float longer = std::max(0.6f, 1 + 0.06f * kernel(random)), wider = std::max(0.4f, 1 + 0.2f * kernel(random));
  sway.wavelength_cm = shape["wavelength_cm"] * longer;
  if (shape["curl_diameter_cm"] > 0) {
    sway.amplitude_cm = 0.5f * shape["curl_diameter_cm"] * wider;
    sway.roundness = uniform(random, 0.85f, 1.0f) * (random.next() < 0.3f ? -1.0f : 1.0f);
    sway.phase = two_pi_f * random.next();
  } else {
    sway.amplitude_cm = shape["wave_amplitude_cm"] * wider;
    sway.roundness = uniform(random, 0.5f, 0.9f);
    sway.phase = 0.8f * std::sin(0.45f * root.x + 0.4f) + 0.5f * root.y + 0.3f * kernel(random);
  }
  return sway;
}

Bundle make_lock(const GroomShape& shape, std::uint32_t index, std::uint32_t count) {
  RandomStream random(shape.seed, 8, index);
  const glm::vec2 extent = extent_cm(shape);
  Bundle lock;
  // Roots are even along the width, and in steps of the golden ratio through the depth.
  const float across = (static_cast<float>(index) + uniform(random, 0.2f, 0.8f)) / static_cast<float>(count);
  const float deep = std::fmod(0.618034f * static_cast<float>(index), 1.0f);
  lock.root = extent * (glm::vec2(across, deep) - 0.5f);
  lock.length_cm = shape["length_cm"] * std::max(0.4f, 1 + 0.5f * shape["length_variation"] * kernel(random));
  lock.sway = lock_sway(shape, lock.root, random);
  return lock;
}

/// Makes a member of `of`, rooted within `spread_cm`, with a small wave of its own.
Bundle make_member(const GroomShape& shape, const Bundle& of, float spread_cm, float amplitude, RandomStream& random) {
  Bundle member;
  member.root = of.root + spread_cm * in_disc(random);
  member.length_cm = of.length_cm * std::clamp(1 + 0.3f * shape["length_variation"] * kernel(random), 0.5f, 1.2f);
  member.sway.amplitude_cm = amplitude * std::max(0.2f, 1 + 0.4f * kernel(random));
  member.sway.wavelength_cm = uniform(random, 5.0f, 11.0f);
  member.sway.roundness = uniform(random, -1.0f, 1.0f);
  member.sway.phase = two_pi_f * random.next();
  return member;
}

Curtain make_curtain(const GroomShape& shape, float lock_area) {
  const glm::vec2 extent = extent_cm(shape);
  const auto count = static_cast<std::uint32_t>(std::clamp(extent.x * extent.y / lock_area, 1.0f, 2000.0f));
  const float spread = std::sqrt(lock_area), loose = 0.3f + shape["frizz"];
  Curtain all;
  for (std::uint32_t l = 0; l < count; ++l) {
    all.locks.push_back(make_lock(shape, l, count));
    RandomStream random(shape.seed, 9, l);
    for (std::uint32_t w = 0; w < wisps_per_curl; ++w) {
      all.wisps.push_back(make_member(shape, all.locks.back(), 0.6f * spread, 0.3f * loose, random));
      for (std::uint32_t s = 0; s < strings_per_curl_wisp; ++s)
        all.strings.push_back(make_member(shape, all.wisps.back(), 0.25f * spread, 0.12f * loose, random));
    }
  }
  return all;
}

/// Turns the offset with the lock, if it is a curl.
glm::vec2 carried(const glm::vec2& offset, const Sway& lock, bool curls, float s) {
  if (!curls) return offset;
  const float angle = lock.turn(s) * (lock.roundness < 0 ? 1.0f : -1.0f);
  const float c = std::cos(angle), d = std::sin(angle);
  return {c * offset.x - d * offset.y, d * offset.x + c * offset.y};
}

/// The individual values of one strand.
struct Own {
  glm::vec2 offset;  ///< from its string, cm
  float length_cm, gathered, astray_cm, wander_cm;
  Sway slow, fast;
};

Own make_own(const GroomShape& shape, const Bundle& string, float spread_cm, RandomStream& random) {
  const float frizz = shape["frizz"];
  const bool stray = random.next() < 0.3f * frizz;
  Own own;
  own.offset = spread_cm * in_disc(random);
  const float shorter = stray ? uniform(random, 0.0f, 0.6f) : shape["length_variation"] * std::pow(random.next(), 3.0f);
  own.length_cm = string.length_cm * (1 - shorter);
  own.gathered = shape["clump"] * (stray ? uniform(random, 0.0f, 0.5f) : uniform(random, 0.85f, 1.0f));
  own.astray_cm = stray ? uniform(random, 0.2f, 1.4f) : 0.0f;
  own.wander_cm = frizz * uniform(random, 0.2f, 1.0f);
  for (Sway* sway : {&own.slow, &own.fast}) {
    sway->wavelength_cm = sway == &own.slow ? uniform(random, 8.0f, 16.0f) : uniform(random, 2.5f, 5.0f);
    sway->amplitude_cm = sway == &own.slow ? 1.0f : 0.25f;
    sway->roundness = uniform(random, -1.0f, 1.0f);
    sway->phase = two_pi_f * random.next();
  }
  return own;
}

void add_strand(const GroomShape& shape, const Curtain& all, std::uint32_t strand, float spread, Groom* groom) {
  RandomStream random(shape.seed, 10, strand);
  const bool curls = shape["curl_diameter_cm"] > 0;
  const auto number = static_cast<std::uint32_t>(random.next_bits() % all.strings.size());
  const Bundle& string = all.strings[number];
  const Bundle& wisp = all.wisps[number / strings_per_curl_wisp];
  const Bundle& lock = all.locks[number / strings_per_curl_wisp / wisps_per_curl];
  const Own own = make_own(shape, string, 0.12f * spread, random);
  for (std::uint32_t i = 0; i < shape.points; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(shape.points - 1);
    const float s = own.length_cm * t, along = std::min(1.0f, s / lock.length_cm), opening = smooth_step(s / 6);
    const float loose = 1 - own.gathered * smooth_step(along);
    const glm::vec2 in_lock = (1 - 0.45f * own.gathered * along) * (wisp.root - lock.root) + opening * wisp.sway.at(s);
    const glm::vec2 in_wisp = (0.25f + 0.75f * loose) * (string.root - wisp.root) + opening * string.sway.at(s);
    glm::vec2 p = lock.root + opening * (1 - 0.25f * along) * lock.sway.at(s);
    p += carried(in_lock + in_wisp + (0.1f + 0.9f * loose) * own.offset, lock.sway, curls, s);
    p += opening * (own.wander_cm * along + own.astray_cm) * (own.slow.at(s) + own.fast.at(s));
    groom->points.emplace_back(p.x, p.y, -s);
    groom->radius_cm.push_back(shape.radius_cm);
  }
  groom->first_point.push_back(static_cast<std::uint32_t>(groom->points.size()));
}

}  // namespace

Groom curtain(const GroomShape& shape) {
  const float diameter = shape["curl_diameter_cm"];
  const float lock_area = diameter > 0 ? std::max(0.1f, curl_area * diameter * diameter) : lock_area_cm2;
  const Curtain all = make_curtain(shape, lock_area);
  Groom groom;
  groom.first_point.push_back(0);
  const float spread = diameter > 0 ? 0.35f * std::sqrt(lock_area) : std::sqrt(lock_area);
  for (std::uint32_t s = 0; s < shape.strands; ++s) add_strand(shape, all, s, spread, &groom);
  return groom;
}

}  // namespace tress::scene
