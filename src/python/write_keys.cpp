// Writes the Python classes that have a field for each key of the objects of a scene, from the table of parameters:
//   tress_write_keys FILE
#include <fmt/format.h>

#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "scene/model/parameters.h"

namespace tress::scene {
namespace {

constexpr std::pair<const char*, const char*> objects[] = {
    {"CameraKeys", "/camera"},           {"ImageKeys", "/image"},    {"IntegratorKeys", "/integrator"},
    {"EnvironmentKeys", "/environment"}, {"LightKeys", "/lights/N"}, {"MeshKeys", "/meshes/N"},
    {"MaterialKeys", "/materials/N"},    {"GroomKeys", "/grooms/N"}};

constexpr std::string_view head =
    R"("""Keys of a scene file: made by the build from the table of parameters, src/scene/model/parameters.cpp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Union

from .keyed import Keyed, Keys, KeysList, Triple
)";

const char* type_of(ValueKind kind) {
  switch (kind) {
    case ValueKind::number:
      return "float";
    case ValueKind::whole:
      return "int";
    case ValueKind::triple:
      return "Triple";
    case ValueKind::numbers_by_name:
    case ValueKind::triples_by_name:
      return "Keys";
    case ValueKind::either:
      return "Union[Triple, str]";
    case ValueKind::number_or_choice:
      return "Union[float, str]";
    case ValueKind::choice:
    case ValueKind::text:
      return "str";
    case ValueKind::flag:
    case ValueKind::only_true:
      return "bool";
  }
  return "";
}

bool has_items(const std::string& place) {
  for (const Parameter& parameter : parameters())
    if (parameter.key.starts_with(place + "/N")) return true;
  return false;
}

/// The sentence of a parameter, with its values and its default.
std::string words_of(const Parameter& parameter) {
  std::string text(parameter.sentence);
  if (parameter.range.least < parameter.range.most) text += fmt::format("; {}", words(parameter));
  if (!parameter.choices.empty()) text += fmt::format("; {}", parameter.choices);
  if (!parameter.usual.empty()) text += fmt::format("; default: {}", parameter.usual);
  return text;
}

std::string field_of(const std::string& place, const std::string& key) {
  const Parameter* parameter = parameter_at(place + "/" + key);
  if (parameter == nullptr)
    return fmt::format("    {}: Optional[{}] = None\n", key, has_items(place + "/" + key) ? "KeysList" : "Keys");
  const std::string type = type_of(parameter->kind);
  return fmt::format("    {}: {} = None\n    \"\"\"{}\"\"\"\n", key,
                     parameter->varies && type != "Keys" ? fmt::format("Union[{}, Keys, None]", type)
                                                         : fmt::format("Optional[{}]", type),
                     words_of(*parameter));
}

std::string module_text() {
  std::string text(head);
  for (const auto& [name, place] : objects) {
    text += fmt::format("\n\n@dataclass(kw_only=True, slots=True)\nclass {}(Keyed):\n", name);
    for (const std::string& key : keys_at(place)) text += field_of(place, key);
  }
  return text;
}

}  // namespace
}  // namespace tress::scene

int main(int count, char** words) {
  if (count != 2) return 2;
  std::ofstream file(words[1], std::ios::binary);
  file << tress::scene::module_text();
  return file.flush() ? 0 : 1;
}
