// Radiance over the sphere, between the centres of a map's pixels: places, bilinear values, coarser copies.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace tress::scene {

/// Radiance at knots, bilinear in between: in azimuth, and in `fall` = 1 - cos of the angle from +z. Both are uniform
/// in solid angle, so the integral over a cell between four knots is their mean times its solid angle. Continuous,
/// except where two rows of knots have the same fall. Immutable; any thread.
class RadianceMap {
 public:
  /// The knots around a direction: rows `row` and `row` + 1, columns `left` and `right`, and the position between them,
  /// [0, 1].
  struct Place {
    std::size_t row, left, right;
    float down, across;
  };

  RadianceMap() = default;
  /// The pixels of a latitude-longitude map, row-major, top row first. Knots are the centres of the pixels and the two
  /// poles; a pole has the mean of the row next to it.
  RadianceMap(int width, int height, const std::vector<glm::vec3>& pixels);
  /// One value for every azimuth. fall: rising from 0 to 2; two equal values make an edge.
  RadianceMap(std::vector<double> fall, std::vector<glm::vec3> values);

  /// Every value times the factor, >= 0.
  RadianceMap scaled(float factor) const;

  bool empty() const { return values_.empty(); }
  std::size_t columns() const { return columns_; }
  /// The number of rows of cells, one less than rows of knots.
  std::size_t rows() const { return fall_.size() - 1; }
  double fall(std::size_t knot_row) const { return fall_[knot_row]; }
  /// The mean over the sphere of the bilinear radiance.
  glm::vec3 mean() const;
  /// The solid angle of each cell of a row, sr.
  double cell_solid_angle(std::size_t row) const;

  /// The place of a unit direction; turn_rad is added to its azimuth. Column 0 begins at azimuth -pi from the map's
  /// centre, -y. Columns grow to the right, seen from inside looking along -y with z up, which is towards -x.
  Place place(const glm::vec3& direction, float turn_rad) const;
  /// The azimuth at `across` between the centres of a column and the next, before it was turned.
  double azimuth(std::size_t column, double across) const;
  Place cell(std::size_t row, std::size_t column) const;

  glm::vec3 at(const Place& place) const {
    const glm::vec3 *above = &values_[place.row * columns_], *below = above + columns_;
    const glm::vec3 top = above[place.left] + place.across * (above[place.right] - above[place.left]);
    const glm::vec3 bottom = below[place.left] + place.across * (below[place.right] - below[place.left]);
    return top + place.down * (bottom - top);
  }
  /// The value at a knot.
  const glm::vec3& value(std::size_t knot_row, std::size_t column) const {
    return values_[knot_row * columns_ + column];
  }

 private:
  std::size_t row_of(double fall, float angle_down) const;

  std::size_t columns_ = 0;
  bool even_ = false;                ///< whether rows are those of a latitude-longitude map
  std::vector<double> fall_;         ///< fall of each row of knots
  std::vector<float> inverse_step_;  ///< 1 / (difference of the falls) of each row of cells; 0 at an edge
  std::vector<glm::vec3> values_;    ///< row-major
};

/// Halves the number of pixels along both sides, which must be even: means by solid angle.
std::vector<glm::vec3> halved(int width, int height, const std::vector<glm::vec3>& pixels);

}  // namespace tress::scene
