#include "scene/generate/groom_kinds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "base/pi.h"

namespace tress::scene {
namespace {

glm::vec3 in_box(RandomStream& random, float half) {
  const float x = uniform(random, -half, half), y = uniform(random, -half, half), z = uniform(random, -half, half);
  return {x, y, z};
}

}  // namespace

Wander::Wander(RandomStream& random)
    : slow_(in_box(random, 1.0f)),
      fast_(in_box(random, 0.35f)),
      slow_phase_(in_box(random, two_pi_f)),
      fast_phase_(in_box(random, two_pi_f)) {}

glm::vec3 Wander::at(float t) const {
  glm::vec3 p;
  for (int c = 0; c < 3; ++c)
    p[c] = slow_[c] * std::sin(5.0f * t + slow_phase_[c]) + fast_[c] * std::sin(14.0f * t + fast_phase_[c]);
  return p;
}

Groom single_fiber(const GroomShape& shape) {
  constexpr float apart_cm = 0.1f;
  const float length_cm = shape["length_cm"];
  Groom groom;
  groom.first_point.push_back(0);
  for (std::uint32_t s = 0; s < shape.strands; ++s) {
    const float x = apart_cm * (static_cast<float>(s) - 0.5f * static_cast<float>(shape.strands - 1));
    for (std::uint32_t i = 0; i < shape.points; ++i) {
      groom.points.emplace_back(x, 0.0f, -length_cm * static_cast<float>(i) / static_cast<float>(shape.points - 1));
      groom.radius_cm.push_back(shape.radius_cm);
    }
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

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

// A curtain of hair that fills a picture: strands form strings, strings form wisps, and wisps form locks that wave
// together or are curls; a few strands fly. It has no head, because its roots should be out of the frame.
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

// A ball of fur: guard hairs in tufts over a shorter, finer undercoat, combed down and around.
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
