// How far the factorised lobes are from a rough fiber traced in three dimensions (../shared/reference/fiber3d.csv):
// with the one-number roughness, the same without its shift towards the normal plane, and with the widths and the shift
// that fit best. A row per configuration and lobe: JSON on stdout, a table on stderr.
//
// Errors are relative L2 over the 36 x 36 bins of the normalised lobes, sqrt(sum (ours - theirs)^2 / sum theirs^2).
// `product` is that of the best factorisation without a model, the product of the reference's own marginals.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "fiber/cross_section.h"
#include "fiber/fiber3d_reference.h"
#include "fiber/longitudinal.h"
#include "fiber/reflection.h"
#include "tress/fiber/parameters.h"

namespace tress {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr int theta_bins = test::flux_bins_a_side, phi_bins = test::flux_bins_a_side, theta_points = 8, harmonics = 320,
              rays = 2048;
using Bins = test::FluxBins;
using Widths = std::array<double, 3>;  ///< lambda, sigma and shift of theta_h (towards the normal), radians

struct Configuration {
  double eta = 0, e = 0, alpha = 0, theta_r = 0, phi_r = 0, sigma_a = 0;
  std::map<std::string, Bins> lobes;
};

std::map<int, Configuration> read(const std::string& file) {
  std::map<int, Configuration> all;
  for (const auto& [id, reference] : test::fiber3d_reference(test::rows_of_file(file))) {
    const fiber::FiberParameters& fiber = reference.parameters;
    Configuration& c = all[id];
    c.eta = static_cast<double>(fiber.eta);
    c.e = static_cast<double>(fiber.eccentricity);
    c.alpha = static_cast<double>(fiber.roughness);
    c.theta_r = static_cast<double>(reference.wr.theta);
    c.phi_r = static_cast<double>(reference.wr.phi);
    c.sigma_a = static_cast<double>(fiber.sigma_a.r);
    for (std::size_t lobe = 0; lobe < test::flux_lobes.size(); ++lobe) {
      c.lobes[test::flux_lobes[lobe]] = reference.flux[lobe];
    }
  }
  return all;
}

Bins normalised(Bins bins) {
  double total = 0;
  for (const double x : bins) total += x;
  for (double& x : bins) x /= total;
  return bins;
}

double relative_l2(const Bins& ours, const Bins& theirs) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    error += (ours[i] - theirs[i]) * (ours[i] - theirs[i]);
    norm += theirs[i] * theirs[i];
  }
  return std::sqrt(error / norm);
}

Bins product_of_marginals(const Bins& bins) {
  std::array<double, theta_bins> theta{};
  std::array<double, phi_bins> phi{};
  for (std::size_t i = 0; i < bins.size(); ++i) theta[i / phi_bins] += bins[i], phi[i % phi_bins] += bins[i];
  Bins product;
  for (std::size_t i = 0; i < bins.size(); ++i) product[i] = theta[i / phi_bins] * phi[i % phi_bins];
  return product;
}

double theta_at(int i) { return -pi / 2 + (i + 0.5) * pi / (theta_bins * theta_points); }

/// Fourier coefficients of the exits of one lobe at every theta_d that a bin row needs, of mass 1 (of the energy at
/// the specular cone they are then the shape). p = 3 stands for TRRT and all after it: those are uniform.
struct Shapes {
  std::vector<std::array<std::complex<double>, harmonics + 1>> c;
  double uniform_share = 0;

  Shapes(const Configuration& k, int p) : c(theta_bins * theta_points) {
    for (int i = 0; i < theta_bins * theta_points; ++i) {
      const double theta_d = 0.5 * std::abs(theta_at(i) - k.theta_r);
      const fiber::CrossSection section(k.eta, k.e, k.phi_r, theta_d);
      auto& series = c[static_cast<std::size_t>(i)];
      for (int ray = 0; ray < rays; ++ray) {
        fiber::TracedOffset out;
        section.trace((2 * ray + 1.0) / rays - 1, p, &out);
        const double weight = out.weight[p] * std::exp(-k.sigma_a * out.path[p]);
        const std::complex<double> turn = std::polar(1.0, -out.azimuth[p]);
        std::complex<double> term = weight;
        for (auto& coefficient : series) coefficient += term, term *= turn;
      }
      const double mass = series[0].real();
      for (auto& coefficient : series) coefficient *= mass > 0 ? 1 / mass : 0;
      if (!(mass > 0)) series[0] = 1;
    }
    if (p < 3) return;
    const fiber::CrossSection section(k.eta, k.e, k.phi_r, k.theta_r);
    double third = 0, later = 0;
    for (int ray = 0; ray < rays; ++ray) {
      fiber::TracedOffset out;
      const double h = (2 * ray + 1.0) / rays - 1;
      section.trace(h, 3, &out);
      third += out.weight[3] * std::exp(-k.sigma_a * out.path[3]);
      section.trace_residual(h, [&](double weight, double path) { later += weight * std::exp(-k.sigma_a * path); });
    }
    uniform_share = later / (third + later);
  }
};

