#include "fiber/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fiber/reference_data.h"

namespace {

using namespace tress;
using test::degree;

TEST(Fresnel, AgreesWithThirtyDigitReference) {
  const auto rows = test::reference_rows("fresnel.csv");
  ASSERT_FALSE(rows.empty());
  // The table prints 10 digits; its tolerance for doubles is 1e-8.
  for (const auto& row : rows) {
    const double eta = std::stod(row[0]), theta = std::stod(row[1]) * degree, gamma = std::stod(row[2]) * degree;
    const double eta_prime = fiber::bravais_index(eta, theta);
    EXPECT_NEAR(eta_prime, std::stod(row[4]), 1e-8 * eta_prime);
    double cos_t;
    const double r = row[3] == "in" ? fiber::fresnel_entering(eta, eta_prime, std::cos(gamma), &cos_t)
                                    : fiber::fresnel_leaving(eta, eta_prime, std::cos(gamma), &cos_t);
    EXPECT_NEAR(r, std::stod(row[11]), 1e-8) << row[0] << ' ' << row[1] << ' ' << row[2] << ' ' << row[3];
    EXPECT_NEAR(cos_t, std::cos(std::stod(row[7]) * degree), 1e-8);
    EXPECT_EQ(row[12] == "1", cos_t == 0);
  }
}

TEST(Fresnel, IsTheSameInBothDirections) {
  for (double theta : {0.0, 0.5, 1.2, 1.5}) {
    const double eta_prime = fiber::bravais_index(1.55, theta);
    for (double c = 0.05; c <= 1; c += 0.05) {
      double inside, outside;
      const double entering = fiber::fresnel_entering(1.55, eta_prime, c, &inside);
      EXPECT_NEAR(fiber::fresnel_leaving(1.55, eta_prime, inside, &outside), entering, 1e-10);
      // cos 1.5 = 0.07: eta' = 16.8 magnifies the rounding of cos_t by eta'^2/c.
      EXPECT_NEAR(outside, c, 1e-11);
    }
  }
}

TEST(Fresnel, NormalIncidenceIsTheTextbookValue) {
  double cos_t;
  EXPECT_NEAR(fiber::fresnel_entering(1.55, 1.55, 1, &cos_t), std::pow(0.55 / 2.55, 2), 1e-15);
}

TEST(Fresnel, GrazingReflectsEverything) {
  double cos_t;
  EXPECT_DOUBLE_EQ(fiber::fresnel_entering(1.55, fiber::bravais_index(1.55, 1.0), 0, &cos_t), 1);
  // At theta = 90 degrees the clamped cosine (1e-6) makes eta' 1.2e6: 1 - R is of the order of 4 eta^2/eta'.
  EXPECT_NEAR(fiber::fresnel_entering(1.55, fiber::bravais_index(1.55, 1.5707963267948966), 1, &cos_t), 1, 1e-5);
}

}  // namespace
