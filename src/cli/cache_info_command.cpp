// tress cache info and verify: what is in a warm cache, and whether it is whole.
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/console.h"
#include "fiber/rough_rows.h"
#include "tress/adaptive/cache.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {
namespace {

struct CacheSettings {
  std::filesystem::path file;
  bool json = false;
};

/// The number that a float was written as: .85, not .8500000238.
double as_typed(float x) { return std::stod(fmt::format("{}", x)); }

struct SliceSummary {
  std::string lobe;
  std::uint64_t ribbons = 0;  ///< rows of a slice of samples that have converged
  std::uint64_t nodes = 0, open = 0, converged = 0, components = 0;
  std::uint64_t knot_densitys = 0, knots = 0;  ///< rows that are knot tables, and the knots in them
  std::size_t bytes = 0;                       ///< in the file
};

/// Of the running slice of the cache, whose rows it uses up.
SliceSummary summarise(const adaptive::SliceDescription& slice, adaptive::CacheFile& cache) {
  SliceSummary summary;
  const std::uint32_t lobe = slice.key.lobe;
  summary.lobe = slice.kind == adaptive::SliceKind::samples
                     ? (lobe == fiber::rough_slice_lobe ? "rough" : std::to_string(lobe))
                 : lobe == fiber::trt_rest_slice   ? "TRT without GLINT"
                 : lobe < fiber::lobe_names.size() ? fiber::lobe_names[lobe]
                                                   : std::to_string(lobe);
  summary.nodes = slice.node_count();
  summary.bytes = adaptive::cached_bytes(slice, cache.contents().format);
  while (const adaptive::CachedRow* next = cache.next_row()) {
    const adaptive::CachedRow& row = *next;
    summary.bytes += adaptive::cached_bytes(row);
    const bool converged = row.state == adaptive::RowState::converged;
    ++(converged ? summary.converged : summary.open);
    if (!converged) continue;
    if (row.ribbons) {
      ++summary.ribbons;
    } else if (row.knots.empty()) {
      summary.components += row.fit.component_count;
    } else {
      ++summary.knot_densitys;
      summary.knots += row.knots.knots().size();
    }
  }
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

/// Prints model, format, slices and hash. Exit status 1 if the file is refused.
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
  while (const adaptive::SliceDescription* slice = rows.next_slice()) {
    const SliceSummary summary = summarise(*slice, rows);
    slices.push_back(to_json(*slice, summary));
    lines.add(*slice, summary);
  }
  if (const std::optional<Error> error = rows.failure()) {
    log_error(error->message());
    return 1;
  }
  if (settings.json) {
    const nlohmann::ordered_json json = {
        {"model", rows.model()},
        {"format", contents.format},
        {"hash", contents.hash},
        {"bytes", contents.bytes},
        {"rows", {{"open", contents.open_rows}, {"converged", contents.converged_rows}}},
        {"knot_tables", contents.knot_rows},
        {"ribbons", contents.ribbon_rows},
        {"pages", slices}};
    fmt::print("{}\n", json.dump());
    return 0;
  }
  fmt::print(
      "model   {}\nformat  {}\nhash    {}\nbytes   {}\nrows    {} open, {} converged\nknots   {} of the converged\n"
      "ribbons {} of the converged\npages   {}\n",
      rows.model(), contents.format, contents.hash, contents.bytes, contents.open_rows, contents.converged_rows,
      contents.knot_rows, contents.ribbon_rows, contents.slices);
  lines.print();
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

Command add_look(CLI::App& cache, const char* name, const char* what, int (*run)(const CacheSettings&)) {
  const auto settings = std::make_shared<CacheSettings>();
  CLI::App* command = cache.add_subcommand(name, what);
  command->add_option("FILE", settings->file, "warm cache")->required()->type_name("FILE");
  command->add_flag("--json", settings->json, "print JSON");
  return {command, [settings, run] { return run(*settings); }};
}

}  // namespace

Command add_cache_info(CLI::App& cache) {
  return add_look(cache, "info", "Print model, format, pages and hash", run_cache_info);
}

Command add_cache_verify(CLI::App& cache) {
  return add_look(cache, "verify", "Exit 0 if the file is whole, 1 if it is refused", run_cache_verify);
}

}  // namespace tress::cli
