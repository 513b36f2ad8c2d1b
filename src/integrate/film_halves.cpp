// The two independent half pictures of a film, with the variance of each.
#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <limits>
#include <string>
#include <utility>

#include "integrate/film.h"

namespace tress::integrate {
namespace {

/// Sums over the paths of one half of a pixel.
struct Half {
  glm::dvec3 sum{0.0};
  double count = 0;
};

Half half_of(const PixelSums& pixel, bool odd, Ground ground) {
  if (odd) return {pixel.odd_beauty, static_cast<double>(pixel.odd_samples)};
  return {pixel.beauty(ground) - pixel.odd_beauty, static_cast<double>(pixel.samples - pixel.odd_samples)};
}

/// Sum of squared deviations from the common mean of two samples, beyond the deviations from their own means (Chan,
/// Golub and LeVeque 1979).
glm::dvec3 between(const Half& a, const Half& b) {
  if (!(a.count > 0) || !(b.count > 0)) return glm::dvec3(0.0);
  const glm::dvec3 apart = a.sum / a.count - b.sum / b.count;
  return apart * apart * (a.count * b.count / (a.count + b.count));
}

}  // namespace

void Film::add_to_halves(std::size_t index, const PixelSums& before) {
  const PixelSums& after = pixels_[index];
  const bool odd = after.odd_samples > before.odd_samples;
  const Half then = half_of(before, odd, ground_), now = half_of(after, odd, ground_);
  (odd ? halves_[index].odd : halves_[index].even) += between(then, {now.sum - then.sum, 1});
}

void Film::add_halves(std::size_t index, const Film& later, std::size_t later_index) {
  const PixelSums &mine = pixels_[index], &other = later.pixels_[later_index];
  const HalfSquares& added = later.halves_[later_index];
  halves_[index].even += added.even + between(half_of(mine, false, ground_), half_of(other, false, ground_));
  halves_[index].odd += added.odd + between(half_of(mine, true, ground_), half_of(other, true, ground_));
}

void Film::add_half_channels(const std::vector<std::size_t>& source, image::Picture* picture) const {
  if (halves_.empty()) return;
  const glm::dvec3 most(static_cast<double>(std::numeric_limits<float>::max()));
  std::array<std::array<std::vector<float>, 3>, half_layers.size()> channels;
  for (auto& layer : channels)
    for (std::vector<float>& pixels : layer) pixels.resize(pixels_.size(), 0.0f);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (source[i] == no_pixel) continue;
    const PixelSums& pixel = pixels_[source[i]];
    for (const bool odd : {false, true}) {
      const Half own = half_of(pixel, odd, ground_), half = own.count > 0 ? own : half_of(pixel, !odd, ground_);
      const glm::dvec3 mean = glm::clamp(half.sum / half.count, -most, most);
      const glm::dvec3& squares = odd ? halves_[source[i]].odd : halves_[source[i]].even;
      const double degrees = own.count * (own.count - 1);
      const glm::dvec3 variance = degrees > 0 ? glm::min(squares / degrees, most) : glm::dvec3(0.0);
      for (std::size_t c = 0; c < 3; ++c) {
        channels[odd ? 1 : 0][c][i] = static_cast<float>(mean[static_cast<int>(c)]);
        channels[odd ? 3 : 2][c][i] = static_cast<float>(variance[static_cast<int>(c)]);
      }
    }
  }
  for (std::size_t layer = 0; layer < half_layers.size(); ++layer)
    for (std::size_t c = 0; c < 3; ++c)
      picture->channels.push_back({std::string(half_layers[layer]) + "." + "RGB"[c], std::move(channels[layer][c])});
}

void remove_halves(image::Picture* picture) {
  std::erase_if(picture->channels, [](const image::Channel& channel) {
    return std::ranges::count(half_layers, image::layer_of(channel.name)) > 0;
  });
}

}  // namespace tress::integrate
