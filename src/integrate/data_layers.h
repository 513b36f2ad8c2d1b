// Layers of data for compositors, which a picture has on request only: the first hit, and the strand that was hit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace tress::integrate {

enum class DataLayer : std::uint8_t { position, strand_uv, strand_place, strand_id, strand_mattes };
/// The names of the layers in the file, in the order above.
inline constexpr std::array<const char*, 5> data_layer_names{"P", "strand_uv", "strand_place", "strand_id",
                                                             "CryptoStrand"};

/// The set of requested layers.
class DataLayers {
 public:
  bool has(DataLayer layer) const { return asked_[static_cast<std::size_t>(layer)]; }
  /// Whether a layer that DataSums has is requested: any except the mattes.
  bool has_sums() const {
    return std::any_of(asked_.begin(), asked_.end() - 1, [](bool asked) { return asked; });
  }
  bool has_any() const { return has_sums() || has(DataLayer::strand_mattes); }
  /// Requests a layer. False, without a change, if no layer has that name.
  bool ask(std::string_view name) {
    const auto found = std::find(data_layer_names.begin(), data_layer_names.end(), name);
    if (found == data_layer_names.end()) return false;
    asked_[static_cast<std::size_t>(found - data_layer_names.begin())] = true;
    return true;
  }
  /// The names of the requested layers, in the order above.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < asked_.size(); ++i)
      if (asked_[i]) names.emplace_back(data_layer_names[i]);
    return names;
  }
  friend bool operator==(const DataLayers&, const DataLayers&) = default;

 private:
  std::array<bool, data_layer_names.size()> asked_{};
};

/// The first hit of a path that hit something; set only if DataLayers has any.
struct DataHit {
  glm::vec3 position{0.0f};      ///< world, cm
  bool on_strand = false;        ///< whether the hit is on a strand; if not, all members below have their defaults
  bool has_uv = false;           ///< whether the groom has root uv
  glm::vec2 root_uv{0.0f};       ///< root uv of the strand
  float place = 0;               ///< place along the strand: share of its length from the root, [0, 1]
  std::int64_t strand = 0;       ///< the strand's id (scene::Groom::strand_id)
  std::uint32_t matte_bits = 0;  ///< bits of its Cryptomatte id (strand_matte_bits); 0 if mattes are not requested
};

/// Sums of DataHit over the paths of one pixel that hit something. Trivially copyable: files have its bytes.
struct DataSums {
  glm::dvec3 position{0.0};
  glm::dvec2 root_uv{0.0};
  double place = 0;
  std::uint64_t on_strands = 0, with_uv = 0;  ///< number of paths in `place` and in `root_uv`
  /// The nearest hit on a strand. Of equally near ones it is the smallest id, so the order of paths does not matter.
  double nearest_cm = std::numeric_limits<double>::max();
  std::int64_t nearest_strand = 0;

  void add(const DataHit& hit, float distance_cm) {
    position += glm::dvec3(hit.position);
    if (!hit.on_strand) return;
    place += static_cast<double>(hit.place);
    ++on_strands;
    if (hit.has_uv) {
      root_uv += glm::dvec2(hit.root_uv);
      ++with_uv;
    }
    take_nearer(static_cast<double>(distance_cm), hit.strand);
  }
  void add(const DataSums& later) {
    position += later.position;
    root_uv += later.root_uv;
    place += later.place;
    on_strands += later.on_strands;
    with_uv += later.with_uv;
    if (later.on_strands > 0) take_nearer(later.nearest_cm, later.nearest_strand);
  }
  bool is_finite() const {
    return std::isfinite(position.x + position.y + position.z) && std::isfinite(root_uv.x + root_uv.y) &&
           std::isfinite(place) && std::isfinite(nearest_cm);
  }

 private:
  void take_nearer(double distance_cm, std::int64_t strand) {
    if (distance_cm > nearest_cm || (distance_cm == nearest_cm && strand >= nearest_strand)) return;
    nearest_cm = distance_cm;
    nearest_strand = strand;
  }
};

}  // namespace tress::integrate
