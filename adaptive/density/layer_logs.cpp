#include "density/layer_logs.h"

#include <algorithm>
#include <cmath>

#include "base/logarithm.h"

// Loops over knots, without calls or branches, are compiled into lanes of every instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "density/layer_logs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

template <std::size_t count>
HWY_INLINE void FindLogs(std::span<const RibbonKnot, count> knots, float largest, LayerLogs::Of<count>& logs) {
  constexpr float least_share = 1e-30f, bend = static_cast<float>(CodeLimits::bend);
  constexpr float per_first = 1 / Ribbon::decay_rates[0], per_second = 1 / Ribbon::decay_rates[1];
  constexpr float per_attribute = static_cast<float>(1 / CodeLimits::least_attribute);
  constexpr float least_scale = Ribbon::least_scale;
  for (std::size_t k = 0; k < count; ++k) {
    const RibbonKnot& knot = knots[k];
    logs.density[k] = std::max(knot.density / largest, least_share);
    logs.mode[k] = std::abs(knot.mode / bend);
    logs.below[k] = std::max(knot.scale_below, least_scale) / least_scale;
    logs.above[k] = std::max(knot.scale_above, least_scale) / least_scale;
    logs.attribute[k] = std::clamp(knot.decays[0], CodeLimits::least_decay, 1.0f);
    logs.second[k] = std::clamp(knot.decays[1], CodeLimits::least_decay, 1.0f);
  }
  for (float& x : logs.density) x = natural_log(x);
  for (float& x : logs.mode) x = natural_log(x + std::sqrt(x * x + 1));
  for (float& x : logs.below) x = natural_log(x);
  for (float& x : logs.above) x = natural_log(x);
  for (float& x : logs.attribute) x = -natural_log(x) * per_first;
  for (float& x : logs.second) x = -natural_log(x) * per_second;
  for (std::size_t k = 0; k < count; ++k)
    logs.logarithm[k] = natural_log(std::max(logs.attribute[k] * per_attribute, 1.0f));
}

void MainLogs(std::span<const RibbonKnot, Ribbon::main_knots> knots, float largest,
              LayerLogs::Of<Ribbon::main_knots>& logs) {
  FindLogs(knots, largest, logs);
}
void BroadLogs(std::span<const RibbonKnot, Ribbon::broad_knots> knots, float largest,
               LayerLogs::Of<Ribbon::broad_knots>& logs) {
  FindLogs(knots, largest, logs);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(MainLogs);
HWY_EXPORT(BroadLogs);

LayerLogs::Of<Ribbon::main_knots> LayerLogs::of(std::span<const RibbonKnot, Ribbon::main_knots> knots, float largest) {
  Of<Ribbon::main_knots> logs;
  HWY_DYNAMIC_DISPATCH(MainLogs)(knots, largest, logs);
  return logs;
}
LayerLogs::Of<Ribbon::broad_knots> LayerLogs::of(std::span<const RibbonKnot, Ribbon::broad_knots> knots,
                                                 float largest) {
  Of<Ribbon::broad_knots> logs;
  HWY_DYNAMIC_DISPATCH(BroadLogs)(knots, largest, logs);
  return logs;
}

}  // namespace tress::inline v0_2::adaptive
#endif
