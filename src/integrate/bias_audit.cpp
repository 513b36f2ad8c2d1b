#include "integrate/bias_audit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "base/color.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

constexpr std::uint64_t choice_purpose = 0x6175646974ull, path_purpose = 0x7472757468ull;

RenderOptions with_own_streams(RenderOptions options) {
  options.seed = mix_bits(options.seed ^ path_purpose);
  return options;
}

}  // namespace

BiasAuditor::BiasAuditor(const BiasAudit& audit, const scene::Scene& scene, const geometry::FiberScene& fibers,
                         const RenderOptions& options, float brightness, const image::Window& window)
    : options_(with_own_streams(options)),
      share_(audit.share),
      window_(window),
      tracer_(PathTracer(scene, fibers, *audit.unbiased, audit.fiber_ids, options_).at_brightness(brightness)),
      pixels_(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height)) {}

void BiasAuditor::audit(int x, int y, std::uint32_t sample) {
  const std::size_t at = static_cast<std::size_t>(y - window_.top) * static_cast<std::size_t>(window_.width) +
                         static_cast<std::size_t>(x - window_.left);
  if (!(RandomStream(options_.seed ^ choice_purpose, at, sample).next() < share_)) return;
  const PathSums path = tracer_.trace(x, y, sample);
  if (!path.is_finite()) return;
  const double light = luminance(glm::dvec3(path.beauty() - path.layers[background_layer]));
  Sums& pixel = pixels_[at];
  pixel.light += light;
  pixel.squares += light * light;
  ++pixel.paths;
}

MeasuredBias BiasAuditor::measured(const Film& film) const {
  MeasuredBias bias;
  double shown = 0, traced = 0, variance = 0;
  for (int y = window_.top; y < window_.top + window_.height; ++y) {
    for (int x = window_.left; x < window_.left + window_.width; ++x) {
      const Sums& pixel = pixels_[static_cast<std::size_t>(y - window_.top) * static_cast<std::size_t>(window_.width) +
                                  static_cast<std::size_t>(x - window_.left)];
      const PixelSums& sums = film.pixel(x, y);
      if (pixel.paths == 0 || sums.samples == 0) continue;
      const auto paths = static_cast<double>(pixel.paths), samples = static_cast<double>(sums.samples);
      const double mean = luminance(sums.beauty() - sums.layers[background_layer]) / samples;
      const double squares = std::max(pixel.squares - 2 * mean * pixel.light + paths * mean * mean, 0.0);
      shown += paths * mean;
      traced += pixel.light;
      variance += squares * (1 + paths / samples);  // the film's mean has noise, too
      bias.paths += pixel.paths;
    }
  }
  if (!(traced > 0)) return bias;
  bias.value = (shown - traced) / traced;
  bias.error = std::sqrt(variance) / traced;
  return bias;
}

std::pair<std::string, std::string_view> BiasAuditor::section() const {
  return {"audit", {reinterpret_cast<const char*>(pixels_.data()), pixels_.size() * sizeof(Sums)}};
}

bool BiasAuditor::set_section(const std::map<std::string, std::string>& sections) {
  const auto found = sections.find("audit");
  if (found == sections.end() || found->second.size() != pixels_.size() * sizeof(Sums)) return false;
  std::memcpy(pixels_.data(), found->second.data(), found->second.size());
  return std::ranges::all_of(pixels_,
                             [](const Sums& sums) { return std::isfinite(sums.light) && std::isfinite(sums.squares); });
}

}  // namespace tress::integrate
