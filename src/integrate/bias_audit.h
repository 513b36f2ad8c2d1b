// How far a picture is from what an unbiased model would have made of it, measured on a few of its samples.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "integrate/film.h"
#include "integrate/path_tracer.h"

namespace tress::integrate {

/// Traces its own paths, with streams that the picture has not, through the same pixels. Thread-safety as of Film:
/// distinct pixels from distinct threads. The same bits for any number of threads.
class BiasAuditor {
 public:
  /// All references must outlive it. options, brightness: of the render.
  BiasAuditor(const BiasAudit& audit, const scene::Scene& scene, const geometry::FiberScene& fibers,
              const RenderOptions& options, float brightness, const image::Window& window);

  /// Traces the pixel once more if the sample is one of the audited.
  void audit(int x, int y, std::uint32_t sample);

  /// Against the film's means: each audited pixel counts as often as it was traced, so that what differs between
  /// pixels is no noise.
  MeasuredBias measured(const Film& film) const;

  /// As of Film.
  std::pair<std::string, std::string_view> section() const;
  bool set_section(const std::map<std::string, std::string>& sections);

 private:
  struct Sums {
    double light = 0, squares = 0;  ///< of luminance
    std::uint64_t paths = 0;        ///< 64 bits, so that no byte of it is unset
  };

  RenderOptions options_;
  float share_;
  image::Window window_;
  PathTracer tracer_;
  std::vector<Sums> pixels_;
};

}  // namespace tress::integrate
