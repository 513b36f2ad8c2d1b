#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "models/row_fit.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/names.h"
#include "python/raised.h"

namespace py = pybind11;

namespace tress::python {
namespace {

/// TRT-REST is what GLINT leaves of TRT.
void set_lobe(const std::string& name, fiber::RowFitRequest* request) {
  constexpr const char* rest = "TRT-REST";
  request->is_rest = name == rest;
  const std::string of = request->is_rest ? "TRT" : name;
  for (const auto lobe : {fiber::Lobe::r, fiber::Lobe::tt, fiber::Lobe::trt, fiber::Lobe::glint, fiber::Lobe::trrt}) {
    if (of != fiber::lobe_names[static_cast<std::size_t>(lobe)]) continue;
    request->lobe = lobe;
    return;
  }
  throw Raised({"", "lobe", "one of TT, TRT, GLINT, TRT-REST, TRRT, R", "\"" + name + "\""});
}

py::dict fit(const std::string& lobe, double eccentricity, double theta_d, double phi, double sigma, double eta,
             double sigma_a, double epsilon, int samples) {
  fiber::RowFitRequest request;
  set_lobe(lobe, &request);
  request.eccentricity = in_range("eccentricity", eccentricity, "--e");
  request.theta_d = in_range("theta_d", theta_d, "--theta-d");
  request.phi = in_range("phi", phi, "--phi");
  request.sigma = in_range("sigma", sigma, "--sigma");
  request.eta = in_range("eta", eta, "--eta");
  request.sigma_a = in_range("sigma_a", sigma_a, "--sigma-a");
  request.epsilon = in_range("epsilon", epsilon, "--epsilon");
  const auto count = static_cast<std::size_t>(in_range("samples", samples, "--samples"));
  std::vector<double> azimuth(count), target(count), answer(count);
  fiber::RowFit row;
  double error = 0;
  Worker worker;
  worker.run([&] {
    row = fiber::fit_row(request);
    error = fiber::relative_l2(row);
    for (std::size_t i = 0; i < count; ++i) {
      const double degrees = -180 + 360.0 * static_cast<double>(i) / static_cast<double>(count);
      azimuth[i] = degrees * std::numbers::pi / 180;
      target[i] = row.target(azimuth[i]);
      answer[i] = row.fit(azimuth[i]);
    }
  });
  py::dict result;
  result["phi"] = array_of<double>(std::move(azimuth));
  result["target"] = array_of<double>(std::move(target));
  result["fit"] = array_of<double>(std::move(answer));
  result["energy"] = row.energy;
  result["relative_l2"] = error;
  result["components"] = row.components;
  result["evaluations"] = row.evaluations;
  result["converged"] = row.converged;
  return result;
}

}  // namespace

void bind_fit(py::module_& module) {
  module.def(
      "fit", &fit, py::arg("lobe"), py::kw_only(), py::arg("eccentricity") = 0.85, py::arg("theta_d") = 30.0,
      py::arg("phi") = 45.0, py::arg("sigma") = 10.0, py::arg("eta") = 1.55, py::arg("sigma_a") = 0.0,
      py::arg("epsilon") = 0.01, py::arg("samples") = 360,
      "One row of the table, learned on its own, beside its reference, as tress-lab fit reports it. Angles given in "
      "degrees; `phi` of the result in radians from the major axis, densities in 1/rad.");
}

}  // namespace tress::python
