// A scene in memory, as the renderer draws it. load_scene() makes it; every value is in range.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/ext/vector_uint3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/pi.h"
#include "image/view_transform.h"
#include "scene/model/absorption.h"
#include "scene/model/environment.h"
#include "scene/model/instance.h"
#include "scene/model/shutter.h"
#include "scene/model/source.h"
#include "scene/model/texture.h"
#include "tress/fiber/parameters.h"

namespace tress::scene {

/// A camera in a right-handed world: z up, centimetres.
struct Camera {
  glm::vec3 eye{0, -60, 0};
  glm::vec3 look_at{0, 0, 0};
  glm::vec3 up{0, 0, 1};
  float vertical_fov_deg = 30;
  /// > 0: replaces the angle of view, with the sensor of CameraDescription. In a loaded scene it matches the angle.
  float focal_length_mm = 0;
  float orthographic_height_cm = 0;  ///< > 0: the rays are parallel, and the picture is as high as this
  float shift_x = 0, shift_y = 0;    ///< offset of the view from `look_at`: picture widths to the right, heights up
  float lens_radius_cm = 0;          ///< > 0: depth of field; for a polygon, radius of its corners
  float focus_cm = 0;                ///< with a lens, > 0: distance along the view from the eye to what is sharp
  int blades = 0;                    ///< number of corners of the lens, at least 3; 0: round
  float blade_rotation_rad = 0;      ///< counter-clockwise as seen behind the focus; 0: a corner to the right
};

struct Image {
  int width = 512, height = 512;
  int samples = 64;
  double exposure_stops = 0;                 ///< exposure of the preview
  image::View view = image::View::standard;  ///< view transform of the preview
  /// Strands that the camera sees thinner than this many pixels are drawn that wide, with less presence in the same
  /// proportion; 0: none.
  float least_width_px = 0;
  float curve_error_px = 0.1f;  ///< largest distance of straight pieces from their curve, pixels, > 0
  bool transparent = false;     ///< whether beauty leaves out the background; else Scene::environment_visible decides
};

/// What a scene says of how light is followed (integrate::set_asked()). Texts are choices of the table of parameters.
struct Integrator {
  std::optional<int> max_depth, light_samples, bcsdf_samples;
  std::optional<std::string> roulette, deep_light;
  std::optional<int> deep_light_depth;
  std::optional<std::string> near;  ///< a choice, or else `near_pixels`
  std::optional<float> near_pixels;
  std::optional<bool> adaptive;
  bool spectral = false;  ///< light, colors and absorptions are in bands (base/bands.h); the picture is not

  bool learns_deep_light() const { return deep_light == "learned"; }
};

/// The differences of strands of one material: half ranges of uniform deviations with mean 0 (strand_fibers.h).
struct StrandVariation {
  float eccentricity = 0;  ///< absolute
  float width = 0;         ///< relative: one factor for the roughness and every given width
  float color = 0;         ///< relative: one factor for the absorption of every channel
  std::uint64_t seed = 0;
};

/// An absorption that varies.
struct Pigment {
  Source source;
  Absorption sigma_a;  ///< of a value of the source
  /// The color of a dye over it, whose absorption adds to it; unset: none.
  std::optional<Source> dye = {};
  Absorption dye_sigma_a = {};  ///< of the dye's color; set if there is a dye

