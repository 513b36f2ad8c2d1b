#include "cli/denoised_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "integrate/camera_projection.h"
#include "integrate/pass_order.h"

namespace tress::cli {
namespace {

std::string_view told_in(const std::map<std::string, std::string>& header, const char* name) {
  const auto found = header.find(name);
  return found == header.end() ? std::string_view() : std::string_view(found->second);
}

constexpr int first_look = 8;      ///< samples a pixel
constexpr int looks_apart = 7;     ///< a seventh more samples each time
constexpr double most_gained = 6;  ///< times less noise: what no filter of 13 x 13 pixels was seen to bring

bool is_looked_at(int samples) {
  int next = first_look;
  while (next < samples) next += next / looks_apart;
  return next == samples;
}

}  // namespace

double FilteredNoise::after(const integrate::PassProgress& pass) {
  const double unfiltered = std::max(last_ > 0 ? last_ : pass.noise, std::nextafter(target_, 2 * target_));
  const int samples = static_cast<int>(integrate::sample_of_pass(pass.pass)) + 1;
  if (pass.noise > most_gained * target_ || !is_looked_at(samples)) return unfiltered;
  image::Picture picture = pass.film->picture();
  integrate::describe_camera(scene_.camera, scene_.image, &picture);
  const Result<denoise::Denoised> found = denoise::denoise(picture, "");
  if (!found) return unfiltered;
  last_ = found->noise();
  return last_;
}

std::string denoised_words(const denoise::Denoised& filtered) {
  return fmt::format("a pixel is off by {:.3g} of the mean brightness, by {:.3g} before; brightness {:+.2g} %",
                     filtered.noise(), filtered.noise_before(), 100 * filtered.brightness);
}

image::Preview preview_of(const std::map<std::string, std::string>& header) {
  image::Preview preview;
  preview.alpha = told_in(header, "alpha").ends_with(alpha_of_png);
  preview.exposure_stops = std::strtod(std::string(told_in(header, "exposure")).c_str(), nullptr);
  const std::string_view view = told_in(header, "view");
  if (const auto known = image::view_of(view.substr(0, view.find(',')))) preview.view = *known;
  return preview;
}

Result<denoise::Denoised> add_denoised(const std::string& name, image::Picture* picture) {
  Result<denoise::Denoised> found = denoise::denoise(*picture, name);
  if (!found) return found;
  for (std::size_t c = 0; c < 3; ++c)
    picture->channels.push_back({std::string(denoised_layer) + "." + "RGB"[c], found -> colors[c]});
  picture->metadata["denoised"] = fmt::format("layer {} and the PNG: {}; R, G, B are as they were rendered",
                                              denoised_layer, denoised_words(*found));
  picture->metadata["denoised_noise"] = fmt::format("{:.4g}", found->noise());
  return found;
}

}  // namespace tress::cli
