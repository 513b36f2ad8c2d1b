// Measures how much of a scene would start warm from a cache: it counts the queries of the scene's paths, and which
// rows answer them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/hair_words.h"
#include "cli/render_settings.h"
#include "scene/model/scene.h"
#include "tress/adaptive/service.h"

namespace tress::cli {

/// The numbers of queries, and of those that are answered.
struct WarmShare {
  std::uint64_t queries = 0;
  std::uint64_t answered = 0;  ///< by rows of the cache that have converged
  double value() const { return queries > 0 ? static_cast<double>(answered) / static_cast<double>(queries) : 0; }
  void add(const WarmShare& other) {
    queries += other.queries;
    answered += other.answered;
  }
};

/// The reason why a row does not answer.
enum class WhyCold {
  no_slice,  ///< the cache has no hair with these parameters
  absent,    ///< the cache has the hair, but this direction was not learned
  open,      ///< it was not learned completely
  coarse,    ///< it converged with a larger error than this render accepts
};
const char* why_cold_name(WhyCold why);

struct ColdRow {
  std::uint32_t node = 0;
  std::uint64_t queries = 0;
  WhyCold why = WhyCold::absent;
};

/// One slice of the scene's fibers.
struct WarmSlice {
  adaptive::SliceDescription slice;
  bool in_cache = false;
  std::optional<adaptive::SliceDescription> nearest;  ///< if the cache lacks it: the most similar one that it has
  /// Blurred by less than 4 degrees: traced at every vertex whatever its rows are, and not counted in any other share.
  bool only_proposes = false;
  WarmShare share;
  std::uint64_t rows_asked = 0, rows_answering = 0;
  std::vector<ColdRow> cold;  ///< the most queried first
};

/// The numbers for one groom.
struct WarmGroom {
  std::string name, material;
  WarmShare share;                    ///< share of all queries to the slices of its fibers
  std::vector<std::uint32_t> slices;  ///< indices into WarmStart::slices; empty if the model does not provide them
};

struct WarmStart {
  std::string model;
  int width = 0, height = 0, samples = 0;  ///< size of the traced picture
  std::optional<std::string> refused;      ///< the reason why a render would refuse the cache
  WarmShare share;
  std::vector<WarmSlice> slices;
  std::vector<WarmGroom> grooms;
};

/// Traces a small picture of the scene, 64 pixels along its longer side and 4 samples per pixel, with the cache frozen.
/// The same cache and scene give the same figures. settings: model, learner and threads' arena of a render that would
/// load the cache. Error if the cache cannot be read.
Result<WarmStart> measure_warm_start(const RenderSettings& settings, scene::Scene scene,
                                     const std::filesystem::path& cache);

nlohmann::ordered_json to_json(const WarmStart& start);
/// The result as lines of text.
std::string in_words(const WarmStart& start);

}  // namespace tress::cli
