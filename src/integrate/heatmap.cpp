#include "integrate/heatmap.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace tress::integrate {
namespace {

/// Linear RGB at heats 0, 0.2, ... 1: black, purple, red, orange, yellow, white. Each is brighter than the one before.
constexpr std::array<std::array<float, 3>, 6> heat_colors{
    {{0, 0, 0}, {0.06f, 0.005f, 0.13f}, {0.35f, 0.02f, 0.1f}, {0.8f, 0.15f, 0.01f}, {0.95f, 0.55f, 0.05f}, {1, 1, 1}}};

/// The value of a channel for a heat in [0, 1].
float heat_color(float heat, std::size_t channel) {
  const float place = heat * static_cast<float>(heat_colors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), heat_colors.size() - 2);
  const float share = place - static_cast<float>(below);
  return (1 - share) * heat_colors[below][channel] + share * heat_colors[below + 1][channel];
}

}  // namespace

image::Picture heatmap(const std::vector<PixelCost>& pixels, const image::Window& window) {
  image::Picture picture;
  picture.width = window.width;
  picture.height = window.height;
  picture.left = window.left;
  picture.top = window.top;
  const auto add = [&](const char* name, auto&& of_pixel) {
    std::vector<float> values(pixels.size(), 0.0f);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i].paths > 0) values[i] = static_cast<float>(of_pixel(pixels[i]));
    }
    picture.channels.push_back({name, std::move(values)});
  };
  const auto per_path = [](const PixelCost& pixel, auto total) {
    return static_cast<double>(total) / static_cast<double>(pixel.paths);
  };
  add("cpu_ns", [&](const PixelCost& pixel) { return per_path(pixel, 1e9 * pixel.cpu_seconds); });
  add("vertices", [&](const PixelCost& pixel) { return per_path(pixel, pixel.vertices); });
  add("queries", [&](const PixelCost& pixel) { return per_path(pixel, pixel.queries); });
  add("exact", [&](const PixelCost& pixel) { return per_path(pixel, pixel.exact_queries); });
  add("paths", [](const PixelCost& pixel) { return pixel.paths; });

  const std::vector<float> time = picture.channels[0].pixels;
  std::vector<float> sorted = time;
  const auto rank = sorted.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), rank, sorted.end());
  const float white = std::max(*rank, 1.0f);
  const char* const rgb[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> values(time.size());
    std::transform(time.begin(), time.end(), values.begin(),
                   [&](float ns) { return heat_color(std::clamp(ns / white, 0.0f, 1.0f), c); });
    picture.channels.push_back({rgb[c], std::move(values)});
  }
  return picture;
}

}  // namespace tress::integrate
