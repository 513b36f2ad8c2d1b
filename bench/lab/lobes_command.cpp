// tress-lab lobes: what a fiber does with light, as a page: its rows beside their targets, and the far fields of all
// models.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/process.h"
#include "cli/progress.h"
#include "lab/commands.h"
#include "lab/far_field_json.h"
#include "lab/fit_json.h"
#include "lab/lobes_page.h"
#include "lab/web_assets.h"
#include "live/web_page.h"
#include "scene/model/parameters.h"
#include "tress/base/replace_file.h"
#include "tress/version.h"

namespace tress::lab {
namespace {

using namespace cli;

using Json = nlohmann::ordered_json;

struct LobesSettings : FarFieldSettings {
  std::vector<std::string> models;  ///< of references::models(); empty: all
  std::filesystem::path output;
  std::optional<int> threads;
};

constexpr int azimuths = 360;

/// A lobe and which of the azimuthal widths of the fiber it has.
constexpr std::array<std::pair<const char*, std::size_t>, 5> row_lobes{
    {{"TT", 0}, {"TRT", 1}, {"GLINT", 1}, {"TRT-REST", 1}, {"TRRT", 2}}};

/// The row of a lobe that this fiber asks where light leaves on its specular cone: theta_i = -theta_r.
fiber::RowFitRequest row_of(const LobesSettings& s, const char* lobe, std::size_t width, double sigma_a) {
  const double degrees = 180 / std::numbers::pi;
  fiber::RowFitRequest row;
  set_lobe(lobe, &row);
  row.eccentricity = s.eccentricity;
  row.theta_d = s.theta_r;
  row.phi = s.phi_r;
  row.sigma = std::max(double(fiber::azimuthal_sigmas(parameters_of(s))[width]) * degrees,
                       scene::option_parameter("--sigma").range.least);
  row.eta = s.eta;
  row.sigma_a = sigma_a;
  row.epsilon = s.table.epsilon;
  return row;
}

std::vector<Json> rows_of(const LobesSettings& s) {
  std::vector<Json> rows;
  const Step step(fmt::format("rows of {} lobes", row_lobes.size()));
  for (const auto& [lobe, width] : row_lobes) {
    for (std::size_t c = 0; c < s.channels(); ++c) {
      rows.push_back(row_json(fitted_row(row_of(s, lobe, width, s.sigma_a[c]), azimuths)));
      rows.back()["channel"] = s.channels() == 1 ? "grey" : channel_names[c];
    }
  }
  return rows;
}

/// The traced truth first, which the others are held against.
std::vector<std::string> model_names() {
  std::vector<std::string> names{fiber::fiber3d_info.name};
  for (const fiber::ModelInfo& model : references::models()) {
    if (model.name != names.front()) names.emplace_back(model.name);
  }
  return names;
}

int run_lobes(const LobesSettings& settings) {
  if (const std::optional<Error> error = check_output(settings.output)) {
    log_error(error->message());
    return 1;
  }
  return run_threaded(settings.threads, [&](int) {
    std::vector<Json> far_fields;
    for (const std::string& model : settings.models.empty() ? model_names() : settings.models) {
      const Step step("far field of " + model);
      FarFieldSettings one = settings;
      one.model = model;
      const MeasuredFarField measured = measure_far_field(one);
      warn_of_rows(one, measured);
      far_fields.push_back(far_field_json(one, measured));
    }
    return write_lobes(settings.output, rows_of(settings), far_fields);
  });
}

}  // namespace

int write_lobes(const std::filesystem::path& file, const std::vector<Json>& rows, const std::vector<Json>& far_fields) {
  const std::string page = live::whole_page(
      "lobes.html", {{"version", version()}, {"rows", rows}, {"far_fields", far_fields}}, web_assets());
  if (const std::optional<Error> error = replace_file(file, page)) {
    log_error(error->message());
    return 1;
  }
  cli::remove_leftovers(file);
  return 0;
}

cli::Command add_lobes(CLI::App& tress) {
  const auto settings = std::make_shared<LobesSettings>();
  LobesSettings& s = *settings;
  CLI::App* lobes = tress.add_subcommand(
      "lobes", "Show in a page the rows of a fiber beside their targets, and the far field of all models");
  const std::vector<std::string> known = model_names();
  lobes
      ->add_option_function<std::vector<std::string>>(
          "--models", [&s](const std::vector<std::string>& models) { s.models = models; },
          "fiber models, first to last; those that have rows learn them first; default: all of " + joined(known, ","))
      ->delimiter(',')
      ->check(expecting("one of " + joined(known, "|"),
                        [known](const std::string& name) { return std::ranges::find(known, name) != known.end(); }))
      ->type_name("NAME,...");
  add_far_field_options(lobes, s);
  add_threads(lobes, s.threads);
  add_file(lobes, "-o,--output", [&s](const std::string& file) { s.output = file; },
           "page, which needs no other file and no network", {".html"})
      ->required();
  add_quiet(lobes);
  return {lobes, [settings] {
            if (const std::string message = far_field_contradiction(*settings); !message.empty())
              throw WrongUsage(message);
            return run_lobes(*settings);
          }};
}

}  // namespace tress::lab
