#include <algorithm>
#include <cmath>

#include "cli/fit_command.h"

namespace tress::cli {
namespace {

constexpr int width = 960, height = 540, margin = 30;
constexpr int plot_width = width - 2 * margin, plot_height = height - 2 * margin;

class Canvas {
 public:
  Canvas() {
    picture_.width = width;
    picture_.height = height;
    for (const char* name : {"R", "G", "B"}) {
      picture_.channels.push_back({name, std::vector<float>(std::size_t(width) * height, 1.0f)});
    }
  }

  /// Covers part of a pixel; out of the picture: nothing.
  void blend(int x, int y, const glm::vec3& color, float share) {
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    for (int c = 0; c < 3; ++c) {
      float& pixel = picture_.channels[std::size_t(c)].pixels[std::size_t(y) * width + std::size_t(x)];
      pixel += share * (color[c] - pixel);
    }
  }

  void vertical(int x, int from, int to, const glm::vec3& color) {
    for (int y = from; y <= to; ++y) blend(x, y, color, 1);
  }

  /// Line 1.5 pixels thick, by the distance of each pixel near it.
  void segment(double x0, double y0, double x1, double y1, const glm::vec3& color) {
    const double dx = x1 - x0, dy = y1 - y0, length2 = std::max(dx * dx + dy * dy, 1e-12);
    for (int y = int(std::floor(std::min(y0, y1))) - 2; y <= int(std::ceil(std::max(y0, y1))) + 2; ++y) {
      for (int x = int(std::floor(std::min(x0, x1))) - 2; x <= int(std::ceil(std::max(x0, x1))) + 2; ++x) {
        const double along = std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0, 1.0);
        const double distance = std::hypot(x - x0 - along * dx, y - y0 - along * dy);
        blend(x, y, color, static_cast<float>(std::clamp(1.25 - distance, 0.0, 1.0)));
      }
    }
  }

  image::Picture take() { return std::move(picture_); }

 private:
  image::Picture picture_;
};

}  // namespace

image::Picture plot_curves(const std::vector<Curve>& curves) {
  double largest = 0;
  for (const Curve& curve : curves) {
    for (const double value : curve.values) largest = std::max(largest, value);
  }
  const double scale = largest > 0 ? plot_height / (1.05 * largest) : 0;

  Canvas canvas;
  const glm::vec3 black(0.05f), light(0.8f);
  const int bottom = height - margin;
  for (int tick = 0; tick <= 8; ++tick) {
    const int x = margin + plot_width * tick / 8;
    canvas.vertical(x, margin, bottom, light);
    canvas.vertical(x, bottom, bottom + (tick % 2 == 0 ? 12 : 6), black);
  }
  canvas.segment(margin, bottom, width - margin, bottom, black);
  for (const Curve& curve : curves) {
    const std::size_t count = curve.values.size();
    const auto x = [&](std::size_t i) { return margin + double(plot_width) * double(i) / double(count); };
    const auto y = [&](std::size_t i) { return bottom - scale * curve.values[i % count]; };
    for (std::size_t i = 0; i < count; ++i) canvas.segment(x(i), y(i), x(i + 1), y(i + 1), curve.color);
  }
  return canvas.take();
}

}  // namespace tress::cli
