// Makes the layered picture of a film.
#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "integrate/film.h"

namespace tress::integrate {
namespace {

constexpr float largest_value = std::numeric_limits<float>::max();
/// Relative variance below which paths count as equal. Paths are floats, so a smaller spread comes from rounded sums.
constexpr double least_spread = 1e-12;

/// The variance as written to a picture. It leaves out the spread that comes from rounding alone, because that depends
/// on the order of the sums.
glm::dvec3 written_variance(const PixelSums& pixel, Ground ground) {
  glm::dvec3 variance = pixel.variance_of_mean();
  const double n = std::max(1u, pixel.samples);
  const glm::dvec3 limit = least_spread * pixel.beauty(ground) / n;
  for (int c = 0; c < 3; ++c)
    if (variance[c] * n < limit[c] * limit[c]) variance[c] = 0;
  return glm::min(variance, static_cast<double>(largest_value));
}

/// Beauty as the sum of the layers as they are in the file.
glm::vec3 shown_beauty(const PixelSums& pixel, Ground ground) {
  glm::vec3 sum(0.0f);
  for (std::size_t layer = 0; layer < beauty_layers(ground); ++layer)
    sum += glm::vec3(pixel.layers[layer] / static_cast<double>(pixel.samples));
  return glm::clamp(sum, -largest_value, largest_value);  // rounding may exceed the largest_value float
}

}  // namespace

image::Picture Film::beauty_picture() const { return beauty_of(shown_pixels()); }

image::Picture Film::beauty_of(const std::vector<std::size_t>& source) const {
  image::Picture picture;
  picture.width = window_.width;
  picture.height = window_.height;
  picture.left = window_.left;
  picture.top = window_.top;
  for (const char* name : {"R", "G", "B", "A"}) picture.channels.push_back({name, std::vector<float>(pixels_.size())});
  std::array<float*, 4> to{};
  for (std::size_t c = 0; c < to.size(); ++c) to[c] = picture.channels[c].pixels.data();
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (source[i] == no_pixel) continue;
    const PixelSums& pixel = pixels_[source[i]];
    const glm::vec3 beauty = shown_beauty(pixel, ground_);
    for (int c = 0; c < 3; ++c) to[static_cast<std::size_t>(c)][i] = beauty[c];
    to[3][i] = static_cast<float>(pixel.opaque / static_cast<double>(pixel.samples));
  }
  return picture;
}

image::DeepPicture Film::deep_picture() const {
  image::DeepPicture deep;
  deep.counts.resize(pixels_.size(), 0);
  const std::vector<std::size_t> source = shown_pixels();
  for (std::size_t i = 0; i < pixels_.size() && !depth_bins_.empty(); ++i) {
    if (source[i] == no_pixel) continue;
    std::uint32_t seen_through = pixels_[source[i]].samples;  // paths that no nearer bin has
    for (const DepthBin& bin : depth_bins_[source[i]].bins) {
      if (bin.paths == 0) break;
      const auto over = static_cast<double>(seen_through);
      const glm::dvec3 color =
          glm::clamp(bin.light / over, -static_cast<double>(largest_value), static_cast<double>(largest_value));
      deep.samples.push_back(
          {glm::vec3(color), static_cast<float>(static_cast<double>(bin.paths) / over), bin.near_cm, bin.far_cm});
      seen_through -= bin.paths;
      ++deep.counts[i];
    }
  }
  return deep;
}

void Film::add_data_channels(const std::vector<std::size_t>& source, image::Picture* picture) const {
  const auto add = [&](DataLayer layer, const char* suffix, auto&& value) {
    if (!extra_.data.has(layer)) return;
    std::vector<float> pixels(pixels_.size(), 0.0f);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      if (source[i] != no_pixel) pixels[i] = static_cast<float>(value(source[i], data_[source[i]]));
    picture->channels.push_back(
        {std::string(data_layer_names[static_cast<std::size_t>(layer)]) + suffix, std::move(pixels)});
  };
  const auto over = [](double sum, double paths) { return paths > 0 ? sum / paths : 0; };
  const char* const xyz[] = {".X", ".Y", ".Z"};
  for (int i = 0; i < 3; ++i)
    add(DataLayer::position, xyz[i],
        [&](std::size_t pixel, const DataSums& sums) { return over(sums.position[i], pixels_[pixel].coverage); });
  for (int i = 0; i < 2; ++i)
    add(DataLayer::strand_uv, i == 0 ? ".u" : ".v",
        [&](std::size_t, const DataSums& sums) { return over(sums.root_uv[i], static_cast<double>(sums.with_uv)); });
  add(DataLayer::strand_place, "",
      [&](std::size_t, const DataSums& sums) { return over(sums.place, static_cast<double>(sums.on_strands)); });
  add(DataLayer::strand_id, "", [](std::size_t, const DataSums& sums) { return sums.nearest_strand; });
}

