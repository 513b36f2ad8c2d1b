// tress cache info and verify: the contents of a warm cache, and a check that it is whole.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/appearance_options.h"
#include "cli/cache_commands.h"
#include "cli/console.h"
#include "cli/hair_words.h"
#include "cli/model_choice.h"
#include "cli/options.h"
#include "cli/process.h"
#include "cli/warm_start.h"
#include "models/catalog.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/cache_folder.h"

namespace tress::cli {
namespace {

struct CacheSettings {
  std::filesystem::path file;
  bool json = false;
  std::optional<std::filesystem::path> scene;  ///< the scene to be rendered with it
  RenderSettings render;
};

struct SliceSummary {
  std::string lobe;
  std::uint64_t ribbons = 0;  ///< rows of a slice of samples that have converged
  std::uint64_t nodes = 0, open = 0, converged = 0, components = 0;
  std::size_t bytes = 0;  ///< size in the file of the rows that are read
  SliceContents contents;
};

/// The smallest value that at least this share of the values does not exceed. Values ascend; there is at least one.
double quantile(const std::vector<float>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return static_cast<double>(sorted[static_cast<std::size_t>(std::floor(share * last))]);
}

/// Summarises the current slice of the cache and reads all of its rows.
SliceSummary summarise(const adaptive::SliceDescription& slice, adaptive::CacheFile& cache) {
  SliceSummary summary;
  summary.lobe = lobe_word(slice);
  summary.contents.slice = slice;
  summary.nodes = slice.node_count();
  summary.bytes = adaptive::cached_bytes(slice, cache.contents().format);
  while (const adaptive::CachedRow* next = cache.next_row()) {
    const adaptive::CachedRow& row = *next;
    summary.bytes += adaptive::cached_bytes(row);
    const bool converged = row.state == adaptive::RowState::converged;
    ++(converged ? summary.converged : summary.open);
    if (!converged) continue;
    summary.contents.objectives.push_back(row.objective);
    summary.contents.samples += row.count;
    summary.ribbons += row.ribbons() != nullptr ? 1 : 0;
    summary.components += row.density() != nullptr ? row.density()->fit.component_count : 0;
  }
  std::ranges::sort(summary.contents.objectives);
  summary.contents.open = summary.open;
  summary.contents.converged = summary.converged;
  return summary;
}

/// The key of a slice: for densities, the members of a hair's lobe; for samples, its parameters unchanged.
nlohmann::ordered_json key_of(const adaptive::SliceDescription& slice, const std::string& lobe) {
  if (slice.kind == adaptive::SliceKind::samples) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const float parameter : slice.key.used_parameters()) parameters.push_back(as_typed(parameter));
    return {{"lobe", lobe}, {"parameters", parameters}};
  }
  const auto parameters = slice.key.parameters;
  return {{"lobe", lobe},
          {"eta", as_typed(parameters[0])},
          {"e", as_typed(parameters[1])},
          {"sigma_deg", double(parameters[2]) * 180 / std::numbers::pi}};
}

nlohmann::ordered_json to_json(const adaptive::SliceDescription& slice, const SliceSummary& s) {
  nlohmann::ordered_json fields{{"key", key_of(slice, s.lobe)},
                                {"kind", slice.kind == adaptive::SliceKind::samples ? "samples" : "densities"},
                                {"nodes", s.nodes},
                                {"rows", {{"open", s.open}, {"converged", s.converged}}},
                                {"samples", s.contents.samples},
                                {"components", s.components},
                                {"ribbons", s.ribbons},
                                {"bytes", s.bytes}};
  const std::vector<float>& errors = s.contents.objectives;
  if (!errors.empty()) {
    fields["error"] = {{"median", quantile(errors, 0.5)},
                       {"q90", quantile(errors, 0.9)},
                       {"q99", quantile(errors, 0.99)},
                       {"max", quantile(errors, 1)}};
  }
  return fields;
}

