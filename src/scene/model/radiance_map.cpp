#include "scene/model/radiance_map.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/vector_double3.hpp>
#include <numbers>
#include <utility>

#include "base/arctangent.h"
#include "base/pi.h"

namespace tress::scene {
namespace {

/// 1 - cos, without cancellation at small angles.
double fall_of(double angle) { return 2 * std::sin(angle / 2) * std::sin(angle / 2); }

glm::vec3 mean_of(const glm::vec3* pixels, int count) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < count; ++i) sum += glm::dvec3(pixels[i]);
  return glm::vec3(sum / static_cast<double>(count));
}

std::vector<float> inverse_steps(const std::vector<double>& fall) {
  std::vector<float> inverse(fall.size() - 1, 0.0f);
  for (std::size_t row = 0; row < inverse.size(); ++row) {
    const double step = fall[row + 1] - fall[row];
    if (step > 0) inverse[row] = static_cast<float>(1 / step);
  }
  return inverse;
}

}  // namespace

RadianceMap::RadianceMap(int width, int height, const std::vector<glm::vec3>& pixels)
    : columns_(static_cast<std::size_t>(width)), even_(true) {
  const std::size_t rows = static_cast<std::size_t>(height);
  fall_.reserve(rows + 2);
  values_.reserve((rows + 2) * columns_);
  fall_.push_back(0);
  values_.assign(columns_, mean_of(pixels.data(), width));
  // The lower half is computed from the upper one: near -z only differences from 2 are exact.
  for (int row = 0; row < height; ++row) {
    const double down = pi * (row + 0.5) / height, up = pi * (height - row - 0.5) / height;
    fall_.push_back(2 * row < height ? fall_of(down) : 2 - fall_of(up));
  }
  values_.insert(values_.end(), pixels.begin(), pixels.end());
  fall_.push_back(2);
  values_.insert(values_.end(), columns_, mean_of(&pixels[(rows - 1) * columns_], width));
  inverse_step_ = inverse_steps(fall_);
}

RadianceMap::RadianceMap(std::vector<double> fall, std::vector<glm::vec3> values)
    : columns_(1), fall_(std::move(fall)), inverse_step_(inverse_steps(fall_)), values_(std::move(values)) {}

double RadianceMap::cell_solid_angle(std::size_t row) const {
  return 2 * pi / static_cast<double>(columns_) * (fall_[row + 1] - fall_[row]);
}

RadianceMap RadianceMap::scaled(float factor) const {
  RadianceMap other = *this;
  for (glm::vec3& value : other.values_) value *= factor;
  return other;
}

glm::vec3 RadianceMap::mean() const {
  glm::dvec3 mean(0.0);
  for (std::size_t row = 0; row < rows(); ++row) {
    glm::dvec3 color(0.0);  // over both rows of knots; each knot belongs to two cells
    for (std::size_t i = row * columns_; i < (row + 2) * columns_; ++i) color += 0.5 * glm::dvec3(values_[i]);
    mean += color * (cell_solid_angle(row) / (4 * pi));
  }
  return glm::vec3(mean);
}

/// The row of cells with fall_[row] <= fall < fall_[row + 1].
std::size_t RadianceMap::row_of(double fall, float angle_down) const {
  const std::size_t last = fall_.size() - 2;
  if (!even_) {
    const auto above = std::upper_bound(fall_.begin() + 1, fall_.end() - 1, fall);
    return static_cast<std::size_t>(above - fall_.begin()) - 1;
  }
  const float guess = angle_down * std::numbers::inv_pi_v<float> * static_cast<float>(last) + 0.5f;
  std::size_t row = std::min(static_cast<std::size_t>(std::max(guess, 0.0f)), last);
  while (row > 0 && fall < fall_[row]) --row;
  while (row < last && fall >= fall_[row + 1]) ++row;
  return row;
}

RadianceMap::Place RadianceMap::place(const glm::vec3& direction, float turn_rad) const {
  // 1 - |z| of a unit vector, without cancellation.
  const float flat2 = direction.x * direction.x + direction.y * direction.y;
  const double fall = direction.z >= 0 ? static_cast<double>(flat2 / (1 + direction.z))
                                       : 2 - static_cast<double>(flat2 / (1 - direction.z));
  const Float4 angles = angle_of(Float4{-direction.x, std::sqrt(flat2), 0, 0}, Float4{-direction.y, direction.z, 1, 1});
  Place place{};
  place.row = row_of(fall, angles[1]);
  place.down = std::clamp(static_cast<float>(fall - fall_[place.row]) * inverse_step_[place.row], 0.0f, 1.0f);
  if (columns_ == 1) return place;
  float turns = (angles[0] + turn_rad) * (0.5f * std::numbers::inv_pi_v<float>)+0.5f;
  turns -= std::floor(turns);
  const float column = turns * static_cast<float>(columns_) - 0.5f, left = std::floor(column);
  place.across = column - left;
  place.left = left < 0 ? columns_ - 1 : std::min(static_cast<std::size_t>(left), columns_ - 1);
  place.right = place.left + 1 < columns_ ? place.left + 1 : 0;
  return place;
}

double RadianceMap::azimuth(std::size_t column, double across) const {
  return 2 * pi * ((static_cast<double>(column) + 0.5 + across) / static_cast<double>(columns_) - 0.5);
}

RadianceMap::Place RadianceMap::cell(std::size_t row, std::size_t column) const {
  return {row, column, column + 1 < columns_ ? column + 1 : 0, 0, 0};
}

std::vector<glm::vec3> halved(int width, int height, const std::vector<glm::vec3>& pixels) {
  std::vector<glm::vec3> half;
  half.reserve(pixels.size() / 4);
  for (int row = 0; row < height; row += 2) {
    // Solid angles of the two rows: the sines of their middles, up to a common factor.
    const double above = std::sin(pi * (row + 0.5) / height), below = std::sin(pi * (row + 1.5) / height);
    const auto share = static_cast<float>(0.5 * above / (above + below));
    const glm::vec3* upper = &pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width)];
    const glm::vec3* lower = upper + width;
    for (int column = 0; column < width; column += 2)
      half.push_back(share * (upper[column] + upper[column + 1]) +
                     (0.5f - share) * (lower[column] + lower[column + 1]));
  }
  return half;
}

}  // namespace tress::scene
