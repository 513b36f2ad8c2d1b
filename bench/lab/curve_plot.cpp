// The curves of `tress-lab fit` as a picture that can be read by itself.
#include "lab/curve_plot.h"

#include <fmt/format.h>
#include <stb_easy_font.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace tress::lab {
namespace {

constexpr int width = 1200, height = 720;
constexpr int left = 110, right = 30, top = 90, bottom = 80;
constexpr int plot_width = width - left - right, plot_height = height - top - bottom;
constexpr int letter = 2;  ///< pixels of a pixel of the font
constexpr int line_height = 12 * letter;

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

  /// x1 and y1 excluded.
  void box(int x0, int y0, int x1, int y1, const glm::vec3& color) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) blend(x, y, color, 1);
    }
  }

  /// Line 2.5 pixels thick, by the distance of each pixel near it.
  void segment(double x0, double y0, double x1, double y1, const glm::vec3& color) {
    const double dx = x1 - x0, dy = y1 - y0, length2 = std::max(dx * dx + dy * dy, 1e-12);
    for (int y = int(std::floor(std::min(y0, y1))) - 3; y <= int(std::ceil(std::max(y0, y1))) + 3; ++y) {
      for (int x = int(std::floor(std::min(x0, x1))) - 3; x <= int(std::ceil(std::max(x0, x1))) + 3; ++x) {
        const double along = std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0, 1.0);
        const double distance = std::hypot(x - x0 - along * dx, y - y0 - along * dy);
        blend(x, y, color, static_cast<float>(std::clamp(1.75 - distance, 0.0, 1.0)));
      }
    }
  }

  static int text_width(std::string text) { return letter * stb_easy_font_width(text.data()); }

  /// (x, y): the upper left corner. ASCII.
  void text(int x, int y, std::string text, const glm::vec3& color = glm::vec3(0.05f)) {
    // Quads of four corners of 16 bytes: x, y, z as floats, a color.
    std::vector<char> quads(text.size() * 300 + 300);
    const int count = stb_easy_font_print(0, 0, text.data(), nullptr, quads.data(), int(quads.size()));
    const auto corner = [&](int quad, int index) {
      std::array<float, 2> at{};
      std::memcpy(at.data(), quads.data() + 64 * quad + 16 * index, sizeof at);
      return at;
    };
    for (int i = 0; i < count; ++i) {
      const std::array<float, 2> from = corner(i, 0), to = corner(i, 2);
      box(x + letter * int(from[0]), y + letter * int(from[1]), x + letter * int(to[0]), y + letter * int(to[1]),
          color);
    }
  }

  image::Picture take() { return std::move(picture_); }

 private:
  image::Picture picture_;
};

/// The step, 1, 2 or 5 times a power of ten, that makes 4 to 10 of `range` > 0.
double tick_step(double range) {
  const double decade = std::pow(10, std::floor(std::log10(range / 4)));
  for (const double step : {5.0, 2.0}) {
    if (range / (step * decade) >= 4) return step * decade;
  }
  return decade;
}

const glm::vec3 black(0.05f), light(0.8f);

void draw_axes(Canvas& canvas, double largest) {
  const int base = height - bottom;
  for (int degrees = -180; degrees <= 180; degrees += 45) {
    const int x = left + plot_width * (degrees + 180) / 360;
    canvas.box(x, top, x + 1, base, light);
    canvas.box(x, base, x + 2, base + 8, black);
    const std::string number = fmt::format("{}", degrees);
    canvas.text(x - Canvas::text_width(number) / 2, base + 12, number);
  }
  const double step = tick_step(largest);
  for (int i = 0; i * step <= largest; ++i) {
    const int y = base - static_cast<int>(std::lround(plot_height * i * step / largest));
    canvas.box(left, y, width - right, y + 1, light);
    canvas.box(left - 8, y, left, y + 2, black);
    const std::string number = fmt::format("{:.4g}", i * step);
    canvas.text(left - 14 - Canvas::text_width(number), y - line_height / 3, number);
  }
  canvas.box(left, base, width - right, base + 2, black);
  canvas.box(left, top, left + 2, base, black);
  const std::string name = "azimuth phi_i, degrees";
  canvas.text(left + (plot_width - Canvas::text_width(name)) / 2, base + 46, name);
  canvas.text(12, top - 2 - line_height, "density, 1/rad");
}

/// Above the curves, from the right: no curve is behind it.
void draw_legend(Canvas& canvas, const std::vector<Curve>& curves) {
  const int y = top - 2 - line_height;
  int x = width - right;
  for (std::size_t i = curves.size(); i-- > 0;) {
    const Curve& curve = curves[i];
    x -= Canvas::text_width(curve.name);
    canvas.text(x, y, curve.name);
    canvas.segment(x - 56, y + 7, x - 12, y + 7, curve.color);
    x -= 90;
  }
}

}  // namespace

image::Picture plot_curves(const std::vector<Curve>& curves, const std::vector<std::string>& title) {
  double largest = 0;
  for (const Curve& curve : curves) {
    for (const double value : curve.values) largest = std::max(largest, value);
  }
  largest = largest > 0 ? 1.05 * largest : 1;

  Canvas canvas;
  for (std::size_t i = 0; i < title.size(); ++i) canvas.text(left, 8 + static_cast<int>(i) * line_height, title[i]);
  draw_axes(canvas, largest);
  for (const Curve& curve : curves) {
    const std::size_t count = curve.values.size();
    const auto x = [&](std::size_t i) { return left + double(plot_width) * double(i) / double(count); };
    const auto y = [&](std::size_t i) { return height - bottom - plot_height * curve.values[i % count] / largest; };
    for (std::size_t i = 0; i < count; ++i) canvas.segment(x(i), y(i), x(i + 1), y(i + 1), curve.color);
  }
  draw_legend(canvas, curves);
  return canvas.take();
}

}  // namespace tress::lab
