#include "geometry/strand_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>
#include <ranges>

#include "scene/model/camera.h"
#include "scene/model/groom_bounds.h"
#include "tress/base/random.h"

namespace tress::geometry {
namespace {

using scene::StrandBasis;

bool is_finite(const glm::vec3& x) { return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z); }

const std::vector<glm::vec3>& points_at(const scene::Groom& groom, std::size_t moment) {
  return moment == 0 ? groom.points : groom.later[moment - 1].points;
}

/// The points of a strand that are drawn; empty if it is not drawn.
std::vector<std::uint32_t> drawn_points(const scene::Groom& groom, std::uint32_t strand) {
  const bool repeats_stay = groom.basis != StrandBasis::linear;
  std::vector<std::uint32_t> drawn;
  for (std::uint32_t i = groom.first_point[strand]; i < groom.first_point[strand + 1]; ++i) {
    if (!std::isfinite(groom.radius_cm[i])) return {};
    const auto is_bad = [i](const auto& moment) {
      return !moment.radius_cm.empty() && !std::isfinite(moment.radius_cm[i]);
    };
    if (std::ranges::any_of(groom.later, is_bad)) return {};
    bool repeats = !drawn.empty();
    for (std::size_t moment = 0; moment <= groom.later.size(); ++moment) {
      const std::vector<glm::vec3>& points = points_at(groom, moment);
      if (!is_finite(points[i])) return {};
      repeats = repeats && points[drawn.back()] == points[i];
    }
    if (repeats && !repeats_stay) continue;
    drawn.push_back(i);
  }
  return drawn;
}

/// Unit tangents of two segments where they meet, root to tip. Both are 0 if either segment has no length.
struct Bend {
  glm::vec3 in{0.0f}, out{0.0f};
};

/// Bends below 0.02 rad have no joint: the wedge that they leave open is 0.01 radii squared.
constexpr float least_corner_cosine = 0.9998f;

/// The direction of the first of these vectors that is not 0 to within rounding of coordinates as large as `size`; 0 if
/// all are.
glm::vec3 first_direction(std::initializer_list<glm::vec3> candidates, float size) {
  for (const glm::vec3& x : candidates)
    if (const float length = glm::length(x); length > 1e-6f * size) return x / length;
  return glm::vec3(0.0f);
}

/// a, b: the four control points of the segment before and of the one after.
Bend bend_between(StrandBasis basis, const glm::vec4* a, const glm::vec4* b) {
  const glm::vec3 a0(a[0]), a1(a[1]), a2(a[2]), a3(a[3]), b0(b[0]), b1(b[1]), b2(b[2]), b3(b[3]);
  const auto largest = [](const glm::vec3& x) { return std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}); };
  const float size = std::max(largest(a3), largest(b0));
  Bend bend;
  if (basis == StrandBasis::bezier) {
    bend = {first_direction({a3 - a2, a3 - a1, a3 - a0}, size), first_direction({b1 - b0, b2 - b0, b3 - b0}, size)};
  } else {
    // The tangent is the first derivative that is not 0. At the end of a segment, an even one counts backwards.
    const glm::vec3 slope = a3 - a1, second = a1 - 2.0f * a2 + a3;
    if (const glm::vec3 along = first_direction({slope}, size); along != glm::vec3(0.0f)) return {along, along};
    bend = {first_direction({-second, a3 - a0}, size), first_direction({second, b3 - b0}, size)};
  }
  return bend.in == glm::vec3(0.0f) || bend.out == glm::vec3(0.0f) ? Bend{} : bend;
}

/// The place where a segment with these four control points begins, with its semi-axis.
glm::vec4 start_of(StrandBasis basis, const glm::vec4* p) {
  return basis == StrandBasis::bezier ? p[0] : (p[0] + 4.0f * p[1] + p[2]) / 6.0f;
}

float axis_at_start(StrandBasis basis, const float* axis) {
  return basis == StrandBasis::bezier ? axis[0] : (axis[0] + 4 * axis[1] + axis[2]) / 6;
}

