// When a render ends: after so many samples, so long a time, or at so little noise.
#pragma once

#include <optional>

#include "integrate/renderer.h"

namespace tress::integrate {

/// At most one of the two; none: the samples of the scene.
struct StopRule {
  std::optional<double> seconds;  ///< since the command began; the picture then depends on the machine
  std::optional<double> noise;    ///< of the picture, relative (PassProgress::noise)

  static constexpr int most_samples = 1 << 20;        ///< a pixel, whatever the rule
  static constexpr int most_samples_noise = 1 << 14;  ///< a pixel, waiting for the noise to fall
  /// Before the variance is believed: samples a pixel, and of the picture paths that brought its light
  /// (PassProgress::light_paths) or still more samples a pixel.
  static constexpr int least_samples_noise = 4, enough_samples_noise = 64;
  static constexpr double least_light_paths = 32;

  /// Samples a pixel after which it ends at the latest; `asked`: those of the scene.
  int samples(int asked) const { return seconds ? most_samples : noise ? most_samples_noise : asked; }
  static bool is_noise_known(const PassProgress& pass);
  /// Why to end after this pass, `elapsed` seconds after the command began: "samples", "time", "noise"; null: go on.
  /// Only where every pixel has as many samples, one at least. By time: where the next pass, if it goes like this one,
  /// would end too late.
  /// noise_now: that of the picture, or of what is made of it.
  const char* reason_to_end(const PassProgress& pass, double noise_now, double elapsed) const;
  const char* reason_to_end(const PassProgress& pass, double elapsed) const {
    return reason_to_end(pass, pass.noise, elapsed);
  }
};

}  // namespace tress::integrate