/// A line for each slice, with how well its rows are known; densities and samples are separate.
struct SliceLines {
  std::string densities, samples, errors;

  void add(const adaptive::SliceDescription& slice, const SliceSummary& s) {
    add_errors(slice, s);
    if (slice.kind == adaptive::SliceKind::samples) {
      const std::string parameters = fmt::format("{}", fmt::join(slice.key.used_parameters(), " "));
      samples += fmt::format("  {:5} {:7} {:7} {:9} {:8} {:10}  {}\n", s.lobe, s.nodes, s.open, s.converged, s.ribbons,
                             s.bytes, parameters);
      return;
    }
    const auto parameters = slice.key.parameters;
    densities += fmt::format("  {:5} {:5.3f} {:5.3f} {:6.2f} {:7} {:7} {:9} {:10} {:10}\n", s.lobe, parameters[0],
                             parameters[1], double(parameters[2]) * 180 / std::numbers::pi, s.nodes, s.open,
                             s.converged, s.components, s.bytes);
  }

  void print() const {
    if (!densities.empty()) {
      fmt::print("  {:5} {:>5} {:>5} {:>6} {:>7} {:>7} {:>9} {:>10} {:>10}\n{}", "lobe", "eta", "e", "sigma", "nodes",
                 "open", "converged", "components", "bytes", densities);
    }
    if (!samples.empty()) {
      fmt::print("  {:5} {:>7} {:>7} {:>9} {:>8} {:>10}  {}\n{}", "lobe", "nodes", "open", "converged", "ribbons",
                 "bytes", "parameters", samples);
    }
    if (errors.empty()) return;
    fmt::print("accuracy of the converged rows: errors are known to be below these\n");
    fmt::print("  {:5} {:>9} {:>12} {:>10} {:>10} {:>10} {:>10}  {}\n{}", "lobe", "rows", "paths", "median", "90 %",
               "99 %", "worst", "hair", errors);
  }

 private:
  void add_errors(const adaptive::SliceDescription& slice, const SliceSummary& s) {
    const std::vector<float>& known = s.contents.objectives;
    if (known.empty()) return;
    errors += fmt::format("  {:5} {:9} {:12} {:10.2g} {:10.2g} {:10.2g} {:10.2g}  {}\n", s.lobe, s.converged,
                          s.contents.samples, quantile(known, 0.5), quantile(known, 0.9), quantile(known, 0.99),
                          quantile(known, 1), hair_words(slice));
  }
};

/// Prints a line for each kind of hair, with how much of it is known and how well.
void print_hair(const std::vector<TableHair>& all) {
  for (const TableHair& hair : all) {
    fmt::print(
        "hair    {} ({}): {} of {} directions converged{}{}\n", words(hair.parameters), fmt::join(hair.lobes, ", "),
        hair.converged, hair.nodes, hair.open > 0 ? fmt::format(", {} begun", hair.open) : "",
        hair.converged > 0
            ? fmt::format("; error at most {:.2g} at the median, {:.2g} at worst", hair.error_median, hair.error_max)
            : "");
  }
}

/// The contents of one or many files.
struct Contents {
  adaptive::CacheContents sum;  ///< its hash and format are those of the last file
  std::string model;            ///< model name of the last file
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  SliceLines lines;
  std::vector<SliceContents> held;

  /// Error if the file cannot be read to its end.
  std::optional<Error> add(adaptive::CacheFile& rows) {
    const adaptive::CacheContents& contents = rows.contents();
    while (const adaptive::SliceDescription* slice = rows.next_slice()) {
      SliceSummary summary = summarise(*slice, rows);
      slices.push_back(to_json(*slice, summary));
      lines.add(*slice, summary);
      held.push_back(std::move(summary.contents));
    }
    model = rows.model();
    sum.format = contents.format;
    sum.hash = contents.hash;
    sum.bytes += contents.bytes;
    sum.slices += contents.slices;
    sum.open_rows += contents.open_rows;
    sum.converged_rows += contents.converged_rows;
    sum.knot_rows += contents.knot_rows;
    sum.ribbon_rows += contents.ribbon_rows;
    return rows.failure();
  }
};

