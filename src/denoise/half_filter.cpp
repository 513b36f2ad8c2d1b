#include "denoise/half_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "denoise/pixel_grid.h"
#include "tress/base/random.h"

namespace tress::denoise {
namespace {

// These were chosen on straight and curly locks of 16 and 64 samples per pixel, and tested on others (bench/README.md,
// Denoising).
constexpr double along = 3, across = 0.5;  ///< pixels, standard deviations of the Gaussian where all hair runs one way
constexpr int reach = 6;                   ///< pixels to each side over which a mean is taken
constexpr double farthest = 9;             ///< exponent beyond which a weight is 0
constexpr int trust_reach = 8;             ///< pixels to each side over which filter and picture are compared
constexpr int trust_hole = 2;              ///< nearer pixels are left out: their own noise would look like a gain
constexpr double guide_step = 0.25;        ///< standard deviations by which halves are perturbed
constexpr double largest = std::numeric_limits<float>::max();
constexpr double least_variance = 1e-7;  ///< in the squared mean of the picture: smaller differences count as none

/// One half picture and its variance, smoothed over neighbours because the variance of few paths is itself noisy.
struct Half {
  Colors color, variance;
};

/// Directions in the picture, right and down; shorter than 1 where strands differ or run towards the camera.
using Directions = std::vector<glm::dvec2>;

std::optional<Colors> colors_of(const image::Picture& picture, const std::string& prefix, const char* suffixes) {
  Colors colors(Grid{picture.width, picture.height}.size());
  for (int c = 0; c < 3; ++c) {
    const image::Channel* channel = picture.find(prefix + suffixes[c]);
    if (channel == nullptr || channel->pixels.size() != colors.size()) return std::nullopt;
    for (std::size_t i = 0; i < colors.size(); ++i) colors[i][c] = static_cast<double>(channel->pixels[i]);
  }
  return colors;
}

/// Projects the tangents as the camera sees them: a step along one, moved to the picture's plane at distance 1.
Directions directions_of(const image::Picture& picture, const Colors& tangents, const std::array<float, 16>& camera) {
  const Grid grid{picture.width, picture.height};
  const image::Window whole = picture.whole();
  const auto ndc = picture.matrices.find("worldToNDC");
  const bool parallel =
      ndc != picture.matrices.end() && ndc->second[3] == 0.0f && ndc->second[7] == 0.0f && ndc->second[11] == 0.0f;
  const auto axis = [&](std::size_t column) {
    return glm::dvec3(camera[column], camera[4 + column], camera[8 + column]);
  };
  const glm::dvec3 right = axis(0), up = axis(1), forward = axis(2);
  const double pixel = parallel ? 0 : static_cast<double>(picture.screen_width) / whole.width;
  Directions directions(grid.size());
  for_rows(grid, [&](int x, int y, std::size_t here) {
    const glm::dvec3& tangent = tangents[here];
    const double away = glm::dot(tangent, forward);
    const double u =
        static_cast<double>(picture.screen_center[0]) + pixel * (picture.left + x + 0.5 - 0.5 * whole.width);
    const double v =
        static_cast<double>(picture.screen_center[1]) - pixel * (picture.top + y + 0.5 - 0.5 * whole.height);
    const glm::dvec2 step(glm::dot(tangent, right) - (parallel ? 0 : u) * away,
                          -(glm::dot(tangent, up) - (parallel ? 0 : v) * away));
    const double length = glm::length(step);
    directions[here] = length > 1 ? step / length : step;
  });
  return directions;
}

/// The difference of the neighbourhoods of two pixels, 3 x 3 about each: squared differences in units of their
/// variance, minus what noise alone makes. At least 0.
double unlikeness(const Grid& grid, const Half& half, int x, int y, int dx, int dy, double tiny) {
  double sum = 0;
  for (int v = -1; v <= 1; ++v) {
    for (int u = -1; u <= 1; ++u) {
      const int px = std::clamp(x + u, 0, grid.width - 1), py = std::clamp(y + v, 0, grid.height - 1);
      const std::size_t p = grid.index(px, py), q = grid.nearest(px + dx, py + dy);
      const glm::dvec3 apart = half.color[p] - half.color[q], mine = half.variance[p], other = half.variance[q];
      for (int c = 0; c < 3; ++c)
        sum += (apart[c] * apart[c] - mine[c] - std::min(mine[c], other[c])) / (tiny + mine[c] + other[c]);
    }
  }
  return std::max(sum / 27, 0.0);
}

/// Sums of the weighted neighbours of one half.
struct Mean {
  glm::dvec3 sum{0.0};
  double weight = 0;
  void add(const glm::dvec3& value, double exponent) {
    const double w = std::exp(-exponent);
    sum += w * value;
    weight += w;
  }
  glm::dvec3 value() const { return sum / weight; }
};

struct Filtered {
  Colors a, b;
};

/// Filters half a with weights from guide b, and half b with weights from guide a.
Filtered filtered(const Grid& grid, const Half& a, const Half& b, const Half& guide_a, const Half& guide_b,
                  const Directions& directions, double tiny) {
  Filtered out{Colors(grid.size()), Colors(grid.size())};
  for_rows(grid, [&](int x, int y, std::size_t here) {
    const double confidence = glm::length(directions[here]);
    const glm::dvec2 direction = confidence > 0 ? directions[here] / confidence : glm::dvec2(0.0);
    const double length = across + (along - across) * confidence;
    Mean mean_a, mean_b;
    for (int dy = std::max(-reach, -y); dy <= std::min(reach, grid.height - 1 - y); ++dy) {
      for (int dx = std::max(-reach, -x); dx <= std::min(reach, grid.width - 1 - x); ++dx) {
        const double u = dx * direction.x + dy * direction.y, rest = dx * dx + dy * dy - u * u;
        const double gauss = 0.5 * (u * u / (length * length) + rest / (across * across));
        if (gauss > farthest) continue;
        const std::size_t there = grid.index(x + dx, y + dy);
        mean_a.add(a.color[there], gauss + unlikeness(grid, guide_b, x, y, dx, dy, tiny));
        mean_b.add(b.color[there], gauss + unlikeness(grid, guide_a, x, y, dx, dy, tiny));
      }
    }
    out.a[here] = mean_a.value();
    out.b[here] = mean_b.value();
  });
  return out;
}

/// Returns 1 or -1, depending on the number.
double sign_of(std::uint64_t number) { return (mix_bits(number + 1) & 1) != 0 ? 1 : -1; }

/// Random colors with the covariance of the noise of a half around each pixel: the difference of the halves there, with
/// random signs. The pixel itself is left out, because its own noise decides its weight.
Colors made_noise(const Grid& grid, const Half& a, const Half& b) {
  constexpr int near = 2;
  Colors noise(grid.size(), glm::dvec3(0.0));
  for_rows(grid, [&](int x, int y, std::size_t here) {
    int count = 0;
    for (int dy = std::max(-near, -y); dy <= std::min(near, grid.height - 1 - y); ++dy) {
      for (int dx = std::max(-near, -x); dx <= std::min(near, grid.width - 1 - x); ++dx) {
        const std::size_t there = grid.index(x + dx, y + dy);
        if (there == here) continue;
        const auto place = static_cast<std::uint64_t>((dy + near) * (2 * near + 1) + dx + near);
        noise[here] += sign_of(here * 64 + place) * (a.color[there] - b.color[there]);
        ++count;
      }
    }
    if (count > 0) noise[here] *= std::sqrt(0.5 / count);
  });
  return noise;
}

Half shaken(const Half& half, const Colors& noise) {
  Half out = half;
  for (std::size_t i = 0; i < out.color.size(); ++i) out.color[i] += guide_step * noise[i];
  return out;
}

/// The share of the filter's result that is used, 0 to 1. It has the least squared error of picture + share (filter -
/// picture) over the pixels around, without the nearest. gain: the noise of the picture times its difference
/// from the filter's result, by halves.
struct Trust {
  Numbers share, gain, way;
};

Trust trust_of(const Grid& grid, const Colors& beauty, const Half& a, const Half& b, const Filtered& filter) {
  Trust trust{Numbers(grid.size()), Numbers(grid.size()), Numbers(grid.size())};
  for_rows(grid, [&](int, int, std::size_t i) {
    const glm::dvec3 apart = a.color[i] - b.color[i];
    const glm::dvec3 way = 0.5 * (filter.a[i] + filter.b[i]) - beauty[i];
    trust.gain[i] = 0.25 * mean_of(apart * ((a.color[i] - filter.a[i]) - (b.color[i] - filter.b[i])));
    trust.way[i] = mean_of(way * way);
  });
  const auto around = [&](const Numbers& values) {
    Numbers sums = sums_around(grid, values, trust_reach);
    const Numbers hole = sums_around(grid, values, trust_hole);
    for_rows(grid, [&](int, int, std::size_t i) { sums[i] -= hole[i]; });
    return sums;
  };
  const Numbers gain = around(trust.gain), way = around(trust.way);
  for_rows(grid,
           [&](int, int, std::size_t i) { trust.share[i] = way[i] > 0 ? std::clamp(gain[i] / way[i], 0.0, 1.0) : 0; });
  return trust;
}

/// The bias of the gain: the noise of a half times the result of the other half, whose weights it has chosen. By
/// Stein's lemma this is its covariance times the derivative of the result, found by a random perturbation (Ramani, Blu
/// and Unser 2008).
Numbers luck_of_weights(const Grid& grid, const Half& a, const Half& b, const Filtered& filter,
                        const Directions& directions, double tiny) {
  const Colors noise = made_noise(grid, a, b);
  const Filtered moved = filtered(grid, a, b, shaken(a, noise), shaken(b, noise), directions, tiny);
  Numbers luck(grid.size());
  for_rows(grid, [&](int, int, std::size_t i) {
    luck[i] = 0.5 / guide_step * mean_of(noise[i] * (moved.a[i] - filter.a[i] + moved.b[i] - filter.b[i]));
  });
  return luck;
}

Error missing(const std::string& name, const std::string& found) {
  return {name, "layers",
          "R, G, B, half_a, half_b, half_a_variance, half_b_variance and tangent, as tress render --layers all,half or "
          "--layers tangent,half writes them",
          found};
}

/// The pixels over which errors are reported: 1 where something is seen, if the picture has that layer.
Numbers counted_pixels(const Grid& grid, const image::Picture& picture) {
  const image::Channel* coverage = picture.find("coverage");
  Numbers counts(grid.size(), 1.0);
  if (coverage == nullptr || std::ranges::none_of(coverage->pixels, [](float x) { return x > 0; })) return counts;
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = coverage->pixels[i] > 0 ? 1 : 0;
  return counts;
}

/// Standard error of a sum of values of equal weight, from squares of pixels whose errors are nearly independent: a
/// square is about as large as the filter's reach. counts: 1 or 0; pixels: their sum.
double deviation_of_sum(const Grid& grid, const Numbers& values, const Numbers& counts, double pixels) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / pixels;
  double squares = 0, total = 0;
  for (int top = 0; top < grid.height; top += trust_reach) {
    for (int left = 0; left < grid.width; left += trust_reach) {
      double apart = 0, counted = 0;
      for (int y = top; y < std::min(top + trust_reach, grid.height); ++y) {
        for (int x = left; x < std::min(left + trust_reach, grid.width); ++x) {
          const std::size_t i = grid.index(x, y);
          apart += values[i] - counts[i] * mean;
          counted += counts[i];
        }
      }
      if (counted == 0) continue;
      total += apart * apart;
      ++squares;
    }
  }
  return squares > 1 ? std::sqrt(total * squares / (squares - 1)) : std::abs(mean) * pixels;
}

}  // namespace

