// The camera at a frame: still, placed to see all of the hair, between keyframes, or moving on a circle.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "tress/base/error.h"

namespace tress::scene {

struct CameraKey {
  int frame = 0;
  Camera camera;
};

/// Either the camera moves on a level circle around `look_at`, counter-clockwise from above, with frame 0 on the side
/// of -y. Or the hair and the meshes turn the other way round under a camera that stays at frame 0, so that a frame
/// shows the same side of them. Lights and the environment stay still either way.
struct Turntable {
  int frames = 1;                    ///< frames of one turn; frame numbers repeat after it
  bool turns_camera = false;         ///< otherwise the objects turn
  std::optional<glm::vec3> look_at;  ///< unset: the middle of the hair
  std::optional<float> distance_cm;  ///< from the axis; unset: so that all frames show all hair, from 8 degrees above
  float height_cm = 0;               ///< above look_at, with distance_cm
};

/// The sensor and lens, from which angles of view and depth of field follow.
struct Lens {
  enum class Fit { longer, width, height };
  float sensor_mm = 36;                  ///< width of the sensor along the side that fits
  Fit sensor_fit = Fit::longer;          ///< the side that fits
  std::optional<float> f_number;         ///< focal length over the diameter of the lens; or
  std::optional<float> radius_cm;        ///< radius of the lens; neither: a pinhole
  std::optional<float> focus_cm;         ///< distance along the view; or
  std::optional<glm::vec3> focus_point;  ///< a point that is sharp; neither: `look_at`
};

/// At most one of `framed`, `keys`, `turntable` is set; otherwise `camera` is used as it is.
struct CameraDescription {
  Camera camera;                ///< if framed or on a turntable, only its optics are used, not its place
  Lens lens;                    ///< camera_at() sets the members of the cameras that it determines
  bool framed = true;           ///< placed to see all grooms
  double turn_rad = 0;          ///< if framed: around the hair, counter-clockwise from above; 0: from -y
  std::vector<CameraKey> keys;  ///< in order of rising frame number
  std::optional<Turntable> turntable;
  Shutter shutter = {};
  std::optional<double> frames_per_second = {};  ///< for files that count in seconds; unset: the file's own
};

/// The camera at a frame. The eye, the point looked at, up and the angle of view are linear between keys and constant
/// before and after them. A fractional frame is a place between two frames. Without a frame it is that of the first
/// key, or 0. Fails if a camera between keys looks along its up or at its eye, if a focal length gives an angle of view
/// out of its range, or if the point in focus is not in front of the camera. `name` is the scene file for the message.
Result<Camera> camera_at(const CameraDescription& description, std::optional<double> frame,
                         const std::vector<Groom>& grooms, const Image& image, const std::string& name);

/// The camera at time [0, 1] of the shutter, linear between the cameras at its moments, of which there are at least
/// two.
Camera camera_during(const std::vector<Camera>& moments, float time);

/// The width of a pixel, cm, at the depth of a point in front of the camera; 0 for points beside the eye and behind it.
float pixel_cm_at(const Camera& camera, const Image& image, const glm::vec3& point);

/// The rotation of grooms and meshes in a frame.
ObjectTurn object_turn_at(const CameraDescription& description, std::optional<double> frame,
                          const std::vector<Groom>& grooms);

/// Turns points and normals of grooms and meshes, and the axes from which the root angles of the strands are counted:
/// by the first turn, and at the later moments of the shutter by the others. Objects that rest start to move if the
/// turns differ.
void turn_objects(std::span<const ObjectTurn> turns, std::vector<Groom>* grooms, std::vector<Mesh>* meshes);

/// The reason why a camera cannot see anything: it looks at its own eye, or along `up`. Empty if it can.
struct CameraFault {
  std::string key, expected, found;
};
std::optional<CameraFault> fault_of(const Camera& camera);

/// Places the camera at -y and slightly above, or at `turn_rad` counter-clockwise from -y, with the vertical angle of
/// view of `camera`, so that every framed point (framed_points.h) is inside the picture with a small margin. Without
/// points: `camera` as it is.
Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad = 0);

/// The same at a distance where every point stays inside while the camera moves around `look_at` (the middle of the
/// hair if unset) on a level circle. Without points: `camera` as it is.
Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at);

/// The middle of the bounding box of all framed points; empty without points.
std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms);

}  // namespace tress::scene
