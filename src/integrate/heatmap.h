// What each pixel costs, as a picture.
#pragma once

#include <cstdint>
#include <vector>

#include "image/picture.h"

namespace tress::integrate {

/// CPU time of the thread that runs, seconds. A call takes some 0.2 us.
double thread_cpu_seconds();

/// The cost of one pixel's paths.
struct PixelCost {
  double cpu_seconds = 0;
  std::uint64_t paths = 0, vertices = 0, queries = 0, exact_queries = 0;
};

/// Channels, each a mean over the pixel's paths: `cpu_ns` (CPU time of the path itself, without learning; depends on
/// the machine and its load), `vertices` (hits that scattered), `queries` (of the table), `exact` (of them answered by
/// tracing); `paths` is their number. R, G, B show cpu_ns, black to white by way of purple and orange, white being its
/// 99th percentile. Pixels row by row.
image::Picture heatmap(const std::vector<PixelCost>& pixels, const image::Window& window);

}  // namespace tress::integrate
