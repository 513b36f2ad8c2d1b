// A scene in memory: what the renderer draws. Made by load_scene(); every value in range.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/environment.h"
#include "tress/adaptive/error.h"
#include "tress/fiber/parameters.h"

namespace tress::scene {

/// Right-handed world, z up, centimetres.
struct Camera {
  glm::vec3 eye{0, -60, 0};
  glm::vec3 look_at{0, 0, 0};
  glm::vec3 up{0, 0, 1};
  float vertical_fov_deg = 30;
};

struct Image {
  int width = 512, height = 512;
  int samples = 64;
};

struct Material {
  std::string name = "brown";
  fiber::FiberParameters fiber;
  /// Turns of the major axis along the strand follow the curl diameter of the eccentricity, unless given here (cm).
  std::optional<double> curl_diameter_cm;
  bool twist = true;                     ///< false: the major axis stays in the rotation-minimising frame
  std::optional<double> root_angle_rad;  ///< major axis at the root; unset: by a hash of the strand
};

/// Strands of one material. Strand s has the points [first_point[s], first_point[s+1]), root first, at least two
/// distinct ones.
struct Groom {
  std::string name;
  std::uint32_t material = 0;
  std::vector<std::uint32_t> first_point;  ///< strand_count + 1 entries
  std::vector<glm::vec3> points;           ///< cm
  std::vector<float> radius_cm;            ///< per point: of the circle with the same mean projected width
  std::uint32_t strand_count() const { return first_point.empty() ? 0 : std::uint32_t(first_point.size() - 1); }
};

struct Scene {
  std::string source;  ///< what it was loaded from
  Camera camera;
  Image image;
  Environment environment;
  bool environment_visible = true;  ///< shown behind the hair (background layer) or black there
  std::vector<Material> materials;
  std::vector<Groom> grooms;
  std::vector<std::string> notes;     ///< said on stderr: chosen units, framing
  std::vector<std::string> warnings;  ///< degenerate strands and their number, ...
};

/// What the command line sets over the scene.
struct Overrides {
  std::optional<std::string> environment_file;
  std::optional<double> environment_rotate_deg;
  std::optional<glm::vec3> color;
  std::optional<std::pair<float, float>> melanin;
  std::optional<glm::vec3> sigma_a;
  std::optional<float> eccentricity, roughness;
  std::optional<bool> y_up;
  std::optional<double> cm_per_unit;
  std::optional<int> width, height, samples;
};

/// A scene JSON file, or a bare .hair file. Errors name the file and the JSON path or byte.
Result<Scene> load_scene(const std::filesystem::path& file, const Overrides& overrides = {});

}  // namespace tress::scene
