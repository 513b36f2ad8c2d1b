// What the command line sets over a scene.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <utility>

#include "image/view_transform.h"
#include "tress/base/error.h"

namespace tress::scene {

/// Unset: as the scene has it. Units and ranges are those of the options of the same names (parameters.cpp).
struct Overrides {
  std::optional<std::string> environment_file = {};
  std::optional<double> environment_rotate_deg = {};
  std::optional<glm::vec3> color = {};
  std::optional<std::pair<float, float>> melanin = {};
  std::optional<glm::vec3> sigma_a = {};
  std::optional<std::string> hair = {};  ///< of hair_color_names()
  std::optional<float> eccentricity = {}, roughness = {};
  std::optional<double> tilt_deg = {};     ///< of the cuticle scales
  std::optional<double> light_scale = {};  ///< of the environment and every light
  std::optional<bool> y_up = {};
  std::optional<double> cm_per_unit = {};
  std::optional<std::string> widths = {};  ///< width_use_of()
  std::optional<double> radius_cm = {};
  bool strict = false;  ///< what a file of strands has and no picture shows is an error
  std::optional<int> width = {}, height = {}, samples = {};
  std::optional<bool> transparent = {};
  std::optional<double> exposure_stops = {};
  std::optional<image::View> view = {};
  std::optional<int> frame = {};                          ///< of what moves
  std::optional<std::pair<double, double>> shutter = {};  ///< when it opens and closes, frames from that one on
  std::optional<int> motion_samples = {};
  std::optional<double> frames_per_second = {};
  std::optional<double> turn_deg = {};  ///< of a camera that is placed to see the hair
};

/// Of an option that a caller gave a value out of the range of its parameter; the command line has checked them.
std::optional<Error> fault_of(const Overrides& overrides);

}  // namespace tress::scene
