// tress-lab fit: what it prints is the row that it says it is.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cli/run_tress.h"
#include "models/learned_row.h"

namespace tress::test {
namespace {

class Fit : public CommandTest {
 protected:
  nlohmann::json fit(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "fit");
    arguments.push_back("--json");
    return run_json(arguments);
  }
};

/// The relative L2 and the mass as a reader of the file would work them out.
struct Recomputed {
  double relative_l2, energy;
};
Recomputed recompute(const nlohmann::json& json) {
  const auto target = json.at("target").get<std::vector<double>>(), fit = json.at("fit").get<std::vector<double>>();
  const double step = 2 * std::numbers::pi / double(target.size());
  double error = 0, square = 0, mass = 0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    error += std::pow(target[i] - fit[i], 2) * step;
    square += target[i] * target[i] * step;
    mass += target[i] * step;
  }
  const double floor = 1e-3 / (2 * std::numbers::pi);
  return {error / std::max(square - mass * mass / (2 * std::numbers::pi), floor), mass};
}

TEST_F(Fit, EveryLobeIsWithinEpsilonOfItsReference) {
  for (const char* lobe : {"R", "TT", "TRT", "GLINT", "TRRT"}) {
    // The azimuth in each quadrant: rows are learned in the first, and folded back.
    for (const char* phi : {"45", "-20", "130", "-110"}) {
      const nlohmann::json json =
          fit({"--lobe", lobe, "--e", ".85", "--theta-d", "30", "--phi", phi, "--sigma", "10", "--samples", "720"});
      ASSERT_EQ(json.at("phi_deg").size(), 720u);
      EXPECT_EQ(json["phi_deg"][0], -180.0);
      EXPECT_NEAR(json["phi_deg"][1].get<double>(), -179.5, 1e-12);
      EXPECT_LE(json.at("relative_l2"), 0.01) << lobe << " " << phi;
      // 720 azimuths are 20 a sigma: the trapezoid on the circle is exact to rounding for such a blur.
      const Recomputed recomputed = recompute(json);
      EXPECT_NEAR(json["relative_l2"], recomputed.relative_l2, 0.01 * recomputed.relative_l2 + 1e-9) << lobe;
      EXPECT_NEAR(json.at("energy"), recomputed.energy, 1e-6 * recomputed.energy) << lobe;
      const bool is_row = std::string(lobe) != "R";
      EXPECT_EQ(json.at("components") > 0, is_row);
      EXPECT_EQ(json.at("evaluations") > 0, is_row);
    }
  }
}

TEST_F(Fit, TheRowIsNotTheReferenceItself) { EXPECT_GT(fit({"--lobe", "TRT"}).at("relative_l2"), 1e-7); }

TEST_F(Fit, ASmallerEpsilonGivesASmallerError) {
  const nlohmann::json json = fit({"--lobe", "TRT", "--e", ".7", "--phi", "20", "--epsilon", ".001"});
  EXPECT_LE(json.at("relative_l2"), 0.001);
}

TEST_F(Fit, AbsorptionDarkensRowAndReferenceAlike) {
  const nlohmann::json clear = fit({"--lobe", "TT"}), dark = fit({"--lobe", "TT", "--sigma-a", ".4"});
  EXPECT_LT(dark.at("energy"), 0.8 * clear.at("energy").get<double>());
  // The fit's own error beside the gamma law's, 0.007 at 99 % for sigma_a 0.4.
  EXPECT_LE(dark.at("relative_l2"), 0.02);
}

TEST_F(Fit, DrawsAPicture) {
  const Outcome outcome = run({"fit", "--lobe", "TT", "-o", path("plot.png")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_text(path("plot.png")).substr(1, 3), "PNG");
  EXPECT_EQ(run({"fit", "--lobe", "TT", "-o", path("none/plot.png")}).status, 1);
}

TEST(TransmittedShare, IsTheGammaLawOfTheMoments) {
  EXPECT_EQ(fiber::transmitted_share(0, 2, 0.5), 1);
  EXPECT_NEAR(fiber::transmitted_share(1, 2, 0), std::exp(-2.0), 1e-12);
  EXPECT_NEAR(fiber::transmitted_share(1, 2, 1e-7), std::exp(-2.0), 1e-7);
  // Gamma distribution of shape 4 and scale 0.5: its Laplace transform is (1 + s/2)^-4.
  EXPECT_NEAR(fiber::transmitted_share(3, 2, 1), std::pow(2.5, -4), 1e-12);
  EXPECT_EQ(fiber::transmitted_share(3, 0, 0), 1);
}

}  // namespace
}  // namespace tress::test