/// The share of the scene that would start warm. Empty, with a message, if it cannot be loaded or uses no rows; status
/// is then the exit status.
std::optional<WarmStart> warm_start_of(const CacheSettings& settings, int* status) {
  RenderSettings render = settings.render;
  *status = 1;
  Result<scene::Scene> scene = scene::load_scene(*settings.scene, render.overrides);
  if (!scene) {
    log_error(scene.error().message());
    return std::nullopt;
  }
  for (const std::string& text : scene->warnings) log_warning(text);
  if (render.model_of_scene) render.model = model_of_scene(*scene);
  if (const std::string message = refused_option(render.asked, render.model, !render.model_of_scene);
      !message.empty()) {
    log_error(message);
    *status = 2;
    return std::nullopt;
  }
  std::optional<WarmStart> found;
  run_threaded(render.threads, [&](int) {
    Result<WarmStart> start = measure_warm_start(render, std::move(*scene), settings.file);
    if (start)
      found = std::move(*start);
    else
      log_error(start.error().message());
    return 0;
  });
  return found;
}

/// Prints the lines that a file and a folder of files have in common.
int print_contents(const CacheSettings& settings, const Contents& contents, nlohmann::ordered_json json,
                   const std::string& head) {
  const std::vector<TableHair> hair = hair_of(contents.held);
  const adaptive::CacheContents& sum = contents.sum;
  std::optional<WarmStart> start;
  if (settings.scene) {
    int status = 1;
    start = warm_start_of(settings, &status);
    if (!start) return status;
  }
  if (settings.json) {
    nlohmann::ordered_json all_hair = nlohmann::ordered_json::array();
    for (const TableHair& one : hair) all_hair.push_back(to_json(one));
    json.update({{"bytes", sum.bytes},
                 {"rows", {{"open", sum.open_rows}, {"converged", sum.converged_rows}}},
                 {"knot_tables", sum.knot_rows},
                 {"ribbons", sum.ribbon_rows},
                 {"hair", all_hair},
                 {"pages", contents.slices}});
    if (start) json["warm_start"] = to_json(*start);
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return 0;
  }
  fmt::print("{}bytes   {}\nrows    {} open, {} converged\nribbons {} of the converged\npages   {}\n", head, sum.bytes,
             sum.open_rows, sum.converged_rows, sum.ribbon_rows, sum.slices);
  if (sum.knot_rows > 0)
    fmt::print("knots   {} more rows, of an earlier version: they are learned anew\n", sum.knot_rows);
  print_hair(hair);
  contents.lines.print();
  if (start) fmt::print("{}", in_words(*start));
  return 0;
}

/// The same for all files of the default folder together. Refused files are reported and counted.
int run_folder_info(const CacheSettings& settings) {
  const Result<std::filesystem::path> folder = adaptive::default_cache_folder();
  if (!folder) {
    log_error(folder.error().message());
    return 1;
  }
  Contents contents;
  std::size_t files = 0, refused = 0;
  for (const adaptive::CacheFolder::File& file : adaptive::CacheFolder(*folder).files()) {
    const auto cache = adaptive::CacheFile::open(file.path, "");
    const std::optional<Error> error = cache ? contents.add(**cache) : std::optional<Error>(cache.error());
    if (error) log_warning(error->message());
    ++(error ? refused : files);
  }
  return print_contents(settings, contents, {{"folder", folder->string()}, {"files", files}, {"refused", refused}},
                        fmt::format("folder  {}\nfiles   {}{}\n", folder->string(), files,
                                    refused > 0 ? fmt::format(", {} refused", refused) : ""));
}

