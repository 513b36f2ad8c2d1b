// The test of whether a row has converged, the same for every learner (ESTIMATOR.md, E3).
#pragma once

#include <cstdint>
#include <functional>

#include "observations/fixed_moments.h"
#include "tress/adaptive/options.h"

namespace tress::inline v0_2::adaptive {

/// The standard error of the mean of m.
double standard_error(const Moments& m);

/// The running objective of one row. A fit is scored only on azimuths that were drawn from its own proposal after it
/// was made, so it was not fitted to them.
class StopTest {
 public:
  enum class Verdict : std::uint8_t { undecided, converged, refused };

  /// failed: number of tests that the row failed before it was reopened.
  explicit StopTest(std::uint32_t failed = 0) { now_.failed = failed; }

  /// Scores an azimuth that was drawn with density q. residual: g - f there. variation: as in TracedNodes. Thread-safe.
  void add(double residual, double q, double variation) { scores_.add(residual * residual / (q * variation)); }
  std::uint64_t scores() const { return scores_.count(); }

  /// Tests the scores and clears them. Does nothing and returns false while there are too few. Not during add().
  /// known: returns an upper bound of the relative squared L2 error; called if the scores alone would end the row. It
  /// must be within epsilon too, because the scores miss errors where the proposal hardly draws.
  bool run(const Options& options, const std::function<double()>& known);

  Verdict verdict() const { return now_.verdict; }
  /// Bound of the last test on the relative squared L2 error, as a cache stores it; negative before the first test.
  /// Once converged, it is the largest bound of the tests that were passed.
  float bound() const { return now_.bound; }
  bool last_failed() const { return now_.last_failed; }
  /// Whether the scores of the last test passed and the known error did not.
  bool overruled() const { return now_.overruled; }
  std::uint32_t failed() const { return now_.failed; }

  struct Progress {
    Verdict verdict = Verdict::undecided;
    float bound = -1;
    float largest_passed = 0;  ///< largest bound of the present run of passed tests
    std::uint32_t passed = 0;  ///< number of tests in that run
    std::uint32_t failed = 0;  ///< failed tests in all
    bool last_failed = false;
    bool overruled = false;
  };
  /// The whole object as plain data. A restored object behaves the same to the bit. Not during add().
  struct State : Progress {
    FixedMoments<2>::Words scores{};
  };
  State state() const { return {now_, scores_.words()}; }
  void set_state(const State& state) {
    scores_.set_words(state.scores);
    now_ = state;
  }

 private:
  FixedMoments<2> scores_;  ///< moments of min(4, r^2/(q L)) since the last test
  Progress now_;
};

}  // namespace tress::inline v0_2::adaptive
