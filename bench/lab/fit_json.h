// One row of the table beside its reference, as tress-lab fit and tress-lab lobes print it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "models/row_fit.h"

namespace tress::lab {

/// The name of the lobe in options: TT, TRT, GLINT, TRT-REST, TRRT or R.
std::string lobe_name(const fiber::RowFitRequest& request);
/// Sets the lobe by such a name, which there must be.
void set_lobe(const std::string& name, fiber::RowFitRequest* request);

/// A learned row at equally spaced azimuths, degrees from -180 up; densities in 1/rad.
struct FittedRow {
  fiber::RowFitRequest request;
  fiber::RowFit curves;
  double error = 0;  ///< relative L2 of the fit
  std::vector<double> phi_deg, target, fit;
};

/// Every value of the request in range; azimuths >= 1.
FittedRow fitted_row(const fiber::RowFitRequest& request, int azimuths);

/// What tress-lab fit --json prints: lobe, phi_deg, target, fit, parts (the components of the fit and its uniform part,
/// by azimuth), energy, relative_l2, components, evaluations, converged and the parameters.
nlohmann::ordered_json row_json(const FittedRow& row);

}  // namespace tress::lab
