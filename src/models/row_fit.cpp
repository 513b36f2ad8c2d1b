#include "models/row_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/pi.h"
#include "fiber/fourier_reference.h"
#include "fiber/reflection.h"
#include "models/learned_row.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {
namespace {

constexpr int integration_nodes = 8192;  // equally spaced on the circle: spectral accuracy for the allowed blurs

double radians(double degrees) { return degrees * pi / 180; }

/// The closed form of R, blurred by sigma only for comparison with the reference. It has edges with a vertical tangent
/// where it falls to 0, so midpoints are used: the error is some 1e-5 of the peak.
CircularDensity blurred_reflection(const RowFitRequest& s) {
  constexpr int nodes = 16384;
  const auto theta = static_cast<float>(std::fabs(radians(s.theta_d)));
  const ReflectionLobe lobe(float(s.eta), float(s.eccentricity), theta, float(radians(s.phi)), 0.5f, 0, 0.1f);
  std::vector<double> mass(nodes);
  for (int i = 0; i < nodes; ++i) {
    mass[std::size_t(i)] = lobe.energy_density(float(-pi + (i + 0.5) * 2 * pi / nodes)) * 2 * pi / nodes;
  }
  // The cosine series of the blurred density, with as many terms as the Gaussian leaves.
  const double sigma = radians(s.sigma);
  const int terms = static_cast<int>(std::ceil(6.5 / sigma));
  std::vector<double> cosine, sine;
  for (int m = 0; m <= terms; ++m) {
    double c = 0, n = 0;
    for (int i = 0; i < nodes; ++i) {
      const double angle = m * (-pi + (i + 0.5) * 2 * pi / nodes);
      c += mass[std::size_t(i)] * std::cos(angle);
      n += mass[std::size_t(i)] * std::sin(angle);
    }
    const double blur = std::exp(-0.5 * m * m * sigma * sigma) / (m == 0 ? 2 * pi : pi);
    cosine.push_back(c * blur);
    sine.push_back(n * blur);
  }
  return [cosine, sine](double phi) {
    double sum = 0;
    for (std::size_t m = 0; m < cosine.size(); ++m) {
      sum += cosine[m] * std::cos(double(m) * phi) + sine[m] * std::sin(double(m) * phi);
    }
    return std::max(sum, 0.0);
  };
}

}  // namespace

RowFit fit_row(const RowFitRequest& s) {
  ReferenceRequest request;
  request.eta = s.eta;
  request.eccentricity = s.eccentricity;
  request.theta_d = radians(s.theta_d);
  request.phi_r = radians(s.phi);
  request.sigma = radians(s.sigma);
  request.sigma_a = s.sigma_a;
  request.p = slice_order(static_cast<int>(s.lobe));
  if (s.lobe == Lobe::glint) request.part = TrtPart::glint;
  // For 5 degrees 2048 are enough; a narrower blur resolves more of the caustics.
  if (s.is_rest) request.part = TrtPart::rest;
  request.nodes = 2048 * std::max(1, static_cast<int>(std::ceil(5 / s.sigma)));
  const FourierReference reference(request);

  RowFit curves;
  curves.target = [reference](double phi) { return reference.density(phi); };
  curves.energy = reference.energy();
  if (s.lobe == Lobe::r) {
    curves.fit = blurred_reflection(s);
    return curves;
  }
  RowRequest row;
  row.slice_lobe = s.is_rest ? trt_rest_slice : static_cast<int>(s.lobe);
  row.eta = static_cast<float>(s.eta);
  row.eccentricity = static_cast<float>(s.eccentricity);
  row.sigma = static_cast<float>(request.sigma);
  row.phi_r = static_cast<float>(request.phi_r);
  row.theta_d = static_cast<float>(request.theta_d);
  row.epsilon = s.epsilon;
  const LearnedRow learned = learn_row(row);
  curves.components = learned.fit.component_count;
  curves.evaluations = learned.evaluations;
  curves.converged = learned.converged;
  curves.fit = [learned, sigma_a = s.sigma_a](double phi) { return learned.density(phi, sigma_a); };
  for (std::size_t part = 0; part <= learned.fit.component_count; ++part) {
    curves.parts.push_back(
        [learned, part, sigma_a = s.sigma_a](double phi) { return learned.density_of(part, phi, sigma_a); });
  }
  return curves;
}

double relative_l2(const RowFit& curves) {
  double error = 0, square = 0, mass = 0;
  constexpr double step = 2 * pi / integration_nodes;
  for (int i = 0; i < integration_nodes; ++i) {
    const double phi = -pi + i * step, target = curves.target(phi), off = target - curves.fit(phi);
    error += off * off * step;
    square += target * target * step;
    mass += target * step;
  }
  return error / std::max(square - mass * mass / (2 * pi), 1e-3 / (2 * pi));
}

}  // namespace tress::inline v0_2::fiber
