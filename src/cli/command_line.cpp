#include "cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "cli/cache_options.h"
#include "cli/console.h"
#include "cli/diff_command.h"
#include "cli/fit_options.h"
#include "cli/option_types.h"
#include "cli/render_options.h"
#include "cli/standard_streams.h"
#include "cli/unknown_word.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

int wrong_usage(const std::string& message) {
  fail(message);
  std::fputs("usage: tress render|fit|diff|cache ...; --help tells more\n", stderr);
  return 2;
}

int run_checked(int argc, char** argv) {
  CLI::App app("Renders hair whose fibers have elliptical cross-sections, learning its scattering tables on the way",
               "tress");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("tress ") + version());
  RenderSettings render_settings;
  bool quiet = false;
  CLI::App* render = add_render(app, render_settings, quiet);
  FitSettings fit_settings;
  CLI::App* fit = add_fit(app, fit_settings);

  DiffSettings diff_settings;
  CLI::App* diff = app.add_subcommand("diff", "Compare two pictures");
  diff->add_option("A", diff_settings.a, "picture")->required()->type_name("A.exr");
  diff->add_option("B", diff_settings.b, "picture held against A")->required()->type_name("B.exr");
  diff->add_flag("--json", diff_settings.json, "print JSON");

  CacheOptions cache_options;
  CLI::App* cache = add_cache(app, cache_options, quiet);

  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (const std::string message = unknown_word(app, words); !message.empty()) return wrong_usage(message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version: standard output
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
      const CLI::App& asked = cache->parsed() ? *cache : app;
      if (asked.get_subcommands().empty()) {
        return wrong_usage("expected a command: " + joined(command_names(asked), "|"));
      }
    }
    return wrong_usage(error.what());
  }
  open_console(quiet);
  if (render->parsed()) {
    if (const std::string message = contradiction(*render, render_settings); !message.empty()) {
      return wrong_usage(message);
    }
    return run_render(render_settings);
  }
  if (fit->parsed()) return run_fit(fit_settings);
  if (diff->parsed()) return run_diff(diff_settings);
  if (const std::string message = contradiction(*cache, cache_options); !message.empty()) return wrong_usage(message);
  return run_cache(*cache, cache_options);
}

}  // namespace

int run(int argc, char** argv) {
  prepare_standard_streams();
  int status = 1;
  try {
    status = run_checked(argc, argv);
  } catch (const std::bad_alloc&) {
    fail("memory: expected more, found none left; what had been saved is as it was");
  } catch (const std::exception& error) {
    if (std::ferror(stdout) == 0) fail(error.what());  // else told below
  }
  if (const std::optional<Error> error = flush_results()) {
    fail(error->message());
    status = std::max(status, 1);
  }
  return status;
}

}  // namespace tress::cli
