// The camera of a scene file, read and checked.
#pragma once

#include "scene/model/camera_motion.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

CameraDescription read_camera(const JsonReader& json);

}  // namespace tress::scene
