// A family of targets for tests: two peaks that move, widen and trade mass over the grid.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tress/adaptive/target.h"

namespace tress::testing {

/// Two bundles of rays around moving directions, each spread unevenly (a caustic's shape: denser at one side). The
/// attribute is 1 in the first bundle and 3 in the second.
class MovingPeaks final : public adaptive::Target {
 public:
  /// turn: of all azimuths, as a target that has changed under its name.
  explicit MovingPeaks(float turn = 0) : turn_(turn) {}
  void trace(const adaptive::SliceDescription& slice, float a, float b,
             std::vector<adaptive::TracedRay>& out) const override {
    const float shift = slice.key.parameters[0];
    for (int i = 0; i < 64; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / 64;
      out.push_back({2.0f * a + shift + 0.8f * t * t + turn_, (0.3f + 0.4f * b) / 64, 1.0f});
      out.push_back({-1.5f + a - b - shift - 0.5f * t * t * t + turn_, (0.5f - 0.4f * b) / 64, 3.0f});
    }
  }
  std::string model_name() const override { return "moving-peaks-1"; }

 private:
  float turn_;
};

/// size x size nodes over [0, 1]^2.
inline adaptive::SliceDescription toy_slice(std::uint32_t lobe, std::uint32_t size, float blur_rad = 0.2f) {
  adaptive::SliceDescription slice;
  slice.key.lobe = lobe;
  slice.key.parameters = {0.3f * static_cast<float>(lobe), 1.0f, blur_rad};
  slice.blur_rad = blur_rad;
  for (std::uint32_t i = 0; i < size; ++i) {
    slice.axis_a.push_back((static_cast<float>(i) + 0.5f) / static_cast<float>(size));
    slice.axis_b.push_back((static_cast<float>(i) + 0.5f) / static_cast<float>(size));
  }
  return slice;
}

}  // namespace tress::testing
