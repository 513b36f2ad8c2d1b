// Places strands and polygons of a file into the world, as a groom or a mesh: axes, unit, radius, taper, degenerate
// parts.
#pragma once

#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/matrix_double4x4.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/model/scene.h"
#include "scene/read/grooms/curve_bases.h"
#include "scene/read/grooms/groom_file.h"
#include "scene/read/input_files.h"
#include "scene/read/obj_file.h"

namespace tress::scene {

/// The radius if neither a file nor a scene gives one.
constexpr float usual_radius_cm = 0.004f;
constexpr double usual_longest_side_cm = 30;
/// If the unit is guessed, widths are used if their median gives a radius within these limits; "clamp" brings every one
/// within them. Human hair has 0.0008 to 0.009 cm.
constexpr double smallest_radius_cm = 5e-4, largest_radius_cm = 0.05;

/// The use of a file's widths. By default they are used unchanged, of any size, if the unit is given; if it is guessed,
/// only if they are those of hair.
struct WidthUse {
  enum class Kind { usual, file, clamp } kind = Kind::usual;  ///< file: used whatever the unit
  double scale = 1;                                           ///< factor on the widths, for `file`

  friend bool operator==(const WidthUse&, const WidthUse&) = default;
};

/// Parses "file", "clamp" or "scale=S" with 0 < S <= 10^6; empty for any other text.
std::optional<WidthUse> width_use_of(std::string_view text);
constexpr const char* width_use_words = "file, clamp or scale=S with S > 0 and at most 10^6";

/// The conversion of a file's widths in a given unit.
struct WidthPlan {
  bool are_used = false;
  double typical_radius_cm = 0;  ///< median of those that are not 0; 0: the file has none
  double cm_per_unit = 1;        ///< unit of the widths
  bool clamps = false;

  float radius_of(float width) const;
};
WidthPlan plan_widths(const GroomFile& file, const WidthUse& use, double cm_per_unit, bool is_unit_said);

/// Gives strands without widths, in a file where others have some, the usual width, for formats that need one
/// everywhere.
void say_widths(GroomFile* file);

/// The placement of an object of the scene.
struct ObjectTransform {
  double scale = 1;            ///< scale of the object, including its radii
  glm::vec3 rotate_deg{0.0f};  ///< about x, then y, then z, after the scale
  glm::vec3 translate{0.0f};   ///< cm, after the turn
  glm::dvec3 origin{0.0};      ///< cm: the point that becomes 0 after all (Scene::origin)

  /// The rotation as a matrix for column vectors.
  glm::dmat3 turn() const;
  /// The place of a point after the transform, cm. turn: the object's turn(), computed once for many points.
  glm::dvec3 of(const glm::dvec3& point, const glm::dmat3& turn) const {
    return turn * (scale * point) + glm::dvec3(translate) - origin;
  }
  /// The same as a matrix.
  glm::dmat4 matrix() const;
  friend bool operator==(const ObjectTransform&, const ObjectTransform&) = default;
};

struct TransformKey {
  int frame = 0;
  ObjectTransform transform;
};

/// A placement that is the same in every frame, or given by keys of rising frame numbers: linear between them, number
/// by number, and constant before and after them.
struct ObjectPath {
  ObjectTransform still;
  std::vector<TransformKey> keys;  ///< if there are any, they replace `still`

  ObjectTransform at(double frame) const;
};

struct GroomPlacement {
  std::optional<bool> y_up = {};  ///< y of the file becomes z, its z becomes -y; unset: from the file, else by guess_up
  bool guess_up = false;          ///< if y_up is unset: whether to judge by how the strands fall
  std::optional<double> cm_per_unit = {};        ///< unset: from the file, else usual_cm_per_unit
  std::optional<double> usual_cm_per_unit = {};  ///< unset: such that the longest side of the bounding box is 30 cm
  std::optional<double> radius_cm = {};          ///< unset: from the file, or 0.004 cm if its widths are not used
  WidthUse widths = {};
  std::optional<CurveKind> basis = {};  ///< for files that do not record it; unset: B-splines through root and tip
  bool strict = false;                  ///< whether data of the file that the picture does not show are an error
  bool normals = true;                  ///< whether the file's normals give the minor axes of its fibers
  bool colors = false;                  ///< whether strands have the colors of the file
  std::string attribute = {};           ///< the file's attribute for the color; empty: the format's own color
};

/// Whether y of the file is up, judged by how its strands fall: from root to tip they go down on average, hair by its
/// weight and fur by its comb. The mean over strands of (tip - root) over the strand's length must be below -0.1 along
/// y, and twice as far down as along z.
bool falls_along_y(const GroomFile& hair);

/// The strands of a groom that its file shares between instances.
struct FileInstances {
  /// By set of strands, instance and moment: from the coordinates of the groom's points, without Groom::origin, to the
  /// same, in cm and the axes of the world.
  std::vector<std::vector<std::vector<glm::dmat4>>> places = {};
  std::vector<std::uint32_t> set = {};  ///< per strand, rising where it is not 0: 0 drawn once, i + 1 at places[i]
};

/// Makes a groom. Choices are appended to `notes`, and omissions to `warnings`. A groom without strands is possible.
/// Fails if the placed groom leaves a world of 10^6 cm. Allocates only radii that the file does not have. instances: of
/// the file; if null, shared strands are where the first instance is.
Result<Groom> assemble_groom(GroomFile file, const GroomPlacement& placement, const std::string& name,
                             std::vector<std::string>* notes, std::vector<std::string>* warnings,
                             FileInstances* instances = nullptr);

/// Scales, turns and moves a groom in the world, at each of the shutter's moments, of which there is at least one. A
/// groom that rests starts to move if the transforms do. Fails if it leaves a world of 10^6 cm.
std::optional<Error> move_groom(std::span<const ObjectTransform> moments, Groom* groom);

/// Adds instances of a groom, each at each of the shutter's moments, of which there is at least one; an instance rests
/// if its places do not differ. Each is a rotation, a uniform scale > 0 and a translation, in cm, to coordinates from
/// which `origin` has been subtracted. Fails if one leaves a world of 10^6 cm.
std::optional<Error> add_instances(std::span<const std::vector<glm::dmat4>> instances, const glm::dvec3& origin,
                                   Groom* groom);

/// Scales, turns and moves a light in the world, at each of the shutter's moments, of which there is at least one; it
/// rests if the transforms do not differ. Radiance and cone angles stay. Fails if it leaves a world of 10^6 cm; `name`
/// and `place` are the scene file and the light for the message.
std::optional<Error> move_light(std::span<const ObjectTransform> moments, const std::string& name,
                                const std::string& place, Light* light);

/// Factors on the radius, linear in between, along the normalised length of the strand's points.
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
  Visibility visibility = {};
  bool holdout = false;  ///< the same as in Mesh
};

/// A mesh from its file at a moment of the shutter, and its placement then.
struct MeshAtMoment {
  const ObjFile* file;
  ObjectTransform transform;
};

/// Places the mesh in the world at each of the shutter's moments, of which there is at least one; the files must have
/// the same faces. It rests if neither files nor transforms differ. Triangles without area at the first moment are left
/// out, with a warning. Fails if the placed mesh leaves a world of 10^6 cm. `name` is the file.
Result<Mesh> place_mesh(std::span<const MeshAtMoment> moments, const MeshDescription& description,
                        const std::string& name, std::vector<std::string>* warnings);

}  // namespace tress::scene
