#include "scene/model/environment.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/ext/vector_double3.hpp>
#include <limits>
#include <utility>

#include "base/color.h"
#include "base/pi.h"

namespace tress::scene {
namespace {

constexpr float everywhere = static_cast<float>(1 / (4 * pi));  ///< density of a uniform direction
constexpr int narrowest = 8;                                    ///< least number of columns of the coarsest copy
constexpr float least_share = 0.02f;                            ///< least weight over the mean, with Draw::contrast

/// Draws x in [0, 1] with density proportional to (1 - x) at_0 + x at_1, both >= 0.
double draw_linear(double at_0, double at_1, double u) {
  const double root = std::sqrt(at_0 * at_0 + u * (at_1 * at_1 - at_0 * at_0));
  return at_0 + root > 0 ? std::min(1.0, u * (at_0 + at_1) / (at_0 + root)) : u;
}

double mix(double a, double b, double x) { return a + x * (b - a); }

/// Returns 2^32 times the share, below 2^32.
std::uint32_t fixed_point(double share) {
  return static_cast<std::uint32_t>(std::min(std::round(share * 0x1p32), 0x1p32 - 1));
}

/// The last of `count` cells that begins at `key` or below, searched between the first and the last candidate.
template <class Key>
std::size_t cell_of(const Key* begins, std::uint32_t first, std::uint32_t last, Key key) {
  return static_cast<std::size_t>(std::upper_bound(begins + first + 1, begins + last + 1, key) - begins) - 1;
}

constexpr std::size_t cells_a_part = 8;  ///< mean number of cells in a part of a row

std::vector<RadianceMap> coarser_maps(int width, int height, std::vector<glm::vec3> pixels) {
  std::vector<RadianceMap> maps;
  while (width % 2 == 0 && height % 2 == 0 && width > narrowest) {
    pixels = halved(width, height, pixels);
    width /= 2;
    height /= 2;
    maps.emplace_back(width, height, pixels);
  }
  return maps;
}

}  // namespace

Environment::Environment(const glm::vec3& radiance) : mean_(radiance) {}

Environment::Environment(int width, int height, std::vector<glm::vec3> pixels, double rotate_rad, float scale)
    : mean_(0.0f), rotate_rad_(static_cast<float>(std::remainder(rotate_rad, 2 * pi))) {
  for (glm::vec3& pixel : pixels) pixel *= scale;
  map_ = RadianceMap(width, height, pixels);
  pixel_rad_ = static_cast<float>(pi / height);
  coarser_ = coarser_maps(width, height, std::move(pixels));
  accumulate(Draw::contrast);
}

Environment::Environment(RadianceMap map) : map_(std::move(map)), mean_(0.0f) { accumulate(Draw::contrast); }

Environment Environment::drawn_by(Draw draw) const {
  Environment other = *this;
  if (!map_.empty()) other.accumulate(draw);
  return other;
}

Environment Environment::scaled(float factor) const {
  Environment other = *this;
  other.mean_ *= factor;
  other.map_ = map_.scaled(factor);
  for (RadianceMap& map : other.coarser_) map = map.scaled(factor);
  if (!map_.empty()) other.accumulate(Draw::contrast);
  return other;
}

float Environment::weight(const glm::vec3& knot) const { return std::max(luminance(knot) - floor_, least_); }

float Environment::weight_at(const RadianceMap::Place& place) const {
  const float top_left = weight(map_.value(place.row, place.left));
  const float bottom_left = weight(map_.value(place.row + 1, place.left));
  const float top = top_left + place.across * (weight(map_.value(place.row, place.right)) - top_left);
  const float bottom = bottom_left + place.across * (weight(map_.value(place.row + 1, place.right)) - bottom_left);
  return top + place.down * (bottom - top);
}

/// Computes the mean, and sums over the cells: where each begins, and the density.
void Environment::accumulate(Draw draw) {
  const std::size_t rows = map_.rows(), columns = map_.columns();
  row_cdf_.assign(rows + 1, 0);
  columns_.assign(rows * columns, 0);
  std::vector<double> begins(columns);
  mean_ = map_.mean();
  floor_ = draw == Draw::contrast ? luminance(mean_) : 0;
  least_ = draw == Draw::contrast ? least_share * luminance(mean_) : 0;
  for (std::size_t row = 0; row < rows; ++row) {
    double sum = 0;
    for (std::size_t column = 0; column < columns; ++column) {
      begins[column] = sum;
      const RadianceMap::Place cell = map_.cell(row, column);
      for (const std::size_t knot_row : {row, row + 1})
        for (const std::size_t knot : {cell.left, cell.right})
          sum += 0.25 * static_cast<double>(weight(map_.value(knot_row, knot)));
    }
    if (sum > 0)
      for (std::size_t column = 0; column < columns; ++column)
        columns_[row * columns + column] = fixed_point(begins[column] / sum);
    row_cdf_[row + 1] = row_cdf_[row] + sum * map_.cell_solid_angle(row);
  }
  const double total = row_cdf_[rows];
  per_weight_ = 0;
  if (!(total > 0)) return;
  for (double& share : row_cdf_) share /= total;
  per_weight_ = static_cast<float>(1 / total);
  make_guides();
}

/// Makes tables of starting points, so that a search reads a few neighbouring cells instead of a dozen all over the
/// row.
void Environment::make_guides() {
  const std::size_t rows = map_.rows(), columns = map_.columns(), row_parts = std::bit_ceil(rows);
  const auto last_row = static_cast<std::uint32_t>(rows - 1), last_column = static_cast<std::uint32_t>(columns - 1);
  row_guide_.assign(row_parts + 1, last_row);
  for (std::size_t part = 0; part < row_parts; ++part) {
    const double from = static_cast<double>(part) / static_cast<double>(row_parts);
    row_guide_[part] = static_cast<std::uint32_t>(cell_of(row_cdf_.data(), 0, last_row, from));
  }
  column_guide_bits_ = std::bit_width(std::bit_ceil((columns + cells_a_part - 1) / cells_a_part)) - 1;
  const std::size_t parts = std::size_t{1} << column_guide_bits_;
  column_guide_.assign(rows * (parts + 1), last_column);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint32_t* begins = &columns_[row * columns];
    std::uint32_t* guide = &column_guide_[row * (parts + 1)];
    for (std::size_t part = 0; part < parts; ++part) {
      const auto from = static_cast<std::uint32_t>(std::uint64_t{part} << (32 - column_guide_bits_));
      guide[part] = static_cast<std::uint32_t>(cell_of(begins, 0, last_column, from));
    }
  }
}

