// tress-lab fit: one row of the table beside its reference.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "lab/commands.h"
#include "lab/curve_plot.h"
#include "lab/fit_json.h"
#include "lab/lobes_page.h"

namespace tress::lab {
namespace {

using namespace cli;

/// Every value in range.
struct FitSettings : fiber::RowFitRequest {
  int samples = 360;  ///< azimuths printed
  bool json = false;
  std::optional<std::filesystem::path> plot;  ///< .png or .html
};

/// What is fitted, and how well.
std::vector<std::string> title_of(const FittedRow& row) {
  const fiber::RowFitRequest& s = row.request;
  const std::string first = fmt::format(
      "{}: e {:.4g}, eta {:.4g}, phi_r {:.4g}, theta_d {:.4g}, sigma {:.4g} degrees{}", lobe_name(s), s.eccentricity,
      s.eta, s.phi, s.theta_d, s.sigma, s.sigma_a > 0 ? fmt::format(", sigma_a {:.4g}", s.sigma_a) : std::string());
  const std::string found = fmt::format("energy {:.4g}, relative L2 {:.3g}", row.curves.energy, row.error);
  if (s.lobe == fiber::Lobe::r) return {first, found};
  return {first,
          fmt::format("{} (epsilon {:.3g}), {} components, {} evaluations{}", found, s.epsilon, row.curves.components,
                      row.curves.evaluations, row.curves.converged ? "" : ": not converged")};
}

bool is_page(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".html";
}

/// Exit status.
int draw(const std::filesystem::path& file, const FittedRow& row) {
  if (is_page(file)) return write_lobes(file, {row_json(row)}, {});
  const image::Picture picture = plot_curves(
      {{"reference", row.target, glm::vec3(0.02f, 0.02f, 0.02f)}, {"fit", row.fit, glm::vec3(0.8f, 0.05f, 0.02f)}},
      title_of(row));
  if (const std::optional<Error> error = image::write_png(file, picture)) {
    log_error(error->message());
    return 1;
  }
  cli::remove_leftovers(file);
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
  const FittedRow row = fitted_row(settings, settings.samples);
  int status = 0;
  if (!row.curves.converged) {
    log_error(fmt::format("lobe {}: expected the row to converge to epsilon {}, found it refused at {:.3g}",
                          lobe_name(settings), settings.epsilon, row.error));
    status = 1;
  }
  if (settings.json) {
    fmt::print("{}\n", row_json(row).dump());
    return status;
  }
  fmt::print("lobe         {}\nenergy       {:.6g}\nrelative_l2  {:.3g}\ncomponents   {}\nevaluations  {}\n",
             lobe_name(settings), row.curves.energy, row.error, row.curves.components, row.curves.evaluations);
  if (!settings.plot) return status;
  return std::max(status, draw(*settings.plot, row));
}

}  // namespace

cli::Command add_fit(CLI::App& tress) {
  const auto settings = std::make_shared<FitSettings>();
  FitSettings& s = *settings;
  CLI::App* fit = tress.add_subcommand("fit", "Learn one row and show it beside its reference");
  add_choice(
      fit, "--lobe", {"TT", "TRT", "GLINT", "TRT-REST", "TRRT", "R"},
      [&s](const std::string& name) { set_lobe(name, &s); }, "lobe; TRT-REST is what GLINT leaves of TRT")
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
  add_file(fit, "-o,--output", [&s](const std::string& file) { s.plot = file; },
           "draw the curves: a picture, or a page that needs no other file", {".png", ".html"})
      ->excludes(json);
  return {fit, [settings] { return run_fit(*settings); }};
}

}  // namespace tress::lab
