// What the paths of each pixel have brought so far, and the layered picture made of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/picture.h"
#include "tress/fiber/lobes.h"

namespace tress::integrate {

/// Sums over paths. Radiance by the lobe of the path's first fiber hit, or of the background behind the hair.
struct PathSums {
  fiber::LobeColors lobes{};
  glm::vec3 background{0.0f};
  float coverage = 0;  ///< paths that met a fiber
  std::uint32_t samples = 0, queries = 0, exact_queries = 0;

  PathSums& operator+=(const PathSums& other);
};

/// Thread-safety: distinct pixels from distinct threads.
class Film {
 public:
  Film(int width, int height);

  PathSums& pixel(int x, int y) { return pixels_[index(x, y)]; }
  const PathSums& pixel(int x, int y) const { return pixels_[index(x, y)]; }

  /// Each pixel is the mean of the samples it has. A pixel that has none yet (an interrupted sample 0) shows the
  /// sampled pixel nearest in steps along rows and columns; if there is none at all, black with A = 0.
  /// Beauty is the sum of the layers, in their order in the file.
  image::Picture picture() const;

  double samples_per_pixel() const;
  std::uint64_t queries() const;
  std::uint64_t exact_queries() const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  std::vector<std::size_t> nearest_sampled() const;

  int width_, height_;
  std::vector<PathSums> pixels_;
};

}  // namespace tress::integrate