Environment::Sample Environment::sample(float u1, float u2) const {
  if (!(per_weight_ > 0)) {  // constant or black: uniform over the sphere
    const double fall = 2 * static_cast<double>(u1), azimuth = 2 * pi * (u2 - 0.5);
    const double flat = std::sqrt(std::max(0.0, fall * (2 - fall)));
    return {glm::vec3(-flat * std::sin(azimuth), -flat * std::cos(azimuth), 1 - fall), mean_, everywhere};
  }
  // Choose a cell with positive probability; the rest of the random numbers gives the place in it.
  const auto row_part = static_cast<std::size_t>(u1 * static_cast<float>(row_guide_.size() - 1));
  const std::size_t row =
      cell_of(row_cdf_.data(), row_guide_[row_part], row_guide_[row_part + 1], static_cast<double>(u1));
  const double in_row = std::clamp((u1 - row_cdf_[row]) / (row_cdf_[row + 1] - row_cdf_[row]), 0.0, 1.0);
  const std::size_t columns = map_.columns();
  const std::uint32_t* begins = &columns_[row * columns];
  const auto key = static_cast<std::uint32_t>(static_cast<double>(u2) * 0x1p32);
  const std::uint32_t* guide = &column_guide_[row * ((std::size_t{1} << column_guide_bits_) + 1) +
                                              (std::uint64_t{key} >> (32 - column_guide_bits_))];
  const std::size_t column = cell_of(begins, guide[0], guide[1], key);
  const double begin = begins[column], end = column + 1 < columns ? begins[column + 1] : 0x1p32;
  const double in_column = (key - begin) / (end - begin);

  RadianceMap::Place place = map_.cell(row, column);
  const double top_left = weight(map_.value(row, place.left)), top_right = weight(map_.value(row, place.right));
  const double bottom_left = weight(map_.value(row + 1, place.left));
  const double bottom_right = weight(map_.value(row + 1, place.right));
  const double down = draw_linear(top_left + top_right, bottom_left + bottom_right, in_row);
  const double across = draw_linear(mix(top_left, bottom_left, down), mix(top_right, bottom_right, down), in_column);
  place.down = static_cast<float>(down);
  place.across = static_cast<float>(across);

  const double fall = mix(map_.fall(row), map_.fall(row + 1), down);
  const double flat = std::sqrt(std::max(0.0, fall * (2 - fall)));
  const double azimuth = map_.azimuth(column, columns > 1 ? across : in_column) - static_cast<double>(rotate_rad_);
  Sample sample{};
  sample.direction = glm::vec3(-flat * std::sin(azimuth), -flat * std::cos(azimuth), 1 - fall);
  sample.radiance = map_.at(place);
  // With Draw::light no cell ends at the edge of its light except by rounding, and no light comes from there.
  sample.pdf_solid_angle = std::max(weight_at(place) * per_weight_, std::numeric_limits<float>::min());
  return sample;
}

Environment::Seen Environment::look(const glm::vec3& direction) const {
  if (map_.empty()) return {mean_, everywhere};
  const RadianceMap::Place place = map_.place(direction, rotate_rad_);
  return {map_.at(place), per_weight_ > 0 ? weight_at(place) * per_weight_ : everywhere};
}

glm::vec3 Environment::radiance(const glm::vec3& direction) const {
  return map_.empty() ? mean_ : map_.at(map_.place(direction, rotate_rad_));
}

glm::vec3 Environment::backdrop(const glm::vec3& direction, float footprint_rad) const {
  if (coarser_.empty() || !(footprint_rad > 2 * pixel_rad_)) return radiance(direction);
  const auto coarsest = static_cast<float>(coarser_.size());
  const float level = std::min(std::log2(footprint_rad / (2 * pixel_rad_)), coarsest);
  const auto finer = static_cast<std::size_t>(level), next = std::min(finer + 1, coarser_.size());
  const auto at = [&](std::size_t i) {
    const RadianceMap& map = i == 0 ? map_ : coarser_[i - 1];
    return map.at(map.place(direction, rotate_rad_));
  };
  const glm::vec3 fine = at(finer);
  return fine + (level - static_cast<float>(finer)) * (at(next) - fine);
}

}  // namespace tress::scene
