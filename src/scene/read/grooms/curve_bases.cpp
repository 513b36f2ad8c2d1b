#include "scene/read/grooms/curve_bases.h"

#include <array>
#include <glm/vec3.hpp>

namespace tress::scene {
namespace {

/// Number of vertices from one segment to the next.
std::uint64_t step_of(CurveBasis basis) {
  return basis == CurveBasis::bezier ? 3 : basis == CurveBasis::hermite ? 2 : 1;
}

/// Number of vertices of one segment that does not wrap.
std::uint64_t least_of(CurveBasis basis) { return basis == CurveBasis::linear ? 2 : 4; }

/// False for Bezier and Hermite curves, which reach their ends anyway.
bool is_pinned(const CurveKind& kind) {
  if (kind.wrap == CurveWrap::repeated) return kind.basis == CurveBasis::catmull_rom;
  return kind.wrap == CurveWrap::pinned && (kind.basis == CurveBasis::bspline || kind.basis == CurveBasis::catmull_rom);
}

/// The vertices of a curve, with those before its first and after its last that its wrap adds.
template <class T>
class Vertices {
 public:
  Vertices(std::span<const T> given, CurveWrap wrap) : given_(given), wrap_(wrap) {}

  T operator[](std::int64_t i) const {
    const auto count = static_cast<std::int64_t>(given_.size());
    if (i >= 0 && i < count) return given_[static_cast<std::size_t>(i)];
    if (wrap_ == CurveWrap::periodic) return given_[static_cast<std::size_t>((i % count + count) % count)];
    if (wrap_ == CurveWrap::repeated) return i < 0 ? given_.front() : given_.back();
    return i < 0 ? 2.0f * given_[0] - given_[1] : 2.0f * given_[given_.size() - 1] - given_[given_.size() - 2];
  }

 private:
  std::span<const T> given_;
  CurveWrap wrap_;
};

template <class T>
using Segment = std::array<T, 4>;

/// Converts the control points of a B-spline segment into its Bezier points.
template <class T>
Segment<T> bezier_of_bspline(const T& a, const T& b, const T& c, const T& d) {
  return {(a + 4.0f * b + c) / 6.0f, (2.0f * b + c) / 3.0f, (b + 2.0f * c) / 3.0f, (b + 4.0f * c + d) / 6.0f};
}

template <class T>
Segment<T> bezier_segment(const CurveKind& kind, const Vertices<T>& p, std::int64_t s) {
  const std::int64_t first = s * static_cast<std::int64_t>(step_of(kind.basis));
  switch (kind.basis) {
    case CurveBasis::linear: {
      const T a = p[s], b = p[s + 1];
      return {a, (2.0f * a + b) / 3.0f, (a + 2.0f * b) / 3.0f, b};
    }
    case CurveBasis::bezier:
      return {p[first], p[first + 1], p[first + 2], p[first + 3]};
    case CurveBasis::hermite: {
      const T a = p[first], b = p[first + 2];
      return {a, a + p[first + 1] / 3.0f, b - p[first + 3] / 3.0f, b};
    }
    default:
      break;
  }
  const std::int64_t at = is_pinned(kind) ? s - 1 : s;
  const T a = p[at], b = p[at + 1], c = p[at + 2], d = p[at + 3];
  if (kind.basis == CurveBasis::bspline) return bezier_of_bspline(a, b, c, d);
  return {b, b + (c - a) / 6.0f, c - (d - b) / 6.0f, c};
}

template <class T>
void append_segments(const CurveKind& kind, std::span<const T> vertices, std::vector<T>* out) {
  const Vertices<T> p(vertices, kind.wrap);
  const auto segments = static_cast<std::int64_t>(segments_of(kind, vertices.size()));
  for (std::int64_t s = 0; s < segments; ++s) {
    const Segment<T> points = bezier_segment(kind, p, s);
    out->insert(out->end(), points.begin() + (s == 0 ? 0 : 1), points.end());
  }
}

CurveKind kind_of(StrandBasis basis) {
  switch (basis) {
    case StrandBasis::linear:
      return {CurveBasis::linear, CurveWrap::nonperiodic};
    case StrandBasis::bspline:
      return {CurveBasis::bspline, CurveWrap::pinned};
    case StrandBasis::open_bspline:
      return {CurveBasis::bspline, CurveWrap::nonperiodic};
    default:
      return {CurveBasis::bezier, CurveWrap::nonperiodic};
  }
}

}  // namespace

std::string words(const CurveKind& kind) {
  static constexpr std::array bases{"linear", "cubic bezier", "cubic bspline", "cubic catmullRom", "cubic hermite"};
  static constexpr std::array wraps{"nonperiodic", "periodic", "pinned", "ends repeated"};
  return std::string(bases[static_cast<std::size_t>(kind.basis)]) + ", " + wraps[static_cast<std::size_t>(kind.wrap)];
}

std::string fault_of(const CurveKind& kind, std::uint64_t vertices) {
  const std::uint64_t step = step_of(kind.basis);
  if (kind.wrap == CurveWrap::periodic) return vertices % step == 0 ? "" : "a multiple of " + std::to_string(step);
  if (vertices < least_of(kind.basis) || vertices % step == least_of(kind.basis) % step) return "";
  return step == 3 ? "3 n + 1" : "an even number";
}

std::uint64_t segments_of(const CurveKind& kind, std::uint64_t vertices) {
  if (kind.wrap == CurveWrap::periodic) return vertices < 2 ? 0 : vertices / step_of(kind.basis);
  if (is_pinned(kind)) return vertices < 2 ? 0 : vertices - 1;
  const std::uint64_t least = least_of(kind.basis);
  return vertices < least ? 0 : (vertices - least) / step_of(kind.basis) + 1;
}

std::uint64_t varying_of(const CurveKind& kind, std::uint64_t vertices) {
  const std::uint64_t segments = segments_of(kind, vertices);
  return kind.wrap == CurveWrap::periodic ? segments : segments + 1;
}

StrandBasis drawn_as(const CurveKind& kind) {
  if (kind.basis == CurveBasis::linear) return StrandBasis::linear;
  if (kind.basis != CurveBasis::bspline) return StrandBasis::bezier;
  return kind.wrap == CurveWrap::pinned ? StrandBasis::bspline : StrandBasis::open_bspline;
}

std::uint64_t drawn_points(const CurveKind& kind, StrandBasis drawn, std::uint64_t vertices) {
  const std::uint64_t segments = segments_of(kind, vertices);
  if (segments == 0) return 0;
  if (drawn == StrandBasis::bezier) return 3 * segments + 1;
  return segments + (drawn == StrandBasis::open_bspline ? 3 : 1);
}

template <class T>
void append_vertex_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> vertices, std::vector<T>* out) {
  const std::uint64_t points = drawn_points(kind, drawn, vertices.size());
  if (points == 0) return;
  if (drawn == StrandBasis::bezier) return append_segments(kind, vertices, out);
  out->insert(out->end(), vertices.begin(), vertices.end());
  for (std::uint64_t i = vertices.size(); i < points; ++i) out->push_back(vertices[i % vertices.size()]);
}

