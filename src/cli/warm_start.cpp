#include "cli/warm_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "cli/row_words.h"
#include "cli/scene_model.h"
#include "fiber/row_axes.h"
#include "geometry/fiber_scene.h"
#include "integrate/renderer.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/cache_folder.h"

namespace tress::cli {
namespace {

using adaptive::RowState;
using adaptive::SliceDescription;

constexpr int longer_side = 64, samples_of_pixel = 4;
constexpr std::size_t most_rows = 20, rows_in_words = 3;

struct CachedState {
  RowState state;
  float objective;
};
using CachedSlice = std::map<std::uint32_t, CachedState>;

/// The states of the rows of a cache, by slice.
struct CachedStates {
  std::map<adaptive::SliceKey, CachedSlice> rows;
  std::vector<SliceDescription> slices;
};

void read_states(adaptive::RowSource& source, CachedStates* states) {
  source.rewind();
  while (const SliceDescription* slice = source.next_slice()) {
    states->slices.push_back(*slice);
    CachedSlice& rows = states->rows[slice->key];
    while (const adaptive::CachedRow* row = source.next_row()) rows[row->node] = {row->state, row->objective};
  }
}

void shrink(scene::Image& image) {
  const double scale = std::min(1.0, static_cast<double>(longer_side) / std::max(image.width, image.height));
  image.width = std::max(1, static_cast<int>(std::lround(image.width * scale)));
  image.height = std::max(1, static_cast<int>(std::lround(image.height * scale)));
  image.samples = samples_of_pixel;
}

WhyCold why_cold(const CachedSlice* cached, std::uint32_t node) {
  if (cached == nullptr) return WhyCold::no_slice;
  const auto found = cached->find(node);
  if (found == cached->end()) return WhyCold::absent;
  return found->second.state == RowState::converged ? WhyCold::coarse : WhyCold::open;
}

WarmSlice counted(const adaptive::Service& service, adaptive::SliceId id, const CachedStates& cached) {
  WarmSlice found;
  found.slice = service.slice(id);
  const auto rows = cached.rows.find(found.slice.key);
  found.in_cache = rows != cached.rows.end();
  if (const SliceDescription* nearest = nearest_hair(found.slice, cached.slices); !found.in_cache && nearest != nullptr)
    found.nearest = *nearest;
  const auto width = static_cast<std::uint32_t>(found.slice.axis_b.size());
  for (std::uint32_t node = 0; node < found.slice.node_count(); ++node) {
    const std::uint32_t queries = service.queries(id, node / width, node % width);
    if (queries == 0) continue;
    found.share.queries += queries;
    ++found.rows_asked;
    const adaptive::RowView row = service.peek(id, node / width, node % width);
    if (row.state == RowState::converged || row.ribbons != nullptr) {
      found.share.answered += queries;
      ++found.rows_answering;
    } else {
      found.cold.push_back({node, queries, why_cold(found.in_cache ? &rows->second : nullptr, node)});
    }
  }
  std::ranges::sort(found.cold, [](const ColdRow& a, const ColdRow& b) {
    return a.queries != b.queries ? a.queries > b.queries : a.node < b.node;
  });
  return found;
}

/// The slices of the scene's fibers whose rows only propose.
std::set<adaptive::SliceKey> narrow_slices(const fiber::ModelInfo& info, const scene::Scene& scene) {
  std::set<adaptive::SliceKey> narrow;
  if (info.slices_of == nullptr || info.learns_samples()) return narrow;
  for (const fiber::FiberParameters& fiber : scene.fibers) {
    const std::array<float, 3> blurs = fiber::azimuthal_sigmas(fiber);
    for (const SliceDescription& slice : info.slices_of(fiber)) {
      const auto order = static_cast<std::size_t>(fiber::slice_order(static_cast<int>(slice.key.lobe)));
      if (fiber::is_below_grid(blurs[order - 1])) narrow.insert(slice.key);
    }
  }
  return narrow;
}

std::vector<WarmGroom> grooms_of(const fiber::ModelInfo& info, const scene::Scene& scene,
                                 const std::vector<WarmSlice>& slices) {
  std::vector<WarmGroom> grooms;
  for (const scene::Groom& groom : scene.grooms) {
    WarmGroom warm{groom.object, scene.materials[groom.material].name, {}, {}};
    std::set<std::uint32_t> used;
    if (info.slices_of != nullptr) {
      std::set<std::uint32_t> fibers;
      for (const scene::FiberChoice& choice : groom.choices) fibers.insert(choice.fiber);
      for (const std::uint32_t fiber : fibers) {
        for (const SliceDescription& slice : info.slices_of(scene.fibers[fiber])) {
          const auto found = std::ranges::find(slices, slice.key, [](const WarmSlice& s) { return s.slice.key; });
          if (found != slices.end()) used.insert(static_cast<std::uint32_t>(found - slices.begin()));
        }
      }
    }
    warm.slices.assign(used.begin(), used.end());
    for (const std::uint32_t slice : warm.slices) {
      if (!slices[slice].only_proposes) warm.share.add(slices[slice].share);
    }
    grooms.push_back(std::move(warm));
  }
  return grooms;
}

/// What a slice lacks, as one or two clauses.
std::string reason(const WarmSlice& slice) {
  if (slice.only_proposes) return "blurred by less than 4 degrees: traced at every vertex, whatever a cache has";
  if (!slice.in_cache) {
    if (!slice.nearest) return "not in the cache, which has no rows of this kind";
    std::string text = "not in the cache";
    for (const HairDifference& difference : hair_differences(slice.slice, *slice.nearest)) {
      text += fmt::format("{} the cache has {}, the scene asks {:.6g}", text.find(':') == std::string::npos ? ":" : ";",
                          words({{difference.name, difference.there}}), difference.here);
    }
    return text;
  }
  std::map<WhyCold, std::uint64_t> rows;
  for (const ColdRow& row : slice.cold) ++rows[row.why];
  std::string text;
  for (const auto& [why, count] : rows) {
    const char* const what = why == WhyCold::absent ? "never learned"
                             : why == WhyCold::open ? "not learned to the end"
                                                    : "of a larger error than is asked for";
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  }
  return text.empty() ? "" : "missing: " + text;
}

nlohmann::ordered_json share_json(const WarmShare& share) {
  return {{"queries", share.queries}, {"answered", share.answered}, {"share", share.value()}};
}

nlohmann::ordered_json to_json(const WarmSlice& slice) {
  nlohmann::ordered_json fields{{"lobe", lobe_word(slice.slice)}};
  for (const HairParameter& parameter : hair_parameters(slice.slice)) fields[parameter.name] = parameter.value;
  if (const auto roughness = roughness_of_blur(slice.slice)) fields["roughness"] = *roughness;
  fields["in_cache"] = slice.in_cache;
  if (slice.only_proposes) fields["only_proposes"] = true;
  fields["share"] = share_json(slice.share);
  fields["rows"] = {{"asked", slice.rows_asked}, {"answering", slice.rows_answering}};
  if (!slice.in_cache) {
    nlohmann::ordered_json differences = nlohmann::ordered_json::array();
    if (slice.nearest) {
      for (const HairDifference& difference : hair_differences(slice.slice, *slice.nearest))
        differences.push_back(
            {{"parameter", difference.name}, {"cache", difference.there}, {"scene", difference.here}});
    }
    fields["differs"] = differences;
  }
  std::map<std::string, std::uint64_t> why;
  for (const ColdRow& row : slice.cold) ++why[why_cold_name(row.why)];
  fields["missing"] = why;
  nlohmann::ordered_json& rows = fields["missing_rows"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < std::min(slice.cold.size(), most_rows); ++i) {
    const ColdRow& row = slice.cold[i];
    nlohmann::ordered_json& one = rows.emplace_back(
        nlohmann::ordered_json{{"node", row.node}, {"queries", row.queries}, {"why", why_cold_name(row.why)}});
    const auto words = words_of_row(slice.slice, row.node, 0.01);
    if (const auto angles = words.find("angles"); angles != words.end())
      one["angles"] = nlohmann::ordered_json::parse(angles->second, nullptr, false);
  }
  return fields;
}

/// "phi_r 45, theta_d 30 degrees (0.02)": the directions that are queried most and not answered, with their shares.
std::string coldest(const WarmSlice& slice) {
  std::string text;
  for (std::size_t i = 0; i < std::min(slice.cold.size(), rows_in_words); ++i) {
    const ColdRow& row = slice.cold[i];
    const auto width = static_cast<std::uint32_t>(slice.slice.axis_b.size());
    const double a = degrees(slice.slice.axis_a[row.node / width]), b = degrees(slice.slice.axis_b[row.node % width]);
    const bool samples = slice.slice.kind == adaptive::SliceKind::samples;
    text += fmt::format("{}{} {:.4g}, {} {:.4g} degrees ({:.2g})", text.empty() ? "" : "; ",
                        samples ? "theta_r" : "phi_r", a, samples ? "phi_r" : "theta_d", b,
                        static_cast<double>(row.queries) / static_cast<double>(slice.share.queries));
  }
  return text;
}

}  // namespace

const char* why_cold_name(WhyCold why) {
  switch (why) {
    case WhyCold::no_slice:
      return "no_slice";
    case WhyCold::absent:
      return "absent";
    case WhyCold::open:
      return "open";
    case WhyCold::coarse:
      return "coarse";
  }
  return "absent";
}

Result<WarmStart> measure_warm_start(const RenderSettings& asked, scene::Scene scene,
                                     const std::filesystem::path& cache) {
  shrink(scene.image);
  RenderSettings settings = asked;
  settings.table.check_passes = true;  // so that each query is counted at its row
  settings.cache_mode = CacheMode::append;
  WarmStart start;
  start.model = settings.model;
  start.width = scene.image.width;
  start.height = scene.image.height;
  start.samples = scene.image.samples;
  SceneModel fibers(settings);
  fibers.add_fibers(scene);
  adaptive::Service& service = *fibers.service();
  CachedStates cached;
  if (is_default_cache(cache)) {
    const Result<std::filesystem::path> folder = adaptive::default_cache_folder();
    if (!folder) return folder.error();
    // Refused files are refused one by one, as in a render.
    for (const adaptive::CacheFolder::File& one : adaptive::CacheFolder(*folder).files()) {
      const auto file = adaptive::CacheFile::open(one.path, fibers.target_name());
      if (file && !service.load(**file)) read_states(**file, &cached);
    }
  } else {
    const Result<std::unique_ptr<adaptive::CacheFile>> file = adaptive::CacheFile::open(cache, "");
    if (!file) return file.error();
    std::optional<Error> refused = service.load(**file);
    if (refused && refused->file.empty()) refused->file = cache.string();
    if (refused)
      start.refused = refused->message();
    else
      read_states(**file, &cached);
  }
  service.set_learning(false);

  integrate::RenderOptions options;
  options.samples = scene.image.samples;
  options.roulette = integrate::Roulette::throughput;
  const geometry::FiberScene strands(scene);
  const std::atomic<bool> never{false};
  (void)integrate::render(scene, strands, fibers.model(), fibers.fiber_ids(), &service, options, never,
                          [](const integrate::PassProgress&) { return true; });

  const fiber::ModelInfo& info = *fiber::find_model(settings.model);
  const std::set<adaptive::SliceKey> narrow = narrow_slices(info, scene);
  for (adaptive::SliceId id = 0; id < service.slice_count(); ++id) {
    WarmSlice slice = counted(service, id, cached);
    slice.only_proposes = narrow.contains(slice.slice.key);
    if (!slice.only_proposes) start.share.add(slice.share);
    start.slices.push_back(std::move(slice));
  }
  start.grooms = grooms_of(info, scene, start.slices);
  return start;
}

nlohmann::ordered_json to_json(const WarmStart& start) {
  nlohmann::ordered_json fields{
      {"model", start.model},
      {"traced", {{"width", start.width}, {"height", start.height}, {"samples", start.samples}}}};
  if (start.refused) fields["refused"] = *start.refused;
  fields["share"] = share_json(start.share);
  nlohmann::ordered_json& grooms = fields["grooms"] = nlohmann::ordered_json::array();
  for (const WarmGroom& groom : start.grooms) {
    grooms.push_back({{"name", groom.name},
                      {"material", groom.material},
                      {"slices", groom.slices},
                      {"share", share_json(groom.share)}});
  }
  nlohmann::ordered_json& slices = fields["slices"] = nlohmann::ordered_json::array();
  for (const WarmSlice& slice : start.slices) slices.push_back(to_json(slice));
  return fields;
}

std::string in_words(const WarmStart& start) {
  std::string text =
      fmt::format("warm    {:.3g} of {} queries of a picture of {} x {} pixels, {} samples, model {}\n",
                  start.share.value(), start.share.queries, start.width, start.height, start.samples, start.model);
  if (start.refused) text += fmt::format("  a render refuses this cache and starts cold: {}\n", *start.refused);
  for (const WarmGroom& groom : start.grooms) {
    text += fmt::format("  groom {}, material {}: {:.3g} of the queries of its hair\n", groom.name, groom.material,
                        groom.share.value());
  }
  for (const WarmSlice& slice : start.slices) {
    text +=
        fmt::format("  {}, {}: {:.3g} of {} queries, {} of {} rows\n", lobe_word(slice.slice), hair_words(slice.slice),
                    slice.share.value(), slice.share.queries, slice.rows_answering, slice.rows_asked);
    if (start.refused) continue;
    if (const std::string why = reason(slice); !why.empty()) text += fmt::format("    {}\n", why);
    if (slice.in_cache && !slice.cold.empty()) text += fmt::format("    asked most of them: {}\n", coldest(slice));
  }
  return text;
}

}  // namespace tress::cli