/// Bin masses of M(theta) N(phi; theta_d): 8 midpoints a bin in theta, the exact integral over a bin in phi.
Bins inner_lobe(const Configuration& k, const Shapes& shapes, const Widths& widths) {
  Bins bins{};
  const fiber::LongitudinalLobe m(static_cast<float>(k.theta_r), static_cast<float>(widths[2]),
                                  static_cast<float>(widths[0]));
  const double width = 2 * pi / phi_bins;
  const int last = std::min(harmonics, static_cast<int>(std::ceil(6.5 / widths[1])));
  for (int i = 0; i < theta_bins * theta_points; ++i) {
    const double mass = m.density(static_cast<float>(theta_at(i))) * pi / (theta_bins * theta_points);
    if (mass < 1e-9) continue;
    std::array<std::complex<double>, harmonics + 1> blurred{};
    for (int n = 1; n <= last; ++n)
      blurred[static_cast<std::size_t>(n)] = shapes.c[static_cast<std::size_t>(i)][static_cast<std::size_t>(n)] *
                                             std::exp(-0.5 * n * n * widths[1] * widths[1]) *
                                             (2 * std::sin(0.5 * n * width) / n / pi);
    for (int j = 0; j < phi_bins; ++j) {
      const std::complex<double> turn = std::polar(1.0, -pi + (j + 0.5) * width);
      std::complex<double> term = turn;
      double sum = width / (2 * pi);
      for (int n = 1; n <= last; ++n)
        sum += (1 - shapes.uniform_share) * (blurred[static_cast<std::size_t>(n)] * term).real(), term *= turn;
      bins[static_cast<std::size_t>(i / theta_points * phi_bins + j)] += mass * sum;
    }
  }
  return bins;
}

Bins reflection(const Configuration& k, const Widths& w) {
  Bins bins{};
  const fiber::ReflectionLobe lobe(static_cast<float>(k.eta), static_cast<float>(k.e), static_cast<float>(k.theta_r),
                                   static_cast<float>(k.phi_r), 0.5f, static_cast<float>(w[2]),
                                   static_cast<float>(w[0]));
  constexpr int points = 8;
  for (int j = 0; j < phi_bins * points; ++j) {
    const auto phi = static_cast<float>(-pi + (j + 0.5) * 2 * pi / (phi_bins * points));
    const double energy = lobe.energy_density(phi);
    const fiber::LongitudinalLobe m = lobe.longitudinal(phi);
    for (int i = 0; i < theta_bins * theta_points; ++i)
      bins[static_cast<std::size_t>(i / theta_points * phi_bins + j / points)] +=
          energy * m.density(static_cast<float>(theta_at(i)));
  }
  return bins;
}

/// Coordinate search in the logarithm of the widths and in the shift: halves its step from 40 % (2 degrees) to 1 %.
/// R has no sigma.
Widths best_widths(Widths widths, bool is_r, const std::function<double(const Widths&)>& error) {
  double best = error(widths);
  for (double step = 0.4; step > 0.008;) {
    bool better = false;
    for (std::size_t k = 0; k < widths.size(); ++k) {
      if (is_r && k == 1) continue;
      for (const double sign : {1.0, -1.0}) {
        Widths tried = widths;
        if (k == 2) {
          tried[k] += sign * step * 5 * degree;
        } else {
          tried[k] = std::clamp(tried[k] * std::exp(sign * step), 0.25 * degree, 60 * degree);
        }
        const double e = error(tried);
        if (e < best) best = e, widths = tried, better = true;
      }
    }
    if (!better) step /= 2;
  }
  return widths;
}

