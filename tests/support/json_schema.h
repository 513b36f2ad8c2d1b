// As much of JSON Schema draft-07 as scenes/schema.json uses, for tests.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace tress::test {

/// The first rule that `value` breaks, as "path: keyword"; empty where it is valid. A keyword that this does not know
/// is a broken rule too, so that none is passed over.
inline std::string broken_rule(const nlohmann::json& schema, const nlohmann::json& value,
                               const std::string& path = "") {
  static const std::set<std::string> annotations{"$schema", "title", "default", "examples", "description", "$comment"};
  for (const auto& [keyword, rule] : schema.items()) {
    const auto broken = [&, &name = keyword] { return (path.empty() ? "/" : path) + ": " + name; };
    if (annotations.count(keyword)) continue;
    if (keyword == "type") {
      const bool fits = rule == "object"    ? value.is_object()
                        : rule == "array"   ? value.is_array()
                        : rule == "string"  ? value.is_string()
                        : rule == "boolean" ? value.is_boolean()
                        : rule == "number"  ? value.is_number()
                        : rule == "integer" ? value.is_number_integer()
                                            : false;
      if (!fits) return broken();
    } else if (keyword == "const") {
      if (value != rule) return broken();
    } else if (keyword == "enum") {
      bool found = false;
      for (const auto& choice : rule) found = found || choice == value;
      if (!found) return broken();
    } else if (keyword == "minimum") {
      if (value.is_number() && value < rule) return broken();
    } else if (keyword == "maximum") {
      if (value.is_number() && value > rule) return broken();
    } else if (keyword == "minLength") {
      if (value.is_string() && value.get_ref<const std::string&>().size() < rule.get<std::size_t>()) return broken();
    } else if (keyword == "maxLength") {
      if (value.is_string() && value.get_ref<const std::string&>().size() > rule.get<std::size_t>()) return broken();
    } else if (keyword == "minItems") {
      if (value.is_array() && value.size() < rule.get<std::size_t>()) return broken();
    } else if (keyword == "maxItems") {
      if (value.is_array() && value.size() > rule.get<std::size_t>()) return broken();
    } else if (keyword == "items") {
      for (std::size_t i = 0; value.is_array() && i < value.size(); ++i)
        if (auto why = broken_rule(rule, value[i], path + "/" + std::to_string(i)); !why.empty()) return why;
    } else if (keyword == "properties") {
      for (const auto& [key, of] : rule.items())
        if (value.is_object() && value.contains(key))
          if (auto why = broken_rule(of, value[key], path + "/" + key); !why.empty()) return why;
    } else if (keyword == "additionalProperties") {
      if (rule != false) return broken();
      if (!value.is_object()) continue;
      for (const auto& [key, of] : value.items())
        if (!schema.at("properties").contains(key)) return broken() + " " + key;
    } else if (keyword == "required") {
      for (const auto& key : rule)
        if (value.is_object() && !value.contains(key.get<std::string>())) return broken();
    } else if (keyword == "dependencies") {
      for (const auto& [key, needs] : rule.items()) {
        if (!value.is_object() || !value.contains(key)) continue;
        const nlohmann::json as_schema = needs.is_array() ? nlohmann::json{{"required", needs}} : needs;
        if (!broken_rule(as_schema, value, path).empty()) return broken() + " " + key;
      }
    } else if (keyword == "not") {
      if (broken_rule(rule, value, path).empty()) return broken();
    } else if (keyword == "allOf" || keyword == "anyOf" || keyword == "oneOf") {
      std::size_t valid = 0;
      for (const auto& part : rule) valid += broken_rule(part, value, path).empty();
      if (keyword == "allOf" ? valid != rule.size() : keyword == "anyOf" ? valid == 0 : valid != 1) return broken();
    } else {
      return broken() + " (not known to this test)";
    }
  }
  return "";
}

}  // namespace tress::test
