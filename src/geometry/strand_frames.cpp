#include "geometry/strand_frames.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

namespace tress::geometry {
namespace {

/// Reflects x in the plane orthogonal to `axis` (any length; zero: unchanged).
glm::dvec3 reflect_across(const glm::dvec3& x, const glm::dvec3& axis) {
  const double length_squared = glm::dot(axis, axis);
  return length_squared > 0 ? x - (2 * glm::dot(axis, x) / length_squared) * axis : x;
}

/// Rotation about z, counter-clockwise from above.
struct Turned {
  double cosine = 1, sine = 0;
  Turned() = default;
  explicit Turned(double turned_rad) : cosine(std::cos(turned_rad)), sine(std::sin(turned_rad)) {}
  glm::dvec3 operator()(const glm::dvec3& a) const {
    return {cosine * a.x - sine * a.y, sine * a.x + cosine * a.y, a.z};
  }
  glm::dvec3 back(const glm::dvec3& a) const { return {cosine * a.x + sine * a.y, cosine * a.y - sine * a.x, a.z}; }
};

/// The tolerance for rounding of turned points. Without it, the axis for a strand that goes straight down, as far from
/// x as from y, would differ between frames.
constexpr double rounding = 1e-5;

/// Returns the axis least aligned with the tangent, made orthogonal to it; the first of those that are equal to within
/// `alike`.
glm::dvec3 least_aligned_normal(const glm::dvec3& tangent, const Turned& turned, double alike) {
  const glm::dvec3 size = glm::abs(turned.back(tangent));
  glm::dvec3 axis(0, 0, 1);
  if (size.x <= size.y + alike && size.x <= size.z + alike) {
    axis = {1, 0, 0};
  } else if (size.y <= size.z + alike) {
    axis = {0, 1, 0};
  }
  axis = turned(axis);
  return glm::normalize(axis - glm::dot(axis, tangent) * tangent);
}

/// The unit vector along x, or 0 if x is 0.
glm::dvec3 direction_of(const glm::dvec3& x) {
  const double length = glm::length(x);
  return length > 0 ? x / length : glm::dvec3(0);
}

using scene::StrandBasis;

/// Adds a knot of the uniform cubic B-spline: (p- + 4 p + p+)/6, with its tangent along p+ - p-.
void add_bspline_knot(const glm::dvec3& before, const glm::dvec3& here, const glm::dvec3& after, StrandKnots* knots) {
  knots->position.push_back((before + 4.0 * here + after) / 6.0);
  knots->tangent.push_back(direction_of(after - before));
}

/// Adds the knot between the segments that end and begin at this point. A Bezier segment leaves its end towards the
/// nearest of its control points that does not coincide with it.
void add_bezier_knot(std::span<const glm::vec3> points, std::size_t i, StrandKnots* knots) {
  const glm::dvec3 here = points[i];
  const auto towards = [&](int step) {
    glm::dvec3 direction(0);
    for (int k = 1; k <= 3 && direction == glm::dvec3(0); ++k) {
      const auto at = static_cast<std::ptrdiff_t>(i) + k * step;
      if (at < 0 || at >= static_cast<std::ptrdiff_t>(points.size())) break;
      direction = direction_of(glm::dvec3(points[static_cast<std::size_t>(at)]) - here);
    }
    return direction;
  };
  knots->position.push_back(here);
  knots->tangent.push_back(direction_of(towards(1) - towards(-1)));
}

/// Gives knots without a tangent that of a neighbour, towards the tip first.
void fill_tangents(std::vector<glm::dvec3>* tangent) {
  const std::size_t count = tangent->size();
  for (std::size_t i = count - 1; i-- > 0;) {
    if ((*tangent)[i] == glm::dvec3(0)) (*tangent)[i] = (*tangent)[i + 1];
  }
  if ((*tangent)[0] == glm::dvec3(0)) (*tangent)[0] = {0, 0, 1};
  for (std::size_t i = 1; i < count; ++i) {
    if ((*tangent)[i] == glm::dvec3(0)) (*tangent)[i] = (*tangent)[i - 1];
  }
}

/// `normal`: at the root. If a tangent turns back on itself, the normal starts anew from axes that are `turned`.
std::vector<KnotFrame> frames_from(glm::dvec3 normal, const StrandKnots& knots, double root_angle_rad,
                                   double turn_rad_per_cm, const Turned& turned) {
  std::vector<KnotFrame> frames;
  frames.reserve(knots.position.size());
  double length = 0;
  frames.push_back({normal, static_cast<float>(root_angle_rad)});
  for (std::size_t i = 1; i < knots.position.size(); ++i) {
    const glm::dvec3 step = knots.position[i] - knots.position[i - 1];
    const glm::dvec3 tangent_reflected = reflect_across(knots.tangent[i - 1], step);
    normal = reflect_across(reflect_across(normal, step), knots.tangent[i] - tangent_reflected);
    normal -= glm::dot(normal, knots.tangent[i]) * knots.tangent[i];
    const double size = glm::length(normal);
    normal = size > 1e-9 ? normal / size : least_aligned_normal(knots.tangent[i], turned, rounding);
    length += glm::length(step);
    frames.push_back({normal, static_cast<float>(root_angle_rad + turn_rad_per_cm * length)});
  }
  return frames;
}

/// Returns the axis or its opposite, whichever is nearer to `to`; the axis if both are equally near.
glm::dvec3 on_the_side_of(const glm::dvec3& to, const glm::dvec3& axis) {
  return glm::dot(axis, to) < -rounding ? -axis : axis;
}

/// Interpolates axes at the knots from those at the points. 0 stands for no axis.
std::vector<glm::dvec3> knot_axes(std::span<const glm::vec3> axis, StrandBasis basis) {
  const std::size_t count = axis.size(), stride = basis == StrandBasis::bezier ? 3 : 1;
  std::vector<glm::dvec3> at;
  at.reserve(count);
  if (basis == StrandBasis::linear || basis == StrandBasis::bezier) {
    for (std::size_t i = 0; i < count; i += stride) at.emplace_back(axis[i]);
    return at;
  }
  if (basis == StrandBasis::bspline && count > 0) at.emplace_back(axis[0]);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const glm::dvec3 before = axis[i - 1], here = axis[i], after = axis[i + 1];
    const glm::dvec3 side = here != glm::dvec3(0) ? here : before != glm::dvec3(0) ? before : after;
    at.push_back((on_the_side_of(side, before) + 4.0 * here + on_the_side_of(side, after)) / 6.0);
  }
  if (basis == StrandBasis::bspline && count > 1) at.emplace_back(axis[count - 1]);
  return at;
}

/// The angle about the tangent, in radians, from `normal` to the major axis that belongs to a minor axis. Empty if that
/// has no part across the tangent.
std::optional<double> turn_of(const glm::dvec3& minor_axis, const glm::dvec3& tangent, const glm::dvec3& normal) {
  constexpr double least_sine = 1e-3;
  const double length = glm::length(minor_axis);
  const glm::dvec3 major = glm::cross(minor_axis, tangent);
  if (!(length > 1e-6) || !(glm::length(major) > least_sine * length)) return std::nullopt;
  return std::atan2(glm::dot(major, glm::cross(tangent, normal)), glm::dot(major, normal));
}

}  // namespace