/// Control points of the joint between two segments, of which these are the first control points. It turns evenly from
/// one tangent to the other within a tenth of the semi-axis.
std::array<glm::vec4, 4> joint_control(StrandBasis basis, const std::vector<glm::vec4>& control, std::uint32_t before,
                                       std::uint32_t after) {
  const Bend bend = bend_between(basis, &control[before], &control[after]);
  const glm::vec4 at = start_of(basis, &control[after]);
  glm::vec3 middle = bend.in + bend.out;
  const float length = glm::length(middle);
  if (length > 1e-3f)
    middle /= length;
  else if (bend.in != glm::vec3(0.0f))
    middle = root_normal(bend.in);
  const float step = 0.05f * at.w;
  const auto point = [&](const glm::vec3& offset) { return at + glm::vec4(step * offset, 0.0f); };
  const glm::vec4 b0 = point(-0.5f * middle - bend.in), b1 = point(-0.5f * middle), b2 = point(0.5f * middle),
                  b3 = point(0.5f * middle + bend.out);
  if (basis == StrandBasis::bezier) return {b0, b1, b2, b3};
  return {6.0f * b0 - 7.0f * b1 + 2.0f * b2, 2.0f * b1 - b2, 2.0f * b2 - b1, 2.0f * b1 - 7.0f * b2 + 6.0f * b3};
}

/// The data of a strand besides its points.
struct StrandShape {
  std::uint32_t index;
  float eccentricity;
  double root_angle_rad, turn_rad_per_cm;
};

/// The size of a pixel in the coordinates of a groom, when the shutter opens: of its instances, for the one that is
/// nearest to the camera and before it.
class PixelSize {
 public:
  PixelSize(const scene::Scene& scene, const scene::Groom& groom)
      : image_(scene.image), camera_(scene.camera_moments.empty() ? scene.camera : scene.camera_moments.front()) {
    const std::optional<scene::Box> box = scene::box_of_points(groom);
    if (!box) return;
    const glm::vec3 middle = 0.5f * (box->low + box->high);
    float least = std::numeric_limits<float>::infinity();
    for (const scene::Instance& instance : groom.instances) {
      const float cm = scene::pixel_cm_at(camera_, image_, instance.first.point(middle)) / instance.first.scale;
      if (cm > 0 && cm < least) {
        least = cm;
        place_ = instance.first;
      }
    }
  }
  /// cm, >= 0; 0 behind the camera.
  float at(const glm::vec3& point) const {
    return scene::pixel_cm_at(camera_, image_, place_.point(point)) / place_.scale;
  }

 private:
  const scene::Image& image_;
  const scene::Camera& camera_;
  scene::Similarity place_;
};

class StrandAdder {
 public:
  StrandAdder(const scene::Scene& scene, const scene::Groom& groom, const PixelSize& pixels, StrandCurves& curves)
      : groom_(groom), least_width_px_(scene.image.least_width_px), pixels_(pixels), curves_(curves) {
    curves_.later_control.resize(groom.later.size());
    curves_.later_frames.resize(groom.later.size());
    all_control_.push_back(&curves_.control);
    for (auto& moment : curves_.later_control) {
      moment.reserve(curves.control.capacity());
      all_control_.push_back(&moment);
    }
    for (auto& moment : curves_.later_frames) moment.reserve(curves.segments.capacity());
  }

