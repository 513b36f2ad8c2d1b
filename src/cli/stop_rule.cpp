#include "cli/stop_rule.h"

#include <algorithm>

#include "integrate/pass_order.h"

namespace tress::cli {
namespace {

double ratio(double part, double whole) { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 1.0; }

}  // namespace

Outlook outlook(const StopRule& rule, const integrate::PassProgress& pass, double elapsed, double rendering) {
  const bool is_even = pass.pass + 1 >= integrate::initial_passes;  // every pixel has as many samples
  const int samples = static_cast<int>(integrate::sample_of_pass(pass.pass)) + 1;
  Outlook result;
  if (rule.seconds) {
    result.share = ratio(elapsed, *rule.seconds);
    result.seconds_left = std::max(0.0, *rule.seconds - elapsed);
    const int samples_at_most = pass.pass_count - integrate::initial_passes + 1;
    const double pixels = static_cast<double>(pass.paths_total) / samples_at_most;
    const double next = pass.seconds * pixels / std::max(1.0, static_cast<double>(pass.pixels));
    if (is_even && elapsed + next > *rule.seconds) result.reason = "time";
  } else {
    result.share = ratio(static_cast<double>(pass.paths_so_far), static_cast<double>(pass.paths_total));
    if (rule.noise && samples >= StopRule::least_samples_noise) {
      const double wanted = pass.noise / *rule.noise;
      result.share = std::max(result.share, ratio(1, wanted * wanted));
      if (pass.noise <= *rule.noise) result.reason = "noise";
    }
    result.seconds_left = result.share > 0 ? rendering * (1 - result.share) / result.share : 0;
  }
  if (result.reason == nullptr && pass.pass + 1 >= pass.pass_count) result.reason = "samples";
  return result;
}

}  // namespace tress::cli
