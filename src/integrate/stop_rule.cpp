#include "integrate/stop_rule.h"

#include <algorithm>
#include <cmath>

#include "integrate/pass_order.h"

namespace tress::integrate {

const Brightening* StopRule::bias_of(const PassProgress& pass) {
  if (pass.bias) return &*pass.bias;
  return pass.excess ? &*pass.excess : nullptr;
}

bool StopRule::is_within(const Brightening& bias, double limit) {
  return bias.error > 0 && std::abs(bias.value) + 2 * bias.error <= limit;
}

bool StopRule::is_noise_known(const PassProgress& pass) {
  const int samples = static_cast<int>(sample_of_pass(pass.pass)) + 1;
  return samples >= enough_samples_noise || (samples >= least_samples_noise && pass.light_paths >= least_light_paths);
}

const char* StopRule::reason_to_end(const PassProgress& pass, double noise_now, double elapsed) const {
  if (seconds && pass.pass + 1 >= initial_passes) {  // every pixel has the same number of samples
    const int samples_at_most = pass.pass_count - initial_passes + 1;
    const double pixels = static_cast<double>(pass.paths_total) / samples_at_most;
    const double next = pass.seconds * pixels / std::max(1.0, static_cast<double>(pass.pixels));
    if (elapsed + next > *seconds) return "time";
  }
  const Brightening* bias = picture_error ? bias_of(pass) : nullptr;
  const bool is_decided = bias == nullptr || !(bias->error > 0) || is_within(*bias, *picture_error) ||
                          std::abs(bias->value) - 2 * bias->error > *picture_error;
  if (noise && is_noise_known(pass) && noise_now <= *noise && is_decided) return "noise";
  return pass.pass + 1 >= pass.pass_count ? "samples" : nullptr;
}

}  // namespace tress::integrate