glm::vec3 root_normal(const glm::vec3& tangent) { return least_aligned_normal(tangent, Turned(), 0); }

StrandKnots strand_knots(std::span<const glm::vec3> points, StrandBasis basis) {
  const std::size_t count = points.size();
  StrandKnots knots;
  if (count < (basis == StrandBasis::open_bspline || basis == StrandBasis::bezier ? 4 : 2)) return knots;
  knots.position.reserve(count);
  knots.tangent.reserve(count);
  if (basis == StrandBasis::bezier) {
    for (std::size_t i = 0; i < count; i += 3) add_bezier_knot(points, i, &knots);
  } else if (basis == StrandBasis::open_bspline) {
    for (std::size_t i = 1; i + 1 < count; ++i) add_bspline_knot(points[i - 1], points[i], points[i + 1], &knots);
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 here = points[i];
      const glm::dvec3 before = i > 0 ? glm::dvec3(points[i - 1]) : 2.0 * here - glm::dvec3(points[i + 1]);
      const glm::dvec3 after = i + 1 < count ? glm::dvec3(points[i + 1]) : 2.0 * here - glm::dvec3(points[i - 1]);
      if (basis == StrandBasis::linear) {
        knots.position.push_back(here);
        knots.tangent.push_back(direction_of(direction_of(after - here) + direction_of(here - before)));
      } else {
        add_bspline_knot(before, here, after, &knots);
      }
    }
  }
  fill_tangents(&knots.tangent);
  return knots;
}

