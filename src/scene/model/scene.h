// A scene in memory: what the renderer draws. Made by load_scene(); every value in range.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/ext/vector_uint3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/view_transform.h"
#include "scene/model/environment.h"
#include "scene/model/source.h"
#include "scene/model/texture.h"
#include "tress/fiber/parameters.h"

namespace tress::scene {

/// Right-handed world, z up, centimetres.
struct Camera {
  glm::vec3 eye{0, -60, 0};
  glm::vec3 look_at{0, 0, 0};
  glm::vec3 up{0, 0, 1};
  float vertical_fov_deg = 30;
  /// > 0: in place of the angle of view, with the sensor of CameraDescription; of a loaded scene that of the angle.
  float focal_length_mm = 0;
  float orthographic_height_cm = 0;  ///< > 0: the rays are parallel, the picture is as high as this
  float shift_x = 0, shift_y = 0;    ///< of the view past `look_at`: picture widths to the right, heights up
  float lens_radius_cm = 0;          ///< > 0: depth of field; of a polygon: of its corners
  float focus_cm = 0;                ///< with a lens, > 0: from the eye to what is sharp, along the view
  int blades = 0;                    ///< corners of the lens, at least 3; 0: round
  float blade_rotation_rad = 0;  ///< counter-clockwise as what is behind the focus shows it; 0: a corner to the right
};

/// While the shutter is open light falls on the picture: frames from that of the picture on, negative before it. What
/// moves is known at `samples` moments, evenly spaced from its opening to its closing, and goes straight in between.
struct Shutter {
  double open = 0, close = 0;  ///< open <= close
  int samples = 2;             ///< >= 2
  bool is_open() const { return close > open; }
  /// Frames from that of the picture to one of the moments.
  double moment(int sample) const { return open + (close - open) * sample / (samples - 1); }
};

/// Between which two of evenly spaced moments of the shutter a time of it is, and how far from the first of them.
struct BetweenMoments {
  std::size_t before;
  float share;  ///< [0, 1] of the way to the next; 0 of one moment
  /// time: [0, 1], from the opening of the shutter to its closing. moments >= 1.
  BetweenMoments(float time, std::size_t moments) {
    const float along = time * static_cast<float>(moments - 1);
    before = std::min(static_cast<std::size_t>(along), moments < 2 ? 0 : moments - 2);
    share = along - static_cast<float>(before);
  }
};

struct Image {
  int width = 512, height = 512;
  int samples = 64;
  double exposure_stops = 0;                 ///< of the preview
  image::View view = image::View::standard;  ///< of the preview
  bool transparent = false;  ///< beauty without what is behind the hair; else as Scene::environment_visible has it
};

/// How strands of one material differ: half ranges, uniform, of mean 0 (strand_fibers.h).
struct StrandVariation {
  float eccentricity = 0;  ///< absolute
  float width = 0;         ///< relative, one factor for the roughness and every given width
  float color = 0;         ///< relative, one factor for the absorption of every channel
  std::uint64_t seed = 0;
};

/// An absorption that varies.
struct Pigment {
  Source source;
  /// What a value of the source makes of the fiber: its absorption, per major semi-axis.
  std::function<glm::vec3(const glm::vec3& value, const fiber::FiberParameters& fiber)> sigma_a;
};

struct Material {
  std::string name = "brown";
  fiber::FiberParameters fiber;
  /// Turns of the major axis along the strand follow the curl diameter of the eccentricity, unless given here (cm).
  std::optional<double> curl_diameter_cm;
  bool twist = true;  ///< false: the major axis stays in the rotation-minimising frame
  StrandVariation variation;
  std::optional<glm::vec3> color;   ///< that a lock should show, which fiber.sigma_a was chosen for; linear RGB
  std::optional<Pigment> pigment;   ///< instead of the fiber's sigma_a
  std::optional<Source> roughness;  ///< instead of the fiber's, which is its middle; widths that are given follow
  /// Widths are of a node's round fiber (`principled`, `chiang_hair_bsdf`), whose ranges are wider: those of strands
  /// that leave theirs are taken for the nearest. The roughness, all but smooth, has no part in how they vary.
  bool has_node_widths = false;
  std::optional<double> root_angle_rad;  ///< major axis at the root; unset: by a hash of the strand
};

/// Calls visit(source) for what varies of a material, const or not.
template <class SomeMaterial, class Visit>
void for_each_source(SomeMaterial& material, Visit&& visit) {
  if (material.pigment) visit(material.pigment->source);
  if (material.roughness) visit(*material.roughness);
}

/// The attributes that a material is made of, each once.
std::vector<std::string> attributes_of(const Material& material);

/// Where light beside the environment comes from, and how much.
struct LightShape {
  enum class Kind { distant, sphere, rectangle, spot };
  Kind kind = Kind::distant;
  glm::vec3 radiance{1.0f};        ///< linear RGB, >= 0, the same in all directions it shines into; spot: on its axis
  glm::vec3 direction{0, 0, 1};    ///< unit; distant: towards the light; spot: where it shines to
  float half_angle_rad = 0.0047f;  ///< distant: angular radius, (0, pi/2]
  glm::vec3 center{0, 0, 0};       ///< sphere, spot, rectangle: cm
  float radius_cm = 1;             ///< sphere, spot: > 0
  /// spot: 1 - cos of the angles to the axis up to which it is full and from which on it is dark, core <= cone.
  float core = 0, cone = 1;
  /// rectangle: half edges, cm, orthogonal, not 0; shines towards edge_u x edge_v.
  glm::vec3 edge_u{1, 0, 0}, edge_v{0, 1, 0};

