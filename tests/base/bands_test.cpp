#include "base/bands.h"

#include <gtest/gtest.h>

namespace tress {
namespace {

TEST(Bands, OfAColorGiveItBack) {
  for (const glm::vec3& rgb : {glm::vec3(1), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}) {
    const glm::vec3 bands = bands_of_rgb(rgb), back = rgb_of_bands(bands);
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(bands[c], 0.0f);
      EXPECT_NEAR(back[c], rgb[c], 1e-6f);
    }
  }
  EXPECT_EQ(bands_of_rgb(glm::vec3(1)), glm::vec3(1)) << "white is 1 in every band";
}

}  // namespace
}  // namespace tress
