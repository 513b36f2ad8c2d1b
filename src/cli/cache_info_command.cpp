// tress cache info and verify: what is in a warm cache, and whether it is whole.
#include <fmt/format.h>

#include <algorithm>
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
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/hair_words.h"
#include "cli/options.h"
#include "cli/process.h"
#include "cli/warm_start.h"
#include "references/default_model.h"
#include "tress/adaptive/cache.h"

namespace tress::cli {
namespace {

struct CacheSettings {
  std::filesystem::path file;
  bool json = false;
  std::optional<std::filesystem::path> scene;  ///< to be rendered with it
  bool model_given = false;
  RenderSettings render;
};

struct SliceSummary {
  std::string lobe;
  std::uint64_t ribbons = 0;  ///< rows of a slice of samples that have converged
  std::uint64_t nodes = 0, open = 0, converged = 0, components = 0;
  std::uint64_t knot_densitys = 0, knots = 0;  ///< rows that are knot tables, and the knots in them
  std::size_t bytes = 0;                       ///< in the file
  SliceContents contents;
};

/// Of the running slice of the cache, whose rows it uses up.
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
    if (row.ribbons) {
      ++summary.ribbons;
    } else if (row.knots.empty()) {
      summary.components += row.fit.component_count;
    } else {
      ++summary.knot_densitys;
      summary.knots += row.knots.knots().size();
    }
  }
  summary.contents.open = summary.open;
  summary.contents.converged = summary.converged;
  return summary;
}

/// The key of a slice of densities: those of a hair's lobe. Of one of samples: its parameters, as they are.
nlohmann::ordered_json key_of(const adaptive::SliceDescription& slice, const std::string& lobe) {
  if (slice.kind == adaptive::SliceKind::samples) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const float parameter : slice.key.told_parameters()) parameters.push_back(as_typed(parameter));
    return {{"lobe", lobe}, {"parameters", parameters}};
  }
  const auto parameters = slice.key.parameters;
  return {{"lobe", lobe},
          {"eta", as_typed(parameters[0])},
          {"e", as_typed(parameters[1])},
          {"sigma_deg", double(parameters[2]) * 180 / std::numbers::pi}};
}

nlohmann::ordered_json to_json(const adaptive::SliceDescription& slice, const SliceSummary& s) {
  return {{"key", key_of(slice, s.lobe)},
          {"kind", slice.kind == adaptive::SliceKind::samples ? "samples" : "densities"},
          {"nodes", s.nodes},
          {"rows", {{"open", s.open}, {"converged", s.converged}}},
          {"components", s.components},
          {"knot_tables", s.knot_densitys},
          {"knots", s.knots},
          {"ribbons", s.ribbons},
          {"bytes", s.bytes}};
}

/// A line for each slice, those of densities apart from those of samples.
struct SliceLines {
  std::string densities, samples;

  void add(const adaptive::SliceDescription& slice, const SliceSummary& s) {
    if (slice.kind == adaptive::SliceKind::samples) {
      const std::string parameters = fmt::format("{}", fmt::join(slice.key.told_parameters(), " "));
      samples += fmt::format("  {:5} {:7} {:7} {:9} {:8} {:10}  {}\n", s.lobe, s.nodes, s.open, s.converged, s.ribbons,
                             s.bytes, parameters);
      return;
    }
    const auto parameters = slice.key.parameters;
    densities += fmt::format("  {:5} {:5.3f} {:5.3f} {:6.2f} {:7} {:7} {:9} {:10} {:7} {:10}\n", s.lobe, parameters[0],
                             parameters[1], double(parameters[2]) * 180 / std::numbers::pi, s.nodes, s.open,
                             s.converged, s.components, s.knots, s.bytes);
  }

  void print() const {
    if (!densities.empty()) {
      fmt::print("  {:5} {:>5} {:>5} {:>6} {:>7} {:>7} {:>9} {:>10} {:>7} {:>10}\n{}", "lobe", "eta", "e", "sigma",
                 "nodes", "open", "converged", "components", "knots", "bytes", densities);
    }
    if (samples.empty()) return;
    fmt::print("  {:5} {:>7} {:>7} {:>9} {:>8} {:>10}  {}\n{}", "lobe", "nodes", "open", "converged", "ribbons",
               "bytes", "parameters", samples);
  }
};

/// A line for each kind of hair, how much of it is known and how well.
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

