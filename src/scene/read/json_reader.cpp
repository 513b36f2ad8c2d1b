#include "scene/read/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/nearest_word.h"

namespace tress::scene {
namespace {

/// A value as text, short enough for a message; invalid UTF-8 is replaced.
std::string shown(const nlohmann::json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  std::string text = value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

}  // namespace

std::string nearest_name(const std::string& word, const std::vector<std::string>& known) {
  return nearest_word(word.substr(0, 64), known);
}

void JsonReader::fail(const std::string& key, std::string expected, std::string found) const {
  if (error_->has_value()) return;
  const std::string place = path_ + (key.empty() ? "" : "/" + key);
  *error_ = Error{file_, place.empty() ? "/" : place, std::move(expected), std::move(found)};
}

bool JsonReader::object(const std::vector<std::string>& known) const {
  if (keys_) (*keys_)[path_] = known;
  if (!value_.is_object()) {
    fail("", "an object", shown(value_));
    return false;
  }
  for (const auto& [key, value] : value_.items())
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      fail(key.size() > 64 ? key.substr(0, 61) + "..." : key,
           fmt::format("a known key (the nearest is \"{}\")", nearest_name(key, known)), "an unknown one");
      return false;
    }
  return true;
}

const nlohmann::json* JsonReader::find(const std::string& key) const {
  for (std::size_t i = 0; i < size(); ++i)
    if (key == std::to_string(i)) return &value_[i];
  if (!value_.is_object()) return nullptr;
  const auto it = value_.find(key);
  return it == value_.end() ? nullptr : &*it;
}

JsonReader JsonReader::child(const std::string& key) const {
  return JsonReader(*find(key), path_ + "/" + key, file_, error_, keys_);
}

std::vector<JsonReader> JsonReader::items(const std::string& key, std::size_t most) const {
  std::vector<JsonReader> items;
  const auto* value = find(key);
  if (!value) return items;
  if (!value->is_array() || value->size() > most) {
    fail(key, fmt::format("an array of at most {}", most), shown(*value));
    return items;
  }
  for (std::size_t i = 0; i < value->size(); ++i)
    items.emplace_back((*value)[i], fmt::format("{}/{}/{}", path_, key, i), file_, error_, keys_);
  return items;
}

/// The key's row of the parameter table. Without a row it returns null and sets the error of the document: no number is
/// read without a range.
const Parameter* JsonReader::parameter_of(const std::string& key) const {
  const Parameter* parameter = parameter_at(path_ + "/" + key);
  if (!parameter) fail(key, "a key of the parameter table", "another");
  return parameter;
}

std::optional<double> JsonReader::number_at(const nlohmann::json& value, const std::string& key,
                                            const Parameter& parameter) const {
  const double x = value.is_number() ? value.get<double>() : std::nan("");
  if (parameter.range.contains(x)) return x;
  fail(key, words(parameter), shown(value));
  return std::nullopt;
}

std::optional<double> JsonReader::number(const std::string& key) const {
  const auto* value = find(key);
  const Parameter* parameter = value ? parameter_of(key) : nullptr;
  return parameter ? number_at(*value, key, *parameter) : std::nullopt;
}

std::optional<std::int64_t> JsonReader::integer(const std::string& key) const {
  const auto* value = find(key);
  const Parameter* parameter = value ? parameter_of(key) : nullptr;
  if (!parameter) return std::nullopt;
  const bool fits = value->is_number_unsigned() ? value->get<std::uint64_t>() <= std::uint64_t{INT64_MAX}
                                                : value->is_number_integer();
  if (fits && parameter->range.contains(value->get<double>())) return value->get<std::int64_t>();
  fail(key, words(*parameter), shown(*value));
  return std::nullopt;
}

std::optional<bool> JsonReader::boolean(const std::string& key) const {
  const auto* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  fail(key, "true or false", shown(*value));
  return std::nullopt;
}

std::optional<std::string> JsonReader::text(const std::string& key) const {
  const auto* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_string() && !value->get_ref<const std::string&>().empty()) {
    const auto& text = value->get_ref<const std::string&>();
    if (text.size() <= 4096 && text.find('\0') == std::string::npos) return text;
  }
  fail(key, "a text of 1..4096 characters", shown(*value));
  return std::nullopt;
}

std::optional<std::string> JsonReader::choice(const std::string& key) const {
  const Parameter* parameter = has(key) ? parameter_of(key) : nullptr;
  return parameter ? choice(key, choices_of(*parameter)) : std::nullopt;
}

std::optional<std::size_t> JsonReader::choice_number(const std::string& key) const {
  const std::optional<std::string> chosen = choice(key);
  if (!chosen) return std::nullopt;
  const std::vector<std::string> choices = choices_of(*parameter_of(key));
  return static_cast<std::size_t>(std::ranges::find(choices, *chosen) - choices.begin());
}

std::optional<std::string> JsonReader::choice(const std::string& key, const std::vector<std::string>& known) const {
  const auto* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_string()) {
    const auto& text = value->get_ref<const std::string&>();
    if (std::find(known.begin(), known.end(), text) != known.end()) return text;
  }
  fail(key, fmt::format("one of {}", fmt::join(known, ", ")), shown(*value));
  return std::nullopt;
}

std::optional<glm::vec3> JsonReader::triple(const std::string& key) const {
  const auto* value = find(key);
  const Parameter* parameter = value ? parameter_of(key) : nullptr;
  if (!parameter) return std::nullopt;
  if (!value->is_array() || value->size() != 3) {
    fail(key, "an array of 3 numbers", shown(*value));
    return std::nullopt;
  }
  glm::vec3 triple;
  for (int c = 0; c < 3; ++c) {
    const auto x = number_at((*value)[static_cast<std::size_t>(c)], fmt::format("{}/{}", key, c), *parameter);
    if (!x) return std::nullopt;
    triple[c] = static_cast<float>(*x);
  }
  return triple;
}

bool JsonReader::at_most_one(const std::vector<std::string>& keys) const {
  std::vector<std::string> there;
  for (const auto& key : keys)
    if (has(key)) there.push_back(key);
  if (there.size() < 2) return true;
  fail("", fmt::format("at most one of {}", fmt::join(keys, ", ")), fmt::format("{}", fmt::join(there, ", ")));
  return false;
}

bool JsonReader::exactly_one(const std::vector<std::string>& keys) const {
  if (!at_most_one(keys)) return false;
  if (std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return has(key); })) return true;
  fail("", fmt::format("one of {}", fmt::join(keys, ", ")), "none of them");
  return false;
}

bool JsonReader::need(const std::vector<std::string>& keys) const {
  for (const auto& key : keys)
    if (!has(key)) {
      fail(key, "this key", "none");
      return false;
    }
  return true;
}

}  // namespace tress::scene
