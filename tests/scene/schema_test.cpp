// scenes/schema.json against the parser: the same keys, the same ranges, the same rules of what goes with what.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "scene/read/scene_file.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

using nlohmann::json;
using Path = std::vector<std::string>;  ///< keys from the root; "0" into an array

const json& schema() {
  static const json read =
      json::parse(std::ifstream(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes" / "schema.json"));
  return read;
}

/// Empty where `value` is valid under a part of the schema, else what is not.
std::string broken_rule(const json& part, const json& value) {
  using Adapter = valijson::adapters::NlohmannJsonAdapter;
  static std::map<const json*, std::unique_ptr<valijson::Schema>>
      parsed;  // parts of schema(), which stay where they are
  auto& rules = parsed[&part];
  if (!rules) {
    rules = std::make_unique<valijson::Schema>();
    valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(Adapter(part), *rules);
  }
  valijson::ValidationResults results;
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  if (validator.validate(*rules, Adapter(value), &results)) return "";
  valijson::ValidationResults::Error error;
  std::string why;
  if (results.popError(error))
    for (const std::string& place : error.context) why.append(place);
  return why.append(": ").append(error.description);
}

std::string joined(const Path& path) {
  std::string text;
  for (const auto& key : path) text += "/" + key;
  return text;
}

/// Empty where the parser takes it, else the place of its error.
std::string refused_at(const json& document, KnownKeys* keys = nullptr) {
  const std::string text = document.dump();
  const auto scene = parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()), "s.json", keys);
  return scene ? "" : scene.error().place;
}

json smallest(const json& node);

/// Objects that hold `given` and are valid under `node`, with as few other keys as that takes (required ones and up to
/// two more, in every value of their enumerations); `most` of them at most.
std::vector<json> completed(const json& node, json given, std::size_t most) {
  for (const auto& key : node.value("required", json::array()))
    if (!given.contains(key.get<std::string>()))
      given[key.get<std::string>()] = smallest(node["properties"][key.get<std::string>()]);
  std::vector<std::pair<std::string, json>> others;
  for (const auto& [key, property] : node["properties"].items()) {
    if (given.contains(key)) continue;
    if (property.contains("enum")) {
      for (const auto& value : property["enum"]) others.emplace_back(key, value);
    } else if (property.value("type", "") != "object" || node.contains("oneOf")) {
      others.emplace_back(key, smallest(property));
    }
  }
  std::vector<json> found;
  const auto keep = [&](const json& object) {
    if (broken_rule(node, object).empty()) found.push_back(object);
    return found.size() >= most;
  };
  if (keep(given)) return found;
  for (std::size_t i = 0; i < others.size(); ++i) {
    json one = given;
    one[others[i].first] = others[i].second;
    if (keep(one)) return found;
  }
  for (std::size_t i = 0; i < others.size(); ++i)
    for (std::size_t j = i + 1; j < others.size(); ++j) {
      json two = given;
      two[others[i].first] = others[i].second;
      two[others[j].first] = others[j].second;
      if (keep(two)) return found;
    }
  return found;
}

json smallest(const json& node) {
  if (node.contains("examples")) return node["examples"][0];
  if (node.contains("default")) return node["default"];
  if (node.contains("const")) return node["const"];
  if (node.contains("enum")) return node["enum"][0];
  const std::string type = node.value("type", "");
  if (type == "boolean") return true;
  if (type == "string") return "x";
  if (type == "number" || type == "integer") return node["minimum"];
  if (type == "array") return json(node.value("minItems", std::size_t{0}), smallest(node["items"]));
  if (type == "object") {
    const auto objects = completed(node, json::object(), 1);
    return objects.empty() ? json() : objects[0];
  }
  return smallest(node["oneOf"][0]);
}

/// Documents that hold `value` at the path from `node` on. The object around it is completed in up to `most` ways.
std::vector<json> documents(const json& node, const Path& path, std::size_t at, const json& value, std::size_t most) {
  if (at == path.size()) return {value};
  std::vector<json> found;
  const bool into_array = node.value("type", "") == "array";
  for (const json& child :
       documents(into_array ? node["items"] : node["properties"][path[at]], path, at + 1, value, most)) {
    if (into_array) {
      found.push_back(json::array({child}));
    } else if (at + 1 == path.size()) {
      for (json& object : completed(node, {{path[at], child}}, most)) found.push_back(std::move(object));
    } else {
      // What is wrong below is left to the parser; the level itself is made valid with a value that is right.
      const auto frame = completed(node, {{path[at], smallest(node["properties"][path[at]])}}, 1);
      json object = frame.empty() ? json::object() : frame[0];
      object[path[at]] = child;
      found.push_back(std::move(object));
    }
  }
  return found;
}

