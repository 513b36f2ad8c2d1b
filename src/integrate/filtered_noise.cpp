#include "integrate/filtered_noise.h"

#include <algorithm>
#include <cmath>

#include "denoise/half_filter.h"
#include "integrate/camera_projection.h"
#include "integrate/pass_order.h"

namespace tress::integrate {
namespace {

constexpr int first_look = 8;      ///< samples per pixel at the first measurement
constexpr int looks_apart = 7;     ///< the next measurement comes after a seventh more samples
constexpr double most_gained = 6;  ///< bound of the factor by which a filter of 13 x 13 pixels reduced noise in tests

bool is_looked_at(int samples) {
  int next = first_look;
  while (next < samples) next += next / looks_apart;
  return next == samples;
}

}  // namespace

double FilteredNoise::after(const PassProgress& pass) {
  const double unfiltered = std::max(last_ > 0 ? last_ : pass.noise, std::nextafter(target_, 2 * target_));
  const int samples = static_cast<int>(sample_of_pass(pass.pass)) + 1;
  if (pass.noise > most_gained * target_ || !is_looked_at(samples)) return unfiltered;
  image::Picture picture = pass.film->picture();
  describe_camera(scene_.camera, scene_.image, &picture, scene_.origin);
  const Result<denoise::Denoised> found = denoise::denoise(picture, "");
  if (!found) return unfiltered;
  last_ = std::hypot(found->noise(), pass.unmet_noise);
  return last_;
}

}  // namespace tress::integrate