std::vector<KnotFrame> strand_frames(const StrandKnots& knots, double root_angle_rad, double turn_rad_per_cm,
                                     double turned_rad) {
  if (knots.position.size() < 2) return {};
  const Turned turned(turned_rad);
  return frames_from(least_aligned_normal(knots.tangent[0], turned, rounding), knots, root_angle_rad, turn_rad_per_cm,
                     turned);
}

std::vector<KnotFrame> later_frames(const StrandKnots& knots, const KnotFrame& first, const glm::dvec3& first_tangent,
                                    const glm::dmat3& turned, double turn_rad_per_cm) {
  const glm::dvec3 &to = knots.tangent[0], from = direction_of(turned * first_tangent), axis = glm::cross(from, to);
  glm::dvec3 normal = turned * glm::dvec3(first.normal);
  const double cosine = glm::dot(from, to);
  if (cosine > -0.999999) {  // for a half turn the direction of rotation is undefined
    const glm::dvec3 once = glm::cross(axis, normal);
    normal += once + glm::cross(axis, once) / (1 + cosine);
  }
  normal = direction_of(normal - glm::dot(normal, to) * to);
  if (normal == glm::dvec3(0)) normal = least_aligned_normal(to, Turned(), rounding);
  return frames_from(normal, knots, double{first.angle}, turn_rad_per_cm, Turned());
}

std::vector<KnotFrame> strand_frames(std::span<const glm::vec3> points, double root_angle_rad, double turn_rad_per_cm,
                                     StrandBasis basis, double turned_rad) {
  return strand_frames(strand_knots(points, basis), root_angle_rad, turn_rad_per_cm, turned_rad);
}

bool turn_to_minor_axes(const StrandKnots& knots, std::span<const glm::vec3> minor_axis, StrandBasis basis,
                        std::vector<KnotFrame>* frames) {
  const std::vector<glm::dvec3> axes = knot_axes(minor_axis, basis);
  if (axes.size() != frames->size()) return false;
  std::vector<KnotFrame>& at = *frames;
  std::optional<std::size_t> last;  // the last knot that has an axis
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::optional<double> turn = turn_of(axes[i], knots.tangent[i], at[i].normal);
    if (!turn) continue;
    const std::size_t from = last.value_or(0);
    const double before = last ? double{at[from].angle} : *turn;
    double step = std::remainder(*turn - before, 2 * std::numbers::pi);
    if (std::abs(step) > std::numbers::pi / 2 + rounding) step -= std::copysign(std::numbers::pi, step);
    for (std::size_t k = last ? from + 1 : 0; k <= i; ++k) {
      const double share = last ? static_cast<double>(k - from) / static_cast<double>(i - from) : 1;
      at[k].angle = static_cast<float>(before + share * step);
    }
    last = i;
  }
  if (!last) return false;
  for (std::size_t k = *last + 1; k < at.size(); ++k) at[k].angle = at[*last].angle;
  return true;
}

FiberFrame frame_between(const KnotFrame& a, const KnotFrame& b, float t, const glm::vec3& tangent) {
  glm::vec3 normal = (1 - t) * a.normal + t * b.normal;
  normal -= glm::dot(normal, tangent) * tangent;
  const float size = glm::length(normal);
  normal = size > 1e-3f ? normal / size : root_normal(tangent);
  const float angle = (1 - t) * a.angle + t * b.angle;
  const glm::vec3 binormal = glm::cross(tangent, normal);
  const glm::vec3 v = std::cos(angle) * normal + std::sin(angle) * binormal;
  return {tangent, v, glm::cross(tangent, v)};
}

}  // namespace tress::geometry
