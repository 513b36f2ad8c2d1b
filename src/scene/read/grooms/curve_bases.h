// Curves of any basis and wrap as the renderer draws them: exactly, by change of basis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// What the vertices of a curve are.
enum class CurveBasis : std::uint8_t { linear, bezier, bspline, catmull_rom, hermite };
/// How a curve ends. pinned: it begins and ends at its first and last vertex, P[-1] = 2 P[0] - P[1].
enum class CurveWrap : std::uint8_t { nonperiodic, periodic, pinned };

struct CurveKind {
  CurveBasis basis = CurveBasis::linear;
  CurveWrap wrap = CurveWrap::nonperiodic;
  friend constexpr bool operator==(const CurveKind&, const CurveKind&) = default;
};

/// "cubic bspline, pinned".
std::string words(const CurveKind& kind);

/// Why a curve cannot have so many vertices: "a multiple of 3"; empty where it can. Too few for a segment are no fault.
std::string fault_of(const CurveKind& kind, std::uint64_t vertices);

/// Segments of a curve of so many vertices; 0: too few.
std::uint64_t segments_of(const CurveKind& kind, std::uint64_t vertices);

/// How many varying values it has: one where segments meet, and at the ends.
std::uint64_t varying_of(const CurveKind& kind, std::uint64_t vertices);

/// The basis that draws such curves with the fewest points.
StrandBasis drawn_as(const CurveKind& kind);

/// Points of a curve when it is drawn as drawn_as(), and as Bezier segments. 0: too few vertices.
std::uint64_t drawn_points(const CurveKind& kind, StrandBasis drawn, std::uint64_t vertices);

/// Appends the points of one curve, of vertices that have no fault. `drawn` is drawn_as(kind) or bezier, which draws
/// any. T: a vector or a number, whatever is interpolated as the points are.
template <class T>
void append_vertex_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> vertices, std::vector<T>* out);

/// The same of varying values, which are linear along each segment. As Bezier segments and polygons they are so
/// exactly; as B-splines they become control values, which is exact where they rise evenly.
template <class T>
void append_varying_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> values, std::vector<T>* out);

/// Strands of any basis as Bezier segments, exactly. `first_point` as in GroomFile, of the result afterwards.
template <class T>
std::vector<T> as_bezier(StrandBasis basis, std::span<const std::uint32_t> first_point, std::span<const T> values);

}  // namespace tress::scene