  bool is_ball() const { return kind == Kind::sphere || kind == Kind::spot; }
};

/// A light of a scene. Seen by rays that leave a fiber or a surface, by the camera where it is `visible`.
struct Light : LightShape {
  bool visible = false;  ///< to the camera, from the side that it shines to
  std::string group;     ///< layer of its light; empty: none of its own
  /// At the later moments of the shutter, of the same kind; the light itself is at its opening. Empty: it rests.
  std::vector<LightShape> later = {};
};

constexpr std::uint32_t no_normal = 0xffffffffu, no_uv = no_normal;

/// A clear rough layer over a diffuse surface.
struct CoatParameters {
  float roughness = 0.3f;  ///< (0, 1]; the width of the GGX distribution is its square
  float eta = 1.5f;        ///< index of refraction, (1, 2.5]
};

/// Where a mesh is at a later moment of the shutter.
struct MeshMoment {
  std::vector<glm::vec3> positions;  ///< as many as of the mesh
  std::vector<glm::vec3> normals;    ///< likewise
};

/// Triangles that occlude: a diffuse surface, coated or not, seen from both sides.
struct Mesh {
  std::string name;
  std::string object;                 ///< its name in mattes
  std::vector<glm::vec3> positions;   ///< cm
  std::vector<glm::uvec3> triangles;  ///< indices into positions, in range
  glm::vec3 albedo{0.18f};            ///< linear RGB, [0, 1]
  std::vector<glm::vec3> normals;     ///< unit, or 0 where the file has none that can be used
  /// Per triangle, of its corners: indices into normals, or no_normal. Empty: all triangles are flat.
  std::vector<glm::uvec3> corner_normals;
  std::optional<Texture> texture;      ///< in place of `albedo`
  std::vector<glm::vec2> uvs;          ///< finite
  std::vector<glm::uvec3> corner_uvs;  ///< the same for uvs, or no_uv; a triangle with one has the texture's mean
  std::optional<CoatParameters> coat;
  bool visible = true;   ///< to the camera; all other rays meet it
  bool holdout = false;  ///< the camera sees nothing where it is: black, alpha 0
  /// After `positions`, which are those of the shutter's opening; empty: it rests.
  std::vector<MeshMoment> later = {};
};

/// What the points of a strand are.
enum class StrandBasis : std::uint8_t {
  bspline,  ///< control points of a uniform cubic B-spline that goes through root and tip, its ends reflected
  linear,   ///< the strand is straight from one to the next
  /// control points of a uniform cubic B-spline: n of them for n - 3 segments, so that it begins beside the first one
  open_bspline,
  bezier  ///< control points of cubic Bezier segments that share their ends: 3 n + 1 of them for n segments
};

/// Where strands are at a later moment of the shutter.
struct StrandMoment {
  std::vector<glm::vec3> points;      ///< cm, as many as of the groom
  glm::dmat3 turned{1.0};             ///< how the whole has turned since the first moment: major axes turn with it
  std::vector<float> radius_cm = {};  ///< as Groom::radius_cm; empty: those of the groom
};

/// How the points of a strand make segments, one cubic or one straight piece each: (points - spare) / points_a_segment
/// of them, the first of which begins at the point `first`. Places on a strand are counted in segments from its root.
struct StrandSegments {
  std::uint32_t first, points_a_segment, spare;

