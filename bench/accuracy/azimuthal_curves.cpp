// Azimuthal curves of TRT and GLINT against the eccentricity, as models of the registry give them: for figure 3
// (bench/figures/figure3.py). S at theta_i = -theta_r over M there, clear hair without tilt, phi relative to the known
// direction. Models with rows answer once these have converged.
//
//   bench_azimuthal_curves [--theta DEG] [--phi DEG] [--sigma DEG]     prints JSON
//     -> {"phi_deg": [...], "curves": [{"model", "e", "TRT": [...], "GLINT": [...]}, ...]}, 1/rad
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/longitudinal.h"
#include "references/registry.h"
#include "tress/base/random.h"

namespace {

using namespace tress;
using fiber::FiberDirection;

constexpr float degree = std::numbers::pi_v<float> / 180;
constexpr int azimuths = 721;

/// Both curves of one model and fiber.
nlohmann::json curve(const char* name, const char* label, fiber::Estimator estimator, const FiberDirection& wr,
                     const fiber::FiberParameters& parameters) {
  const fiber::ModelInfo& info = *references::find_model(name);
  fiber::ModelService learned;
  if (info.has_rows() && estimator != fiber::Estimator::exact) learned = fiber::make_service(info, adaptive::Options{});
  adaptive::Service* service = learned.service.get();
  const auto model = info.make({.estimator = estimator, .service = service});
  const fiber::FiberId id = model->add_fiber(parameters);
  RandomStream random(3);
  for (int pass = 0; service && pass < 24; ++pass) {
    for (int i = 0; i < 400; ++i) {
      const fiber::FiberEvent event = model->begin(id, wr, 0, 0, 0);
      (void)model->sample(event, {random.next(), random.next(), random.next(), random.next()});
      (void)model->evaluate(event, {-wr.theta, 6.28f * (random.next() - 0.5f)});
    }
    (void)service->publish();
  }
  // M at the specular cone: of the logistic normalised over the hemisphere, or half of Marschner's Gaussian.
  const float lambda = fiber::longitudinal_lambda(parameters, 2, wr.theta);
  const float m = std::string(name) == "marschner2003"
                      ? 0.5f / (std::sqrt(2 * std::numbers::pi_v<float>) * 1.8137994f * lambda)
                      : fiber::LongitudinalLobe(wr.theta, 0, lambda).density(-wr.theta);
  const fiber::FiberEvent event = model->begin(id, wr, 0, 0, 0);
  nlohmann::json json{{"model", label}, {"e", parameters.eccentricity}};
  for (const fiber::Lobe lobe : {fiber::Lobe::trt, fiber::Lobe::glint}) {
    nlohmann::json& values = json[fiber::lobe_names[static_cast<std::size_t>(lobe)]];
    for (int i = 0; i < azimuths; ++i) {
      const float phi = (-180 + 360.0f * static_cast<float>(i) / (azimuths - 1)) * degree;
      const fiber::FiberValue value = model->evaluate(event, {-wr.theta, wr.phi + phi});
      values.push_back(value.s[static_cast<std::size_t>(lobe)].g / m);
    }
  }
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  float theta = 0, phi = 40, sigma = 15;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const auto value = static_cast<float>(std::atof(argv[i + 1]));
    if (name == "--theta") theta = value;
    if (name == "--phi") phi = value;
    if (name == "--sigma") sigma = value;
  }
  nlohmann::json json;
  for (int i = 0; i < azimuths; ++i) json["phi_deg"].push_back(-180 + 360.0 * i / (azimuths - 1));
  for (const float e : {1.0f, 0.95f, 0.9f, 0.85f}) {
    fiber::FiberParameters parameters;
    parameters.eccentricity = e;
    parameters.tilt = 0;
    parameters.sigma_a = glm::vec3(0);
    parameters.split_glint = true;
    parameters.azimuthal_sigma.fill(sigma * degree);
    parameters.longitudinal_lambda.fill(5 * degree);
    const FiberDirection wr{theta * degree, phi * degree};
    json["curves"].push_back(curve("elliptical", "traced", fiber::Estimator::exact, wr, parameters));
    json["curves"].push_back(curve("marschner2003", "marschner2003", fiber::Estimator::exact, wr, parameters));
    json["curves"].push_back(curve("pekelis2015", "pekelis2015", fiber::Estimator::fitted, wr, parameters));
  }
  std::printf("%s\n", json.dump().c_str());
}
