// From strands and polygons as a file has them to a groom or a mesh in the world: axes, unit, radius, taper, what is
// degenerate.
#pragma once

#include <glm/ext/matrix_double3x3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/grooms/curve_bases.h"
#include "scene/read/grooms/groom_file.h"
#include "scene/read/input_files.h"

namespace tress::scene {

/// What is taken where neither a file nor a scene says it.
constexpr float usual_radius_cm = 0.004f;
constexpr double usual_longest_side_cm = 30;
/// Where a unit is guessed, widths count whose middle gives a radius within; "clamp" brings every one of them in. A
/// human hair has .0008 to .009 cm.
constexpr double smallest_radius_cm = 5e-4, largest_radius_cm = 0.05;

/// What becomes of the widths of a file. By themselves they are used as they are where the unit is said, of any size;
/// where it is guessed, if they are those of hair.
struct WidthUse {
  enum class Kind { usual, file, clamp } kind = Kind::usual;  ///< file: used whatever the unit
  double scale = 1;                                           ///< of file

  friend bool operator==(const WidthUse&, const WidthUse&) = default;
};

/// "file", "clamp" or "scale=S" with 0 < S <= 10^6; nothing for another text.
std::optional<WidthUse> width_use_of(std::string_view text);
constexpr const char* width_use_words = "file, clamp or scale=S with S > 0 and at most 10^6";

/// What a file's widths become in a unit.
struct WidthPlan {
  bool are_used = false;
  double typical_radius_cm = 0;  ///< the middle of those that are not 0; 0: the file has none
  double cm_per_unit = 1;        ///< of widths
  bool clamps = false;

  float radius_of(float width) const;
};
WidthPlan plan_widths(const GroomFile& file, const WidthUse& use, double cm_per_unit, bool is_unit_said);

/// Gives strands whose widths the file does not say, beside others, the usual ones, for files that cannot leave them
/// out.
void say_widths(GroomFile* file);

/// Where an object of the scene is.
struct ObjectTransform {
  double scale = 1;            ///< of the object, radii too
  glm::vec3 rotate_deg{0.0f};  ///< about x, then y, then z, after the scale
  glm::vec3 translate{0.0f};   ///< cm, after the turn

  /// Of column vectors.
  glm::dmat3 turn() const;
  /// Where it brings a point, cm. turn: its own, made once for many points.
  glm::dvec3 of(const glm::dvec3& point, const glm::dmat3& turn) const {
    return turn * (scale * point) + glm::dvec3(translate);
  }
  friend bool operator==(const ObjectTransform&, const ObjectTransform&) = default;
};

struct TransformKey {
  int frame = 0;
  ObjectTransform transform;
};

/// The same in every frame, or by keys of rising frame numbers: linear between them, number by number, held before and
/// after them.
struct ObjectPath {
  ObjectTransform still;
  std::vector<TransformKey> keys;  ///< where there are any, in place of `still`

  ObjectTransform at(double frame) const;
};

struct GroomPlacement {
  std::optional<bool> y_up = {};  ///< y of the file becomes z, its z becomes -y; unset: as it says, else guess_up
  bool guess_up = false;          ///< where y_up is unset: by how the strands fall
  std::optional<double> cm_per_unit = {};        ///< unset: the file's, else usual_cm_per_unit
  std::optional<double> usual_cm_per_unit = {};  ///< unset: the longest side of the bounding box is 30 cm
  std::optional<double> radius_cm = {};          ///< unset: the file's, or .004 cm where they are not used
  WidthUse widths = {};
  std::optional<CurveKind> basis = {};  ///< of files that do not say; unset: B-splines through root and tip
  bool strict = false;                  ///< what the file has and the picture does not show is an error
  bool normals = true;                  ///< those of the file give the minor axes of its fibers
  bool colors = false;                  ///< strands have the colors of the file
  std::string attribute = {};           ///< what of the file is taken for its color; empty: what the format has for it
};

/// Whether y of the file is up, by how its strands fall: from root to tip they go down on average, hair by its weight
/// and fur by its comb. The mean over strands of tip - root over the length of the strand must be below -0.1 along y
/// and twice as far down as along z.
bool falls_along_y(const GroomFile& hair);

/// Appends to `notes` what was chosen and to `warnings` what was left out. A groom without strands is possible.
/// Fails where the placed groom leaves a world of 10^6 cm. Takes no memory but for radii that the file has not.
Result<Groom> assemble_groom(GroomFile file, const GroomPlacement& placement, const std::string& name,
                             std::vector<std::string>* notes, std::vector<std::string>* warnings);

/// Scales, turns and moves a groom that stands in the world, at each of the moments of the shutter, at least one. A
/// groom that rests moves where the transforms do. Fails where it leaves a world of 10^6 cm.
std::optional<Error> move_groom(std::span<const ObjectTransform> moments, Groom* groom);

/// Scales, turns and moves a light that stands in the world, at each of the moments of the shutter, at least one; where
/// the transforms do not differ it rests. Radiance and the angles of cones stay. Fails where it leaves a world of 10^6
/// cm; `name` and `place` are the scene file and the light of the message.
std::optional<Error> move_light(std::span<const ObjectTransform> moments, const std::string& name,
                                const std::string& place, Light* light);

/// Factors of the radius, linear in between along the normalised length of the strand's points.
struct Taper {
  double root = 1, tip = 1;
};

void apply_taper(const Taper& taper, Groom* groom);

struct MeshDescription {
  std::optional<std::string> name = {};  ///< Mesh::object
  std::string file;                      ///< as written
  bool y_up = false;                     ///< y of the file becomes z, its z becomes -y
  double cm_per_unit = 1;                ///< before the transform
  ObjectPath path = {};                  ///< in the world's axes
  glm::vec3 albedo = Mesh{}.albedo;
  std::optional<std::string> albedo_file = {};  ///< as written
  std::optional<CoatParameters> coat = {};
  bool visible = true, holdout = false;  ///< as of Mesh
};

/// A mesh as its file has it at a moment of the shutter, and where it is then.
struct MeshAtMoment {
  const ObjFile* file;
  ObjectTransform transform;
};

/// The mesh in the world, at each of the moments of the shutter, at least one; the files have the same faces. Where
/// neither files nor transforms differ it rests. Triangles without area at the first moment are left out, which is a
/// warning. Fails where the placed mesh leaves a world of 10^6 cm. `name` is the file.
Result<Mesh> place_mesh(std::span<const MeshAtMoment> moments, const MeshDescription& description,
                        const std::string& name, std::vector<std::string>* warnings);

}  // namespace tress::scene