  void add(const StrandShape& strand) {
    drawn_ = drawn_points(groom_, strand.index);
    const std::vector<glm::vec3> p = points(0);
    const StrandKnots knots = strand_knots(p, groom_.basis);
    std::vector<KnotFrame> frames =
        strand_frames(knots, strand.root_angle_rad, strand.turn_rad_per_cm, groom_.turned_rad);
    if (frames.empty()) return;
    const bool has_axes =
        !groom_.minor_axis.empty() && turn_to_minor_axes(knots, drawn_of(groom_.minor_axis), groom_.basis, &frames);
    set_axes(groom_.radius_cm, strand.eccentricity);
    const auto base = static_cast<std::uint32_t>(curves_.control.size());
    if (least_width_px_ > 0) widen(p, strand.eccentricity);
    add_control(p, curves_.control);
    later_.clear();
    for (std::size_t moment = 0; moment < groom_.later.size(); ++moment) {
      const std::vector<glm::vec3> moved = points(moment + 1);
      if (const std::vector<float>& radii = groom_.later[moment].radius_cm; !radii.empty()) {
        set_axes(radii, strand.eccentricity);
        for (std::size_t i = 0; i < widening_.size(); ++i) axes_[i] *= widening_[i];
        curves_.radii_change = true;
      }
      add_control(moved, curves_.later_control[moment]);
      later_.push_back(later_frames(strand_knots(moved, groom_.basis), frames[0], knots.tangent[0],
                                    groom_.later[moment].turned, strand.turn_rad_per_cm));
      // Axes from a file turn with the strand: their angles about it stay.
      for (std::size_t i = 0; has_axes && i < frames.size(); ++i) later_.back()[i].angle = frames[i].angle;
    }
    const std::uint32_t stride = groom_.basis == StrandBasis::bezier ? 3 : 1;
    std::optional<std::uint32_t> before;  // the last segment with a length
    for (std::uint32_t i = 0; i + 1 < frames.size(); ++i) {
      const std::uint32_t first = base + stride * i;
      if (has_length(first)) {
        if (before && is_corner(*before, first)) {
          const StrandSegment joint{frames[i], frames[i], {}, strand.index, i, strand.eccentricity, 0};
          add_segment(add_joint_control(*before, first), joint, i);
        }
        before = first;
      }
      add_segment(first, {frames[i], frames[i + 1], {}, strand.index, i, strand.eccentricity}, i);
    }
  }

 private:
  /// Adds a segment with these control points. knot: where it begins.
  void add_segment(std::uint32_t first, StrandSegment segment, std::uint32_t knot) {
    curves_.first_control.push_back(first);
    const std::uint32_t controls = curves_.is_linear() ? 2 : 4;
    for (std::uint32_t c = 0; c < controls; ++c) segment.semi_axis[c] = curves_.control[first + c].w;
    curves_.segments.push_back(segment);
    const std::uint32_t end = segment.advance > 0 ? knot + 1 : knot;
    for (std::size_t moment = 0; moment < later_.size(); ++moment)
      curves_.later_frames[moment].push_back({later_[moment][knot], later_[moment][end]});
  }

  /// Whether the control points of a segment differ at any moment. Linear strands have no joints and are not asked.
  bool has_length(std::uint32_t first) const {
    return !curves_.is_linear() && std::ranges::any_of(all_control_, [first](const std::vector<glm::vec4>* control) {
      const auto at = control->begin() + first;
      return std::any_of(at + 1, at + 4, [at](const glm::vec4& p) { return glm::vec3(p) != glm::vec3(*at); });
    });
  }

  /// Returns the first of the control points.
  std::uint32_t add_joint_control(std::uint32_t before, std::uint32_t after) {
    const auto first = static_cast<std::uint32_t>(curves_.control.size());
    for (std::vector<glm::vec4>* control : all_control_)
      for (const glm::vec4& point : joint_control(curves_.basis, *control, before, after)) control->push_back(point);
    if (!curves_.own_axis.empty())
      curves_.own_axis.insert(curves_.own_axis.end(), 4, axis_at_start(curves_.basis, &curves_.own_axis[after]));
    return first;
  }

  /// Whether a joint is needed, at any moment, between the segments with these first control points.
  bool is_corner(std::uint32_t before, std::uint32_t after) const {
    return std::ranges::any_of(all_control_, [&](const std::vector<glm::vec4>* control) {
      const Bend bend = bend_between(curves_.basis, &(*control)[before], &(*control)[after]);
      return bend.in != glm::vec3(0.0f) && glm::dot(bend.in, bend.out) < least_corner_cosine;
    });
  }

  void set_axes(const std::vector<float>& radius_cm, float eccentricity) {
    axes_.clear();
    const double axis_per_radius = fiber::major_semi_axis(1.0, eccentricity);
    for (const std::uint32_t i : drawn_)
      axes_.push_back(std::max(0.0f, static_cast<float>(axis_per_radius * radius_cm[i])));
  }