/// Prints model, format, hair, slices and hash, and how a scene would start. Exit status 1 if a file is refused, 2 if
/// the scene's model has no rows or does not support the options.
int run_cache_info(const CacheSettings& settings) {
  if (is_default_cache(settings.file)) return run_folder_info(settings);
  const Result<std::unique_ptr<adaptive::CacheFile>> cache = adaptive::CacheFile::open(settings.file, "");
  if (!cache) {
    log_error(cache.error().message());
    return 1;
  }
  Contents contents;
  if (const std::optional<Error> error = contents.add(**cache)) {
    log_error(error->message());
    return 1;
  }
  return print_contents(
      settings, contents, {{"model", contents.model}, {"format", contents.sum.format}, {"hash", contents.sum.hash}},
      fmt::format("model   {}\nformat  {}\nhash    {}\n", contents.model, contents.sum.format, contents.sum.hash));
}

/// Exit status 0 if every byte of the file is as it was written, 1 with the reason if not.
int run_cache_verify(const CacheSettings& settings) {
  const Result<std::unique_ptr<adaptive::CacheFile>> cache = adaptive::CacheFile::open(settings.file, "");
  if (settings.json) {
    nlohmann::ordered_json json = {{"file", settings.file.string()}, {"ok", bool(cache)}};
    if (!cache) json["reason"] = cache.error().message();
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (cache) {
    fmt::print("{}: ok\n", settings.file.string());
  }
  if (cache) return 0;
  log_error(cache.error().message());
  return 1;
}

CLI::App* add_look(CLI::App& cache, const char* name, const char* what, const char* file, CacheSettings& settings) {
  CLI::App* command = cache.add_subcommand(name, what);
  command->add_option("FILE", settings.file, file)->required()->type_name("FILE");
  command->add_flag("--json", settings.json, "print JSON");
  return command;
}

/// Adds the options of a render that decide which rows it uses.
void add_scene(CLI::App* info, CacheSettings& s) {
  CLI::Option* scene = info->add_option_function<std::string>(
      "--for", [&s](const std::string& file) { s.scene = file; },
      "scene, as of render: how much of it would start warm, by a small picture of it; the options below are of it");
  scene->type_name("SCENE");
  const std::size_t before = info->get_options().size();
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : fiber::models()) {
    if (model.has_rows()) models.emplace_back(model.name);
  }
  add_choice(
      info, "--model", models, [&s](const std::string& name) { s.render.model = name; },
      "fiber model that would render it; default: as of render");
  add_learner(info, s.render.table);
  add_appearance(info, s.render.overrides);
  add_signed(info, "--frame", [&s](std::int64_t n) { s.render.overrides.frame = int(n); });
  add_threads(info, s.render.threads);
  const std::vector<CLI::Option*> options = info->get_options();
  for (std::size_t i = before; i < options.size(); ++i) options[i]->needs(scene);
}

}  // namespace

Command add_cache_info(CLI::App& cache) {
  const auto settings = std::make_shared<CacheSettings>();
  CLI::App* info =
      add_look(cache, "info", "What hair is in the cache, how good, and how much of a scene would start warm",
               "warm cache; the word default: all that render --warm-cache default has learned", *settings);
  add_scene(info, *settings);
  add_quiet(info);
  return {info, [info, settings] {
            log_replaced(*info);
            RenderSettings& render = settings->render;
            render.model_of_scene = info->count("--model") == 0;
            render.asked = model_options(*info, fiber::Estimator::fitted);
            render.asked.insert(render.asked.begin(), {"cache info --for", fiber::Asks::rows});
            if (!render.model_of_scene) {
              if (const std::string message = refused_option(render.asked, render.model, true); !message.empty())
                throw WrongUsage(message);
            }
            return run_cache_info(*settings);
          }};
}

Command add_cache_verify(CLI::App& cache) {
  const auto settings = std::make_shared<CacheSettings>();
  CLI::App* verify =
      add_look(cache, "verify", "Exit 0 if the file is whole, 1 if it is refused", "warm cache", *settings);
  return {verify, [settings] { return run_cache_verify(*settings); }};
}

}  // namespace tress::cli
