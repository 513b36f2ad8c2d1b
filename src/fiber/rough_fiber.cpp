#include "fiber/rough_fiber.h"

#include <algorithm>
#include <cmath>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "fiber/fresnel.h"
#include "fiber/microsurface_walk.h"
#include "tress/adaptive/mixture.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr float largest_tilt = 1.5f;
constexpr int last_named_order = 3;
constexpr float least_cosine = 1e-6f;  // least cosine to the normal, of light that grazes a surface

/// One Newton step onto the unit sphere, so that rounding cannot build up.
template <class Vector>
Vector onto_unit(const Vector& v) {
  return v * (1.5f - 0.5f * glm::dot(v, v));
}

float largest(const glm::vec3& color) { return std::max({color.r, color.g, color.b}); }

glm::vec3 unit_vector(const FiberDirection& w) {
  const float cosine = std::max(std::cos(w.theta), 0.0f);
  return {std::sin(w.theta), cosine * std::cos(w.phi), cosine * std::sin(w.phi)};
}

/// The surface that light meets from `toward`, a unit direction back to its origin.
struct Surface {
  const Beckmann& facets;
  float index;  ///< index of the far side over that of this side
  bool from_inside;
  bool is_outermost;                  ///< whether there is air beyond or on this side
  const glm::vec3 &outward, &facing;  ///< the fiber's normal; the normal of the face on this side
  glm::vec3 toward;
};

/// The chance of following the light that a facet reflects, by its share and by what else would be kept.
float chance_of_reflection(float reflected, float kept_inside) {
  return reflected / (reflected + (1 - reflected) * kept_inside);
}

}  // namespace

FiberDirection RoughExit::angles() const {
  return {std::asin(std::clamp(direction.x, -1.0f, 1.0f)), adaptive::wrap_angle(std::atan2(direction.z, direction.y))};
}

RoughFiber::RoughFiber(const FiberParameters& parameters, Masked masked)
    : masked_(masked),
      facets_(parameters.roughness),
      film_(film_roughness(parameters.roughness)),
      eta_(parameters.eta),
      eccentricity_(parameters.eccentricity),
      tan_tilt_(std::tan(std::clamp(parameters.tilt, 0.0f, largest_tilt))),
      cos_tilt_(1 / std::sqrt(1 + tan_tilt_ * tan_tilt_)),
      parts_(TracedParts::of(parameters)),
      wetness_(parameters.wetness),
      sigma_a_(parameters.sigma_a) {}

RoughEntry RoughFiber::entry(const FiberDirection& wr, float h) const {
  const float cosine = std::max(std::cos(wr.theta), 0.0f), cos_phi = std::cos(wr.phi), sin_phi = std::sin(wr.phi);
  const glm::vec2 middle = glm::normalize(glm::vec2(eccentricity_ * cos_phi, sin_phi));
  const float cos_h = std::sqrt(std::max(1 - h * h, 0.0f));
  return {{std::sin(wr.theta), cosine * cos_phi, cosine * sin_phi},
          {middle.x * cos_h - middle.y * h, middle.y * cos_h + middle.x * h}};
}

glm::vec3 RoughFiber::outward_normal(const glm::vec2& point) const {
  const glm::vec2 normal = glm::normalize(glm::vec2(eccentricity_ * point.x, point.y));
  return {0, normal.x, normal.y};
}

glm::vec3 RoughFiber::face(const Interface& at, const glm::vec3& w, const glm::vec3& outward,
                           RandomStream& random) const {
  const float side = at.side();
  if (!(tan_tilt_ > 0) || !at.has_scales()) return side * outward;
  const glm::vec3 step(side, 0, 0), slope = side * (outward - tan_tilt_ * glm::vec3(1, 0, 0));
  const float seen_step = tan_tilt_ * std::max(glm::dot(w, step), 0.0f),
              seen_slope = std::max(glm::dot(w, slope), 0.0f);
  return random.next() * (seen_step + seen_slope) < seen_step ? step : cos_tilt_ * slope;
}

glm::vec3 RoughFiber::toward_face(const glm::vec3& w, const glm::vec3& facing) {
  const float cosine = glm::dot(w, facing);
  return cosine < least_cosine ? glm::normalize(w + (least_cosine - cosine) * facing) : w;
}

InnerWay RoughFiber::cross(InnerRay& ray, RandomStream& random) const {
  if (!parts_.are_plain()) return cross_interior(parts_, eccentricity_, ray, random);
  const glm::vec2 across(ray.direction.y, ray.direction.z / eccentricity_);
  const float length = std::max(-2 * glm::dot(ray.point, across), 0.0f) / std::max(glm::dot(across, across), 1e-12f);
  ray.point = onto_unit(ray.point + length * across);
  return {length, 1, length * ray.direction.x};
}

