// Two curves over the azimuth as a small picture.
#pragma once

#include <vector>

#include "image/picture.h"

namespace tress::cli {

/// A line of one color, linear RGB. Values over equally spaced azimuths from -180 degrees, finite.
struct Curve {
  std::vector<double> values;
  glm::vec3 color;
};

/// 960 x 540, white, zero line and ticks every 45 degrees; the vertical axis runs from 0 to 1.05 of the largest value.
image::Picture plot_curves(const std::vector<Curve>& curves);

}  // namespace tress::cli
