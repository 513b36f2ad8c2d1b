#include "learner/row_learner.h"

#include <memory>
#include <utility>

namespace tress::adaptive {

float Lesson::g(float x) {
  ++g_evaluations;
  ++count;
  return nodes.density(x);
}

void Lesson::publish(const Mixture& mixture) {
  fit = mixture;
  has_fit = true;
  ++fits;
}

void Lesson::close(KnotTable table, double objective) {
  ++fits;
  has_fit = false;
  stop.judge(objective, options);
  if (stop.verdict() == StopTest::Verdict::converged) knots = std::make_unique<const KnotTable>(std::move(table));
}

ObservedPair Lesson::draw_own() {
  const float share = options.uniform_share_open;
  const float x = fit.sample(random.next(), share);
  const float value = g(x);
  stop.add(static_cast<double>(value) - fit.density(x), fit.proposal_density(x, share), nodes.variation());
  return {x, value};
}

void RowLearner::before_test(Lesson&) {}

}  // namespace tress::adaptive