float RoughFiber::to_middle(const glm::vec2& point, const glm::vec3& direction) const {
  const glm::vec2 across(direction.y, direction.z), at(point.x, eccentricity_ * point.y);
  return -glm::dot(at, across) / std::max(glm::dot(across, across), 1e-6f) * direction.x;
}

FiberExit RoughFiber::place_of(const glm::vec2& point, const glm::vec3& direction, float along) const {
  const float length = std::max(std::hypot(direction.y, direction.z), 1e-6f);
  return {(point.x * direction.z - eccentricity_ * point.y * direction.y) / length, along + to_middle(point, direction),
          true};
}

RoughFiber::Event RoughFiber::scatter(const Interface& at, const glm::vec3& w, const glm::vec3& outward,
                                      const std::array<float, 2>& u_facet, float u_choice, RandomStream& random) const {
  const glm::vec3 facing = face(at, w, outward, random);
  const glm::vec3 toward = toward_face(w, facing);
  if (masked_ == Masked::meets_others) {
    const Departure leaves = walk_microsurface(at.facets, at.index(), toward, facing, u_facet, u_choice, random);
    return {onto_unit(leaves.direction), leaves.refracted, 1};
  }
  const glm::vec3 m = at.facets.visible_normal(toward, facing, u_facet, random);
  const double cos_i = std::clamp(static_cast<double>(glm::dot(toward, m)), 0.0, 1.0);
  const bool thins = at.from_inside == (at.eta >= 1);
  const double eta = at.eta >= 1 ? at.eta : 1 / at.eta;
  double cos_t;
  const double reflected = thins ? fresnel_leaving(eta, eta, cos_i, &cos_t) : fresnel_entering(eta, eta, cos_i, &cos_t);
  Event event;
  event.refracted = static_cast<double>(u_choice) >= reflected;
  float side = 1;
  if (event.refracted) {
    const double ratio = thins ? eta : 1 / eta;
    event.direction = static_cast<float>(cos_i * ratio - cos_t) * m - static_cast<float>(ratio) * toward;
    side = -1;
  } else {
    event.direction = static_cast<float>(2 * cos_i) * m - toward;
  }
  event.direction = onto_unit(event.direction);
  event.weight = at.facets.unmasked(side * glm::dot(event.direction, facing));
  return event;
}

RoughFiber::Event RoughFiber::scatter_first(const Interface& at, const glm::vec3& w, const glm::vec3& outward,
                                            const std::array<float, 4>& u, RandomStream& random,
                                            float kept_inside) const {
  const glm::vec3 facing = face(at, w, outward, random);
  const SplitDeparture split =
      split_microsurface(at.facets, at.eta, toward_face(w, facing), facing, {u[0], u[1]}, random);
  const float reflected = split.share_reflected, chance = chance_of_reflection(reflected, kept_inside);
  const bool reflects = u[2] < chance;
  const Departure& leaves = reflects ? split.reflected : split.refracted;
  return {onto_unit(leaves.direction), leaves.refracted,
          reflects ? reflected / chance : (1 - reflected) / (1 - chance)};
}

float RoughFiber::first_reflection(const RoughEntry& entry, const FiberDirection& wi, float kept_inside) const {
  const float dry = first_reflection(bare(false), entry, wi, kept_inside);
  return wetness_ > 0 ? (1 - wetness_) * dry + wetness_ * first_reflection(film(false), entry, wi, kept_inside) : dry;
}

float RoughFiber::first_reflection(const Interface& at, const RoughEntry& entry, const FiberDirection& wi,
                                   float kept_inside) const {
  const glm::vec3 outward = outward_normal(entry.point), w = entry.direction, sum = w + unit_vector(wi);
  const float length = glm::length(sum), toward = 0.5f * length;  // the cosine between w and the facet's normal
  if (!(length > least_cosine)) return 0;
  const glm::vec3 normal = sum / length;
  const double eta = at.eta;
  double cos_t;
  const auto reflected =
      static_cast<float>(fresnel_entering(eta, eta, std::min(static_cast<double>(toward), 1.0), &cos_t));
  const auto by = [&](const glm::vec3& facing) {
    const float seen = at.facets.seen_area(glm::dot(toward_face(w, facing), facing));
    return seen > 0 ? at.facets.facet_area(glm::dot(normal, facing)) / (4 * seen) : 0.0f;
  };
  float density = 0;
  if (tan_tilt_ > 0 && at.has_scales()) {
    const glm::vec3 step(1, 0, 0), slope = outward - tan_tilt_ * step;
    const float seen_step = tan_tilt_ * std::max(w.x, 0.0f), seen_slope = std::max(glm::dot(w, slope), 0.0f);
    if (!(seen_step + seen_slope > 0)) return 0;
    if (seen_step > 0) density += seen_step * by(step);
    if (seen_slope > 0) density += seen_slope * by(cos_tilt_ * slope);
    density /= seen_step + seen_slope;
  } else {
    density = by(outward);
  }
  return chance_of_reflection(reflected, kept_inside) * density;
}