  /// Widens axes that the camera sees too thin, and keeps their own widths as own_axis.
  void widen(const std::vector<glm::vec3>& p, float eccentricity) {
    std::vector<glm::vec4> own;
    add_control(p, own);
    for (const glm::vec4& control : own) curves_.own_axis.push_back(control.w);
    const double axis_per_radius = fiber::major_semi_axis(1.0, eccentricity);
    const bool has_width = std::ranges::any_of(axes_, [](float axis) { return axis > 0; });
    widening_.assign(axes_.size(), 1.0f);
    for (std::size_t i = 0; i < axes_.size() && has_width; ++i) {
      const float least_radius_cm = least_width_px_ / 2 * pixels_.at(p[i]);
      const float widened = std::max(axes_[i], static_cast<float>(axis_per_radius * least_radius_cm));
      if (axes_[i] > 0) widening_[i] = widened / axes_[i];
      axes_[i] = widened;
    }
  }

  std::vector<glm::vec3> points(std::size_t moment) const { return drawn_of(points_at(groom_, moment)); }

  std::vector<glm::vec3> drawn_of(const std::vector<glm::vec3>& all) const {
    std::vector<glm::vec3> drawn;
    drawn.reserve(drawn_.size());
    for (const std::uint32_t i : drawn_) drawn.push_back(all[i]);
    return drawn;
  }

  void add_control(const std::vector<glm::vec3>& p, std::vector<glm::vec4>& control) const {
    const std::size_t count = p.size();
    // Reflected end points make the spline pass through root and tip. A reflected radius is at least 0.
    const auto reflect = [&](std::size_t end, std::size_t next) {
      return glm::vec4(2.0f * p[end] - p[next], std::max(0.0f, 2 * axes_[end] - axes_[next]));
    };
    if (groom_.basis == StrandBasis::bspline) control.push_back(reflect(0, 1));
    for (std::size_t i = 0; i < count; ++i) control.emplace_back(p[i], axes_[i]);
    if (groom_.basis == StrandBasis::bspline) control.push_back(reflect(count - 1, count - 2));
  }

  const scene::Groom& groom_;
  float least_width_px_;
  const PixelSize& pixels_;
  StrandCurves& curves_;
  std::vector<std::uint32_t> drawn_;                  ///< points of the strand that is being added
  std::vector<float> axes_;                           ///< major semi-axes at those points, cm
  std::vector<float> widening_;                       ///< factors of the axes; empty if there is no least width
  std::vector<std::vector<glm::vec4>*> all_control_;  ///< at every moment
  std::vector<std::vector<KnotFrame>> later_;         ///< frames of the strand at the later moments
};

KnotFrame between(const KnotFrame& a, const KnotFrame& b, float share) {
  return {(1 - share) * a.normal + share * b.normal, (1 - share) * a.angle + share * b.angle};
}

/// The largest second derivative of a segment, cm.
float bend_of(const StrandCurves& curves, const std::vector<glm::vec4>& control, std::uint32_t segment) {
  const glm::vec4* p = &control[curves.first_control[segment]];
  const auto second = [&](int i) {
    return glm::length(glm::vec3(p[i]) - 2.0f * glm::vec3(p[i + 1]) + glm::vec3(p[i + 2]));
  };
  return (curves.basis == StrandBasis::bezier ? 6 : 1) * std::max(second(0), second(1));
}

/// A piece of 1 / n of a segment stays within bend / (8 n^2) of it.
int pieces_for(const StrandCurves& curves, const PixelSize& pixels, float curve_error_px) {
  if (curves.is_linear()) return least_pieces;
  std::vector<float> needed;
  needed.reserve(curves.first_control.size());
  for (std::uint32_t segment = 0; segment < curves.first_control.size(); ++segment) {
    const glm::vec3 middle(curves.control[curves.first_control[segment] + 1]);
    const float pixel_cm = pixels.at(middle);
    float bend = bend_of(curves, curves.control, segment);
    for (const auto& later : curves.later_control) bend = std::max(bend, bend_of(curves, later, segment));
    needed.push_back(pixel_cm > 0 ? std::sqrt(bend / (8 * curve_error_px * pixel_cm)) : 0);
  }
  if (needed.empty()) return least_pieces;
  const auto most = needed.end() - 1 - std::ptrdiff_t(needed.size() / 1000);
  std::ranges::nth_element(needed, most);
  int pieces = least_pieces;
  while (pieces < most_pieces && float(pieces) < *most) pieces *= 2;
  return pieces;
}

}  // namespace

