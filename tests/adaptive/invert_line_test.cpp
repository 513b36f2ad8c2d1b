// The inverse of a straight line of density.
#include "density/invert_line.h"

#include <gtest/gtest.h>

namespace tress::inline v0_2::adaptive {
namespace {

TEST(InvertLine, KeepsItsBitsWhereTheLineIsNearlyFlat) {
  EXPECT_FLOAT_EQ(invert_line(1, 1, 0.3f), 0.3f);
  EXPECT_NEAR(invert_line(1, 1.000001f, 0.3f), 0.3f, 1e-6f);
  EXPECT_FLOAT_EQ(invert_line(0, 1, 0.25f), 0.5f);
  EXPECT_FLOAT_EQ(invert_line(1, 0, 0.75f), 0.5f);
  EXPECT_FLOAT_EQ(invert_line(0, 0, 0.4f), 0.4f);
  EXPECT_FLOAT_EQ(invert_line(2, 5, 1), 1.0f);
  EXPECT_FLOAT_EQ(invert_line(2, 5, 0), 0.0f);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
