// Light from everywhere: a constant or a latitude-longitude map, importance sampled.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tress::scene {

/// Radiance by direction, world frame z up. Latitude-longitude maps: top row is +z; the centre column looks along
/// -y before rotation. Immutable after construction; any thread.
class Environment {
 public:
  /// Constant radiance, linear RGB, >= 0.
  explicit Environment(const glm::vec3& radiance = glm::vec3(1.0f));
  /// width*height pixels, row-major, top row first; finite, >= 0. rotate_rad turns the light about +z.
  Environment(int width, int height, std::vector<glm::vec3> pixels, double rotate_rad, float scale);

  struct Sample {
    glm::vec3 direction;  ///< unit, towards the light
    glm::vec3 radiance;
    float pdf_solid_angle;  ///< 1/sr; > 0
  };
  /// u1, u2 uniform in [0,1). Draws in proportion to luminance times solid angle (bilinear in nothing: per pixel).
  Sample sample(float u1, float u2) const;
  float pdf_solid_angle(const glm::vec3& direction) const;
  glm::vec3 radiance(const glm::vec3& direction) const;
  /// Mean radiance over the sphere.
  glm::vec3 mean() const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<glm::vec3> pixels_;
  std::vector<float> row_cdf_, column_cdf_;
  glm::vec3 mean_;
  double rotate_rad_ = 0;
};

}  // namespace tress::scene