FiberFrame StrandCurves::frame(std::uint32_t segment, float t, const glm::vec3& tangent, float time) const {
  const StrandSegment& first = segments[segment];
  if (later_frames.empty()) return frame_between(first.from, first.to, t, tangent);
  const scene::BetweenMoments at(time, moments());
  const auto frames = [&](std::size_t moment) {
    return moment == 0 ? SegmentFrames{first.from, first.to} : later_frames[moment - 1][segment];
  };
  const SegmentFrames a = frames(at.before), b = frames(at.before + 1);
  return frame_between(between(a.from, b.from, at.share), between(a.to, b.to, at.share), t, tangent);
}

float StrandCurves::semi_axis(std::uint32_t segment, float t, float time) const {
  std::array<float, 4> a = segments[segment].semi_axis;
  if (radii_change) {
    const std::uint32_t first = first_control[segment], controls = is_linear() ? 2 : 4;
    for (std::uint32_t c = 0; c < controls; ++c) a[c] = control_at(first + c, time).w;
  }
  return interpolated(a, t);
}

float StrandCurves::presence(std::uint32_t segment, float t) const {
  const StrandSegment& of = segments[segment];
  const float presence = with_presence != nullptr ? with_presence->presence_at(of.strand, of.place_at(t)) : 1;
  if (own_axis.empty()) return presence;
  std::array<float, 4> own{};
  std::copy_n(own_axis.begin() + first_control[segment], is_linear() ? 2 : 4, own.begin());
  const float drawn = semi_axis(segment, t, 0);
  return drawn > 0 ? presence * std::min(interpolated(own, t) / drawn, 1.0f) : presence;
}

float StrandCurves::interpolated(const std::array<float, 4>& a, float t) const {
  const float s = 1 - t;
  if (is_linear()) return s * a[0] + t * a[1];
  if (basis == StrandBasis::bezier) return s * s * s * a[0] + 3 * s * t * (s * a[1] + t * a[2]) + t * t * t * a[3];
  return (s * s * s * a[0] + (4 - 3 * t * t * (2 - t)) * a[1] + (4 - 3 * s * s * (2 - s)) * a[2] + t * t * t * a[3]) /
         6;
}

glm::vec4 StrandCurves::control_at(std::uint32_t index, float time) const {
  if (later_control.empty()) return control[index];
  const scene::BetweenMoments at(time, moments());
  const glm::vec4 &a = at.before == 0 ? control[index] : later_control[at.before - 1][index],
                  &b = later_control[at.before][index];
  return (1 - at.share) * a + at.share * b;
}

glm::vec3 StrandCurves::axis(std::uint32_t segment, float t, float time) const {
  const std::uint32_t first = first_control[segment];
  return glm::vec3((1 - t) * control_at(first, time) + t * control_at(first + 1, time));
}