  /// The absorption at a place.
  glm::vec3 at(const StrandPlace& place, const fiber::FiberParameters& fiber) const {
    const glm::vec3 own = sigma_a(source.at(place), fiber);
    return dye ? own + dye_sigma_a(dye->at(place), fiber) : own;
  }
};

/// The numbers of a fiber, besides its roughness, that sources may replace.
enum class FiberNumber : std::uint8_t {
  eccentricity,  ///< by strand only, because it is the strand's shape too
  tilt,          ///< radians
  medulla_radius,
  medulla_scattering,
  medulla_asymmetry,
  medulla_absorption,
  cortex_scattering,
  cortex_asymmetry,
  wetness
};
constexpr std::size_t fiber_numbers = 9;

struct Material {
  std::string name = "brown";
  bool spectral = false;  ///< Integrator::spectral
  fiber::FiberParameters fiber;
  /// The curl diameter (cm) that determines how the major axis turns along the strand; unset: that of the eccentricity.
  std::optional<double> curl_diameter_cm;
  bool twist = true;  ///< if false, the major axis stays in the rotation-minimising frame
  StrandVariation variation;
  std::optional<glm::vec3> color;   ///< the lock's color, linear RGB, for which fiber.sigma_a was chosen
  std::optional<Pigment> pigment;   ///< replaces the fiber's sigma_a
  std::optional<Source> roughness;  ///< replaces the fiber's, which is its middle; given widths follow it
  std::array<std::optional<Source>, fiber_numbers> numbers;  ///< by FiberNumber: replace the fiber's, their middles
  /// Factors of the fiber's gain by lobe, each a number and a color.
  std::array<std::optional<Source>, fiber::lobe_count> gain, tint;
  std::optional<Source> presence;   ///< the probability that a ray hits a segment on its way, [0, 1]; unset: 1
  std::optional<Source> thickness;  ///< factor, >= 0, on the radii of the strands' points; unset: 1
  /// Whether the widths are those of a node's round fiber (`principled`, `chiang_hair_bsdf`), whose ranges are wider:
  /// widths of strands that leave their range are clamped. The roughness, which is almost smooth, does not vary with
  /// them.
  bool has_node_widths = false;
  std::vector<std::string> left_out;     ///< keys of its description that fibers have no counterpart of
  std::optional<double> root_angle_rad;  ///< major axis at the root; unset: from a hash of the strand
};

/// A number of a material that its key alone gives. read_material() reads every row of `material_numbers`, so that a
/// new one is its row in parameters.cpp, its member in Material and its row here.
struct MaterialNumber {
  const char* key;
  std::variant<std::optional<double> Material::*, std::optional<Source> Material::*> member;  ///< a Source may vary
  double unit = 1;  ///< one of the key in units of the member
};
inline constexpr MaterialNumber material_numbers[] = {{"presence", &Material::presence},
                                                      {"thickness", &Material::thickness},
                                                      {"curl_diameter_cm", &Material::curl_diameter_cm},
                                                      {"root_angle_deg", &Material::root_angle_rad, degree}};

/// Calls visit(source) for each source of a material, const or not.
template <class SomeMaterial, class Visit>
void for_each_source(SomeMaterial& material, Visit&& visit) {
  if (material.pigment) visit(material.pigment->source);
  if (material.pigment && material.pigment->dye) visit(*material.pigment->dye);
  if (material.roughness) visit(*material.roughness);
  for (auto* sources : {&material.gain, &material.tint})
    for (auto& source : *sources)
      if (source) visit(*source);
  for (auto& number : material.numbers)
    if (number) visit(*number);
  for (const MaterialNumber& number : material_numbers)
    if (const auto* source = std::get_if<std::optional<Source> Material::*>(&number.member))
      if (material.**source) visit(*(material.**source));
}

/// The attributes that a material uses, each once.
std::vector<std::string> attributes_of(const Material& material);

/// Position, shape and radiance of a light besides the environment.
struct LightShape {
  enum class Kind { distant, sphere, rectangle, spot };
  Kind kind = Kind::distant;
  glm::vec3 radiance{1.0f};        ///< linear RGB, >= 0, equal wherever it shines; spot: on its axis
  glm::vec3 direction{0, 0, 1};    ///< unit; distant: towards the light; spot: the direction in which it shines
  float half_angle_rad = 0.0047f;  ///< distant: angular radius, (0, pi/2]
  glm::vec3 center{0, 0, 0};       ///< sphere, spot, rectangle: cm
  float radius_cm = 1;             ///< sphere, spot: > 0
  /// spot: 1 - cos of two angles to the axis: it is full up to `core` and dark from `cone` on; core <= cone.
  float core = 0, cone = 1;
  /// rectangle: half edges, cm, orthogonal, not 0; it shines towards edge_u x edge_v.
  glm::vec3 edge_u{1, 0, 0}, edge_v{0, 1, 0};

  bool is_ball() const { return kind == Kind::sphere || kind == Kind::spot; }
};

/// Objects by their names in mattes: those of the list, or all but those of the list.
struct ObjectList {
  bool is_only = false;  ///< whether it has those of the list
  std::vector<std::string> names = {};

