#include "density/blurred_sum.h"

#include <cstdint>

// foreach_target compiles this once for every instruction set; the first call chooses the machine's.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "density/blurred_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, 16>;
using Integers = hn::Repartition<std::int32_t, Floats>;
using V = hn::Vec<Floats>;

// Same method as exp_of_negative.
HWY_INLINE V Exp(V x) {
  const Floats d;
  const Integers i;
  x = hn::Max(x, hn::Set(d, -87.0f));
  const auto n = hn::ConvertTo(i, hn::MulAdd(x, hn::Set(d, 1.44269504f), hn::Set(d, -0.5f)));
  const V k = hn::ConvertTo(d, n);
  V r = hn::NegMulAdd(k, hn::Set(d, 0.693359375f), x);
  r = hn::MulAdd(k, hn::Set(d, 2.12194440e-4f), r);
  V p = hn::MulAdd(r, hn::Set(d, 1.38888889e-3f), hn::Set(d, 8.33333333e-3f));
  p = hn::MulAdd(p, r, hn::Set(d, 4.16666667e-2f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.66666667e-1f));
  p = hn::MulAdd(p, r, hn::Set(d, 0.5f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f));
  p = hn::MulAdd(p, r, hn::Set(d, 1.0f));
  return hn::BitCast(d, hn::Add(hn::BitCast(i, p), hn::ShiftLeft<23>(n)));
}

float BlurredSum(const float* azimuth, const float* weight, std::size_t count, float x, float precision) {
  const Floats d;
  const std::size_t lanes = hn::Lanes(d);
  const V centre = hn::Set(d, x), minus = hn::Set(d, -precision);
  const auto terms = [&](const float* a, const float* w) HWY_ATTR {
    const V offset = hn::Sub(hn::LoadU(d, a), centre);
    return hn::Mul(hn::LoadU(d, w), Exp(hn::Mul(hn::Mul(offset, offset), minus)));
  };
  V even = hn::Zero(d), odd = hn::Zero(d);
  for (std::size_t j = 0; j < count; j += 2 * lanes) {
    even = hn::Add(even, terms(azimuth + j, weight + j));
    if (j + lanes < count) odd = hn::Add(odd, terms(azimuth + j + lanes, weight + j + lanes));
  }
  return hn::GetLane(hn::SumOfLanes(d, hn::Add(even, odd)));
}

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tress::inline v0_2::adaptive {

HWY_EXPORT(BlurredSum);

float blurred_sum(const float* azimuth, const float* weight, std::size_t count, float x, float precision) {
  return HWY_DYNAMIC_DISPATCH(BlurredSum)(azimuth, weight, count, x, precision);
}

}  // namespace tress::inline v0_2::adaptive
#endif
