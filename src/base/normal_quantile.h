// The inverse of the standard normal distribution function (Giles 2012, in single precision).
#pragma once

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace tress::inline v0_2 {

/// The z, of the sign of x, that a normal value exceeds in magnitude with probability 1 - |x|. x in (-1, 1); w: -ln(1 -
/// x^2), which the caller may know better than x.
inline float normal_beyond(float x, float w) {
  float p;
  if (w < 5) {
    w -= 2.5f;
    p = 2.81022636e-08f;
    for (const float c : {3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f, -0.00125372503f,
                          -0.00417768164f, 0.246640727f, 1.50140941f})
      p = c + p * w;
  } else {
    w = std::sqrt(w) - 3;
    p = -0.000200214257f;
    for (const float c : {0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f, -0.0076224613f,
                          0.00943887047f, 1.00167406f, 2.83297682f})
      p = c + p * w;
  }
  return std::numbers::sqrt2_v<float> * p * x;
}

/// Finite for u in [0, 1].
float normal_quantile(float u);

}  // namespace tress::inline v0_2
