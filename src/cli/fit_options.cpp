#include "cli/fit_options.h"

#include <filesystem>
#include <map>
#include <string>

#include "cli/option_types.h"

namespace tress::cli {

CLI::App* add_fit(CLI::App& app, FitSettings& s) {
  CLI::App* fit = app.add_subcommand("fit", "Learn one row and show it beside its reference");
  const std::map<std::string, fiber::Lobe> lobes{{"R", fiber::Lobe::r},
                                                 {"TT", fiber::Lobe::tt},
                                                 {"TRT", fiber::Lobe::trt},
                                                 {"GLINT", fiber::Lobe::glint},
                                                 {"TRRT", fiber::Lobe::trrt}};
  add_choice(
      fit, "--lobe", {"TT", "TRT", "GLINT", "TRRT", "R"},
      [&s, lobes](const std::string& name) { s.lobe = lobes.at(name); }, "lobe")
      ->required();
  add_number(fit, "--e", {0.5, 1}, [&s](double x) { s.eccentricity = x; }, "minor over major semi-axis, .5 to 1");
  add_number(fit, "--theta-d", {-89.9, 89.9}, [&s](double x) { s.theta_d = x; }, "difference angle, degrees");
  add_number(
      fit, "--phi", {-36000, 36000}, [&s](double x) { s.phi = x; },
      "azimuth of the known direction from the major axis, degrees");
  add_number(fit, "--sigma", {0.5, 45}, [&s](double x) { s.sigma = x; }, "blur of the exit azimuth, degrees");
  add_number(fit, "--eta", {1.05, 3}, [&s](double x) { s.eta = x; }, "index of refraction, default 1.55");
  add_number(fit, "--sigma-a", {0, 1000}, [&s](double x) { s.sigma_a = x; }, "absorption per major semi-axis");
  add_number(fit, "--epsilon", {0, 1, true}, [&s](double x) { s.epsilon = x; }, "default .01");
  add_integer(fit, "--samples", 1, 1 << 20, [&s](int n) { s.samples = n; }, "azimuths printed, default 360");
  auto* json = fit->add_flag("--json", s.json, "print the curves as JSON");
  fit->add_option_function<std::string>(
         "-o,--output",
         [&s](const std::string& file) {
           if (std::filesystem::path(file).extension() != ".png") refuse("-o", "a name that ends in .png", file);
           s.plot = file;
         },
         "draw the curves")
      ->type_name("plot.png")
      ->excludes(json);
  return fit;
}
}  // namespace tress::cli
