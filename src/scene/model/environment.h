// Light from all directions: a constant or a map, importance sampled.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/model/radiance_map.h"

namespace tress::scene {

/// Radiance by direction; the world frame has z up. Latitude-longitude maps: the top row is +z, and the centre column
/// looks along -y before rotation. Bilinear between the centres of the pixels, across the seam and over the poles
/// (RadianceMap). Immutable after construction; any thread.
class Environment {
 public:
  /// The weight by which directions are drawn. light: luminance, so that grey light has no noise. contrast: the part of
  /// it above its mean, but at least 0.02 of the mean. It serves multiple importance sampling, where samples of the
  /// BCSDF find the even light anyway (Karlik et al. 2019, "MIS compensation"; measured in bench/README.md).
  enum class Draw { contrast, light };

  /// Constant radiance, linear RGB, >= 0.
  explicit Environment(const glm::vec3& radiance = glm::vec3(1.0f));
  /// width*height pixels, row-major, top row first; finite, >= 0. rotate_rad turns the light about +z.
  Environment(int width, int height, std::vector<glm::vec3> pixels, double rotate_rad, float scale);
  /// The map's values must be finite and >= 0.
  explicit Environment(RadianceMap map);
  /// The same light with another weight for drawing.
  Environment drawn_by(Draw draw) const;
  /// The light times a factor, finite and >= 0, drawn by contrast.
  Environment scaled(float factor) const;

  struct Sample {
    glm::vec3 direction;  ///< unit, towards the light
    glm::vec3 radiance;
    float pdf_solid_angle;  ///< 1/sr; > 0
  };
  /// Draws a direction; u1, u2 uniform in [0,1). Its density is exactly the weight there over the weight's integral,
  /// and is above 0 wherever light comes from. The weight is bilinear between the knots of the map, where Draw computes
  /// it from the luminance.
  Sample sample(float u1, float u2) const;

  /// The light from a direction (unit), and the density with which sample() draws it, 1/sr.
  struct Seen {
    glm::vec3 radiance;
    float pdf_solid_angle;
  };
  Seen look(const glm::vec3& direction) const;
  glm::vec3 radiance(const glm::vec3& direction) const;
  float pdf_solid_angle(const glm::vec3& direction) const { return look(direction).pdf_solid_angle; }
  /// The radiance for a pixel that is `footprint_rad` wide, the distance between neighbours. For a map with finer
  /// pixels it reads a copy whose pixels are half as wide as that, so that a picture with few samples shows no grain.
  glm::vec3 backdrop(const glm::vec3& direction, float footprint_rad) const;
  /// Mean of the bilinear radiance over the sphere.
  glm::vec3 mean() const { return mean_; }

 private:
  void accumulate(Draw draw);
  void make_guides();
  /// The weight at a knot, from its luminance.
  float weight(const glm::vec3& knot) const;
  /// The weight at a place, bilinear as in RadianceMap::at().
  float weight_at(const RadianceMap::Place& place) const;

  RadianceMap map_;                          ///< empty: constant
  std::vector<RadianceMap> coarser_;         ///< each has half as many pixels along both sides as the one before
  std::vector<double> row_cdf_;              ///< the beginning of each row of cells, from 0, and then 1
  std::vector<std::uint32_t> columns_;       ///< the beginning of the cells of each row, from 0, in 2^-32 of the row
  std::vector<std::uint32_t> row_guide_;     ///< the row where each of equal parts of [0, 1) begins, and the last
  std::vector<std::uint32_t> column_guide_;  ///< the same for the columns of each row, one row after the other
  int column_guide_bits_ = 0;                ///< log2 of the number of parts of a row
  glm::vec3 mean_;
  float floor_ = 0;       ///< luminance below which only `least_` is drawn; >= 0
  float least_ = 0;       ///< least weight
  float per_weight_ = 0;  ///< density over weight, 1/sr; 0 if all is black
  float rotate_rad_ = 0;
  float pixel_rad_ = 0;  ///< height of the pixels of a map; 0 without a map
};

}  // namespace tress::scene