image::Picture Film::picture() const {
  const std::vector<std::size_t> source = shown_pixels();
  image::Picture picture = beauty_of(source);
  /// Adds a channel; `value` is called for every pixel that is shown.
  const auto add = [&](const std::string& name, auto&& value) {
    std::vector<float> pixels(pixels_.size(), 0.0f);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (source[i] != no_pixel) pixels[i] = value(pixels_[source[i]]);
    }
    picture.channels.push_back({name, std::move(pixels)});
  };
  /// Adds three channels. prefix: ends with a dot, or is empty.
  const auto add_three = [&](const std::string& prefix, const char* const(&suffixes)[3], auto&& value) {
    for (int i = 0; i < 3; ++i) {
      add(prefix + suffixes[i], [&](const PixelSums& pixel) { return static_cast<float>(value(pixel)[i]); });
    }
  };
  const char* const rgb[] = {"R", "G", "B"};
  const char* const xyz[] = {"X", "Y", "Z"};
  const auto samples = [](const PixelSums& pixel) { return static_cast<double>(pixel.samples); };

  const auto coverage = [&](const PixelSums& pixel) { return static_cast<float>(pixel.coverage / samples(pixel)); };
  add("coverage", coverage);
  for (std::size_t layer = 0; layer < layer_count; ++layer) {
    if (layer == static_cast<std::size_t>(fiber::Lobe::glint) && !glint_) continue;
    if (layer == emission_layer && !extra_.emission) continue;
    add_three(std::string(layer_name(layer)) + ".", rgb,
              [&](const PixelSums& pixel) { return pixel.layers[layer] / samples(pixel); });
  }
  for (std::size_t group = 0; group < extra_.groups.size(); ++group) {
    add_three("light." + extra_.groups[group] + ".", rgb, [&](const PixelSums& pixel) {
      const auto at = static_cast<std::size_t>(&pixel - pixels_.data());
      const glm::dvec3 most(static_cast<double>(largest_value));
      return glm::clamp(group_sums_[at * extra_.groups.size() + group] / samples(pixel), -most, most);
    });
  }
  const auto over_covered = [](const PixelSums& pixel, const auto& sum) {
    return pixel.coverage > 0 ? sum / pixel.coverage : 0.0 * sum;
  };
  add_three("albedo.", rgb, [&](const PixelSums& pixel) { return pixel.albedo / samples(pixel); });
  add_three("N.", xyz, [&](const PixelSums& pixel) { return over_covered(pixel, pixel.normal); });
  add_three("tangent.", xyz, [&](const PixelSums& pixel) { return over_covered(pixel, pixel.tangent); });
  add("Z", [&](const PixelSums& pixel) { return static_cast<float>(over_covered(pixel, pixel.distance_cm)); });
  add_data_channels(source, &picture);
  add_three("variance.", rgb, [&](const PixelSums& pixel) { return written_variance(pixel, ground_); });
  add_half_channels(source, &picture);
  for (int i = 0; i < 2 && !motion_.empty(); ++i) {
    std::vector<float> pixels(pixels_.size(), 0.0f);
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      if (source[p] == no_pixel) continue;
      const PixelSums& pixel = pixels_[source[p]];
      const MotionSums& sums = motion_[source[p]];
      pixels[p] =
          static_cast<float>(pixel.coverage > 0 ? sums.seen[i] / pixel.coverage : sums.behind[i] / samples(pixel));
    }
    picture.channels.push_back({i == 0 ? "forward.u" : "forward.v", std::move(pixels)});
  }
  add("samples", [](const PixelSums& pixel) { return static_cast<float>(pixel.samples); });
  const auto over_queries = [](const PixelSums& pixel, double sum) {
    return pixel.queries > 0 ? static_cast<float>(sum / static_cast<double>(pixel.queries)) : 0.0f;
  };
  add("ais.exact",
      [&](const PixelSums& pixel) { return over_queries(pixel, static_cast<double>(pixel.exact_queries)); });
  add("ais.objective", [&](const PixelSums& pixel) { return over_queries(pixel, pixel.objective); });
  return picture;
}

// The two independent half pictures of a film, with the variance of each.
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
