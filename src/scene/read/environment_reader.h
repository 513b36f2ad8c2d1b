// The environment of a scene file, read and checked but with nothing loaded yet.
#pragma once

#include <optional>
#include <string>

#include "scene/generate/generated_environments.h"
#include "scene/model/scene.h"
#include "scene/read/json_reader.h"

namespace tress::scene {

struct EnvironmentDescription {
  enum class Kind { studio, constant, file, sky } kind = Kind::studio;
  std::string file;  ///< as written
  glm::vec3 constant{1.0f};
  GradientSky sky;
  std::optional<Light> sun;  ///< of the sky: distant, before rotation and scale
  double rotate_deg = 0;
  float scale = 1;
};

EnvironmentDescription read_environment(const JsonReader& json);

/// The sun as a light of the scene: turned and scaled with its sky.
std::optional<Light> sun_of(const EnvironmentDescription& environment);

}  // namespace tress::scene