glm::vec3 StrandCurves::way(std::uint32_t segment, float t) const {
  if (later_control.empty()) return glm::vec3(0.0f);
  const float s = 1 - t;
  std::array<float, 4> weight{s, t, 0, 0};
  if (basis == StrandBasis::bezier) {
    weight = {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
  } else if (!is_linear()) {
    weight = {s * s * s / 6, (4 - 3 * t * t * (2 - t)) / 6, (4 - 3 * s * s * (2 - s)) / 6, t * t * t / 6};
  }
  const std::uint32_t first = first_control[segment], controls = is_linear() ? 2 : 4;
  glm::vec3 sum(0.0f);
  for (std::uint32_t c = 0; c < controls; ++c)
    sum += weight[c] * (glm::vec3(later_control.back()[first + c]) - glm::vec3(control[first + c]));
  return sum;
}

bool StrandCurves::is_in_joint(std::uint32_t segment, float t, const glm::vec3& position, const glm::vec3& direction,
                               float time) const {
  // The strand's next point beyond the joint. The point where the ray passes nearest must not lie on its side.
  const bool at_root = t < 0.5f;
  if (at_root ? segment == 0 : segment + 1 == segments.size()) return false;
  const std::uint32_t neighbour = at_root ? segment - 1 : segment + 1;
  if (segments[neighbour].strand != segments[segment].strand) return false;
  const std::uint32_t at = first_control[at_root ? segment : neighbour];
  const glm::vec3 joint(control_at(at, time)),
      beyond = glm::vec3(control_at(first_control[neighbour] + (at_root ? 0 : 1), time)) - joint;
  const float towards = glm::dot(position - joint, beyond);
  if (towards <= 0) return true;
  // The tolerance is a thousandth of the semi-axis along the neighbour as the ray sees it, so that rounding does not
  // open the seam.
  const float along = glm::dot(beyond, direction), limit = 1e-3f * control[at].w;
  return towards * towards <= limit * limit * (glm::dot(beyond, beyond) - along * along);
}

std::size_t StrandCurves::bytes() const {
  const std::size_t indices = first_control.capacity() + first_segment.capacity();
  std::size_t bytes = control.capacity() * sizeof(glm::vec4) + indices * sizeof(std::uint32_t) +
                      segments.capacity() * sizeof(StrandSegment) + own_axis.capacity() * sizeof(float);
  for (const auto& moment : later_control) bytes += moment.capacity() * sizeof(glm::vec4);
  for (const auto& moment : later_frames) bytes += moment.capacity() * sizeof(SegmentFrames);
  return bytes;
}

StrandCurves strand_curves(const scene::Scene& scene, std::uint32_t groom_index) {
  const scene::Groom& groom = scene.grooms[groom_index];
  const scene::Material& material = scene.materials[groom.material];
  StrandCurves curves;
  curves.groom = groom_index;
  curves.basis = groom.basis;
  if (!groom.presence.empty()) curves.with_presence = &groom;
  const std::uint32_t strands = groom.strand_count();
  curves.control.reserve(groom.points.size() + (groom.basis == StrandBasis::bspline ? 2 * std::size_t{strands} : 0));
  const std::size_t most_segments = groom.points.size() - std::min<std::size_t>(groom.points.size(), strands);
  curves.first_control.reserve(most_segments);
  curves.segments.reserve(most_segments);
  curves.first_segment.reserve(std::size_t{strands} + 1);
  const PixelSize pixels(scene, groom);
  StrandAdder adder(scene, groom, pixels, curves);
  for (std::uint32_t strand = 0; strand < strands; ++strand) {
    const double hashed = 2 * std::numbers::pi * RandomStream(groom_index, strand).next();
    const double root_angle = material.root_angle_rad ? *material.root_angle_rad : hashed;
    const float eccentricity = scene.fibers[groom.fiber_at(groom.station_at(strand, 0, 1), 0)].eccentricity;
    const double curl_diameter =
        material.curl_diameter_cm ? *material.curl_diameter_cm : fiber::curl_diameter_cm(eccentricity);
    const double turn_rad_per_cm = material.twist && curl_diameter > 0 ? 2 / curl_diameter : 0;
    curves.least_eccentricity = std::min(curves.least_eccentricity, eccentricity);
    curves.first_segment.push_back(static_cast<std::uint32_t>(curves.segments.size()));
    adder.add({strand, eccentricity, root_angle, turn_rad_per_cm});
  }
  curves.first_segment.push_back(static_cast<std::uint32_t>(curves.segments.size()));
  const auto is_own = [](const glm::vec4& control, float own) { return control.w == own; };
  if (std::ranges::equal(curves.control, curves.own_axis, is_own)) curves.own_axis = {};
  curves.pieces = pieces_for(curves, pixels, scene.image.curve_error_px);
  curves.is_sparse = curves.with_presence != nullptr || !curves.own_axis.empty();
  return curves;
}

}  // namespace tress::geometry
