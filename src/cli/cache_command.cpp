#include "cli/cache_command.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "cli/console.h"
#include "tress/adaptive/cache.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/lobes.h"

namespace tress::cli {
namespace {

/// The number after the magic of 8 bytes (adaptive/cache/CACHE_FORMAT.md).
std::uint32_t format_version(const std::string& bytes) {
  std::uint32_t version = 0;
  for (std::size_t i = 0; i < 4; ++i) version |= std::uint32_t{static_cast<unsigned char>(bytes[8 + i])} << (8 * i);
  return version;
}

/// The number that a float was written as: .85, not .8500000238.
double as_typed(float x) { return std::stod(fmt::format("{}", x)); }

struct SliceSummary {
  std::string lobe;
  std::uint64_t nodes = 0, open = 0, converged = 0, components = 0;
  std::uint64_t knot_densitys = 0, knots = 0;  ///< rows that are knot tables, and the knots in them
  std::size_t bytes = 0;                       ///< in the file
};

SliceSummary summarise(const adaptive::TableSnapshot& image, const adaptive::CachedSlice& slice) {
  SliceSummary summary;
  const std::uint32_t lobe = slice.description.key.lobe;
  summary.lobe = lobe == fiber::trt_rest_slice     ? "TRT without GLINT"
                 : lobe < fiber::lobe_names.size() ? fiber::lobe_names[lobe]
                                                   : std::to_string(lobe);
  summary.nodes = slice.description.node_count();
  for (const adaptive::CachedRow& row : slice.rows) {
    const bool converged = row.state == adaptive::RowState::converged;
    ++(converged ? summary.converged : summary.open);
    if (!converged) continue;
    if (row.knots.empty()) {
      summary.components += row.fit.component_count;
    } else {
      ++summary.knot_densitys;
      summary.knots += row.knots.knots().size();
    }
  }
  summary.bytes =
      adaptive::encode_cache({image.model, {slice}}).size() - adaptive::encode_cache({image.model, {}}).size();
  return summary;
}

}  // namespace

int run_cache_info(const CacheSettings& settings) {
  const Result<adaptive::TableSnapshot> image = adaptive::load_cache(settings.file, "");
  if (!image) {
    fail(image.error().message());
    return 1;
  }
  // What was read, not what a session may have put in its place since: equal tables are equal files.
  const std::string bytes = adaptive::encode_cache(*image);
  const std::string hash = adaptive::cache_hash(*image);
  std::uint64_t open = 0, converged = 0, knot_densitys = 0;
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  std::string text;
  for (const adaptive::CachedSlice& slice : image->slices) {
    const SliceSummary s = summarise(*image, slice);
    open += s.open;
    converged += s.converged;
    knot_densitys += s.knot_densitys;
    const auto& parameters = slice.description.key.parameters;
    const double sigma_deg = double(parameters[2]) * 180 / std::numbers::pi;
    slices.push_back({{"key",
                       {{"lobe", s.lobe},
                        {"eta", as_typed(parameters[0])},
                        {"e", as_typed(parameters[1])},
                        {"sigma_deg", sigma_deg}}},
                      {"nodes", s.nodes},
                      {"rows", {{"open", s.open}, {"converged", s.converged}}},
                      {"components", s.components},
                      {"knot_tables", s.knot_densitys},
                      {"knots", s.knots},
                      {"bytes", s.bytes}});
    text += fmt::format("  {:5} {:5.3f} {:5.3f} {:6.2f} {:7} {:7} {:9} {:10} {:7} {:10}\n", s.lobe, parameters[0],
                        parameters[1], sigma_deg, s.nodes, s.open, s.converged, s.components, s.knots, s.bytes);
  }
  if (settings.json) {
    const nlohmann::ordered_json json = {{"model", image->model},
                                         {"format", format_version(bytes)},
                                         {"hash", hash},
                                         {"bytes", bytes.size()},
                                         {"rows", {{"open", open}, {"converged", converged}}},
                                         {"knot_tables", knot_densitys},
                                         {"pages", slices}};
    fmt::print("{}\n", json.dump());
    return 0;
  }
  fmt::print(
      "model   {}\nformat  {}\nhash    {}\nbytes   {}\nrows    {} open, {} converged\nknots   {} of the converged\n"
      "pages   {}\n",
      image->model, format_version(bytes), hash, bytes.size(), open, converged, knot_densitys, image->slices.size());
  if (!text.empty()) {
    fmt::print("  {:5} {:>5} {:>5} {:>6} {:>7} {:>7} {:>9} {:>10} {:>7} {:>10}\n{}", "lobe", "eta", "e", "sigma",
               "nodes", "open", "converged", "components", "knots", "bytes", text);
  }
  return 0;
}

int run_cache_verify(const CacheSettings& settings) {
  const Result<adaptive::TableSnapshot> image = adaptive::load_cache(settings.file, "");
  if (settings.json) {
    nlohmann::ordered_json json = {{"file", settings.file.string()}, {"ok", bool(image)}};
    if (!image) json["reason"] = image.error().message();
    fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (image) {
    fmt::print("{}: ok\n", settings.file.string());
  }
  if (image) return 0;
  fail(image.error().message());
  return 1;
}

}  // namespace tress::cli
