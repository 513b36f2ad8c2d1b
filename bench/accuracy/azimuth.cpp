// The azimuthal density of one lobe of a model, for plots.
//
// usage: bench_azimuth MODEL LOBE THETA_DEG SIGMA_DEG [POINTS [E [SAMPLES]]]
// Clear hair without tilt under wr = (THETA, 0), the detector of TT, TRT and TRRT of SIGMA wide; models that integrate
// with POINTS points (0: their own). Prints JSON on stdout: phi_deg (SAMPLES of them from -180, 1440 unless given; of
// phi_i, and of phi_i - phi_r) and density, 1/rad: S_p on the specular cone theta_i = -THETA, scaled to the energy that
// the model gives the lobe.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "references/registry.h"

int main(int argc, char** argv) {
  using namespace tress;
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto number = [&](std::size_t i, double otherwise) {
    return i < words.size() ? std::strtod(words[i].c_str(), nullptr) : otherwise;
  };
  const fiber::ModelInfo* info = words.empty() ? nullptr : references::find_model(words[0]);
  std::size_t lobe = 0;
  while (words.size() > 1 && lobe < fiber::lobe_count && words[1] != fiber::lobe_names[lobe]) ++lobe;
  const auto samples = static_cast<int>(number(6, 1440));
  if (words.size() < 4 || info == nullptr || lobe == fiber::lobe_count || samples < 1) {
    fmt::print(stderr, "usage: bench_azimuth MODEL R|TT|TRT|TRRT THETA_DEG SIGMA_DEG [POINTS [E [SAMPLES]]]\n");
    return 2;
  }
  constexpr double degree = std::numbers::pi / 180;
  fiber::FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.tilt = 0;
  parameters.eccentricity = static_cast<float>(number(5, 1));
  parameters.azimuthal_sigma.fill(static_cast<float>(number(3, 0) * degree));
  const auto model =
      info->make({.estimator = fiber::Estimator::exact, .quadrature_points = static_cast<int>(number(4, 0))});
  const auto theta = static_cast<float>(number(2, 0) * degree);
  const fiber::FiberEvent event = model->begin(model->add_fiber(parameters), {theta, 0}, 0.5f, 0.5f, 0);
  std::vector<double> phi, density;
  double sum = 0;
  for (int k = 0; k < samples; ++k) {
    phi.push_back(360.0 * k / samples - 180);
    const fiber::FiberValue value = model->evaluate(event, {-theta, static_cast<float>(phi.back() * degree)});
    density.push_back(static_cast<double>(value.s[lobe].g));
    sum += density.back() * 2 * std::numbers::pi / samples;
  }
  for (double& d : density) d *= sum > 0 ? static_cast<double>(event.energy[lobe].g) / sum : 0;
  fmt::print("{}\n", nlohmann::json{{"phi_deg", phi}, {"density", density}}.dump());
  return 0;
}
