#include "denoise/denoised_layer.h"

#include <fmt/format.h>

#include <cstddef>

namespace tress::denoise {
std::string denoised_words(const Denoised& filtered) {
  return fmt::format("a pixel is off by {:.3g} of the mean brightness, by {:.3g} before; brightness {:+.2g} %",
                     filtered.noise(), filtered.noise_before(), 100 * filtered.brightness);
}

Result<Denoised> add_denoised(const std::string& name, image::Picture* picture) {
  Result<Denoised> found = denoise(*picture, name);
  if (!found) return found;
  for (std::size_t c = 0; c < 3; ++c)
    picture->channels.push_back({std::string(denoised_layer) + "." + "RGB"[c], found -> colors[c]});
  picture->metadata["denoised"] = fmt::format("layer {} and the PNG: {}; R, G, B are as they were rendered",
                                              denoised_layer, denoised_words(*found));
  picture->metadata["denoised_noise"] = fmt::format("{:.4g}", found->noise());
  return found;
}

}  // namespace tress::denoise
