// Natural logarithm without libm, so that it is inlined where lobes are sampled.
#pragma once

#include <bit>
#include <cstdint>

namespace tress::inline v0_2 {

/// ln x for a normal x > 0. The relative error is below 2e-7, also near x = 1 (Cephes, logf).
inline float natural_log(float x) {
  // x = m 2^k, m in [sqrt 1/2, sqrt 2)
  const auto bits = std::bit_cast<std::int32_t>(x) - 0x3f3504f3;
  const float k = static_cast<float>(bits >> 23);
  const float r = std::bit_cast<float>((bits & 0x7fffff) + 0x3f3504f3) - 1;
  const float z = r * r, z2 = z * z;
  // Adds terms in pairs, and the pairs by z: the chain of dependent operations is half as long.
  const float low = (3.3333331174e-1f - 2.4999993993e-1f * r) + z * (2.0000714765e-1f - 1.6668057665e-1f * r);
  const float high = (1.4249322787e-1f - 1.2420140846e-1f * r) + z * (1.1676998740e-1f - 1.1514610310e-1f * r);
  const float p = low + z2 * high + z2 * z2 * 7.0376836292e-2f;
  return ((r * z * p - 2.12194440e-4f * k) - 0.5f * z) + r + 0.693359375f * k;
}

}  // namespace tress::inline v0_2
