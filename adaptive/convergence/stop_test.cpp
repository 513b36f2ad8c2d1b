#include "convergence/stop_test.h"

#include <algorithm>
#include <cmath>

namespace tress::inline v0_2::adaptive {

double standard_error(const Moments& m) { return std::sqrt(m.variance() / static_cast<double>(m.count)); }

bool StopTest::run(const Options& options, const std::function<double()>& known) {
  const Moments scores = scores_.moments();
  if (scores.count < options.scores_per_test()) return false;
  scores_.clear();
  // The bound is rounded to the float that a cache stores, so that the stored bound passes whenever this one does.
  now_.bound = static_cast<float>(scores.mean + 2 * standard_error(scores));
  now_.last_failed = !(now_.bound <= options.epsilon);
  now_.overruled = false;
  if (!now_.last_failed && now_.passed + 1 >= options.tests_to_converge()) {
    now_.bound = std::max(now_.bound, static_cast<float>(known()));
    now_.last_failed = now_.overruled = !(now_.bound <= options.epsilon);
  }
  if (now_.last_failed) {
    now_.passed = 0;
    now_.largest_passed = 0;
    if (++now_.failed >= options.tests_before_refusal) now_.verdict = Verdict::refused;
    return true;
  }
  now_.largest_passed = std::max(now_.largest_passed, now_.bound);
  if (++now_.passed < options.tests_to_converge()) return true;
  now_.verdict = Verdict::converged;
  now_.bound = now_.largest_passed;
  return true;
}

}  // namespace tress::inline v0_2::adaptive
