#include "tress/fiber/fiber_model.h"

#include <algorithm>

namespace tress::inline v0_2::fiber {

FiberValue FiberModel::mean(FiberId fiber, const FiberDirection& wr, const FiberDirection& wi, float h) const {
  if (fiber >= fiber_count_) return {};
  NodeSteps steps = steps_between_nodes(fiber, wr, wi);
  std::ranges::sort(steps.xi1);
  FiberValue mean;
  // Between two steps all events are the same.
  float from1 = 0;
  for (std::size_t i = 0; i <= steps.xi1.size(); ++i) {
    const float to1 = i < steps.xi1.size() ? steps.xi1[i] : 1;
    if (!(to1 > from1)) continue;
    for (const auto& [from2, to2] : {std::array{0.0f, steps.xi2}, std::array{steps.xi2, 1.0f}}) {
      if (!(to2 > from2)) continue;
      FiberEvent event = begin(fiber, wr, 0.5f * (from1 + to1), 0.5f * (from2 + to2), h, 0);
      if (!evaluates(event)) return {};
      event.is_of_mean = true;
      const FiberValue value = evaluate_event(event, wi);
      const float share = (to1 - from1) * (to2 - from2);
      for (std::size_t lobe = 0; lobe < lobe_count; ++lobe) mean.s[lobe] += share * value.s[lobe];
      mean.pdf += share * value.pdf;
      mean.queries = static_cast<std::uint16_t>(mean.queries + value.queries);
      mean.exact_queries = static_cast<std::uint16_t>(mean.exact_queries + value.exact_queries);
      mean.objective += value.objective;
    }
    from1 = to1;
  }
  return mean;
}

FiberSample FiberModel::sample_mean(FiberId fiber, const FiberDirection& wr, const std::array<float, 6>& u,
                                    float importance, float h) const {
  FiberEvent event = begin(fiber, wr, u[4], u[5], h, importance);
  if (event.fiber >= fiber_count_ || !evaluates(event)) return {};
  event.is_of_mean = true;
  FiberSample drawn = sample(event, {u[0], u[1], u[2], u[3]});
  drawn.value = mean(fiber, wr, drawn.wi, h);
  return drawn;
}

}  // namespace tress::inline v0_2::fiber
