// Lanes for the laws of rows, for kernels that foreach_target compiles once for every instruction set. There
// is no #pragma once, because it is read once for every target. Sums use at most eight lanes, so that AVX2 and AVX-512
// add up in one order.
#if defined(TRESS_DENSITY_LAW_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TRESS_DENSITY_LAW_LANES_H
#undef TRESS_DENSITY_LAW_LANES_H
#else
#define TRESS_DENSITY_LAW_LANES_H
#endif

#include <hwy/highway.h>

#include "base/float_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace tress::inline v0_2::adaptive {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, 8>;
using Fours = hn::CappedTag<float, 4>;
using F = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;
// For what is not added up.
using Wide = hn::CappedTag<float, 16>;
using W = hn::Vec<Wide>;
using WideMask = hn::Mask<Wide>;
using Integers = hn::RebindToSigned<Wide>;

HWY_INLINE F ExpOf(F x) { return tress::HWY_NAMESPACE::ExpOf(Floats(), x); }
HWY_INLINE W WideExpOf(W x) { return tress::HWY_NAMESPACE::ExpOf(Wide(), x); }
HWY_INLINE F LogOf(F x) { return tress::HWY_NAMESPACE::LogOf(Floats(), x); }

}  // namespace HWY_NAMESPACE
}  // namespace tress::inline v0_2::adaptive
HWY_AFTER_NAMESPACE();

#endif