RoughExit RoughFiber::trace(const RoughEntry& entry, const std::array<float, 4>& u, RandomStream& random,
                            float kept_inside) const {
  RoughExit exit;
  InnerRay ray{entry.point, entry.direction};
  glm::vec3 outward = outward_normal(ray.point), throughput(1.0f);
  Medium medium = Medium::air;
  bool outwards = false;
  const bool favors_reflection = kept_inside < 1 && masked_ == Masked::meets_others;
  const auto meet = [&](const auto& scatter_at) {
    const Interface at = met(medium, outwards, random);
    const Event event = scatter_at(at);
    medium = at.after(event.refracted);
    return event;
  };
  Event event = meet([&](const Interface& at) {
    return favors_reflection ? scatter_first(at, entry.direction, outward, u, random, kept_inside)
                             : scatter(at, entry.direction, outward, {u[0], u[1]}, u[2], random);
  });
  float u_choice = u[3], along = -to_middle(entry.point, entry.direction);
  for (int events = 1; events < most_events; ++events, u_choice = random.next()) {
    throughput *= event.weight;
    if (!(largest(throughput) > 0)) return exit;
    ray.direction = event.direction;
    const float away = glm::dot(event.direction, outward);
    outwards = away > 0;
    if (medium == Medium::air && outwards) {
      exit.direction = event.direction;
      exit.throughput = throughput;
      exit.place = place_of(ray.point, event.direction, along);
      return exit;
    }
    if (medium == Medium::fiber && away < 0) {
      ++exit.order;
      const InnerWay way = cross(ray, random);
      outward = outward_normal(ray.point);
      exit.way += way.cortex;
      along += way.along;
      throughput *= way.kept * glm::exp(-sigma_a_ * way.cortex);
    }  // otherwise it meets another face of the cuticle on the same side
    const float kept = largest(throughput);
    if (!(kept > 0)) return exit;
    if (kept < roulette_below) {
      if ((1 - random.next()) * roulette_below > kept) return exit;
      throughput *= roulette_below / kept;
    }
    const std::array<float, 2> u_facet{random.next(), random.next()};
    event = meet([&](const Interface& at) { return scatter(at, -ray.direction, outward, u_facet, u_choice, random); });
  }
  return exit;
}

/// The visitor of trace_split().
class RoughFiber::Exits {
 public:
  explicit Exits(std::vector<SplitExit>& exits) : exits_(exits) {}
  void leaves(const SplitExit& exit) { exits_.push_back(exit); }
  void at(const glm::vec2& /*point*/, float /*way_along*/) const {}
  float kept(float weight, float /*path*/) const { return weight; }
  SplitDeparture meets(const Surface& surface, const SplitExit& /*light*/, const std::array<float, 2>& u_facet,
                       RandomStream& random) const {
    return split_microsurface(surface.facets, surface.index, surface.toward, surface.facing, u_facet, random);
  }

 private:
  std::vector<SplitExit>& exits_;
};

/// The visitor of estimate().
class RoughFiber::Estimate {
 public:
  Estimate(const RoughFiber& fiber, const RoughEntry& entry, const FiberDirection& wi, FiberExit* place)
      : cosine_(std::max(std::cos(wi.theta), 0.0f)),
        wi_(unit_vector(wi)),
        fiber_(fiber),
        place_(place),
        point_(entry.point),
        along_(-fiber.to_middle(entry.point, entry.direction)) {}
  const LobeColors& s() const { return s_; }

  void leaves(const SplitExit&) const {}
  void at(const glm::vec2& point, float way_along) {
    point_ = point;
    along_ += way_along;
  }
  float kept(float weight, float path) const { return weight * largest(glm::exp(-fiber_.sigma_a_ * path)); }
  SplitDeparture meets(const Surface& surface, const SplitExit& light, const std::array<float, 2>& u_facet,
                       RandomStream& random) {
    if (!surface.is_outermost || !(glm::dot(wi_, surface.outward) > 0)) {
      return split_microsurface(surface.facets, surface.index, surface.toward, surface.facing, u_facet, random);
    }
    Outlook outlook{wi_, surface.from_inside};
    const SplitDeparture split =
        split_microsurface(surface.facets, surface.index, surface.toward, surface.facing, u_facet, random, outlook);
    const glm::vec3 sent = cosine_ * light.weight * outlook.density * glm::exp(-fiber_.sigma_a_ * light.path);
    glm::vec3& of_lobe = s_[static_cast<std::size_t>(std::min(light.order, static_cast<int>(Lobe::residual)))];
    if (place_ == nullptr)
      of_lobe += sent;
    else if (const float most = largest(sent); most > 0)
      choose(sent, most, of_lobe, random);
    return split;
  }

