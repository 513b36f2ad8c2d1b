#include "fiber/fourier_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fiber/reference_data.h"

namespace {

using namespace tress;
using test::degree;

TEST(FourierReference, AgreesWithReference) {
  const auto rows = test::reference_rows("azimuthal.csv");
  ASSERT_FALSE(rows.empty());
  // The table's tolerance at 8192 midpoints: 3e-4 1/rad, and relative L2 3e-3 where E_p > 1e-6.
  for (const auto& row : rows) {
    fiber::ReferenceRequest request;
    request.eta = std::stod(row[1]);
    request.eccentricity = std::stod(row[2]);
    request.theta_d = std::stod(row[3]) * degree;
    request.phi_r = std::stod(row[4]) * degree;
    request.sigma = std::stod(row[5]) * degree;
    request.sigma_a = std::stod(row[6]);
    request.p = std::stoi(row[7]);
    request.nodes = 8192;
    const fiber::FourierReference reference(request);
    const double energy = std::stod(row[9]);
    double difference = 0, norm = 0, largest = 0;
    for (int k = 0; k < 360; ++k) {
      const double n = std::stod(row[std::size_t(10 + k)]), d = reference.density((k - 180) * degree) - n;
      difference += d * d;
      norm += n * n;
      largest = std::max(largest, std::abs(d));
    }
    EXPECT_LT(largest, 3e-4) << "row " << row[0] << ' ' << row[8];
    if (energy > 1e-6) {
      EXPECT_LT(std::sqrt(difference / norm), 3e-3) << "row " << row[0] << ' ' << row[8];
    }
    EXPECT_NEAR(reference.energy(), energy, 5e-5) << "row " << row[0] << ' ' << row[8];
  }
}

}  // namespace
