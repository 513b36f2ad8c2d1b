// When a render ends, after so many samples, so long a time, or at so little noise; how far it is; and what of that
// is shown.
#pragma once

#include <chrono>
#include <optional>

#include "integrate/renderer.h"

namespace tress::cli {

/// At most one of the two; none: the samples of the scene.
struct StopRule {
  std::optional<double> seconds;  ///< since the command began; the picture then depends on the machine
  std::optional<double> noise;    ///< of the picture, relative (integrate::PassProgress::noise)

  static constexpr int most_samples = 1 << 20;        ///< a pixel, whatever the rule
  static constexpr int most_samples_noise = 1 << 14;  ///< a pixel, waiting for the noise to fall
  static constexpr int least_samples_noise = 4;       ///< a pixel, before its variance is believed

  /// Samples a pixel after which it ends at the latest; `asked`: those of the scene.
  int samples(int asked) const { return seconds ? most_samples : noise ? most_samples_noise : asked; }
};

struct Outlook {
  const char* reason = nullptr;  ///< to end here: "samples", "time", "noise"; null: go on
  double share = 0;              ///< of the work that is done, as far as can be told, [0, 1]
  double seconds_left = 0;
};

/// After a pass, `elapsed` seconds after the command began and `rendering` after the first pass did. Ends only where
/// every pixel has as many samples, one at least. By time: where the next pass, if it goes like this one, would end too
/// late. The time left until a noise is reached takes it to fall as 1 / sqrt(samples).
Outlook outlook(const StopRule& rule, const integrate::PassProgress& pass, double elapsed, double rendering);

/// One thread at a time. Says nothing under --quiet.
class Progress {
 public:
  Progress();
  /// After each pass.
  void update(const integrate::PassProgress& pass, const Outlook& outlook);
  /// Removes the bar.
  void finish();
  /// Since construction.
  double seconds() const;

 private:
  std::chrono::steady_clock::time_point start_, last_line_;
};

}  // namespace tress::cli
