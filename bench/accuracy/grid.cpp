// grid [POINTS]: how far the density that the nodes of a slice's grid give in the mean is from the one at the very
// direction: the error that no fit can mend. Shapes of mass 1, relative squared L2; e 0.7..1, all
// directions, the slices' own axes. `light > 0.02`: the share of the light that leaves in directions off by more.
// Seed 1.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "fiber/fourier_reference.h"
#include "fiber/row_axes.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

using namespace tress;

namespace {

constexpr int azimuths = 256;
constexpr double pi = std::numbers::pi, degree = pi / 180;

struct Shape {
  double energy = 0;
  std::vector<double> values;
};

/// Shape at azimuths relative to phi_r; empty where less than 1e-3 of the light leaves: such nodes have no row.
Shape shape(const fiber::ReferenceRequest& request) {
  const fiber::FourierReference reference(request);
  Shape shape{reference.energy(), {}};
  if (shape.energy < 1e-3) return shape;
  for (int i = 0; i < azimuths; ++i) {
    shape.values.push_back(reference.density(request.phi_r + 2 * pi * (i + 0.5) / azimuths) / reference.energy());
  }
  return shape;
}

double relative_error(const std::vector<double>& g, const std::vector<double>& f) {
  double square = 0, variation = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    square += (g[i] - f[i]) * (g[i] - f[i]);
    variation += (g[i] - 1 / (2 * pi)) * (g[i] - 1 / (2 * pi));
  }
  return square / std::max(variation, 1e-3 / (2 * pi) * azimuths / (2 * pi));
}

/// Place on an axis: lower node and the share of the upper one, linear in `coordinate`.
template <class Coordinate>
std::pair<std::size_t, double> place(const std::vector<float>& axis, double at, const Coordinate& coordinate) {
  const auto upper = static_cast<std::size_t>(std::upper_bound(axis.begin(), axis.end(), at) - axis.begin());
  if (upper == 0 || axis.size() == 1) return {0, 0};
  if (upper == axis.size()) return {axis.size() - 2, 1};
  const double low = coordinate(axis[upper - 1]), high = coordinate(axis[upper]);
  return {upper - 1, (coordinate(at) - low) / (high - low)};
}

}  // namespace

int main(int argument_count, char** arguments) {
  const int points = argument_count > 1 ? std::max(1, std::atoi(arguments[1])) : 500;
  fmt::print("{:>5} {:>5} {:>6} {:>9} {:>9} {:>9} {:>9} {:>12}\n", "lobe", "sigma", "nodes", "median", "90 %", "99 %",
             "most", "light > .02");
  for (const double sigma : {4.0, 5.0, 10.0, 20.0}) {
    for (int p = 1; p <= 3; ++p) {
      RandomStream random(1, static_cast<std::uint64_t>(p), static_cast<std::uint64_t>(sigma));
      std::vector<double> errors;
      std::size_t nodes = 0;
      double light = 0, badly_placed = 0;
      while (errors.size() < static_cast<std::size_t>(points)) {
        fiber::ReferenceRequest request;
        request.p = p;
        request.sigma = sigma * degree;
        request.eccentricity = 0.7 + 0.3 * random.next();
        request.phi_r = pi / 2 * random.next();
        request.theta_d = pi / 2 * random.next();
        const auto slice = fiber::elliptical_slice(p, 1.55f, static_cast<float>(request.eccentricity),
                                                   static_cast<float>(request.sigma));
        nodes = std::max<std::size_t>(nodes, slice.node_count());
        const auto [energy, g] = shape(request);
        if (g.empty()) continue;
        const auto [a, up_a] = place(slice.axis_a, request.phi_r, [](double phi) { return phi; });
        const auto [b, up_b] = place(slice.axis_b, request.theta_d, [](double theta) { return std::cos(theta); });
        std::vector<double> f(g.size(), 0.0);
        for (int corner = 0; corner < 4; ++corner) {
          const std::size_t i = a + (corner & 1), j = b + (corner >> 1);
          const double share = ((corner & 1) != 0 ? up_a : 1 - up_a) * ((corner >> 1) != 0 ? up_b : 1 - up_b);
          if (share <= 0) continue;
          fiber::ReferenceRequest at = request;
          at.phi_r = slice.axis_a[i];
          at.theta_d = slice.axis_b[j];
          const std::vector<double> node = shape(at).values;
          for (std::size_t k = 0; k < f.size(); ++k) f[k] += share * (node.empty() ? 1 / (2 * pi) : node[k]);
        }
        errors.push_back(relative_error(g, f));
        light += energy;
        if (errors.back() > 0.02) badly_placed += energy;
      }
      std::sort(errors.begin(), errors.end());
      const auto quantile = [&](double q) {
        return errors[std::min(errors.size() - 1, static_cast<std::size_t>(q * double(errors.size())))];
      };
      fmt::print("{:>5} {:>5} {:>6} {:9.2g} {:9.2g} {:9.2g} {:9.2g} {:12.2g}\n",
                 std::array{"TT", "TRT", "TRRT"}[std::size_t(p - 1)], sigma, nodes, quantile(0.5), quantile(0.9),
                 quantile(0.99), errors.back(), badly_placed / light);
    }
  }
}
