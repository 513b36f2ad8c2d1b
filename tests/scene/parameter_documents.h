// The parameter table as the documents have it.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "scene/generate/generated_grooms.h"
#include "scene/model/parameters.h"

namespace tress::scene {

/// The values of a parameter in few words; "*" if a source may take the place of one.
inline std::string values_as_text(const Parameter& parameter) {
  std::string range = words(parameter);
  if (parameter.kind == ValueKind::whole) range.replace(0, range.find(','), "whole");
  for (const auto& [end, unit] : {std::pair("_deg", " degrees"), std::pair("_cm", " cm"), std::pair("_mm", " mm")})
    if (parameter.key.ends_with(end) && range.ends_with(unit)) range.resize(range.size() - std::string(unit).size());
  const std::string text = [&]() -> std::string {
    switch (parameter.kind) {
      case ValueKind::number:
      case ValueKind::whole:
        return range;
      case ValueKind::triple:
        return "3 of " + range;
      case ValueKind::numbers_by_name:
        return fmt::format("`{}`, each {}", parameter.choices, range);
      case ValueKind::triples_by_name:
        return fmt::format("`{}`, each 3 of {}", parameter.choices, range);
      case ValueKind::either:
        return fmt::format("3 of {}, or `{}`", range, parameter.choices);
      case ValueKind::number_or_choice:
        return fmt::format("{}, or `{}`", range, parameter.choices);
      case ValueKind::choice:
        return fmt::format("`{}`", parameter.choices);
      case ValueKind::text:
        return "text";
      case ValueKind::flag:
        return "flag";
      case ValueKind::only_true:
        return "true";
    }
    return {};
  }();
  return text + (parameter.varies ? " *" : "");
}

/// Whether a key belongs to kinds of generated grooms, which have a table of their own.
inline bool shapes_a_generated_groom(const Parameter& parameter) {
  return parameter.key.starts_with("/grooms/N/") && parameter.usual == "by kind" && parameter.kind != ValueKind::whole;
}

/// Keys of a scene file; of keys in the same object the first has the whole path. Keys without options of one object
/// that have the same values, default and sentence are one row.
inline std::string scene_keys_as_markdown() {
  std::string table = "| key, option: value; default | meaning |\n|---|---|\n", row, rest;
  std::string_view before;
  for (const Parameter& parameter : parameters()) {
    if (parameter.key.empty() || shapes_a_generated_groom(parameter)) continue;
    const std::string_view key = parameter.key.substr(1), object = key.substr(0, key.rfind('/') + 1);
    const bool same = !object.empty() && object == before, left_out = parameter.sentence == "left out";
    before = object;
    const std::string usual = parameter.usual.empty() ? "" : fmt::format("; {}", parameter.usual);
    const std::string next = left_out
                                 ? " | left out with a warning |\n"
                                 : fmt::format(": {}{} | {} |\n", values_as_text(parameter), usual, parameter.sentence);
    if (same && next == rest && parameter.option.empty()) {
      row += fmt::format(", `{}`", key.substr(object.size()));
      continue;
    }
    table += row + rest;
    const std::string option = parameter.option.empty() ? "" : fmt::format(", `{}`", parameter.option);
    row = fmt::format("| `{}{}`{}", same ? ".../" : "", same ? key.substr(object.size()) : key, option);
    rest = next;
  }
  return table + row + rest;
}

/// Keys of generated grooms, with the default of each kind.
inline std::string generated_grooms_as_markdown() {
  std::string head = "| key, range | meaning |", line = "|---|---|", table = "| `strands` | |";
  for (const std::string& kind : generated_groom_kinds()) {
    head += fmt::format(" `{}` |", kind);
    line += "---|";
    table += fmt::format(" {} |", usual_strands(kind));
  }
  table = head + "\n" + line + "\n" + table + "\n";
  constexpr std::string_view grooms = "/grooms/N/";
  for (const Parameter& parameter : parameters()) {
    if (!shapes_a_generated_groom(parameter)) continue;
    const std::string_view key = parameter.key.substr(grooms.size());
    table += fmt::format("| `{}`, {} | {} |", key, values_as_text(parameter), parameter.sentence);
    for (const std::string& kind : generated_groom_kinds()) {
      std::string usual = " |";
      for (const ShapeParameter& shape : shape_parameters(kind))
        if (shape.key == key) usual = fmt::format(" {:g} |", shape.usual);
      table += usual;
    }
    table += "\n";
  }
  return table;
}

/// Replaces the table of `text` that has the same first line. False if `text` has no such table.
inline bool replace_table(const std::string& table, std::string* text) {
  const std::size_t begin = text->find(table.substr(0, table.find('\n') + 1));
  if (begin == std::string::npos) return false;
  std::size_t end = begin;
  while (end < text->size() && (*text)[end] == '|') end = text->find('\n', end) + 1;
  text->replace(begin, end - begin, table);
  return true;
}

/// A rule of a schema for the values of a parameter, to which describe_values() adds ranges. Null for kinds that a
/// schema spells out by name.
inline nlohmann::ordered_json rule_of(const Parameter& parameter) {
  nlohmann::ordered_json rule;
  const nlohmann::ordered_json number{{"type", "number"}, {"minimum", 0}, {"maximum", 0}};
  switch (parameter.kind) {
    case ValueKind::number:
    case ValueKind::whole:
      rule = number;
      break;
    case ValueKind::triple:
      rule = {{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", number}};
      break;
    case ValueKind::text:
      rule = {{"type", "string"}, {"minLength", 1}, {"maxLength", 4096}};
      break;
    case ValueKind::flag:
      rule = {{"type", "boolean"}};
      break;
    case ValueKind::only_true:
      rule = {{"const", true}};
      break;
    case ValueKind::number_or_choice:
      rule["oneOf"] = {number, {{"enum", choices_of(parameter)}}};
      break;
    case ValueKind::choice:
      rule["enum"] = choices_of(parameter);
      break;
    default:
      return nullptr;
  }
  const auto usual = nlohmann::ordered_json::parse(parameter.usual, nullptr, false);
  if (!usual.is_discarded()) rule["default"] = usual;
  if (parameter.kind == ValueKind::choice && std::ranges::count(choices_of(parameter), parameter.usual) > 0)
    rule["default"] = parameter.usual;
  if (parameter.varies) return {{"oneOf", nlohmann::ordered_json::array({rule, {{"type", "object"}}})}};
  return rule;
}

/// Gives every value of a schema the range and the sentence of its parameter, and adds the keys that it lacks; the
/// number of values, or -1 where one has no parameter.
inline int describe_values(nlohmann::ordered_json* node, const std::string& place) {
  const auto sum = [](int a, int b) { return a < 0 || b < 0 ? -1 : a + b; };
  int count = 0;
  if (node->contains("oneOf") && node->value("type", "") != "object") {
    for (auto& alternative : (*node)["oneOf"]) count = sum(count, describe_values(&alternative, place));
    return count;
  }
  if (node->value("type", "") == "object" && !node->contains("properties")) {
    (*node)["description"] =
        "a source: ramp, random, normal, mix, sum, hsvadjust, attribute or texture (scenes/README.md)";
    const Parameter* parameter = parameter_at(place);
    return parameter != nullptr && parameter->varies ? 1 : -1;
  }
  if (node->value("type", "") == "object") {
    for (const std::string& key : keys_at(place)) {
      const Parameter* parameter = parameter_at(place + "/" + key);
      if ((*node)["properties"].contains(key)) continue;
      if (parameter == nullptr) {
        if (!keys_at(place + "/" + key).empty())
          (*node)["properties"][key] = {
              {"type", "object"}, {"additionalProperties", false}, {"properties", nlohmann::ordered_json::object()}};
        continue;
      }
      if (auto rule = rule_of(*parameter); !rule.is_null()) (*node)["properties"][key] = std::move(rule);
    }
    for (auto& [key, property] : (*node)["properties"].items())
      count = sum(count, describe_values(&property, place + "/" + key));
    return count;
  }
  if (node->contains("items") && !(*node)["items"].contains("minimum"))
    return describe_values(&(*node)["items"], place + "/0");
  const Parameter* parameter = parameter_at(place);
  if (parameter == nullptr) return -1;
  auto& number = node->contains("items") ? (*node)["items"] : *node;
  const auto put = [&](const char* key, double end) {
    if (end >= past_int64)
      number[key] = INT64_MAX;
    else if (end == static_cast<double>(static_cast<std::int64_t>(end)))
      number[key] = static_cast<std::int64_t>(end);
    else
      number[key] = end;
  };
  if (number.contains("minimum")) {
    number["type"] = parameter->kind == ValueKind::whole ? "integer" : "number";
    put("minimum", parameter->range.least);
    put("maximum", parameter->range.most);
  }
  (*node)["description"] = parameter->sentence;
  return 1;
}

}  // namespace tress::scene