template <class T>
void append_varying_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> values, std::vector<T>* out) {
  std::vector<T> knots(values.begin(), values.end());
  if (kind.wrap == CurveWrap::periodic) knots.push_back(values[0]);
  if (knots.size() < 2) return;
  if (drawn == StrandBasis::bezier) return append_segments<T>({CurveBasis::linear, CurveWrap::nonperiodic}, knots, out);
  const Vertices<T> p(knots, CurveWrap::pinned);
  const auto count = static_cast<std::int64_t>(knots.size());
  const std::int64_t beyond = drawn == StrandBasis::open_bspline ? 1 : 0;
  for (std::int64_t i = -beyond; i < count + beyond; ++i) out->push_back(p[i]);
}

template <class T>
std::vector<T> as_bezier(StrandBasis basis, std::span<const std::uint32_t> first_point, std::span<const T> values) {
  std::vector<T> out;
  for (std::size_t s = 0; s + 1 < first_point.size(); ++s)
    append_vertex_values(kind_of(basis), StrandBasis::bezier,
                         values.subspan(first_point[s], first_point[s + 1] - first_point[s]), &out);
  return out;
}

template void append_vertex_values(const CurveKind&, StrandBasis, std::span<const float>, std::vector<float>*);
template void append_vertex_values(const CurveKind&, StrandBasis, std::span<const glm::vec3>, std::vector<glm::vec3>*);
template void append_varying_values(const CurveKind&, StrandBasis, std::span<const float>, std::vector<float>*);
template void append_varying_values(const CurveKind&, StrandBasis, std::span<const glm::vec3>, std::vector<glm::vec3>*);
template std::vector<float> as_bezier(StrandBasis, std::span<const std::uint32_t>, std::span<const float>);
template std::vector<glm::vec3> as_bezier(StrandBasis, std::span<const std::uint32_t>, std::span<const glm::vec3>);

}  // namespace tress::scene