struct Node {
  Path path;
  const json* schema;
};

/// Every property of every object, and the alternatives of its value but sources, which only the parser knows
/// (source_test.cpp).
void collect(const json& node, const Path& path, std::vector<Node>* leaves, std::vector<Node>* objects) {
  const std::string type = node.value("type", "");
  Path below = path;
  if (type == "object" && !node.contains("properties")) return;
  if (type == "object") {
    objects->push_back({path, &node});
    for (const auto& [key, property] : node["properties"].items()) {
      below.push_back(key);
      collect(property, below, leaves, objects);
      below.pop_back();
    }
  } else if (type == "array" && node["items"].value("type", "") == "object") {
    leaves->push_back({path, &node});
    below.push_back("0");
    collect(node["items"], below, leaves, objects);
  } else if (type.empty() && node.contains("oneOf")) {
    for (const auto& alternative : node["oneOf"]) collect(alternative, path, leaves, objects);
  } else {
    leaves->push_back({path, &node});
  }
}

std::vector<Node> nodes(bool objects) {
  std::vector<Node> leaves, all;
  collect(schema(), {}, &leaves, &all);
  return objects ? all : leaves;
}

/// A document that the parser takes, with the leaf's smallest value; found among what the schema allows.
json accepted_document(const Node& leaf, KnownKeys* keys = nullptr) {
  for (const json& document : documents(schema(), leaf.path, 0, smallest(*leaf.schema), 400))
    if (refused_at(document, keys).empty()) return document;
  ADD_FAILURE() << joined(leaf.path) << ": no document with it is accepted, last refused at "
                << refused_at(documents(schema(), leaf.path, 0, smallest(*leaf.schema), 1)[0]);
  return json();
}

json& at(json& document, const Path& path) { return document[json::json_pointer(joined(path))]; }

void expect_accepted(json document, const Path& path, const json& value) {
  at(document, path) = value;
  EXPECT_EQ(refused_at(document), "") << joined(path) << " = " << value;
}

void expect_refused(json document, const Path& path, const json& value) {
  at(document, path) = value;
  EXPECT_EQ(refused_at(document), joined(path)) << joined(path) << " = " << value.dump().substr(0, 80);
}

void check_number(const json& document, const Path& path, const json& range) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  expect_accepted(document, path, range["minimum"]);
  expect_accepted(document, path, range["maximum"]);
  if (range["type"] == "integer") {
    expect_refused(document, path, range["minimum"].get<std::int64_t>() - 1);
    expect_refused(document, path, range["maximum"].get<std::uint64_t>() + 1);
    expect_refused(document, path, range["minimum"].get<double>() + 0.5);
  } else {
    expect_refused(document, path, std::nextafter(range["minimum"].get<double>(), -infinity));
    expect_refused(document, path, std::nextafter(range["maximum"].get<double>(), infinity));
  }
  expect_refused(document, path, "1");
  expect_refused(document, path, nullptr);
}

TEST(Schema, BoundsAndChoicesAreTheParsers) {
  std::size_t checked = 0;
  for (const Node& leaf : nodes(false)) {
    const json document = accepted_document(leaf);
    if (document.is_null()) continue;
    ++checked;
    const json& rule = *leaf.schema;
    const std::string type = rule.value("type", "");
    if (type == "number" || type == "integer") {
      check_number(document, leaf.path, rule);
    } else if (type == "array" && rule["items"].contains("minimum")) {
      Path component = leaf.path;
      component.push_back("1");
      check_number(document, component, rule["items"]);
      for (const std::size_t size : {0, 2, 4})
        expect_refused(document, leaf.path, json(size, rule["items"]["minimum"]));
      expect_refused(document, leaf.path, 1);
    } else if (type == "array") {
      if (rule.contains("minItems")) expect_refused(document, leaf.path, json::array());
      expect_refused(document, leaf.path, json(rule["maxItems"].get<std::size_t>() + 1, smallest(rule["items"])));
      expect_refused(document, leaf.path, json::object());
    } else if (type == "boolean") {
      expect_refused(document, leaf.path, "true");
      expect_refused(document, leaf.path, 1);
    } else if (type == "string") {
      expect_refused(document, leaf.path, "");
      expect_refused(document, leaf.path, std::string(rule["maxLength"].get<std::size_t>() + 1, 'x'));
      if (!rule.contains("examples"))
        expect_accepted(document, leaf.path, std::string(rule["maxLength"].get<std::size_t>(), 'x'));
      expect_refused(document, leaf.path, 3);
    } else {
      for (const auto& choice : rule.contains("enum") ? rule["enum"] : json::array({rule["const"]}))
        if (leaf.path.back() != "generate") expect_accepted(document, leaf.path, choice);
      expect_refused(document, leaf.path, "no such choice");
      expect_refused(document, leaf.path, json::object());
      if (rule.contains("const") && rule["const"] == true) expect_refused(document, leaf.path, false);
    }
  }
  EXPECT_GT(checked, 80u);
}

