// Where the camera is at a frame: still, placed so that it sees all of the hair, between keyframes, or going around.
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

/// The camera on a level circle around `look_at`, counter-clockwise from above, frame 0 on the side of -y; or the hair
/// and the meshes the other way round under a camera that stands at frame 0, so that a frame shows the same side of
/// them. Lights and the environment stand still either way.
struct Turntable {
  int frames = 1;                    ///< of one turn; frame numbers repeat after them
  bool turns_camera = false;         ///< else the objects
  std::optional<glm::vec3> look_at;  ///< unset: the middle of the hair
  std::optional<float> distance_cm;  ///< from the axis; unset: all hair is seen in every frame, from 8 degrees above
  float height_cm = 0;               ///< above look_at, with distance_cm
};

/// What makes angles of focal lengths, and a lens.
struct Lens {
  enum class Fit { longer, width, height };
  float sensor_mm = 36;                  ///< what the side of the picture spans that fits
  Fit sensor_fit = Fit::longer;          ///< which side that is
  std::optional<float> f_number;         ///< focal length over the diameter of the lens; or
  std::optional<float> radius_cm;        ///< that of the lens; neither: a pinhole
  std::optional<float> focus_cm;         ///< along the view; or
  std::optional<glm::vec3> focus_point;  ///< a point that is sharp; neither: that of `look_at`
};

/// At most one of `framed`, `keys`, `turntable`; else `camera` as it is.
struct CameraDescription {
  Camera camera;                ///< only how it looks, not where, where it is framed or goes around
  Lens lens;                    ///< the members of the cameras that it determines are set by camera_at()
  bool framed = true;           ///< placed to see all grooms
  double turn_rad = 0;          ///< where it is framed: about the hair, counter-clockwise from above; 0: from -y
  std::vector<CameraKey> keys;  ///< by rising frame number
  std::optional<Turntable> turntable;
  Shutter shutter = {};
  std::optional<double> frames_per_second = {};  ///< of files that count in seconds; unset: as they say
};

/// The eye, the point looked at, up and the angle of view are linear between keys and hold before and after them.
/// Between two frames it is where it is on its way from one to the other.
/// Without a frame: that of the first key, or 0. Fails where a camera between keys looks along its up or at its eye, a
/// focal length gives an angle of view out of its range, or the point in focus is not before the camera; `name` is the
/// scene file of the message.
Result<Camera> camera_at(const CameraDescription& description, std::optional<double> frame,
                         const std::vector<Groom>& grooms, const Image& image, const std::string& name);

/// At time [0, 1] of the shutter, of the cameras at its moments, at least two: linear from each to the next.
Camera camera_during(const std::vector<Camera>& moments, float time);

/// How far grooms and meshes are turned in a frame.
ObjectTurn object_turn_at(const CameraDescription& description, std::optional<double> frame,
                          const std::vector<Groom>& grooms);

/// Turns points and normals of grooms and meshes, and the axes that the root angles of the strands are counted from, by
/// the first turn and at the later moments of the shutter by the others; objects that rest move where turns differ.
void turn_objects(std::span<const ObjectTurn> turns, std::vector<Groom>* grooms, std::vector<Mesh>* meshes);

/// What keeps the camera from seeing anything: looks at its own eye, or along `up`. Nothing where it can.
struct CameraFault {
  std::string key, expected, found;
};
std::optional<CameraFault> fault_of(const Camera& camera);

/// From -y and slightly above, or from `turn_rad` counter-clockwise of -y, at the vertical angle of view of `camera`,
/// every framed point (framed_points.h) inside the picture with a small margin. Without points: `camera` as it is.
Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad = 0);

/// The same from a distance at which every one stays inside while the camera goes around `look_at` (the middle of the
/// hair where unset) on a level circle. Without points: `camera` as it is.
Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at);

/// Middle of the bounding box of all framed points; nothing without any.
std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms);

}  // namespace tress::scene