  bool has(const std::string& object) const { return (std::ranges::find(names, object) != names.end()) == is_only; }
};

/// The objects that a light illuminates, and those that block it.
struct LightLinks {
  ObjectList lit = {}, blocking = {};
};

/// Which rays meet an object: those of the camera, those from a hit to a light, and those that a hit scatters.
struct Visibility {
  bool camera = true, shadow = true, indirect = true;
};

/// A light of a scene. Rays that leave a fiber or a surface see it; the camera sees it if it is `visible`.
struct Light : LightShape {
  bool visible = false;  ///< whether the camera sees it, from the side to which it shines
  std::string group;     ///< the layer for its light; empty: none
  LightLinks links = {};
  /// The light at the later moments of the shutter, of the same kind; the light itself is at its opening. Empty if it
  /// does not move.
  std::vector<LightShape> later = {};
};

constexpr std::uint32_t no_normal = 0xffffffffu, no_uv = no_normal;

/// A clear rough layer over a diffuse surface.
struct CoatParameters {
  float roughness = 0.3f;  ///< (0, 1]; the width of the GGX distribution is the square of it
  float eta = 1.5f;        ///< index of refraction, (1, 2.5]
};

/// A mesh at a later moment of the shutter.
struct MeshMoment {
  std::vector<glm::vec3> positions;  ///< as many as in the mesh
  std::vector<glm::vec3> normals;    ///< as many as in the mesh
};

/// Triangles that occlude: a two-sided diffuse surface, with or without a coat.
struct Mesh {
  std::string name;
  std::string object;                 ///< its name in mattes
  std::vector<glm::vec3> positions;   ///< cm
  std::vector<glm::uvec3> triangles;  ///< indices into positions, in range
  glm::vec3 albedo{0.18f};            ///< linear RGB, [0, 1]
  std::vector<glm::vec3> normals;     ///< unit, or 0 if the file has no valid one
  /// Per triangle, for its corners: indices into normals, or no_normal. Empty: all triangles are flat.
  std::vector<glm::uvec3> corner_normals;
  std::optional<Texture> texture;      ///< replaces `albedo`
  std::vector<glm::vec2> uvs;          ///< finite
  std::vector<glm::uvec3> corner_uvs;  ///< the same for uvs, or no_uv; a triangle with one has the texture's mean
  std::optional<CoatParameters> coat;
  Visibility visibility = {};
  bool holdout = false;  ///< whether the camera sees nothing in its place: black, alpha 0
  /// The later moments after `positions`, which are at the shutter's opening; empty if it does not move.
  std::vector<MeshMoment> later = {};
};

/// The meaning of the points of a strand.
enum class StrandBasis : std::uint8_t {
  bspline,  ///< control points of a uniform cubic B-spline through root and tip, with reflected ends
  linear,   ///< the strand is straight between them
  /// control points of a uniform cubic B-spline: n of them for n - 3 segments, so it does not pass through the first
  /// one
  open_bspline,
  bezier  ///< control points of cubic Bezier segments that share their ends: 3 n + 1 of them for n segments
};

/// Strands at a later moment of the shutter.
struct StrandMoment {
  std::vector<glm::vec3> points;      ///< cm, as many as in the groom
  glm::dmat3 turned{1.0};             ///< rotation of the whole since the first moment: major axes turn with it
  std::vector<float> radius_cm = {};  ///< the same as Groom::radius_cm; empty: those of the groom
};

/// How the points of a strand form segments, each one cubic or one straight piece. There are (points - spare) /
/// points_a_segment of them, and the first one begins at the point `first`. Places on a strand are counted in segments
/// from its root.
struct StrandSegments {
  std::uint32_t first, points_a_segment, spare;

  explicit constexpr StrandSegments(StrandBasis basis)
      : first(basis == StrandBasis::open_bspline ? 1 : 0),
        points_a_segment(basis == StrandBasis::bezier ? 3 : 1),
        spare(basis == StrandBasis::open_bspline ? 3 : 1) {}
  constexpr std::uint32_t count(std::uint32_t points) const { return (points - spare) / points_a_segment; }
};

/// A fiber that hits at a place may have: those whose number in [0, 1) is not below from / 65536, up to the next
/// choice.
struct FiberChoice {
  std::uint16_t from;
  std::uint16_t fiber;  ///< index into Scene::fibers

