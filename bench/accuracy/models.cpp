// What every model of the registry returns and how well it is sampled: furnace, weights, chi-square.
//
// A case is clear hair of one e under one theta_r. The furnace is the mean weight of samples with xi and h at random,
// beside the integral of S by quadrature at one xi and h (of models that evaluate()); chi-square is of samples against
// the density at that xi and h. Models with rows are traced at the vertex. JSON on stdout, a table on stderr.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "models/model_measures.h"
#include "references/registry.h"

namespace tress {
namespace {

constexpr float degree = std::numbers::pi_v<float> / 180;
constexpr float phi_r = 0.7f;

struct Options {
  std::string model;  ///< empty: all
  int samples = 20000;
  float roughness = 0.2f;
};

nlohmann::ordered_json measure(const fiber::ModelInfo& info, float e, float theta_deg, const Options& options) {
  fiber::FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.eccentricity = e;
  parameters.roughness = options.roughness;
  const test::OneFiber fiber(info, parameters);
  const fiber::FiberDirection wr{theta_deg * degree, phi_r};
  const test::Weights weights = test::weights(fiber, wr, options.samples, 1);
  nlohmann::ordered_json row{{"model", info.name},
                             {"e", std::round(1000 * double{e}) / 1000},
                             {"theta_deg", theta_deg},
                             {"furnace", weights.mean},
                             {"standard_error", weights.standard_error},
                             {"variance_of_weight", weights.variance},
                             {"largest_weight", weights.largest}};
  std::fprintf(stderr, "%-14s %4.2f %5.0f   %.4f +- %.4f", info.name, double{e}, double{theta_deg}, weights.mean,
               weights.standard_error);
  if (fiber.model().evaluates()) {
    const fiber::FiberEvent event = fiber.begin(wr);
    const test::Masses masses = test::masses(fiber.model(), event, 24, 16);
    const test::ChiSquare fit = test::samples_against_density(fiber.model(), event, options.samples, 16, 2);
    row["furnace_by_quadrature"] = masses.s;
    row["mass_of_density"] = masses.pdf;
    row["chi_square_p"] = fit.p_value;
    std::fprintf(stderr, "   %.4f   %.4f   %.3f", masses.s, masses.pdf, fit.p_value);
  } else {
    std::fprintf(stderr, "        -        -       -");
  }
  std::fprintf(stderr, "   %8.2f   %.4f\n", weights.largest, weights.variance);
  return row;
}

int run(const Options& options) {
  std::fprintf(stderr,
               "model             e theta   furnace (sampled)  by quadr.  mass    chi2 p   largest w   variance\n");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bool found = false;
  for (const fiber::ModelInfo& info : references::models()) {
    if (!options.model.empty() && options.model != info.name) continue;
    found = true;
    for (const float e : {1.0f, 0.85f, 0.7f}) {
      for (const float theta : {0.0f, 30.0f, 60.0f, 80.0f}) rows.push_back(measure(info, e, theta, options));
    }
  }
  if (!found) {
    std::fprintf(stderr, "%s: no such model\n", options.model.c_str());
    return 2;
  }
  std::printf("%s\n", rows.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  tress::Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--model") {
      options.model = argv[i + 1];
    } else if (name == "--samples") {
      options.samples = std::max(std::atoi(argv[i + 1]), 1000);
    } else if (name == "--roughness") {
      options.roughness = static_cast<float>(std::clamp(std::atof(argv[i + 1]), 0.01, 1.0));
    } else {
      argc = 0;
    }
  }
  if (argc % 2 == 1) return tress::run(options);
  std::fprintf(stderr, "usage: bench_models [--model NAME] [--samples N] [--roughness ALPHA] > models.json\n");
  return 2;
}