/// "/materials/0/gain" and the like; indices are all the same to a schema.
TEST(Schema, HasTheKeysThatTheParserKnowsAndNoOthers) {
  KnownKeys of_parser, of_schema;
  for (const Node& leaf : nodes(false)) accepted_document(leaf, &of_parser);
  for (const Node& object : nodes(true)) {
    auto& keys = of_schema[joined(object.path)];
    for (const auto& [key, property] : (*object.schema)["properties"].items()) keys.push_back(key);
    EXPECT_EQ((*object.schema)["additionalProperties"], false) << joined(object.path);
  }
  for (auto& [path, keys] : of_parser) std::sort(keys.begin(), keys.end());
  EXPECT_EQ(of_parser, of_schema);
}

/// Which keys need or exclude which: random halves of the keys of each object, seed 31. Kinds of grooms take keys of
/// their own, which the schema does not list.
TEST(Schema, AgreesWithTheParserOnWhatGoesTogether) {
  RandomStream random(31);
  std::map<bool, int> seen;
  for (const Node& object : nodes(true)) {
    if (joined(object.path) == "/grooms/0") continue;
    const json base = accepted_document(object);
    for (int i = 0; i < 150; ++i) {
      json subset = json::object();
      const std::size_t keep = random.next_bits() % 4 + 1;
      for (const auto& [key, property] : (*object.schema)["properties"].items())
        if (random.next_bits() % ((*object.schema)["properties"].size() + 1) < keep) {
          subset[key] = smallest(property);
          if (property.value("type", "") == "boolean") subset[key] = random.next_bits() % 2 == 0;
        }
      json document = base;
      at(document, object.path) = subset;
      const bool valid = broken_rule(schema(), document).empty();
      ++seen[valid];
      ASSERT_EQ(refused_at(document).empty(), valid)
          << document.dump() << " " << refused_at(document) << " " << broken_rule(schema(), document);
    }
  }
  EXPECT_GT(seen[true], 300);
  EXPECT_GT(seen[false], 300);
}

std::vector<std::pair<std::string, std::string>> scenes_of_the_project() {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(TRESS_SOURCE_DIR) / "scenes")) {
    if (entry.path().extension() != ".json" || entry.path().filename() == "schema.json") continue;
    std::ifstream stream(entry.path());
    texts.emplace_back(entry.path().filename().string(),
                       std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()));
  }
  std::sort(texts.begin(), texts.end());
  return texts;
}

TEST(Schema, TakesTheScenesOfTheProject) {
  const auto scenes = scenes_of_the_project();
  EXPECT_GE(scenes.size(), 4u);
  for (const auto& [name, text] : scenes) EXPECT_EQ(broken_rule(schema(), json::parse(text)), "") << name;
}

/// Seed 37: a value somewhere in a document becomes another. What the schema refuses, the parser refuses too; the
/// other way round there are rules that only the parser has (a camera at the point that it looks at).
TEST(Schema, RefusesNothingThatTheParserTakes) {
  const std::vector<json> others{nullptr,
                                 true,
                                 false,
                                 0,
                                 -1,
                                 1,
                                 0.5,
                                 1e30,
                                 -1e30,
                                 1e-300,
                                 9223372036854775807ull,
                                 18446744073709551615ull,
                                 "",
                                 "x",
                                 "file",
                                 json::array(),
                                 json::object(),
                                 {1, 2, 3},
                                 {0, 0, 0},
                                 {1, 2},
                                 {nullptr, 1, 2},
                                 {{"R", 1}}};
  RandomStream random(37);
  int refused = 0, taken = 0;
  const auto leaves = nodes(false);
  std::vector<json> bases;
  for (const Node& leaf : leaves)
    if (auto document = accepted_document(leaf); !document.is_null()) bases.push_back(std::move(document));
  for (int i = 0; i < 6000; ++i) {
    json flat = bases[random.next_bits() % bases.size()].flatten();
    auto it = flat.begin();
    std::advance(it, random.next_bits() % flat.size());
    json document = flat.unflatten();
    std::string place = it.key();  // a value, or one of the containers around it
    for (auto up = random.next_bits() % 3; up > 0 && place.find('/', 1) != std::string::npos; --up)
      place.resize(place.rfind('/'));
    document[json::json_pointer(place)] = others[random.next_bits() % others.size()];
    const bool accepted = refused_at(document).empty();
    (accepted ? taken : refused) += 1;
    if (!accepted) continue;
    ASSERT_EQ(broken_rule(schema(), document), "") << document.dump();
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace tress::scene
