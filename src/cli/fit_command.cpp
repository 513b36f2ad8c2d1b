// tress fit: one row of the table beside its reference.
#include "cli/fit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "fiber/fourier_reference.h"
#include "fiber/reflection.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {
namespace {

/// Angles in degrees, as typed. Every value in range.
struct FitSettings {
  fiber::Lobe lobe = fiber::Lobe::trt;  ///< any but the residual; trt is the whole of p = 2
  bool is_rest = false;                 ///< of trt: what is left where GLINT is split off
  double eccentricity = 0.85;           ///< [0.5, 1]
  double theta_d = 30;                  ///< [-89.9, 89.9]; its sign changes nothing
  double phi = 45;                      ///< phi_r, absolute azimuth of the known direction from the major axis
  double sigma = 10;                    ///< blur, [.5, 45]
  double eta = 1.55;                    ///< [1.05, 3]
  double sigma_a = 0;                   ///< per major semi-axis, one channel
  double epsilon = 0.01;
  int samples = 360;  ///< azimuths printed
  bool json = false;
  std::optional<std::filesystem::path> plot;  ///< PNG
};

constexpr double pi = std::numbers::pi;
constexpr int integration_nodes = 8192;  // equally spaced on the circle: spectral for the blurs allowed here

double radians(double degrees) { return degrees * pi / 180; }

/// A density on the circle, 1/rad, by absolute azimuth in radians.
using CircularDensity = std::function<double(double)>;

struct Curves {
  CircularDensity target, fit;
  double energy = 0;  ///< mass of the target
  std::size_t components = 0;
  std::uint64_t evaluations = 0;
  bool converged = true;
};

/// The closed form of R, blurred by sigma here only so that it can be held against the reference. The closed form has
/// edges where it falls to 0 with a vertical tangent, hence midpoints: error some 1e-5 of the peak.
CircularDensity blurred_reflection(const FitSettings& s) {
  constexpr int nodes = 16384;
  const auto theta = static_cast<float>(std::fabs(radians(s.theta_d)));
  const fiber::ReflectionLobe lobe(float(s.eta), float(s.eccentricity), theta, float(radians(s.phi)), 0.5f, 0, 0.1f);
  std::vector<double> mass(nodes);
  for (int i = 0; i < nodes; ++i) {
    mass[std::size_t(i)] = lobe.energy_density(float(-pi + (i + 0.5) * 2 * pi / nodes)) * 2 * pi / nodes;
  }
  // Cosine series of the blurred density: as many terms as the Gaussian leaves.
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

Curves make_curves(const FitSettings& s) {
  fiber::ReferenceRequest request;
  request.eta = s.eta;
  request.eccentricity = s.eccentricity;
  request.theta_d = radians(s.theta_d);
  request.phi_r = radians(s.phi);
  request.sigma = radians(s.sigma);
  request.sigma_a = s.sigma_a;
  request.p = fiber::slice_order(static_cast<int>(s.lobe));
  if (s.lobe == fiber::Lobe::glint) request.part = fiber::TrtPart::glint;
  // 2048 do for 5 degrees; a narrower blur resolves more of the caustics.
  if (s.is_rest) request.part = fiber::TrtPart::rest;
  request.nodes = 2048 * std::max(1, static_cast<int>(std::ceil(5 / s.sigma)));
  const fiber::FourierReference reference(request);

  Curves curves;
  curves.target = [reference](double phi) { return reference.density(phi); };
  curves.energy = reference.energy();
  if (s.lobe == fiber::Lobe::r) {
    curves.fit = blurred_reflection(s);
    return curves;
  }
  RowRequest row;
  row.slice_lobe = s.is_rest ? fiber::trt_rest_slice : static_cast<int>(s.lobe);
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
  return curves;
}

/// The objective of the table (adaptive/options.h) against the reference, on absolute densities.
double relative_l2(const Curves& curves) {
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

/// What is fitted, and how well.
std::vector<std::string> title_of(const FitSettings& s, const char* lobe, const Curves& curves, double error) {
  const std::string row = fmt::format("{}: e {:.4g}, eta {:.4g}, phi_r {:.4g}, theta_d {:.4g}, sigma {:.4g} degrees{}",
                                      lobe, s.eccentricity, s.eta, s.phi, s.theta_d, s.sigma,
                                      s.sigma_a > 0 ? fmt::format(", sigma_a {:.4g}", s.sigma_a) : std::string());
  if (s.lobe == fiber::Lobe::r) return {row, fmt::format("energy {:.4g}, relative L2 {:.3g}", curves.energy, error)};
  return {row, fmt::format("energy {:.4g}, relative L2 {:.3g} (epsilon {:.3g}), {} components, {} evaluations{}",
                           curves.energy, error, s.epsilon, curves.components, curves.evaluations,
                           curves.converged ? "" : ": not converged")};
}

int draw(const std::filesystem::path& file, const std::vector<double>& target, const std::vector<double>& fit,
         const std::vector<std::string>& title) {
  const image::Picture picture = plot_curves(
      {{"reference", target, glm::vec3(0.02f, 0.02f, 0.02f)}, {"fit", fit, glm::vec3(0.8f, 0.05f, 0.02f)}}, title);
  if (const std::optional<Error> error = image::write_png(file, picture)) {
    log_error(error->message());
    return 1;
  }
  remove_leftovers(file);
  return 0;
}

/// Learns the row at exactly (phi, theta_d) and prints or draws it beside the Fourier reference.
/// Exit status 1 if the row does not converge.
int run_fit(const FitSettings& settings) {
  if (settings.plot) {
    if (const std::optional<Error> error = check_output(*settings.plot)) {
      log_error(error->message());
      return 1;
    }
  }
  const Curves curves = make_curves(settings);
  std::vector<double> phi_deg, target, fit;
  for (int i = 0; i < settings.samples; ++i) {
    phi_deg.push_back(-180 + 360.0 * i / settings.samples);
    target.push_back(curves.target(radians(phi_deg.back())));
    fit.push_back(curves.fit(radians(phi_deg.back())));
  }
  const double error = relative_l2(curves);
  const char* lobe = settings.is_rest ? "TRT-REST" : fiber::lobe_names[static_cast<std::size_t>(settings.lobe)];
  int status = 0;
  if (!curves.converged) {
    log_error(fmt::format("lobe {}: expected the row to converge to epsilon {}, found it refused at {:.3g}", lobe,
                          settings.epsilon, error));
    status = 1;
  }
  if (settings.json) {
    const nlohmann::ordered_json json = {{"lobe", lobe},
                                         {"phi_deg", phi_deg},
                                         {"target", target},
                                         {"fit", fit},
                                         {"energy", curves.energy},
                                         {"relative_l2", error},
                                         {"components", curves.components},
                                         {"evaluations", curves.evaluations}};
    fmt::print("{}\n", json.dump());
    return status;
  }
  fmt::print("lobe         {}\nenergy       {:.6g}\nrelative_l2  {:.3g}\ncomponents   {}\nevaluations  {}\n", lobe,
             curves.energy, error, curves.components, curves.evaluations);
  if (!settings.plot) return status;
  return std::max(status, draw(*settings.plot, target, fit, title_of(settings, lobe, curves, error)));
}

}  // namespace

Command add_fit(CLI::App& tress) {
  const auto settings = std::make_shared<FitSettings>();
  FitSettings& s = *settings;
  CLI::App* fit = tress.add_subcommand("fit", "Learn one row and show it beside its reference");
  const std::map<std::string, fiber::Lobe> lobes{{"R", fiber::Lobe::r},
                                                 {"TT", fiber::Lobe::tt},
                                                 {"TRT", fiber::Lobe::trt},
                                                 {"GLINT", fiber::Lobe::glint},
                                                 {"TRRT", fiber::Lobe::trrt}};
  add_choice(
      fit, "--lobe", {"TT", "TRT", "GLINT", "TRT-REST", "TRRT", "R"},
      [&s, lobes](const std::string& name) {
        s.is_rest = name == "TRT-REST";
        s.lobe = s.is_rest ? fiber::Lobe::trt : lobes.at(name);
      },
      "lobe; TRT-REST is what GLINT leaves of TRT")
      ->required();
  add_number(fit, "--e", [&s](double x) { s.eccentricity = x; });
  add_number(fit, "--theta-d", [&s](double x) { s.theta_d = x; });
  add_number(fit, "--phi", [&s](double x) { s.phi = x; });
  add_number(fit, "--sigma", [&s](double x) { s.sigma = x; });
  add_number(fit, "--eta", [&s](double x) { s.eta = x; });
  add_numbers(
      fit, "--sigma-a", 1, 1, [&s](const auto& x) { s.sigma_a = x[0]; },
      "absorption per major semi-axis, of one channel");
  add_number(fit, "--epsilon", [&s](double x) { s.epsilon = x; });
  add_whole(fit, "--samples", [&s](std::uint64_t n) { s.samples = int(n); });
  auto* json = fit->add_flag("--json", s.json, "print the curves as JSON");
  add_file(
      fit, "-o,--output", [&s](const std::string& file) { s.plot = file; }, "draw the curves", ".png")
      ->excludes(json);
  return {fit, [settings] { return run_fit(*settings); }};
}

}  // namespace tress::cli