/// How much of the scene would start warm. Unset, and told, if it cannot be loaded.
std::optional<WarmStart> warm_start_of(const CacheSettings& settings, adaptive::CacheFile& cache) {
  RenderSettings render = settings.render;
  if (!settings.model_given) {
    if (const fiber::ModelInfo* info = references::model_of_rows(cache)) render.model = info->name;
  }
  Result<scene::Scene> scene = scene::load_scene(*settings.scene, render.overrides);
  if (!scene) {
    log_error(scene.error().message());
    return std::nullopt;
  }
  for (const std::string& text : scene->warnings) log_warning(text);
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

/// Prints model, format, hair, slices and hash, and how a scene would start. Exit status 1 if a file is refused.
int run_cache_info(const CacheSettings& settings) {
  const Result<std::unique_ptr<adaptive::CacheFile>> cache = adaptive::CacheFile::open(settings.file, "");
  if (!cache) {
    log_error(cache.error().message());
    return 1;
  }
  adaptive::CacheFile& rows = **cache;
  const adaptive::CacheContents& contents = rows.contents();
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  SliceLines lines;
  std::vector<SliceContents> held;
  while (const adaptive::SliceDescription* slice = rows.next_slice()) {
    SliceSummary summary = summarise(*slice, rows);
    slices.push_back(to_json(*slice, summary));
    lines.add(*slice, summary);
    held.push_back(std::move(summary.contents));
  }
  if (const std::optional<Error> error = rows.failure()) {
    log_error(error->message());
    return 1;
  }
  const std::vector<TableHair> hair = hair_of(held);
  std::optional<WarmStart> start;
  if (settings.scene) {
    start = warm_start_of(settings, rows);
    if (!start) return 1;
  }
  if (settings.json) {
    nlohmann::ordered_json told = nlohmann::ordered_json::array();
    for (const TableHair& one : hair) told.push_back(to_json(one));
    nlohmann::ordered_json json = {{"model", rows.model()},
                                   {"format", contents.format},
                                   {"hash", contents.hash},
                                   {"bytes", contents.bytes},
                                   {"rows", {{"open", contents.open_rows}, {"converged", contents.converged_rows}}},
                                   {"knot_tables", contents.knot_rows},
                                   {"ribbons", contents.ribbon_rows},
                                   {"hair", told},
                                   {"pages", slices}};
    if (start) json["warm_start"] = to_json(*start);
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return 0;
  }
  fmt::print(
      "model   {}\nformat  {}\nhash    {}\nbytes   {}\nrows    {} open, {} converged\nknots   {} of the converged\n"
      "ribbons {} of the converged\npages   {}\n",
      rows.model(), contents.format, contents.hash, contents.bytes, contents.open_rows, contents.converged_rows,
      contents.knot_rows, contents.ribbon_rows, contents.slices);
  print_hair(hair);
  lines.print();
  if (start) fmt::print("{}", in_words(*start));
  return 0;
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

CLI::App* add_look(CLI::App& cache, const char* name, const char* what, CacheSettings& settings) {
  CLI::App* command = cache.add_subcommand(name, what);
  command->add_option("FILE", settings.file, "warm cache")->required()->type_name("FILE");
  command->add_flag("--json", settings.json, "print JSON");
  return command;
}

/// What of a render decides which rows it asks.
void add_scene(CLI::App* info, CacheSettings& s) {
  CLI::Option* scene = info->add_option_function<std::string>(
      "--for", [&s](const std::string& file) { s.scene = file; },
      "scene, as of render: how much of it would start warm, by a small picture of it; the options below are of it");
  scene->type_name("SCENE");
  const std::size_t before = info->get_options().size();
  std::vector<std::string> models;
  for (const fiber::ModelInfo& model : references::models()) {
    if (model.has_rows()) models.emplace_back(model.name);
  }
  add_choice(
      info, "--model", models,
      [&s](const std::string& name) {
        s.render.model = name;
        s.model_given = true;
      },
      "fiber model that would render it; default: that whose rows the cache has");
  add_learner(info, s.render.table);
  add_appearance(info, s.render.overrides);
  add_whole(info, "--frame", [&s](std::uint64_t n) { s.render.overrides.frame = int(n); });
  add_threads(info, s.render.threads);
  const std::vector<CLI::Option*> options = info->get_options();
  for (std::size_t i = before; i < options.size(); ++i) options[i]->needs(scene);
}

}  // namespace

Command add_cache_info(CLI::App& cache) {
  const auto settings = std::make_shared<CacheSettings>();
  CLI::App* info = add_look(cache, "info",
                            "What hair is in the cache, how good, and how much of a scene would start warm", *settings);
  add_scene(info, *settings);
  add_quiet(info);
  return {info, [settings] { return run_cache_info(*settings); }};
}

Command add_cache_verify(CLI::App& cache) {
  const auto settings = std::make_shared<CacheSettings>();
  CLI::App* verify = add_look(cache, "verify", "Exit 0 if the file is whole, 1 if it is refused", *settings);
  return {verify, [settings] { return run_cache_verify(*settings); }};
}

}  // namespace tress::cli
