// Measures how far a picture is from that of an unbiased model, on a few of its samples.
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

/// Traces its own paths through the same pixels, with random streams that the picture does not use. Distinct pixels may
/// be audited from distinct threads. The result is the same to the bit for any number of threads.
class BiasAuditor {
 public:
  /// All references must outlive this object. options, brightness: those of the render.
  BiasAuditor(const BiasAudit& audit, const scene::Scene& scene, const geometry::FiberScene& fibers,
              const RenderOptions& options, float brightness, const image::Window& window);

  /// Traces the pixel once more if the sample is audited.
  void audit(int x, int y, std::uint32_t sample);

  /// Compares with the film's means. Each audited pixel counts as often as it was traced, so that differences between
  /// pixels are not noise.
  MeasuredBias measured(const Film& film) const;

  /// The state as named bytes, with the rules of Film::sections() and Film::set_sections().
  std::pair<std::string, std::string_view> section() const;
  bool set_section(const std::map<std::string, std::string>& sections);

 private:
  struct Sums {
    double light = 0, squares = 0;  ///< sums of luminance and of its square
    std::uint64_t paths = 0;        ///< 64 bits, so that the struct has no padding
  };

  RenderOptions options_;
  float share_;
  image::Window window_;
  PathTracer tracer_;
  std::vector<Sums> pixels_;
};

}  // namespace tress::integrate
