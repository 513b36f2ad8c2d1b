// tress-lab far-field: what it prints is the far field of the model that it names.
#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "cli/run_tress.h"
#include "references/registry.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;

class FarField : public CommandTest {
 protected:
  nlohmann::json far_field(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "far-field");
    arguments.push_back("--json");
    return run_json(arguments);
  }
};

double energy(const nlohmann::json& json, const char* lobe, std::size_t channel = 0) {
  return json.at("lobes").at(lobe).at("energy").at(channel);
}
double energy_error(const nlohmann::json& json, const char* lobe) {
  return json.at("lobes").at(lobe).at("energy_error").at(0);
}

// Models that conserve energy: 5 standard errors beside what closed forms have in floats, 5e-4.
TEST_F(FarField, AClearFiberReturnsAllLight) {
  for (const fiber::ModelInfo& model : references::models()) {
    if (!model.conserves_energy) continue;
    const nlohmann::json json = far_field({"--model", model.name, "--e", "1", "--paths", "60000", "--quiet"});
    EXPECT_NEAR(energy(json, "whole"), 1, 5 * energy_error(json, "whole") + 5e-4) << model.name;
  }
}

TEST_F(FarField, EveryModelOfTheRegistryAnswers) {
  for (const fiber::ModelInfo& model : references::models()) {
    const nlohmann::json json = far_field({"--model", model.name, "--paths", "4000", "--bins", "6x8", "--quiet"});
    EXPECT_EQ(json.at("model"), model.name);
    EXPECT_GT(energy(json, "whole"), 0.5) << model.name;
    EXPECT_EQ(json.contains("rows"), model.make_target != nullptr) << model.name;
    const nlohmann::json& flux = json.at("lobes").at("whole").at("flux");
    ASSERT_EQ(flux.size(), 1u);
    ASSERT_EQ(flux[0].size(), 6u);
    double sum = 0;
    for (const auto& row : flux[0]) {
      ASSERT_EQ(row.size(), 8u);
      for (const double x : row) sum += x;
    }
    EXPECT_NEAR(sum, energy(json, "whole"), 1e-6 * sum + 1e-9) << model.name;
  }
}

// The lobes of `elliptical` have the energies of its table.
TEST_F(FarField, EllipticalHasItsOwnEnergies) {
  const nlohmann::json json = far_field({"--model", "elliptical", "--e", ".75", "--alpha", ".25", "--theta-r", "-40",
                                         "--phi-r", "20", "--sigma-a", "0.1,0.3,1", "--paths", "100000"});
  EXPECT_EQ(json.at("channels"), (nlohmann::json{"red", "green", "blue"}));
  EXPECT_EQ(json.at("rows").at("open"), 0);
  fiber::FiberParameters parameters;
  parameters.eccentricity = 0.75f;
  parameters.roughness = 0.25f;
  parameters.tilt = static_cast<float>(3 * std::numbers::pi / 180);
  parameters.sigma_a = {0.1f, 0.3f, 1};
  const auto model = *fiber::make_elliptical_model(fiber::Estimator::exact, nullptr);
  constexpr float degree = std::numbers::pi_v<float> / 180;
  const fiber::FiberEvent event =
      model->begin(model->add_fiber(parameters), {-40 * degree, 20 * degree}, 0.5f, 0.5f, 0);
  const auto own = [&](fiber::Lobe lobe, int channel) {
    return static_cast<double>(event.energy[static_cast<std::size_t>(lobe)][channel]);
  };
  for (int c = 0; c < 3; ++c) {
    const auto expect = [&](const char* lobe, double expected) {
      // Fits have mass 1; their colors are the gamma law's, good to 1 %.
      const double color = std::string(lobe) == "R" ? 0 : 0.01 * expected;
      const double error = json.at("lobes").at(lobe).at("energy_error").at(static_cast<std::size_t>(c));
      EXPECT_NEAR(energy(json, lobe, static_cast<std::size_t>(c)), expected, 5 * error + color + 1e-6) << lobe << c;
    };
    expect("R", own(fiber::Lobe::r, c));
    expect("TT", own(fiber::Lobe::tt, c));
    expect("TRT", own(fiber::Lobe::trt, c));
    expect("rest", own(fiber::Lobe::trrt, c) + own(fiber::Lobe::residual, c));
  }
}

TEST_F(FarField, IsTheSameForAnyNumberOfThreads) {
  for (const char* model : {"elliptical", "fiber3d"}) {
    std::vector<std::string> words{"far-field", "--model", model, "--paths", "40000", "--json", "--threads", "1"};
    const std::string one = run(words).out;
    words.back() = "3";
    EXPECT_EQ(run(words).out, one) << model;
    words.insert(words.end(), {"--seed", "2"});
    EXPECT_NE(run(words).out, one) << model;
  }
}

TEST_F(FarField, WritesATableAndItsConventions) {
  const Outcome outcome = run({"far-field", "--model", "fiber3d", "--paths", "1000"});
  EXPECT_EQ(outcome.status, 0);
  for (const char* part : {"fiber3d", "TRT", "whole", "grey", "traced    1000 paths", "--json"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  const nlohmann::json json = far_field({"--model", "fiber3d", "--paths", "1000", "--phi-r", "-315", "--tilt", "0"});
  EXPECT_EQ(json.at("channels"), (nlohmann::json{"grey"}));
  EXPECT_EQ(json.at("parameters").at("phi_r_deg"), -315.0);
  EXPECT_FALSE(json.at("version").get<std::string>().empty());
  EXPECT_TRUE(json.contains("commit"));
  const nlohmann::json turned = far_field({"--model", "fiber3d", "--paths", "1000", "--phi-r", "45", "--tilt", "0"});
  EXPECT_EQ(json.at("lobes"), turned.at("lobes")) << "-315 degrees are 45";
}

}  // namespace
}  // namespace tress::test
