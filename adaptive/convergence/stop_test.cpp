#include "convergence/stop_test.h"

#include <algorithm>
#include <cmath>

namespace tress::adaptive {

double standard_error(const Moments& m) { return std::sqrt(m.variance() / static_cast<double>(m.count)); }

bool StopTest::run(const Options& options, const std::function<double()>& known) {
  const Moments scores = scores_.moments();
  if (scores.count < options.scores_per_test()) return false;
  scores_.clear();
  // The bound is rounded to the float that a cache stores, so that the stored bound passes whenever this one does.
  bound_ = static_cast<float>(scores.mean + 2 * standard_error(scores));
  last_failed_ = !(bound_ <= options.epsilon);
  overruled_ = false;
  if (!last_failed_ && passed_ + 1 >= options.tests_to_converge()) {
    bound_ = std::max(bound_, static_cast<float>(known()));
    last_failed_ = overruled_ = !(bound_ <= options.epsilon);
  }
  if (last_failed_) {
    passed_ = 0;
    largest_passed_ = 0;
    if (++failed_ >= options.tests_before_refusal) verdict_ = Verdict::refused;
    return true;
  }
  largest_passed_ = std::max(largest_passed_, bound_);
  if (++passed_ < options.tests_to_converge()) return true;
  verdict_ = Verdict::converged;
  bound_ = largest_passed_;
  return true;
}

void StopTest::judge(double objective, const Options& options) {
  bound_ = static_cast<float>(objective);
  last_failed_ = !(bound_ <= options.epsilon);
  failed_ += last_failed_ ? 1 : 0;
  verdict_ = last_failed_ ? Verdict::refused : Verdict::converged;
}

StopTest::State StopTest::state() const {
  return {scores_.words(), verdict_, bound_, largest_passed_, passed_, failed_, last_failed_, overruled_};
}

void StopTest::set_state(const State& state) {
  scores_.set_words(state.scores);
  verdict_ = state.verdict;
  bound_ = state.bound;
  largest_passed_ = state.largest_passed;
  passed_ = state.passed;
  failed_ = state.failed;
  last_failed_ = state.last_failed;
  overruled_ = state.overruled;
}

}  // namespace tress::adaptive
