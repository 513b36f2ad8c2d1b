// The description of a part of a picture besides its sums, from which `tress merge` makes the picture.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/render_identity.h"
#include "cli/render_settings.h"
#include "image/picture.h"
#include "integrate/cryptomatte.h"

namespace tress::cli {

struct PartHeader {
  image::Window window;
  int whole_width = 0, whole_height = 0;
  int from = 0, to = 0;  ///< samples of a pixel; the end is excluded
  bool opaque = false, glint = false, moving = false, emission = false;
  bool halves = false;                             ///< whether it has integrate::half_layers
  bool deep_light = false;                         ///< whether it uses integrate::DeepLight::learned
  integrate::DataLayers data;                      ///< layers of data that it holds
  bool frozen = false;                             ///< whether no path depends on what was learned during the render
  std::string table;                               ///< hash of the table
  std::vector<std::string> groups;                 ///< groups of lights
  std::vector<integrate::MatteKind> mattes;        ///< empty: without object ids
  std::optional<std::vector<std::string>> layers;  ///< layers to keep; unset: all
  image::Preview look;
  image::Picture request;  ///< without pixels: the header of the requested picture

  std::size_t object_count() const { return mattes.empty() ? 0 : mattes.front().names.size(); }
  /// Whether both are parts of one picture.
  bool fits(const PartHeader& other) const;
};

/// The header for the settings of a render; window, table and frozen are set by the caller.
PartHeader part_header_of(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                          bool counts_objects);

nlohmann::json to_json(const PartHeader& part);
/// Empty if it is no valid header of a part: every count must be within its bounds.
std::optional<PartHeader> parse_part_header(const nlohmann::json& header);

}  // namespace tress::cli