  explicit constexpr StrandSegments(StrandBasis basis)
      : first(basis == StrandBasis::open_bspline ? 1 : 0),
        points_a_segment(basis == StrandBasis::bezier ? 3 : 1),
        spare(basis == StrandBasis::open_bspline ? 3 : 1) {}
  constexpr std::uint32_t count(std::uint32_t points) const { return (points - spare) / points_a_segment; }
};

/// Strands of one material. Strand s has the points [first_point[s], first_point[s+1]), root first, at least two
/// distinct ones, as many as the basis needs.
struct Groom {
  std::string name;
  std::string object;  ///< its name in mattes
  std::uint32_t material = 0;
  /// Per strand, or of strands that vary along their length per station: index into Scene::fibers. Look it up by
  /// fiber_at().
  std::vector<std::uint32_t> fiber;
  /// Stations divide each segment of a strand into so many equal parts, and stand at the root and the tip too. 0:
  /// strands do not vary along their length.
  std::uint32_t stations_a_segment = 0;
  std::vector<std::uint32_t> first_point;  ///< strand_count + 1 entries
  std::vector<glm::vec3> points;           ///< cm
  std::vector<float> radius_cm;            ///< per point: of the circle with the same mean projected width
  /// The attribute of the file that its material takes, in [0, 1], linear RGB where it is a color: per point where it
  /// differs along a strand, else per strand; empty unless its material takes one.
  std::vector<glm::vec3> color;
  std::vector<std::int64_t> id = {};    ///< per strand, as the file calls them; empty: by their index
  std::vector<glm::vec2> root_uv = {};  ///< per strand, as the file has it, or empty
  /// Per point, unit, along the minor axis of the cross-section as the file says it, or 0 where it says none;
  /// interpolated as the points are. Empty: axes are the material's.
  std::vector<glm::vec3> minor_axis = {};
  StrandBasis basis = StrandBasis::bspline;
  double turned_rad = 0;  ///< about the vertical since it was made: root angles are counted from axes that turn with it
  /// After `points`, which are those of the shutter's opening; empty: it rests.
  std::vector<StrandMoment> later = {};
  bool is_animated = false;  ///< its file has samples of other frames
  std::uint32_t strand_count() const { return first_point.empty() ? 0 : std::uint32_t(first_point.size() - 1); }
  /// Of a strand; for the strand after the last the number of all stations.
  std::size_t first_station(std::uint32_t strand) const {
    const StrandSegments segments(basis);
    const std::size_t before = first_point[strand] - std::size_t{segments.spare} * strand;
    return before / segments.points_a_segment * stations_a_segment + strand;
  }
  /// Index into Scene::fibers of a strand at a place, in segments from its root. u: in [0, 1]; where it is uniform,
  /// each of the two stations around the place counts by how near it is.
  std::uint32_t fiber_at(std::uint32_t strand, float place, float u) const {
    if (stations_a_segment == 0) return fiber[strand];
    const float along = place * static_cast<float>(stations_a_segment), whole = std::floor(along);
    const std::size_t station = first_station(strand) + static_cast<std::size_t>(whole) + (u < along - whole ? 1 : 0);
    return fiber[std::min(station, first_station(strand + 1) - 1)];
  }
};

/// What turns on a turntable: grooms and meshes, about the vertical through `pivot`, counter-clockwise from above.
struct ObjectTurn {
  double turn_rad = 0;  ///< 0: nothing turns
  glm::vec3 pivot{0.0f};

  /// Where a point is after the turn.
  glm::dvec3 of(const glm::dvec3& point) const;
};

/// What differs in the frame after this one of a scene that moves.
struct NextFrame {
  Camera camera;
  ObjectTurn turn = {};              ///< from this frame to that
  std::vector<Camera> moments = {};  ///< as Scene::camera_moments
  double environment_turn_rad = 0;   ///< of the environment, from this frame to that
};

struct Scene {
  std::string source;  ///< what it was loaded from
  Camera camera;       ///< at the frame, whenever the shutter opens
  Shutter shutter;
  std::vector<Camera> camera_moments;  ///< at those of the shutter; empty: it rests
  std::optional<NextFrame> next;       ///< in every frame of a scene that has keyframes or a turntable
  Image image;
  Environment environment;
  /// How far the environment has turned at each moment of the shutter since it opened, counter-clockwise from above;
  /// empty: it rests.
  std::vector<float> environment_turns_rad;
  bool environment_visible = true;  ///< shown behind the hair (background layer) or black there
  std::string environment_group;    ///< as Light::group
  std::vector<Light> lights;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  /// The distinct fibers of all strands: the materials' own, varied and quantised per strand (design section 5).
  std::vector<fiber::FiberParameters> fibers;
  std::vector<Groom> grooms;
  std::vector<std::string> notes;     ///< said on stderr: chosen units, framing
  std::vector<std::string> warnings;  ///< degenerate strands and their number, ...
};

}  // namespace tress::scene
