#include "denoise/denoised_layer.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

namespace tress::denoise {
namespace {

std::string channel_name(std::size_t c) { return std::string(denoised_layer) + "." + "RGB"[c]; }

}  // namespace

std::string denoised_words(const Denoised& filtered) {
  return fmt::format("a pixel is off by {:.3g} of the mean brightness, by {:.3g} before; brightness {:+.2g} %",
                     filtered.noise(), filtered.noise_before(), 100 * filtered.brightness);
}

Result<Denoised> add_denoised(const std::string& name, image::Picture* picture) {
  Result<Denoised> found = denoise(*picture, name);
  if (!found) return found;
  for (std::size_t c = 0; c < 3; ++c) picture->channels.push_back({channel_name(c), found->colors[c]});
  picture->metadata["denoised"] = fmt::format("layer {} and the PNG: {}; R, G, B are as they were rendered",
                                              denoised_layer, denoised_words(*found));
  picture->metadata["denoised_noise"] = fmt::format("{:.4g}", found->noise());
  return found;
}

image::Picture shown(image::Picture picture) {
  for (std::size_t c = 0; c < 3; ++c) {
    const image::Channel* filtered = picture.find(channel_name(c));
    if (filtered == nullptr) return picture;
    for (image::Channel& channel : picture.channels)
      if (channel.name == std::string(1, "RGB"[c])) channel.pixels = filtered->pixels;
  }
  return picture;
}

}  // namespace tress::denoise
