// The lanes as machines without SSE have them, which no other program of ours compiles here.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

#undef __SSE2__
#include "base/exp_of_negative.h"
#include "base/float4.h"

namespace tress::inline v0_2 {
namespace {

TEST(Float4, WithoutSseHasTheSameValues) {
  const Float4 a{1, -2, 3, -4}, b{0.5f, 2, -6, -4}, c{9, 16, 0, 1}, d{7, 5, 3, 1};
  Float4 rows[4] = {a, b, c, d};
  transpose4(rows[0], rows[1], rows[2], rows[3]);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(max4(a, b)[i], std::fmax(a[i], b[i]));
    EXPECT_EQ(min4(a, b)[i], std::fmin(a[i], b[i]));
    EXPECT_EQ(sqrt4(c)[i], std::sqrt(c[i]));
    EXPECT_EQ(abs4(a)[i], std::abs(a[i]));
    EXPECT_EQ(exp_of_negative(-abs4(a))[i], exp_of_negative(-std::abs(a[i])));
    EXPECT_EQ(rows[i][0], a[i]);
    EXPECT_EQ(rows[i][3], d[i]);
  }
  const Float4 sums = sums4(a, b, c);
  EXPECT_EQ(sums[0], -2);
  EXPECT_EQ(sums[1], -7.5f);
  EXPECT_EQ(sums[2], 26);
  EXPECT_TRUE(any4(a < -3.0f));
  EXPECT_FALSE(any4(a < -4.0f));
}

}  // namespace
}  // namespace tress::inline v0_2
