// Cem Yuksel's .hair files (www.cemyuksel.com/research/hairmodels).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// Strands as the file has them: file units, file axes, degenerate ones included.
struct HairFile {
  std::vector<std::uint32_t> first_point;  ///< strand count + 1 entries
  std::vector<glm::vec3> points;           ///< finite
  std::vector<float> thickness;            ///< per point, a diameter in file units; empty: default_thickness
  float default_thickness = 0;
  std::vector<glm::vec3> color = {};  ///< per point, linear RGB in [0, 1]; empty: default_color
  glm::vec3 default_color{0.0f};      ///< as color
};

/// Parses the bytes of a .hair file. Every count is held against the number of bytes before memory is taken; points and
/// thicknesses must be finite. `name` is the file named in errors, which give the byte.
Result<HairFile> parse_hair_file(std::span<const unsigned char> bytes, const std::string& name);

}  // namespace tress::scene
