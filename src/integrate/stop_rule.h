// The rule that ends a render: by number of samples, by time or by noise.
#pragma once

#include <optional>

#include "integrate/renderer.h"

namespace tress::integrate {

/// At most one of `seconds` and `noise` is set. If neither is, the render ends after the samples of the scene.
struct StopRule {
  std::optional<double> seconds;  ///< since the command began; the picture then depends on the machine
  std::optional<double> noise;    ///< relative noise of the picture (PassProgress::noise)
  /// Limit of the relative bias by rows. Where the bias is estimated (bias_of()), a rule by noise ends only once its
  /// two standard errors reach to one side of the limit: below it, or above it, where more samples would not mend it.
  std::optional<double> picture_error = {};

  static constexpr int most_samples = 1 << 20;        ///< per pixel, for any rule
  static constexpr int most_samples_noise = 1 << 14;  ///< per pixel, for a rule by noise
  /// The variance is trusted from least_samples_noise per pixel on, if the picture has least_light_paths paths that
  /// brought its light (PassProgress::light_paths) or enough_samples_noise per pixel.
  static constexpr int least_samples_noise = 4, enough_samples_noise = 64;
  static constexpr double least_light_paths = 32;

  /// Largest number of samples per pixel. asked: samples of the scene.
  int samples(int asked) const { return seconds ? most_samples : noise ? most_samples_noise : asked; }
  /// The estimate of the bias by rows: PassProgress::bias, else `excess`; null if there is neither.
  static const Brightening* bias_of(const PassProgress& pass);
  /// Whether a bias of no more than `limit` on either side is known by two standard errors.
  static bool is_within(const Brightening& bias, double limit);
  static bool is_noise_known(const PassProgress& pass);
  /// The reason to end after this pass: "samples", "time" or "noise"; null to go on. A render ends only where every
  /// pixel has the same number of samples, at least one. It ends by time if a next pass as long as this one would end
  /// too late. noise_now: noise of the picture, or of the filtered picture. elapsed: seconds since the command began.
  const char* reason_to_end(const PassProgress& pass, double noise_now, double elapsed) const;
  const char* reason_to_end(const PassProgress& pass, double elapsed) const {
    return reason_to_end(pass, pass.noise, elapsed);
  }
};

}  // namespace tress::integrate
