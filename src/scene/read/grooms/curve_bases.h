// Converts curves of any basis and wrap into those that the renderer draws, exactly, by change of basis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace tress::scene {

/// The meaning of the vertices of a curve.
enum class CurveBasis : std::uint8_t { linear, bezier, bspline, catmull_rom, hermite };
/// The ends of a curve. pinned: it begins and ends at its first and last vertex, P[-1] = 2 P[0] - P[1]. repeated: the
/// same for Catmull-Rom curves with P[-1] = P[0], as Blender has them.
enum class CurveWrap : std::uint8_t { nonperiodic, periodic, pinned, repeated };

struct CurveKind {
  CurveBasis basis = CurveBasis::linear;
  CurveWrap wrap = CurveWrap::nonperiodic;
  friend constexpr bool operator==(const CurveKind&, const CurveKind&) = default;
};

/// Text such as "cubic bspline, pinned".
std::string words(const CurveKind& kind);

/// The reason why a curve cannot have this number of vertices: "a multiple of 3"; empty if it can. Too few for a
/// segment are no error.
std::string fault_of(const CurveKind& kind, std::uint64_t vertices);

/// The number of segments of a curve with this number of vertices; 0: too few.
std::uint64_t segments_of(const CurveKind& kind, std::uint64_t vertices);

/// The number of its varying values: one where segments meet, and one at each end.
std::uint64_t varying_of(const CurveKind& kind, std::uint64_t vertices);

/// The basis that draws such curves with the fewest points.
StrandBasis drawn_as(const CurveKind& kind);

/// The number of points of a curve drawn by drawn_as(), or as Bezier segments. 0: too few vertices.
std::uint64_t drawn_points(const CurveKind& kind, StrandBasis drawn, std::uint64_t vertices);

/// Appends the points of one curve, whose vertices must be valid (fault_of()). `drawn` is drawn_as(kind) or bezier,
/// which can draw any. T: a vector or a number that is interpolated as the points are.
template <class T>
void append_vertex_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> vertices, std::vector<T>* out);

/// The same for varying values, which are linear along each segment. For Bezier segments and polygons this is exact;
/// for B-splines they become control values, which is exact if they rise evenly.
template <class T>
void append_varying_values(const CurveKind& kind, StrandBasis drawn, std::span<const T> values, std::vector<T>* out);

/// Converts strands of any basis into Bezier segments, exactly. `first_point` is as in GroomFile, and belongs to the
/// result afterwards.
template <class T>
std::vector<T> as_bezier(StrandBasis basis, std::span<const std::uint32_t> first_point, std::span<const T> values);

}  // namespace tress::scene
