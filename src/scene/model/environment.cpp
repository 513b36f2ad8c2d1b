#include "scene/model/environment.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace tress::scene {
namespace {

constexpr double pi = std::numbers::pi;

double luminance(const glm::vec3& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

/// Solid angle of one pixel of a row, sr: exact, the difference of the cosines of its edges.
double pixel_solid_angle(int row, int width, int height) {
  return 2 * pi / width * (std::cos(pi * row / height) - std::cos(pi * (row + 1) / height));
}

/// Cumulative sums of n weights scaled to end at exactly 1; uniform where all are 0. n + 1 entries.
void accumulate(const double* weights, int n, float* cdf) {
  double total = 0;
  for (int i = 0; i < n; ++i) total += weights[i];
  double sum = 0;
  cdf[0] = 0;
  for (int i = 0; i < n; ++i) {
    sum += weights[i];
    cdf[i + 1] = static_cast<float>(total > 0 ? sum / total : (i + 1.0) / n);
  }
  cdf[n] = 1;
}

/// Bin of u in [0, 1) with a positive probability, and the position in it, [0, 1).
int find_bin(const float* cdf, int n, float u, float* within) {
  int bin = static_cast<int>(std::upper_bound(cdf, cdf + n + 1, u) - cdf) - 1;
  bin = std::clamp(bin, 0, n - 1);
  while (bin > 0 && cdf[bin + 1] <= cdf[bin]) --bin;
  const float mass = cdf[bin + 1] - cdf[bin];
  *within = mass > 0 ? std::clamp((u - cdf[bin]) / mass, 0.0f, 0x1.fffffep-1f) : 0.5f;
  return bin;
}

struct MapPlace {
  int row, column;
};

/// The pixel that `direction` (unit) looks at. Column 0 begins at azimuth -pi from the map's centre, -y; columns
/// grow to the right as seen from inside looking along -y with z up, that is towards -x.
MapPlace place_of(const glm::vec3& direction, double rotate_rad, int width, int height) {
  const double z = std::clamp(static_cast<double>(direction.z), -1.0, 1.0);
  const double down = std::atan2(std::hypot(direction.x, direction.y), z);
  const double azimuth = std::atan2(-direction.x, -direction.y) + rotate_rad;
  double turns = azimuth / (2 * pi) + 0.5;
  turns -= std::floor(turns);
  return {std::clamp(static_cast<int>(down / pi * height), 0, height - 1),
          std::clamp(static_cast<int>(turns * width), 0, width - 1)};
}

}  // namespace

Environment::Environment(const glm::vec3& radiance) : mean_(radiance) {}

Environment::Environment(int width, int height, std::vector<glm::vec3> pixels, double rotate_rad, float scale)
    : width_(width), height_(height), pixels_(std::move(pixels)), mean_(0.0f), rotate_rad_(rotate_rad) {
  row_cdf_.resize(static_cast<std::size_t>(height) + 1);
  column_cdf_.resize(static_cast<std::size_t>(height) * (static_cast<std::size_t>(width) + 1));
  std::vector<double> row_weights(static_cast<std::size_t>(height)), weights(static_cast<std::size_t>(width));
  double mean[3] = {0, 0, 0};
  for (int row = 0; row < height; ++row) {
    const double solid_angle = pixel_solid_angle(row, width, height);
    double row_weight = 0;
    for (int column = 0; column < width; ++column) {
      auto& pixel =
          pixels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
      pixel *= scale;
      weights[static_cast<std::size_t>(column)] = luminance(pixel);
      row_weight += luminance(pixel);
      for (int c = 0; c < 3; ++c) mean[c] += solid_angle / (4 * pi) * pixel[c];
    }
    accumulate(weights.data(), width,
               &column_cdf_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(width) + 1)]);
    // A black map is drawn uniformly over the sphere.
    row_weights[static_cast<std::size_t>(row)] = row_weight * solid_angle;
  }
  double total = 0;
  for (double w : row_weights) total += w;
  if (!(total > 0))
    for (int row = 0; row < height; ++row)
      row_weights[static_cast<std::size_t>(row)] = pixel_solid_angle(row, width, height);
  accumulate(row_weights.data(), height, row_cdf_.data());
  mean_ = glm::vec3(static_cast<float>(mean[0]), static_cast<float>(mean[1]), static_cast<float>(mean[2]));
}

Environment::Sample Environment::sample(float u1, float u2) const {
  double cos_down, azimuth;
  int row = 0, column = 0;
  if (pixels_.empty()) {
    cos_down = 1 - 2 * static_cast<double>(u1);
    azimuth = 2 * pi * (u2 - 0.5);
  } else {
    float in_row, in_column;
    row = find_bin(row_cdf_.data(), height_, u1, &in_row);
    const float* columns = &column_cdf_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(width_) + 1)];
    column = find_bin(columns, width_, u2, &in_column);
    const double top = std::cos(pi * row / height_), bottom = std::cos(pi * (row + 1) / height_);
    cos_down = top + (bottom - top) * in_row;
    azimuth = 2 * pi * ((column + static_cast<double>(in_column)) / width_ - 0.5) - rotate_rad_;
  }
  const double sin_down = std::sqrt(std::max(0.0, 1 - cos_down * cos_down));
  Sample sample;
  sample.direction = glm::vec3(static_cast<float>(-sin_down * std::sin(azimuth)),
                               static_cast<float>(-sin_down * std::cos(azimuth)), static_cast<float>(cos_down));
  // Looked up from the direction itself: float rounding at a pixel's edge cannot make sample and pdf disagree ...
  sample.radiance = radiance(sample.direction);
  sample.pdf_solid_angle = pdf_solid_angle(sample.direction);
  if (!(sample.pdf_solid_angle > 0)) {  // ... except across the edge to a pixel that is never drawn.
    const auto w = static_cast<std::size_t>(width_);
    const float* columns = &column_cdf_[static_cast<std::size_t>(row) * (w + 1)];
    const double mass =
        static_cast<double>(row_cdf_[static_cast<std::size_t>(row) + 1] - row_cdf_[static_cast<std::size_t>(row)]) *
        (columns[column + 1] - columns[column]);
    sample.radiance = pixels_[static_cast<std::size_t>(row) * w + static_cast<std::size_t>(column)];
    sample.pdf_solid_angle = static_cast<float>(mass / pixel_solid_angle(row, width_, height_));
  }
  return sample;
}

float Environment::pdf_solid_angle(const glm::vec3& direction) const {
  if (pixels_.empty()) return static_cast<float>(1 / (4 * pi));
  const auto place = place_of(direction, rotate_rad_, width_, height_);
  const auto row = static_cast<std::size_t>(place.row), column = static_cast<std::size_t>(place.column);
  const float* columns = &column_cdf_[row * (static_cast<std::size_t>(width_) + 1)];
  const double mass = (static_cast<double>(row_cdf_[row + 1]) - row_cdf_[row]) *
                      (static_cast<double>(columns[column + 1]) - columns[column]);
  return static_cast<float>(mass / pixel_solid_angle(place.row, width_, height_));
}

glm::vec3 Environment::radiance(const glm::vec3& direction) const {
  if (pixels_.empty()) return mean_;
  const auto place = place_of(direction, rotate_rad_, width_, height_);
  return pixels_[static_cast<std::size_t>(place.row) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(place.column)];
}

glm::vec3 Environment::mean() const { return mean_; }

}  // namespace tress::scene
