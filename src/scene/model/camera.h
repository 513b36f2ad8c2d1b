// Where the camera is at a frame: still, placed so that it sees all of the hair, between keyframes, or going around.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "tress/base/error.h"

namespace tress::scene {

struct CameraKey {
  int frame = 0;
  Camera camera;
};

/// A level circle around `look_at`, counter-clockwise from above; frame 0 is on the side of -y.
struct Turntable {
  int frames = 1;                    ///< of one turn; frame numbers repeat after them
  std::optional<glm::vec3> look_at;  ///< unset: the middle of the hair
  std::optional<float> distance_cm;  ///< from the axis; unset: all hair is seen in every frame, from 8 degrees above
  float height_cm = 0;               ///< above look_at, with distance_cm
};

/// At most one of `framed`, `keys`, `turntable`; else `camera` as it is.
struct CameraDescription {
  Camera camera;                ///< only its angle of view where it is framed or goes around
  bool framed = true;           ///< placed to see all grooms
  double turn_rad = 0;          ///< where it is framed: about the hair, counter-clockwise from above; 0: from -y
  std::vector<CameraKey> keys;  ///< by rising frame number
  std::optional<Turntable> turntable;
};

/// The eye, the point looked at, up and the angle of view are linear between keys and hold before and after them.
/// Without a frame: that of the first key, or 0. Fails where a camera between keys looks along its up or at its eye;
/// `name` is the scene file of the message.
Result<Camera> camera_at(const CameraDescription& description, std::optional<int> frame,
                         const std::vector<Groom>& grooms, const Image& image, const std::string& name);

/// What keeps the camera from seeing anything: looks at its own eye, or along `up`. Nothing where it can.
struct CameraFault {
  std::string key, expected, found;
};
std::optional<CameraFault> fault_of(const Camera& camera);

/// From -y and slightly above, or from `turn_rad` counter-clockwise of -y, at the vertical angle of view of `camera`,
/// every point inside the picture with a small margin. Without points: `camera` as it is.
Camera frame_grooms(const std::vector<Groom>& grooms, const Image& image, const Camera& camera, double turn_rad = 0);

/// The same from a distance at which every point stays inside while the camera goes around `look_at` (the middle of the
/// hair where unset) on a level circle. Without points: `camera` as it is.
Camera frame_grooms_all_round(const std::vector<Groom>& grooms, const Image& image, const Camera& camera,
                              const std::optional<glm::vec3>& look_at);

/// Middle of the bounding box of all points; nothing without any.
std::optional<glm::vec3> middle_of(const std::vector<Groom>& grooms);

}  // namespace tress::scene
