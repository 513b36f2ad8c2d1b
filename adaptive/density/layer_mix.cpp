#include "density/layer_mix.h"

#include <algorithm>
#include <array>

#include "base/exp_of_negative.h"
#include "base/logarithm.h"

// Loops over knots, without calls or branches, are compiled into lanes of every instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "density/layer_mix.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

template <std::size_t count>
HWY_INLINE void Mix(std::span<const LayerPart<count>> layers, std::span<RibbonKnot, count> mean) {
  constexpr float log_of_largest = -0.105360516f;  // ln of the largest scale
  static_assert(Ribbon::largest_scale == 0.9f);
  using Lanes = std::array<float, count>;
  Lanes density{}, mode{}, below{}, above{}, first{}, second{};
  for (const LayerPart<count>& layer : layers) {
    const float w = layer.weight;
    Lanes below_here, above_here;
    for (std::size_t k = 0; k < count; ++k) {
      const RibbonKnot& from = layer.knots[(k + layer.shift) % count];
      density[k] += w * from.density;
      mode[k] += w * from.mode;
      first[k] += w * from.decays[0];
      second[k] += w * from.decays[1];
      below_here[k] = from.scale_below;
      above_here[k] = from.scale_above;
    }
    for (std::size_t k = 0; k < count; ++k) below[k] += w * (natural_log(below_here[k]) + layer.widen);
    for (std::size_t k = 0; k < count; ++k) above[k] += w * (natural_log(above_here[k]) + layer.widen);
  }
  for (Lanes* scale : {&below, &above}) {
    for (float& x : *scale) x = Ribbon::largest_scale * exp_of_negative(std::min(x - log_of_largest, 0.0f));
  }
  for (std::size_t k = 0; k < count; ++k) {
    mean[k].density = density[k];
    mean[k].mode = std::clamp(mode[k], -Ribbon::largest_mode, Ribbon::largest_mode);
    mean[k].scale_below = std::clamp(below[k], Ribbon::least_scale, Ribbon::largest_scale);
    mean[k].scale_above = std::clamp(above[k], Ribbon::least_scale, Ribbon::largest_scale);
    mean[k].decays = {std::min(first[k], 1.0f), std::min(second[k], 1.0f)};
  }
}

void MixMain(std::span<const LayerPart<Ribbon::main_knots>> layers, std::span<RibbonKnot, Ribbon::main_knots> mean) {
  Mix(layers, mean);
}
void MixBroad(std::span<const LayerPart<Ribbon::broad_knots>> layers, std::span<RibbonKnot, Ribbon::broad_knots> mean) {
  Mix(layers, mean);
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(MixMain);
HWY_EXPORT(MixBroad);

void mix_layers(std::span<const LayerPart<Ribbon::main_knots>> layers, std::span<RibbonKnot, Ribbon::main_knots> mean) {
  HWY_DYNAMIC_DISPATCH(MixMain)(layers, mean);
}
void mix_layers(std::span<const LayerPart<Ribbon::broad_knots>> layers,
                std::span<RibbonKnot, Ribbon::broad_knots> mean) {
  HWY_DYNAMIC_DISPATCH(MixBroad)(layers, mean);
}

}  // namespace tress::inline v0_2::adaptive
#endif
