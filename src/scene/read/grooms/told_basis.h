// What the points of strands are where a scene or a host says it, since their file does not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/read/grooms/curve_bases.h"
#include "scene/read/grooms/groom_file.h"

namespace tress::scene {

/// Values of the key "basis": bspline, linear, catmull_rom (through every point, ends mirrored), open_bspline,
/// open_catmull_rom (from the second point to the last but one), bezier (3 n + 1 points), hermite (point and tangent in
/// turn).
const std::vector<std::string>& basis_names();

/// The kind of a name of basis_names().
CurveKind kind_of_basis(const std::string& name);

/// Makes points of this kind those that are drawn, and what is given at them likewise, exactly. Strands that are too
/// short for a segment are left without points. Fails, naming `name` and the strand, where one cannot have as many
/// points; `file` is then as it was.
std::optional<Error> take_points_as(const CurveKind& kind, const std::string& name, GroomFile* file);

/// The same of a groom that was made by a recipe, whose strands can be of every kind but bezier and hermite.
void take_points_as(const CurveKind& kind, Groom* groom);

}  // namespace tress::scene