  friend bool operator==(const FiberChoice&, const FiberChoice&) = default;
};

/// Strands of one material. Strand s has the points [first_point[s], first_point[s+1]), root first: at least two
/// distinct ones, and as many as the basis needs.
struct Groom {
  std::string name;
  std::string object;  ///< its name in mattes
  Visibility visibility = {};
  /// The copies of the groom that the scene has, which share its strands; points, radii and minor axes are theirs
  /// before they are placed. Empty: the groom itself, whose points are in the scene's coordinates.
  std::vector<Instance> instances = {};
  std::uint32_t first_instance = 0;  ///< the number of its first instance in mattes, of those of its object
  std::uint32_t material = 0;
  /// The fibers of hits, per strand, or per station if strands vary along their length (station_at()): as many choices
  /// for each, in ascending order, the last one repeated. If choices_a_station is 0, there is one choice for all.
  std::vector<FiberChoice> choices = {};
  std::uint32_t choices_a_station = 0;
  /// The number of equal parts into which stations divide each segment of a strand; root and tip are stations too. 0:
  /// strands do not vary along their length.
  std::uint32_t stations_a_segment = 0;
  /// The probability that a ray which comes to the strand hits it, [0, 1]: per strand, or per station if it varies
  /// along strands, with presence_stations per segment. Empty: 1 everywhere. Look it up by presence_at().
  std::vector<float> presence;
  std::uint32_t presence_stations = 0;
  std::vector<std::uint32_t> first_point;  ///< strand_count + 1 entries
  std::vector<glm::vec3> points;           ///< cm
  glm::dvec3 origin{0.0};                  ///< cm: has been subtracted from points that are not yet placed; else 0
  std::vector<float> radius_cm;            ///< per point: radius of the circle with the same mean projected width
  /// The attribute of the file that its material uses, in [0, 1], linear RGB if it is a color: per point if it differs
  /// along a strand, else per strand. Empty unless its material uses one.
  std::vector<glm::vec3> color;
  std::vector<std::int64_t> id = {};    ///< per strand, from the file; empty: by their index
  std::vector<glm::vec2> root_uv = {};  ///< per strand, from the file or generated, or empty
  /// Per point: the file's direction of the minor axis of the cross-section, unit, or 0 if it has none; interpolated as
  /// the points are. Empty: axes are the material's.
  std::vector<glm::vec3> minor_axis = {};
  StrandBasis basis = StrandBasis::bspline;
  double turned_rad = 0;  ///< rotation about the vertical so far: root angles are counted from axes that turn with it
  /// The later moments after `points`, which are at the shutter's opening; empty if it does not move.
  std::vector<StrandMoment> later = {};
  bool is_animated = false;  ///< whether its file has samples of other frames
  /// The file's id of a strand, or its index if the file has none.
  std::int64_t strand_id(std::uint32_t strand) const { return id.empty() ? std::int64_t{strand} : id[strand]; }
  std::uint32_t strand_count() const { return first_point.empty() ? 0 : std::uint32_t(first_point.size() - 1); }
  /// How often the scene has the groom's strands.
  std::size_t times() const { return instances.empty() ? 1 : instances.size(); }
  /// Returns the transform from the groom's coordinates to the scene's when the shutter opens. i < times().
  Similarity place(std::size_t i) const { return instances.empty() ? Similarity{} : instances[i].first; }
  /// The first station of a strand; for the strand after the last, the number of all stations.
  std::size_t first_station(std::uint32_t strand) const { return first_of(strand, stations_a_segment); }
  /// The number of a station: a place on a strand, in segments from its root. u in [0, 1] chooses between the two
  /// stations around the place; if it is uniform, the nearer one is more likely.
  std::size_t station_at(std::uint32_t strand, float place, float u) const {
    if (stations_a_segment == 0) return strand;
    const float along = place * static_cast<float>(stations_a_segment), whole = std::floor(along);
    const std::size_t station = first_station(strand) + static_cast<std::size_t>(whole) + (u < along - whole ? 1 : 0);
    return std::min(station, first_station(strand + 1) - 1);
  }
  /// Index into Scene::fibers for a hit at a strand or station. u in [0, 1) rounds what varies; the means over uniform
  /// u are the values of the station.
  std::uint32_t fiber_at(std::size_t station, float u) const {
    if (choices_a_station == 0) return choices.front().fiber;
    const auto of_hit = static_cast<std::uint32_t>(65536 * u);
    const FiberChoice* first = &choices[station * choices_a_station];
    std::uint32_t choice = choices_a_station - 1;
    while (first[choice].from > of_hit) --choice;
    return first[choice].fiber;
  }
  /// The presence at a place, linear between stations, if `presence` is not empty. place: in segments from the root.
  float presence_at(std::uint32_t strand, float place) const {
    if (presence_stations == 0) return presence[strand];
    const float along = place * static_cast<float>(presence_stations), whole = std::floor(along);
    const std::size_t last = first_of(strand + 1, presence_stations) - 1,
                      at = std::min(first_of(strand, presence_stations) + static_cast<std::size_t>(whole), last);
    const float share = along - whole;
    return (1 - share) * presence[at] + share * presence[std::min(at + 1, last)];
  }

