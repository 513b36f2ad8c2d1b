// The traced fiber against goniophotometry of human hair: F.-J. Wortmann, E. Schulze zur Wiesche and A. Bierbaum,
// "Analyzing the laser-light reflection from human hair fibers", Journal of Cosmetic Science 54 (2003). For light at 40
// degrees and scales tilted by 2.5 degrees they state a specular peak at 35 degrees and one reflected inside at 55.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/pi.h"
#include "fiber/rough_rows.h"
#include "support/scale.h"
#include "support/seed.h"
#include "tress/adaptive/sampled_target.h"

namespace tress::fiber {
namespace {

enum Part : std::uint32_t { specular = 0, internal = 2 };

/// Degrees from the normal plane at which the radiance of a part is highest, among the exits within 15 degrees of the
/// plane of light and axis, after a blur of 2 degrees.
double peak_of(const std::vector<adaptive::SampledExit>& exits, double incidence, std::uint32_t part) {
  constexpr int bins = 360;
  constexpr double per_degree = 2;
  std::vector<double> flux(bins, 0.0), blurred(bins, 0.0);
  for (const adaptive::SampledExit& exit : exits) {
    if (exit.part != part || std::abs(std::remainder(static_cast<double>(exit.azimuth), two_pi)) > 15 * degree)
      continue;
    const float height = exit.height + static_cast<float>(specular_height(static_cast<float>(incidence)));
    const double theta = static_cast<double>(theta_of(height));
    const int bin = std::clamp(static_cast<int>((theta / degree + 90) * per_degree), 0, bins - 1);
    flux[static_cast<std::size_t>(bin)] += static_cast<double>(exit.weight) / std::cos(theta);
  }
  for (int i = 0; i < bins; ++i) {
    for (int j = 0; j < bins; ++j) {
      const double sigmas = (i - j) / (2 * per_degree);
      blurred[static_cast<std::size_t>(i)] += flux[static_cast<std::size_t>(j)] * std::exp(-0.5 * sigmas * sigmas);
    }
  }
  return static_cast<double>(std::ranges::max_element(blurred) - blurred.begin()) / per_degree - 90;
}

// Roughness 0.02: a rougher surface moves the internal peak towards the normal plane, by 3 degrees at 0.05. Seed 77;
// the peaks of other seeds differ by one bin of half a degree at most, also with a 16th of the draws.
TEST(MeasuredHair, ReflectsWhereGoniophotometersFindThePeaks) {
  const auto target = make_rough_target();
  for (const double tilt : {2.5, 3.0, 4.0}) {
    FiberParameters hair;
    hair.eccentricity = 1;
    hair.roughness = 0.02f;
    hair.tilt = static_cast<float>(tilt * degree);
    const double incidence = -40 * degree;  // towards the root
    std::vector<adaptive::SampledExit> exits;
    target->draw(rough_slice(hair), static_cast<float>(incidence), 0, test::seed(77), 0,
                 static_cast<std::uint32_t>(test::scaled(1 << 20)), exits);
    EXPECT_NEAR(peak_of(exits, incidence, specular), 40 - 2 * tilt, 1) << tilt;
    if (tilt == 2.5) {
      EXPECT_NEAR(peak_of(exits, incidence, internal), 55, 1);
    }
  }
}

}  // namespace
}  // namespace tress::fiber
