// What a part of a picture says of itself beside its sums: what `tress merge` needs to make the picture of it.
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
  int from = 0, to = 0;  ///< samples of a pixel, the second excluded
  bool opaque = false, glint = false, moving = false, emission = false;
  bool halves = false;                             ///< integrate::half_layers
  bool deep_light = false;                         ///< integrate::DeepLight::learned
  bool frozen = false;                             ///< its paths do not depend on what others learn
  std::string table;                               ///< hash of the table
  std::vector<std::string> groups;                 ///< of light
  std::vector<integrate::MatteKind> mattes;        ///< empty: objects were not counted
  std::optional<std::vector<std::string>> layers;  ///< that are kept; unset: all
  image::Preview look;
  image::Picture request;  ///< no pixels: the header of the picture as it was asked for

  std::size_t object_count() const { return mattes.empty() ? 0 : mattes.front().names.size(); }
  /// Whether they are parts of one picture.
  bool fits(const PartHeader& other) const;
};

/// Of a render as it was asked for; window, table and frozen are left to the caller.
PartHeader part_header_of(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                          bool counts_objects);

nlohmann::json to_json(const PartHeader& part);
/// Unset where it is no part's: every count within its bounds.
std::optional<PartHeader> parse_part_header(const nlohmann::json& told);

}  // namespace tress::cli