Result<Denoised> denoise(const image::Picture& picture, const std::string& name) {
  std::array<Colors, 6> layers;
  const std::array<std::pair<const char*, const char*>, 6> wanted{{{"", "RGB"},
                                                                   {"half_a.", "RGB"},
                                                                   {"half_b.", "RGB"},
                                                                   {"half_a_variance.", "RGB"},
                                                                   {"half_b_variance.", "RGB"},
                                                                   {"tangent.", "XYZ"}}};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    std::optional<Colors> colors = colors_of(picture, wanted[i].first, wanted[i].second);
    if (!colors) return missing(name, std::string("no ") + wanted[i].first + wanted[i].second[0]);
    layers[i] = std::move(*colors);
  }
  const auto camera = picture.matrices.find("worldToCamera");
  if (camera == picture.matrices.end())
    return Error{name, "header", "worldToCamera, as tress writes it", "no such matrix"};

  const Grid grid{picture.width, picture.height};
  const Colors& beauty = layers[0];
  const auto is_zero = [](const glm::dvec3& x) { return x == glm::dvec3(0.0); };
  if (std::ranges::all_of(layers[3], is_zero) && std::ranges::all_of(layers[4], is_zero) && layers[1] != layers[2])
    return Error{name, "half_a_variance", "at least 4 samples a pixel, 2 of each half", "no variance in any pixel"};
  double level = 0;
  for (const glm::dvec3& color : beauty) level += mean_of(color) / static_cast<double>(grid.size());
  const double tiny = std::max(least_variance * level * level, std::numeric_limits<double>::min());
  const Half a{layers[1], smoothed(grid, layers[3], 1)}, b{layers[2], smoothed(grid, layers[4], 1)};
  const Directions directions = directions_of(picture, layers[5], camera->second);
  const Filtered filter = filtered(grid, a, b, a, b, directions, tiny);
  const Trust trust = trust_of(grid, beauty, a, b, filter);
  const Numbers luck = luck_of_weights(grid, a, b, filter, directions, tiny);

  Denoised out;
  const Numbers counts = counted_pixels(grid, picture);
  const double pixels = std::accumulate(counts.begin(), counts.end(), 0.0);
  for (std::vector<float>& channel : out.colors) channel.resize(grid.size());
  double filtered_mean = 0;
  Numbers left(grid.size());
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double share = trust.share[i], weight = counts[i] / pixels;
    const glm::dvec3 apart = a.color[i] - b.color[i];
    const glm::dvec3 color = beauty[i] + share * (0.5 * (filter.a[i] + filter.b[i]) - beauty[i]);
    for (int c = 0; c < 3; ++c)
      out.colors[static_cast<std::size_t>(c)][i] = static_cast<float>(std::clamp(color[c], -largest, largest));
    const double noise = 0.25 * mean_of(apart * apart);
    out.error_before += weight * noise;
    left[i] = weight * (noise - 2 * share * (trust.gain[i] - luck[i]) + share * share * trust.way[i]);
    out.error_after += left[i];
    out.filtered_share += weight * share;
    out.mean += weight * mean_of(beauty[i]);
    filtered_mean += weight * mean_of(color);
  }
  out.error_after_deviation = deviation_of_sum(grid, left, counts, pixels);
  out.brightness = out.mean != 0 ? filtered_mean / out.mean - 1 : 0;
  return out;
}

image::Picture with_filtered(image::Picture picture, const Denoised& filtered) {
  std::erase_if(picture.channels, [](const image::Channel& channel) {
    const std::string layer = image::layer_of(channel.name);
    return layer.ends_with("variance") || layer == "half_a" || layer == "half_b";
  });
  for (image::Channel& channel : picture.channels) {
    const std::size_t c = std::string("RGB").find(channel.name);
    if (channel.name.size() == 1 && c != std::string::npos) channel.pixels = filtered.colors[c];
  }
  return picture;
}

}  // namespace tress::denoise
