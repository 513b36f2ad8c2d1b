// Sines and cosines of angles within a quarter turn of 0, without libm, for inclinations and half angles.
#pragma once

namespace tress::inline v0_2 {

/// sin x of a float or of lanes for |x| <= pi/2, with a relative error below 2e-7: the series to x^11, whose next term
/// is x^13/13! <= 6e-8.
template <class Float>
inline Float quarter_sine(Float x) {
  const Float z = x * x;
  return x + x * z *
                 (-1.66666667e-1f +
                  z * (8.33333333e-3f + z * (-1.98412698e-4f + z * (2.75573192e-6f + z * -2.50521084e-8f))));
}

/// Returns pi/2 - |x| for |x| <= pi/2; its sine is the cosine of x.
inline float from_quarter(float x) {
  const float from_the_end = (1.57079637f - (x < 0 ? -x : x)) - 4.37113883e-8f;  // pi/2 as the sum of two floats
  return from_the_end > 0 ? from_the_end : 0;
}

/// cos x for |x| <= pi/2, relative error below 3e-7 where it is above 1e-6; 0 at the float just above pi/2.
inline float quarter_cosine(float x) { return quarter_sine(from_quarter(x)); }

}  // namespace tress::inline v0_2
