// Light from everywhere: a constant or a map, importance sampled.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/model/radiance_map.h"

namespace tress::scene {

/// Radiance by direction, world frame z up. Latitude-longitude maps: top row is +z; the centre column looks along
/// -y before rotation; bilinear between the centres of the pixels, round the seam and over the poles (RadianceMap).
/// Immutable after construction; any thread.
class Environment {
 public:
  /// What is drawn in proportion to. light: luminance, so that grey light is drawn without noise. contrast: what is
  /// left of it above its mean, and 0.02 of the mean at least; for multiple importance sampling, where samples of the
  /// BCSDF meet the even light anyhow (Karlik et al. 2019, "MIS compensation"; measured in bench/README.md).
  enum class Draw { contrast, light };

  /// Constant radiance, linear RGB, >= 0.
  explicit Environment(const glm::vec3& radiance = glm::vec3(1.0f));
  /// width*height pixels, row-major, top row first; finite, >= 0. rotate_rad turns the light about +z.
  Environment(int width, int height, std::vector<glm::vec3> pixels, double rotate_rad, float scale);
  /// Finite, >= 0.
  explicit Environment(RadianceMap map);
  /// The same light, drawn otherwise.
  Environment drawn_by(Draw draw) const;
  /// Its light times a factor, finite, >= 0, drawn by contrast.
  Environment scaled(float factor) const;

  struct Sample {
    glm::vec3 direction;  ///< unit, towards the light
    glm::vec3 radiance;
    float pdf_solid_angle;  ///< 1/sr; > 0
  };
  /// u1, u2 uniform in [0,1). The density of a direction is the weight there over its integral, exactly; it is above 0
  /// wherever light comes from. The weight is bilinear between the knots of the map: what Draw makes of their
  /// luminance.
  Sample sample(float u1, float u2) const;

  /// What light comes from a direction (unit), and the density of sample() drawing it, 1/sr.
  struct Seen {
    glm::vec3 radiance;
    float pdf_solid_angle;
  };
  Seen look(const glm::vec3& direction) const;
  glm::vec3 radiance(const glm::vec3& direction) const;
  float pdf_solid_angle(const glm::vec3& direction) const { return look(direction).pdf_solid_angle; }
  /// The radiance as a pixel sees it that is `footprint_rad` wide, the distance between neighbours: of a map with finer
  /// pixels a copy whose own are half as wide as that, so that a picture with few samples has no grain of it.
  glm::vec3 backdrop(const glm::vec3& direction, float footprint_rad) const;
  /// Mean radiance over the sphere: that of the bilinear radiance.
  glm::vec3 mean() const { return mean_; }

 private:
  void accumulate(Draw draw);
  void make_guides();
  /// Of a knot, whose luminance it is made of.
  float weight(const glm::vec3& knot) const;
  /// Bilinear, as RadianceMap::at().
  float weight_at(const RadianceMap::Place& place) const;

  RadianceMap map_;                          ///< empty: constant
  std::vector<RadianceMap> coarser_;         ///< each of half as many pixels along both sides as the one before
  std::vector<double> row_cdf_;              ///< where the rows of cells begin, from 0, and 1
  std::vector<std::uint32_t> columns_;       ///< where the cells of each row begin, from 0, in 2^-32 of the row
  std::vector<std::uint32_t> row_guide_;     ///< the row that each of equal parts of [0, 1) begins in, and the last
  std::vector<std::uint32_t> column_guide_;  ///< likewise the columns of each row, one row after the other
  int column_guide_bits_ = 0;                ///< log2 of the parts of a row
  glm::vec3 mean_;
  float floor_ = 0;       ///< of the luminance, below it nothing is drawn but `least_`; >= 0
  float least_ = 0;       ///< weight, at least
  float per_weight_ = 0;  ///< density over weight, 1/sr; 0: nothing but black
  float rotate_rad_ = 0;
  float pixel_rad_ = 0;  ///< height of the pixels of a map; 0: it has none
};

}  // namespace tress::scene
