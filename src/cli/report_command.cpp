// tress report: makes a page about runs from their telemetry.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "live/report_data.h"
#include "live/web_page.h"
#include "tress/base/replace_file.h"

namespace tress::cli {
namespace {

struct ReportSettings {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path output;
};

int run_report(const ReportSettings& settings) {
  const auto failed = [](const Error& error) {
    log_error(error.message());
    return 1;
  };
  if (const auto error = check_output(settings.output)) return failed(*error);
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (const std::filesystem::path& file : settings.runs) {
    const auto data = live::report_data(file);
    if (!data) return failed(data.error());
    for (const nlohmann::ordered_json& run : *data) {
      log_note(run["name"].get<std::string>() + ": " + run["verdict"]["text"].get<std::string>());
      runs.push_back(run);
    }
  }
  if (const auto error = replace_file(settings.output, live::whole_page("report.html", runs))) return failed(*error);
  remove_leftovers(settings.output);
  return 0;
}

}  // namespace

Command add_report(CLI::App& tress) {
  const auto settings = std::make_shared<ReportSettings>();
  ReportSettings& s = *settings;
  CLI::App* report = tress.add_subcommand("report", "Show in a page how renders converged and what learning cost");
  report
      ->add_option_function<std::vector<std::string>>(
          "RUN", [&s](const std::vector<std::string>& files) { s.runs.assign(files.begin(), files.end()); },
          "telemetry of a render; several are compared")
      ->required();
  add_file(report, "-o,--output", [&s](const std::string& file) { s.output = file; },
           "page, which needs no other file and no network", {".html"})
      ->required();
  add_quiet(report);
  return {report, [settings] { return run_report(*settings); }};
}

}  // namespace tress::cli
