// When a row is converged: the one test that judges every learner (ESTIMATOR.md, E3).
#pragma once

#include <cstdint>
#include <functional>

#include "observations/fixed_moments.h"
#include "tress/adaptive/options.h"

namespace tress::adaptive {

/// m.variance() as the standard error of the mean.
double standard_error(const Moments& m);

/// The running objective of one row. Scores are of fits that did not know them: azimuths drawn from the proposal of the
/// fit that they score, after it was made.
class StopTest {
 public:
  enum class Verdict : std::uint8_t { undecided, converged, refused };

  /// failed: tests that the row failed in an earlier life.
  explicit StopTest(std::uint32_t failed = 0) : failed_(failed) {}

  /// Scores an azimuth drawn with density q: residual = g - f there, variation as of TracedNodes. Any thread.
  void add(double residual, double q, double variation) { scores_.add(residual * residual / (q * variation)); }
  std::uint64_t scores() const { return scores_.count(); }

  /// Tests and clears the scores. False, and nothing done, while there are too few. Not beside add().
  /// known: the most that the relative squared L2 error can be, asked where the scores alone would end the row. It must
  /// be within epsilon too: a region that the proposal hardly draws from may be wrong without any score seeing it.
  bool run(const Options& options, const std::function<double()>& known);

  /// The verdict on an error that is known, as relative squared L2, not sampled: converged if it is at most epsilon,
  /// else refused, which counts as one failed test. Not beside add().
  void judge(double objective, const Options& options);

  Verdict verdict() const { return verdict_; }
  /// Of the last test, as a cache stores it; once converged, the largest of the tests that were passed. Relative
  /// squared L2; negative before the first test.
  float bound() const { return bound_; }
  bool last_failed() const { return last_failed_; }
  /// Whether the scores of the last test passed and the known error did not.
  bool overruled() const { return overruled_; }
  std::uint32_t failed() const { return failed_; }

  /// All that it is, as plain data, and back: what it then does is the same to the bit. Not beside add().
  struct State {
    FixedMoments<2>::Words scores{};
    Verdict verdict = Verdict::undecided;
    float bound = -1;
    float largest_passed = 0;  ///< largest bound of the present run of passed tests
    std::uint32_t passed = 0;  ///< length of that run
    std::uint32_t failed = 0;  ///< in all
    bool last_failed = false;
    bool overruled = false;
  };
  State state() const;
  void set_state(const State& state);

 private:
  FixedMoments<2> scores_;  ///< of min(4, r^2/(q L)), since the last test
  // The same as in State.
  Verdict verdict_ = Verdict::undecided;
  float bound_ = -1;
  float largest_passed_ = 0;
  std::uint32_t passed_ = 0;
  std::uint32_t failed_ = 0;
  bool last_failed_ = false;
  bool overruled_ = false;
};

}  // namespace tress::adaptive