 private:
  /// Keeps this facet's light in place of all before, or makes what is kept stand for it, so that no mean changes.
  void choose(const glm::vec3& sent, float most, glm::vec3& of_lobe, RandomStream& random) {
    all_ += most;
    if (most < all_ && random.next() * all_ >= most) {
      for (glm::vec3& s : s_) s *= all_ / (all_ - most);
      return;
    }
    s_ = {};
    of_lobe = sent * (all_ / most);
    *place_ = fiber_.place_of(point_, wi_, along_);
  }

  float cosine_;
  glm::vec3 wi_;
  const RoughFiber& fiber_;
  FiberExit* place_;  ///< null if light of all facets is added up
  glm::vec2 point_;   ///< where light is
  float along_;       ///< and its way along the axis
  float all_ = 0;     ///< of all facets, the largest channel
  LobeColors s_{};
};

void RoughFiber::trace_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random,
                             std::vector<SplitExit>& exits, const SplitRules& rules) const {
  Exits visitor(exits);
  follow_split(entry, u, random, rules, visitor);
}

LobeColors RoughFiber::estimate(const RoughEntry& entry, const FiberDirection& wi, const FacetNumbers& u,
                                RandomStream& random) const {
  Estimate visitor(*this, entry, wi, nullptr);
  follow_split(entry, u, random, {roulette_below, std::numeric_limits<float>::infinity()}, visitor);
  return visitor.s();
}

LobeColors RoughFiber::estimate(const RoughEntry& entry, const FiberDirection& wi, const FacetNumbers& u,
                                RandomStream& random, FiberExit& place) const {
  Estimate visitor(*this, entry, wi, &place);
  follow_split(entry, u, random, {roulette_below, std::numeric_limits<float>::infinity()}, visitor);
  return visitor.s();
}

template <class Visitor>
void RoughFiber::follow_split(const RoughEntry& entry, const FacetNumbers& u, RandomStream& random,
                              const SplitRules& rules, Visitor& visitor) const {
  struct Part {
    glm::vec3 direction;
    float weight = 0;
    Medium medium = Medium::air;
    bool away = false;
  };
  InnerRay ray{entry.point, entry.direction};
  glm::vec3 outward = outward_normal(ray.point), w = entry.direction;
  Medium medium = Medium::air;
  bool outwards = false;
  float weight = 1, path = 0;
  int order = 0;
  for (int events = 0; events < most_events; ++events) {
    const Interface at = met(medium, outwards, random);
    const glm::vec3 facing = face(at, w, outward, random);
    const std::array<float, 2> u_facet = static_cast<std::size_t>(events) < u.size()
                                             ? u[static_cast<std::size_t>(events)]
                                             : std::array<float, 2>{random.next(), random.next()};
    const Surface surface{at.facets, at.index(), at.from_inside,        at.outer == Medium::air,
                          outward,   facing,     toward_face(w, facing)};
    const SplitDeparture split = visitor.meets(surface, {order, weight, path, w}, u_facet, random);
    float kept = 0;
    std::array<Part, 2> parts;
    for (std::size_t i = 0; i < 2; ++i) {
      const Departure& leaves = i == 0 ? split.reflected : split.refracted;
      const float share = i == 0 ? split.share_reflected : 1 - split.share_reflected;
      if (!(share > 0)) continue;
      Part part{onto_unit(leaves.direction), weight * share, at.after(leaves.refracted)};
      part.away = glm::dot(part.direction, outward) > 0;
      if (part.medium == Medium::air && part.away) {
        visitor.leaves({order, part.weight, path, part.direction});
        continue;
      }
      parts[i] = part;
      kept += part.weight;
    }
    if (!(kept > 0)) return;
    const bool second = parts[1].weight > 0 && (!(parts[0].weight > 0) || random.next() * kept < parts[1].weight);
    const Part& chosen = parts[second ? 1 : 0];
    weight = kept;
    medium = chosen.medium;
    outwards = chosen.away;
    ray.direction = chosen.direction;
    if (medium == Medium::fiber && !chosen.away) {
      ++order;
      const InnerWay way = cross(ray, random);
      outward = outward_normal(ray.point);
      path += way.cortex;
      weight *= way.kept;
      visitor.at(ray.point, way.along);
      if (path > rules.longest_way && order > last_named_order) {
        visitor.leaves({order, weight, path, ray.direction});
        return;
      }
      if (!(weight > 0)) return;
    }
    const float left = visitor.kept(weight, path);
    if (left < rules.roulette_below) {
      if ((1 - random.next()) * rules.roulette_below > left) return;
      weight = rules.roulette_below * (weight / left);
    }
    w = -ray.direction;
  }
}

}  // namespace tress::inline v0_2::fiber
