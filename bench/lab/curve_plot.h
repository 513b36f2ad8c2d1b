// What the fit command draws: curves over the azimuth as a small picture.
#pragma once

#include <string>
#include <vector>

#include "image/picture.h"

namespace tress::lab {

/// A line of one color, linear RGB. Values over equally spaced azimuths from -180 degrees, finite, >= 0.
struct Curve {
  std::string name;  ///< in the legend, ASCII
  std::vector<double> values;
  glm::vec3 color;
};

/// 1200 x 720, white: axes with numbers, a legend, the lines of the title (ASCII) above; the vertical axis begins at 0.
image::Picture plot_curves(const std::vector<Curve>& curves, const std::vector<std::string>& title);

}  // namespace tress::lab
