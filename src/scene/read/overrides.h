// Settings of the command line that override a scene.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// An unset member leaves the scene's value. Units and ranges are those of the options of the same names
/// (parameters.cpp).
struct Overrides {
  std::vector<std::string> settings = {};  ///< texts for parse_setting(), set in the scene file before it is read
  std::optional<std::string> environment_file = {};  ///< replaces the environment, before `settings`
  std::optional<glm::vec3> color = {};
  std::optional<std::string> color_source = {};  ///< in place of `color`: a text for parse_color()
  std::optional<std::pair<float, float>> melanin = {};
  std::optional<glm::vec3> sigma_a = {};
  std::optional<std::string> hair = {};  ///< one of hair_color_names()
  std::optional<float> eccentricity = {}, roughness = {};
  std::optional<double> tilt_deg = {};     ///< tilt of the cuticle scales
  std::optional<double> light_scale = {};  ///< factor on the environment and every light
  std::optional<bool> y_up = {};
  std::optional<double> cm_per_unit = {};
  std::optional<std::string> widths = {};  ///< text for width_use_of()
  std::optional<double> radius_cm = {};
  bool strict = false;  ///< whether data of a file of strands that no picture shows are an error
  std::optional<int> width = {}, height = {}, samples = {};
  std::optional<int> frame = {};  ///< frame of everything that moves
};

/// The error if a caller set an option out of the range of its parameter; the command line has checked its own.
std::optional<Error> fault_of(const Overrides& overrides);

}  // namespace tress::scene
