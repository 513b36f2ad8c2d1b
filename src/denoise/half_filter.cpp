#include "denoise/half_filter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tress::denoise {
namespace {

// Chosen on straight and curly locks of 16 and 64 samples a pixel, judged on others (bench/README.md, Denoising).
constexpr double along = 3, across = 0.5;  ///< pixels, standard deviations of the Gaussian where all hair runs one way
constexpr int reach = 6;                   ///< pixels to each side that a mean is over
constexpr double farthest = 9;             ///< exponent beyond which a weight counts as 0
constexpr int trust_reach = 8;             ///< pixels to each side over which filter and picture are held together
constexpr double largest = std::numeric_limits<float>::max();
constexpr double least_variance = 1e-7;  ///< of the squared mean of the picture: what differs by less is alike

struct Grid {
  int width = 0, height = 0;
  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  /// The nearest pixel that is there.
  std::size_t nearest(int x, int y) const { return index(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1)); }
};

using Colors = std::vector<glm::dvec3>;
using Numbers = std::vector<double>;

/// For every row, in parallel.
template <class Work>
void for_rows(const Grid& grid, const Work& work) {
  tbb::parallel_for(0, grid.height, [&](int y) {
    for (int x = 0; x < grid.width; ++x) work(x, y, grid.index(x, y));
  });
}

/// Mean over the square of pixels around each; beyond the border the nearest pixel counts.
template <class Value>
std::vector<Value> smoothed(const Grid& grid, const std::vector<Value>& values, int to_each_side) {
  std::vector<Value> rows(values.size()), all(values.size());
  const double scale = 1.0 / (2 * to_each_side + 1);
  for_rows(grid, [&](int x, int y, std::size_t here) {
    Value sum(0);
    for (int d = -to_each_side; d <= to_each_side; ++d) sum += values[grid.nearest(x + d, y)];
    rows[here] = sum * scale;
  });
  for_rows(grid, [&](int x, int y, std::size_t here) {
    Value sum(0);
    for (int d = -to_each_side; d <= to_each_side; ++d) sum += rows[grid.nearest(x, y + d)];
    all[here] = sum * scale;
  });
  return all;
}

double mean_of(const glm::dvec3& x) { return (x.x + x.y + x.z) / 3; }

/// One half picture and its variance, which neighbours have smoothed: that of few paths is itself noise.
struct Half {
  Colors color, variance;
};

/// Direction in the picture, right and down; shorter than 1 where strands differ, or run towards the camera.
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

/// The tangents as the camera shows them: a step along one, moved to the picture's plane at distance 1.
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

/// How unlike the neighbourhoods of two pixels are, 3 x 3 about each: squared differences in units of their variance,
/// less what noise alone makes. At least 0.
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

/// Sums of weighted neighbours, of one half.
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

Filtered filtered(const Grid& grid, const Half& a, const Half& b, const Directions& directions, double tiny) {
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
        mean_a.add(a.color[there], gauss + unlikeness(grid, b, x, y, dx, dy, tiny));
        mean_b.add(b.color[there], gauss + unlikeness(grid, a, x, y, dx, dy, tiny));
      }
    }
    out.a[here] = mean_a.value();
    out.b[here] = mean_b.value();
  });
  return out;
}

/// How much of the filter's answer is taken, 0 to 1: what makes the least squared error of picture + share (filter -
/// picture) over the pixels around. gain: of the noise of the picture times its way to the filter's answer, by halves:
/// the other half's noise is in neither factor, so that its mean is what it should be.
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
  const Numbers gain = smoothed(grid, trust.gain, trust_reach), way = smoothed(grid, trust.way, trust_reach);
  for_rows(grid,
           [&](int, int, std::size_t i) { trust.share[i] = way[i] > 0 ? std::clamp(gain[i] / way[i], 0.0, 1.0) : 0; });
  return trust;
}

Error missing(const std::string& name, const std::string& found) {
  return {name, "layers",
          "R, G, B, half_a, half_b, half_a_variance, half_b_variance and tangent, as tress render --layers all,half or "
          "--layers tangent,half writes them",
          found};
}

/// Without what tells of noise that is no longer there.
image::Picture with_colors(const image::Picture& picture, const Colors& colors) {
  image::Picture out = picture;
  std::erase_if(out.channels, [](const image::Channel& channel) {
    const std::string layer = image::layer_of(channel.name);
    return layer.ends_with("variance") || layer == "half_a" || layer == "half_b";
  });
  for (image::Channel& channel : out.channels) {
    const int c = channel.name == "R" ? 0 : channel.name == "G" ? 1 : channel.name == "B" ? 2 : -1;
    for (std::size_t i = 0; c >= 0 && i < colors.size(); ++i)
      channel.pixels[i] = static_cast<float>(std::clamp(colors[i][c], -largest, largest));
  }
  return out;
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
  Denoised out;
  for (const glm::dvec3& color : beauty) out.mean += mean_of(color) / static_cast<double>(grid.size());
  const double tiny = std::max(least_variance * out.mean * out.mean, std::numeric_limits<double>::min());
  const Half a{layers[1], smoothed(grid, layers[3], 1)}, b{layers[2], smoothed(grid, layers[4], 1)};
  const Directions directions = directions_of(picture, layers[5], camera->second);
  const Filtered filter = filtered(grid, a, b, directions, tiny);
  const Trust trust = trust_of(grid, beauty, a, b, filter);

  Colors colors(grid.size());
  double mean = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double share = trust.share[i], pixels = static_cast<double>(grid.size());
    const glm::dvec3 apart = a.color[i] - b.color[i];
    colors[i] = beauty[i] + share * (0.5 * (filter.a[i] + filter.b[i]) - beauty[i]);
    const double noise = 0.25 * mean_of(apart * apart);
    out.error_before += noise / pixels;
    out.error_after += (noise - 2 * share * trust.gain[i] + share * share * trust.way[i]) / pixels;
    out.filtered_share += share / pixels;
    mean += mean_of(colors[i]) / pixels;
  }
  out.brightness = out.mean != 0 ? mean / out.mean - 1 : 0;
  out.picture = with_colors(picture, colors);
  return out;
}

}  // namespace tress::denoise