 private:
  std::size_t first_of(std::uint32_t strand, std::uint32_t stations) const {
    const StrandSegments segments(basis);
    const std::size_t before = first_point[strand] - std::size_t{segments.spare} * strand;
    return before / segments.points_a_segment * stations + strand;
  }
};

/// The rotation of grooms and meshes on a turntable: about the vertical through `pivot`, counter-clockwise from above.
struct ObjectTurn {
  double turn_rad = 0;  ///< 0: no rotation
  glm::vec3 pivot{0.0f};

  /// The position of a point after the turn.
  glm::dvec3 of(const glm::dvec3& point) const;
};

/// The changes of a moving scene from this frame to the next.
struct NextFrame {
  Camera camera;
  ObjectTurn turn = {};              ///< from this frame to the next
  std::vector<Camera> moments = {};  ///< the same as Scene::camera_moments
  double environment_turn_rad = 0;   ///< rotation of the environment from this frame to the next
};

struct Scene {
  std::string source;  ///< the file that it was loaded from
  /// The point of the world, cm, from which all places of the scene are counted: 0 unless the camera is far from 0,
  /// where floats are coarser than hair.
  glm::dvec3 origin{0.0};
  Camera camera;  ///< at the frame, independent of the shutter
  Shutter shutter;
  std::vector<Camera> camera_moments;  ///< at the moments of the shutter; empty if it does not move
  std::optional<NextFrame> next;       ///< set in every frame of a scene that has keyframes or a turntable
  Image image;
  Integrator integrator;
  Environment environment;
  /// The rotation of the environment at each moment of the shutter since its opening, counter-clockwise from above;
  /// empty if it does not turn.
  std::vector<float> environment_turns_rad;
  bool environment_visible = true;  ///< whether it is behind the hair (background layer), or black
  std::string environment_group;    ///< the same as Light::group
  LightLinks environment_links;     ///< the same as Light::links
  std::vector<Light> lights;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  /// The distinct fibers of all hits: the materials' own, varied and rounded (strand_fibers.h).
  std::vector<fiber::FiberParameters> fibers;
  std::vector<Groom> grooms;
  std::vector<std::string> notes;     ///< for stderr: chosen units, framing
  std::vector<std::string> warnings;  ///< degenerate strands and their number, and the like
};

/// A mark for each object of a scene: grooms, then meshes, in their order. Empty if none is marked.
using ObjectMarks = std::vector<std::uint8_t>;
constexpr std::uint32_t no_object = 0xffffffffu;

/// Marks the grooms and meshes for which is_marked(object) is true.
template <class Rule>
ObjectMarks marked_objects(const Scene& scene, Rule&& is_marked) {
  ObjectMarks marks;
  for (const Groom& groom : scene.grooms) marks.push_back(is_marked(groom) ? 1 : 0);
  for (const Mesh& mesh : scene.meshes) marks.push_back(is_marked(mesh) ? 1 : 0);
  if (std::ranges::find(marks, 1) == marks.end()) marks.clear();
  return marks;
}

}  // namespace tress::scene
