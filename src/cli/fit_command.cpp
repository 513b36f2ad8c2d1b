// tress fit: one row of the table beside its reference.
#include "cli/fit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
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
#include "models/row_fit.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {
namespace {

/// Every value in range.
struct FitSettings : fiber::RowFitRequest {
  int samples = 360;  ///< azimuths printed
  bool json = false;
  std::optional<std::filesystem::path> plot;  ///< PNG
};

/// What is fitted, and how well.
std::vector<std::string> title_of(const FitSettings& s, const char* lobe, const fiber::RowFit& curves, double error) {
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
  const fiber::RowFit curves = fiber::fit_row(settings);
  std::vector<double> phi_deg, target, fit;
  for (int i = 0; i < settings.samples; ++i) {
    phi_deg.push_back(-180 + 360.0 * i / settings.samples);
    target.push_back(curves.target(phi_deg.back() * std::numbers::pi / 180));
    fit.push_back(curves.fit(phi_deg.back() * std::numbers::pi / 180));
  }
  const double error = fiber::relative_l2(curves);
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
