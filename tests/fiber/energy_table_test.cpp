#include "fiber/energy_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tress/adaptive/random.h"

namespace {

using namespace tress;
constexpr float pi = std::numbers::pi_v<float>;

const fiber::EnergyTable& brown() {
  static const fiber::EnergyTable table(1.55f, 0.85f, glm::vec3(0.545f, 0.906f, 1.781f));
  return table;
}

TEST(EnergyTable, ClearLobesSumToOne) {
  RandomStream random(3);
  for (int i = 0; i < 2000; ++i) {
    const auto e = brown().at(2 * pi * random.next() - pi, pi * random.next() - pi / 2);
    double sum = 0;
    for (float lobe : e.clear) sum += lobe;
    EXPECT_NEAR(sum, 1, 1e-6);
  }
}

TEST(EnergyTable, AgreesWithDirectTraces) {
  // Against 8192 rays at 300 directions, uniform in phi and cos theta; the design has 4e-5 median, 1.5e-3 at 99 %,
  // .008 largest (absolute, one e).
  RandomStream random(4);
  std::vector<double> errors;
  for (int i = 0; i < 300; ++i) {
    const float phi = 2 * pi * random.next() - pi, theta = std::acos(random.next());
    const auto table = brown().interpolated(phi, theta);
    const auto direct = fiber::traced_energies(1.55f, 0.85f, glm::vec3(0.545f, 0.906f, 1.781f), phi, theta, 8192);
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
      errors.push_back(std::abs(table.clear[p] - direct.clear[p]));
      for (int c = 0; c < 3; ++c) errors.push_back(std::abs(table.colored[p][c] - direct.colored[p][c]));
    }
  }
  std::sort(errors.begin(), errors.end());
  const double median = errors[errors.size() / 2], most = errors[errors.size() * 99 / 100];
  RecordProperty("median", std::to_string(median));
  RecordProperty("most", std::to_string(most));
  RecordProperty("largest", std::to_string(errors.back()));
  EXPECT_LT(median, 1e-4);
  EXPECT_LT(most, 3e-3);
  EXPECT_LT(errors.back(), 0.015);
}

TEST(EnergyTable, WeakLobesGiveTheirEnergyToTheResidual) {
  const fiber::EnergyTable dark(1.55f, 0.85f, glm::vec3(3.0f));
  RandomStream random(5);
  int moved = 0;
  for (int i = 0; i < 500; ++i) {
    const float phi = pi * random.next(), theta = 3 * random.next() - 1.5f;
    const auto all = dark.interpolated(phi, theta), kept = dark.at(phi, theta);
    float before = 0, after = 0, luminance = 0;
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
      before += all.colored[p].r;
      after += kept.colored[p].r;
      luminance += fiber::luminance(all.colored[p]);
    }
    EXPECT_NEAR(before, after, 1e-6f);
    for (std::size_t p = 1; p < 4; ++p) {
      const bool weak = all.clear[p] < 1e-3f || fiber::luminance(all.colored[p]) < 1e-3f * luminance;
      EXPECT_EQ(kept.clear[p], weak ? 0 : all.clear[p]);
      EXPECT_EQ(kept.colored[p], weak ? glm::vec3(0) : all.colored[p]);
      moved += weak;
    }
  }
  EXPECT_GT(moved, 100);  // sigma_a 3 leaves TRRT e^-18 of its light
}

TEST(EnergyTable, FoldsAzimuthAndInclination) {
  const auto at = [](float phi, float theta) { return brown().at(phi, theta).clear[2]; };
  EXPECT_NEAR(at(0.4f, 0.7f), at(-0.4f, 0.7f), 1e-6f);
  EXPECT_NEAR(at(0.4f, 0.7f), at(pi - 0.4f, -0.7f), 1e-6f);
  EXPECT_NEAR(at(0.4f, 0.7f), at(0.4f - pi, -0.7f), 1e-6f);
}

TEST(EnergyTable, ExtremeFibersAreFinite) {
  for (float eta : {1.05f, 3.0f}) {
    const fiber::EnergyTable table(eta, 0.5f, glm::vec3(0, 1, 100));
    for (float theta : {-pi / 2, -1.57f, 0.0f, 1.5f, pi / 2}) {
      for (float phi : {-pi, -0.1f, 0.0f, pi / 2, pi}) {
        const auto e = table.at(phi, theta);
        double sum = 0;
        for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
          sum += e.clear[p];
          for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(std::isfinite(e.colored[p][c]) && e.colored[p][c] >= 0);
            EXPECT_LE(e.colored[p][c], e.clear[p] + 1e-6f);
          }
        }
        EXPECT_NEAR(sum, 1, 1e-6);
      }
    }
    EXPECT_NEAR(table.at(0.3f, pi / 2).clear[0], 1, 1e-5);
  }
}

}  // namespace