struct Prediction {
  double energy = 0;                         ///< of the smooth fiber, exactly traced
  std::function<Bins(const Widths&)> shape;  ///< not normalised
};

Prediction prediction(const Configuration& k, int p) {
  Prediction result;
  for (int ray = 0; ray < rays; ++ray) {
    fiber::TracedOffset out;
    const fiber::CrossSection section(k.eta, k.e, k.phi_r, k.theta_r);
    const double h = (2 * ray + 1.0) / rays - 1;
    section.trace(h, p, &out);
    result.energy += out.weight[p] * std::exp(-k.sigma_a * out.path[p]) / rays;
    if (p < 3) continue;
    section.trace_residual(
        h, [&](double weight, double path) { result.energy += weight * std::exp(-k.sigma_a * path) / rays; });
  }
  if (p == 0) {
    result.shape = [k](const Widths& w) { return reflection(k, w); };
  } else {
    result.shape = [k, shapes = Shapes(k, p)](const Widths& w) { return inner_lobe(k, shapes, w); };
  }
  return result;
}

int run(const std::string& file) {
  const auto all = read(file);
  if (all.empty()) {
    std::fprintf(stderr, "%s: no configurations there\n", file.c_str());
    return 1;
  }
  constexpr std::array<const char*, 4> names{"R", "TT", "TRT", "TRRT+"};
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::fprintf(stderr,
               "  e   alpha theta sigma_a lobe   energy 3D/smooth | unshifted  one number (lambda sigma shift) | best "
               "(lambda sigma shift) | product\n");
  for (const auto& [id, k] : all) {
    fiber::FiberParameters parameters;
    parameters.eta = static_cast<float>(k.eta);
    parameters.eccentricity = static_cast<float>(k.e);
    parameters.roughness = static_cast<float>(k.alpha);
    const auto sigmas = fiber::azimuthal_sigmas(parameters);
    for (int p = 0; p < 4; ++p) {
      const char* name = names[static_cast<std::size_t>(p)];
      const Bins& traced = k.lobes.at(name);
      const Bins theirs = normalised(traced);
      double energy = 0;
      for (const double x : traced) energy += x;
      const Prediction ours = prediction(k, p);
      const auto error = [&](const Widths& w) { return relative_l2(normalised(ours.shape(w)), theirs); };
      const auto theta_r = static_cast<float>(k.theta_r);
      const Widths given{fiber::longitudinal_lambda(parameters, p, theta_r),
                         p == 0 ? 0.0 : static_cast<double>(sigmas[static_cast<std::size_t>(p - 1)]),
                         fiber::roughness_shift(parameters, p, theta_r)};
      const Widths unshifted{given[0], given[1], 0};
      const Widths best = best_widths(given, p == 0, error);
      const double product = relative_l2(product_of_marginals(theirs), theirs);
      rows.push_back({{"id", id},
                      {"e", k.e},
                      {"alpha", k.alpha},
                      {"theta_deg", k.theta_r / degree},
                      {"phi_deg", k.phi_r / degree},
                      {"sigma_a", k.sigma_a},
                      {"lobe", name},
                      {"energy", energy},
                      {"energy_smooth", ours.energy},
                      {"error_unshifted", error(unshifted)},
                      {"error", error(given)},
                      {"widths_deg", {given[0] / degree, given[1] / degree, given[2] / degree}},
                      {"best_error", error(best)},
                      {"best_widths_deg", {best[0] / degree, best[1] / degree, best[2] / degree}},
                      {"product_error", product}});
      std::fprintf(stderr,
                   "%5.2f %5.2f %4.0f %6.1f   %-6s %.4f / %.4f | %.3f  %.3f (%5.2f %5.2f %5.2f) | %.3f (%5.2f %5.2f "
                   "%5.2f) | %.3f\n",
                   k.e, k.alpha, k.theta_r / degree, k.sigma_a, name, energy, ours.energy, error(unshifted),
                   error(given), given[0] / degree, given[1] / degree, given[2] / degree, error(best), best[0] / degree,
                   best[1] / degree, best[2] / degree, product);
    }
  }
  std::printf("%s\n", rows.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace tress

int main(int argc, char** argv) {
  if (argc == 2) return tress::run(argv[1]);
  std::fprintf(stderr, "usage: bench_fiber3d .../reference/fiber3d.csv > fiber3d.json\n");
  return 2;
}
