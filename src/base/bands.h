// Three narrow bands of light, in which a spectral render works in place of Rec. 709.
//
// A band is one wavelength. Under white light (D65) that has passed a length of eumelanin, pheomelanin or any mix of
// them, rgb_of_bands() of what the bands keep is within 0.0025 of the color of the whole spectrum (CIE 1931), white
// being 1; bench/figures/spectral.py fitted the wavelengths and the matrices, and checks them.
#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace tress::inline v0_2 {

constexpr std::array<double, 3> band_wavelengths_nm{615, 538, 448};

/// The bands of light or of a reflectance, linear Rec. 709. None of the factors is negative, so colors stay colors.
inline glm::vec3 bands_of_rgb(const glm::vec3& rgb) {
  return {0.74f * rgb.r + 0.245f * rgb.g + 0.015f * rgb.b, 0.951f * rgb.g + 0.049f * rgb.b,
          0.035f * rgb.r + 0.965f * rgb.b};
}

/// The inverse. Saturated light is outside of Rec. 709, and has a channel below 0.
inline glm::vec3 rgb_of_bands(const glm::vec3& bands) {
  return {1.35150877f * bands.r - 0.34818049f * bands.g - 0.00332828f * bands.b,
          0.00252566f * bands.r + 1.05087404f * bands.g - 0.05339970f * bands.b,
          -0.04901845f * bands.r + 0.01262831f * bands.g + 1.03639015f * bands.b};
}

}  // namespace tress::inline v0_2
