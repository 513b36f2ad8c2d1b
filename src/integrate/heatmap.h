// A picture of the cost of each pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "image/picture.h"

namespace tress::integrate {

/// The cost of one pixel's paths.
struct PixelCost {
  double cpu_seconds = 0;
  std::uint64_t paths = 0, vertices = 0, queries = 0, exact_queries = 0;
};

/// Makes a picture with these channels: `paths` is the number of paths of the pixel, and the others are means over
/// them. `cpu_ns` is the CPU time of the path itself without learning, which depends on the machine and its load.
/// `vertices` are hits that scattered, `queries` those of the table, and `exact` queries answered by tracing. R, G, B
/// show cpu_ns from black over purple and orange to white, which is its 99th percentile. pixels: row by row.
image::Picture heatmap(const std::vector<PixelCost>& pixels, const image::Window& window);

}  // namespace tress::integrate
