// How much of a scene would start warm from a cache: the queries that its paths make, counted, and who answers them.
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

/// Asked and answered, or not.
struct WarmShare {
  std::uint64_t queries = 0;
  std::uint64_t answered = 0;  ///< by rows of the cache that have converged
  double value() const { return queries > 0 ? static_cast<double>(answered) / static_cast<double>(queries) : 0; }
  void add(const WarmShare& other) {
    queries += other.queries;
    answered += other.answered;
  }
};

/// Why a row does not answer.
enum class WhyCold {
  no_slice,  ///< the cache has no hair with these parameters
  absent,    ///< the cache has the hair, and this direction was not learned
  open,      ///< it was not learned to the end
  coarse,    ///< it has converged, at a larger error than this render asks for
};
const char* why_cold_name(WhyCold why);

struct ColdRow {
  std::uint32_t node = 0;
  std::uint64_t queries = 0;
  WhyCold why = WhyCold::absent;
};

/// Of one slice that fibers of the scene have.
struct WarmSlice {
  adaptive::SliceDescription slice;
  bool in_cache = false;
  std::optional<adaptive::SliceDescription> nearest;  ///< where it is not: the one of the cache that is most like it
  /// Blurred by less than 4 degrees: traced at every vertex whatever its rows are, and in no other share.
  bool only_proposes = false;
  WarmShare share;
  std::uint64_t rows_asked = 0, rows_answering = 0;
  std::vector<ColdRow> cold;  ///< most asked first
};

/// Of one groom.
struct WarmGroom {
  std::string name, material;
  WarmShare share;                    ///< of all queries to the slices that its fibers have
  std::vector<std::uint32_t> slices;  ///< indices into WarmStart::slices; empty where the model does not tell
};

struct WarmStart {
  std::string model;
  int width = 0, height = 0, samples = 0;  ///< of the picture that was traced
  std::optional<std::string> refused;      ///< a render would refuse the cache: why
  WarmShare share;
  std::vector<WarmSlice> slices;
  std::vector<WarmGroom> grooms;
};

/// Traces a small picture of the scene, 64 pixels along its longer side and 4 samples a pixel, with the cache as it is,
/// frozen; the same cache and scene give the same figures. settings: model, learner, threads' arena as of a render that
/// would load the cache. Error if the cache cannot be read.
Result<WarmStart> measure_warm_start(const RenderSettings& settings, scene::Scene scene,
                                     const std::filesystem::path& cache);

nlohmann::ordered_json to_json(const WarmStart& start);
/// Lines for a person.
std::string in_words(const WarmStart& start);

}  // namespace tress::cli
