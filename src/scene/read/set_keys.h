// Sets keys of a scene document from texts, before it is read.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tress/base/error.h"

namespace tress::scene {

/// One key of a scene file and its value, "image/width=640".
struct KeySetting {
  std::string text;                      ///< as it was given
  std::vector<std::string> path;         ///< the names of objects, indices or names of elements, `*` for all of them
  nlohmann::json value;                  ///< the value as JSON, null to remove the key; what is not JSON is a text
  std::vector<std::string> places = {};  ///< the places that were set, "/image/width"
};

/// What a text must be for parse_setting().
inline constexpr const char* setting_words = "KEY=VALUE, as in image/width=640 or materials/*/roughness=0.3";

/// Parses KEY=VALUE; empty if the text has no "=" or an empty name in the key. A "/" before the key is ignored.
std::optional<KeySetting> parse_setting(const std::string& text);

/// Sets the keys of texts for parse_setting() in their order, and returns them. Objects that are missing are made;
/// elements of arrays must exist, but without "materials" the document gets one. An element is found by its index, or
/// by its "name". The error names no file.
Result<std::vector<KeySetting>> set_keys(std::span<const std::string> texts, nlohmann::json* document);

/// The setting that set the place, or something that it lies in; null if none did.
const KeySetting* setting_of(std::span<const KeySetting> settings, std::string_view place);

}  // namespace tress::scene
