#include "scene/read/set_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <utility>

#include "scene/model/scene.h"

namespace tress::scene {
namespace {

std::optional<std::size_t> index_of(const nlohmann::json& array, const std::string& name) {
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (name == std::to_string(i)) return i;
  }
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (array[i].is_object() && array[i].contains("name") && array[i]["name"] == name) return i;
  }
  return std::nullopt;
}

/// Sets the rest of the path, from `depth` on, in `at`, whose own place is `place`.
std::optional<Error> set_in(nlohmann::json& at, std::size_t depth, const std::string& place, KeySetting* setting) {
  if (depth == setting->path.size()) {
    at = setting->value;
    setting->places.push_back(place);
    return std::nullopt;
  }
  const std::string& name = setting->path[depth];
  if (at.is_null()) at = nlohmann::json::object();
  if (at.is_object()) {
    if (depth == 0 && name == "materials" && !at.contains(name)) at[name] = {{{"name", Material{}.name}}};
    if (setting->value.is_null() && !at.contains(name)) return std::nullopt;
    if (setting->value.is_null() && depth + 1 == setting->path.size()) {
      at.erase(name);
      return std::nullopt;
    }
    return set_in(at[name], depth + 1, place + "/" + name, setting);
  }
  const std::string option = "--set " + setting->text;
  if (!at.is_array())
    return Error{"", option, fmt::format("an object or an array at {}", place),
                 at.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).substr(0, 64)};
  std::vector<std::size_t> elements;
  for (std::size_t i = 0; name == "*" && i < at.size(); ++i) elements.push_back(i);
  if (const auto one = index_of(at, name); name != "*" && one) elements.push_back(*one);
  if (elements.empty())
    return Error{"", option, fmt::format("*, or the index or name of one of the {} elements of {}", at.size(), place),
                 name};
  for (const std::size_t i : elements) {
    if (auto error = set_in(at[i], depth + 1, fmt::format("{}/{}", place, i), setting)) return error;
  }
  return std::nullopt;
}

}  // namespace

std::optional<KeySetting> parse_setting(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return std::nullopt;
  KeySetting setting{text, {}, nlohmann::json::parse(text.substr(equals + 1), nullptr, false)};
  if (setting.value.is_discarded()) setting.value = text.substr(equals + 1);
  const std::size_t begin = text.starts_with('/') ? 1 : 0;
  for (const auto part : std::views::split(std::string_view(text).substr(begin, equals - begin), '/')) {
    setting.path.emplace_back(part.begin(), part.end());
  }
  const bool is_whole = std::ranges::none_of(setting.path, [](const std::string& name) { return name.empty(); });
  return equals > begin && is_whole ? std::optional(std::move(setting)) : std::nullopt;
}

Result<std::vector<KeySetting>> set_keys(std::span<const std::string> texts, nlohmann::json* document) {
  std::vector<KeySetting> settings;
  for (const std::string& text : texts) {
    auto setting = parse_setting(text);
    if (!setting) return Error{"", "--set", setting_words, text};
    if (auto error = set_in(*document, 0, "", &*setting)) return *error;
    settings.push_back(std::move(*setting));
  }
  return settings;
}

const KeySetting* setting_of(std::span<const KeySetting> settings, std::string_view place) {
  const auto covers = [&](const std::string& set) {
    return place.starts_with(set) && (place.size() == set.size() || place[set.size()] == '/');
  };
  for (const KeySetting& setting : std::views::reverse(settings)) {  // the last one to set a key counts
    if (std::ranges::any_of(setting.places, covers)) return &setting;
  }
  return nullptr;
}

}  // namespace tress::scene
