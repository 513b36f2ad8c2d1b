// A family of targets for tests that can only be drawn from: two lobes over a cylinder that move and trade mass.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tress/adaptive/sampled_target.h"
#include "tress/base/random.h"

namespace tress::testing {

/// Part 0: a normal lobe. Part 1: a broader one, behind it. Each path leaves in both, with the part's mass. Of one
/// model with MovingPeaks.
class MovingLobes : public adaptive::SampledTarget {
 public:
  /// turn: of all azimuths, as a target that has changed under its name.
  explicit MovingLobes(float turn = 0) : turn_(turn) {}
  std::uint32_t parts(const adaptive::SliceDescription&) const override { return 2; }
  void draw(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<adaptive::SampledExit>& out) const override {
    for (std::uint32_t i = first; i < first + count; ++i) {
      RandomStream random(mix_bits(slice.key.lobe) ^ stream, i,
                          static_cast<std::uint64_t>(64 * a) * 64 + static_cast<std::uint64_t>(64 * b));
      const Pair one = normal_pair(random), other = normal_pair(random);
      out.push_back({2 * a + turn_ + 0.3f * one.x, b + 0.2f * one.y, 0, 0.3f + 0.4f * b, 1.0f});
      out.push_back(
          {a - 2 - turn_ + 0.6f * other.x, -b + 0.3f * other.y, 1, 0.5f - 0.4f * b, 2.0f + 0.1f * other.x * other.x});
    }
  }
  std::string model_name() const override { return "moving-peaks-1"; }

 protected:
  struct Pair {
    float x, y;
  };
  static Pair normal_pair(RandomStream& random) {
    const float r = std::sqrt(-2 * std::log(1 - random.next())), phi = 2 * std::numbers::pi_v<float> * random.next();
    return {r * std::cos(phi), r * std::sin(phi)};
  }

 private:
  float turn_;
};

/// size x size nodes over [0, 1]^2.
inline adaptive::SliceDescription sampled_slice(std::uint32_t lobe, std::uint32_t size) {
  adaptive::SliceDescription slice;
  slice.key.lobe = lobe;
  slice.key.parameters = {0.3f, 1.0f, 0.2f, 0.0f, 0.05f};
  slice.kind = adaptive::SliceKind::samples;
  for (std::uint32_t i = 0; i < size; ++i) {
    slice.axis_a.push_back((static_cast<float>(i) + 0.5f) / static_cast<float>(size));
    slice.axis_b.push_back((static_cast<float>(i) + 0.5f) / static_cast<float>(size));
  }
  return slice;
}

}  // namespace tress::testing
