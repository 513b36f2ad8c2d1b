#include "lab/fit_json.h"

#include <cstddef>
#include <map>
#include <numbers>

namespace tress::lab {

std::string lobe_name(const fiber::RowFitRequest& request) {
  return request.is_rest ? "TRT-REST" : fiber::lobe_names[static_cast<std::size_t>(request.lobe)];
}

void set_lobe(const std::string& name, fiber::RowFitRequest* request) {
  static const std::map<std::string, fiber::Lobe> lobes{{"R", fiber::Lobe::r},
                                                        {"TT", fiber::Lobe::tt},
                                                        {"TRT", fiber::Lobe::trt},
                                                        {"GLINT", fiber::Lobe::glint},
                                                        {"TRRT", fiber::Lobe::trrt}};
  request->is_rest = name == "TRT-REST";
  request->lobe = request->is_rest ? fiber::Lobe::trt : lobes.at(name);
}

FittedRow fitted_row(const fiber::RowFitRequest& request, int azimuths) {
  FittedRow row{request, fiber::fit_row(request), 0, {}, {}, {}};
  row.error = fiber::relative_l2(row.curves);
  for (int i = 0; i < azimuths; ++i) {
    row.phi_deg.push_back(-180 + 360.0 * i / azimuths);
    const double phi = row.phi_deg.back() * std::numbers::pi / 180;
    row.target.push_back(row.curves.target(phi));
    row.fit.push_back(row.curves.fit(phi));
  }
  return row;
}

nlohmann::ordered_json row_json(const FittedRow& row) {
  const fiber::RowFitRequest& s = row.request;
  nlohmann::ordered_json parts = nlohmann::ordered_json::array();
  for (const fiber::CircularDensity& part : row.curves.parts) {
    parts.push_back(nlohmann::ordered_json::array());
    for (const double degrees : row.phi_deg) parts.back().push_back(part(degrees * std::numbers::pi / 180));
  }
  return {{"lobe", lobe_name(s)},
          {"phi_deg", row.phi_deg},
          {"target", row.target},
          {"fit", row.fit},
          {"energy", row.curves.energy},
          {"relative_l2", row.error},
          {"components", row.curves.components},
          {"evaluations", row.curves.evaluations},
          {"converged", row.curves.converged},
          {"parts", std::move(parts)},
          {"parameters",
           {{"e", s.eccentricity},
            {"eta", s.eta},
            {"phi_deg", s.phi},
            {"theta_d_deg", s.theta_d},
            {"sigma_deg", s.sigma},
            {"sigma_a", s.sigma_a},
            {"epsilon", s.epsilon}}}};
}

}  // namespace tress::lab
