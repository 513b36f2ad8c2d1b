// The meaning of the points of strands, if a scene or a host sets it because their file does not record it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/curve_bases.h"
#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Values of the key "basis": bspline, linear, catmull_rom (through every point, ends mirrored),
/// clamped_catmull_rom (the same with ends repeated, as Blender draws it), open_bspline,
/// open_catmull_rom (from the second point to the last but one), bezier (3 n + 1 points), hermite (point and tangent in
/// turn).
const std::vector<std::string>& basis_names();

/// The kind of a name of basis_names().
CurveKind kind_of_basis(const std::string& name);

/// Converts points of this kind, and the attributes at them, into those that are drawn, exactly. Strands that are too
/// short for a segment are left without points. Fails, naming `name` and the strand, if one cannot have its number of
/// points; `file` is then unchanged.
std::optional<Error> take_points_as(const CurveKind& kind, const std::string& name, GroomFile* file);

/// The same for a groom that was made by a recipe; its strands can be of every kind except bezier and hermite.
void take_points_as(const CurveKind& kind, Groom* groom);

}  // namespace tress::scene
