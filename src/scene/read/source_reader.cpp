#include "scene/read/source_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tress::scene {
namespace {

constexpr std::size_t most_stops = 256, most_terms = 16;
const std::vector<std::string> kinds{"ramp", "root",      "random",  "normal",   "mix",
                                     "sum",  "attribute", "texture", "hsvadjust"};

/// Sources have few levels: a document of nothing but braces must not end the program.
constexpr int most_levels = 16;

class SourceReader {
 public:
  SourceReader(const ReadValue& read, const glm::vec3& unit) : read_(read), unit_(unit) {}

  Source read(const JsonReader& json, const std::string& key, int level = 0) const {
    if (!json.is_object(key)) return {.value = read_(json, key).value_or(glm::vec3(0.0f))};
    if (level == most_levels) json.fail(key, fmt::format("sources of at most {} levels", most_levels), "more");
    const JsonReader source = json.child(key);
    if (json.failed() ||
        !source.object({"ramp", "root", "tip", "along", "interpolation", "random", "normal", "deviation", "seed", "mix",
                        "sum", "share", "attribute", "texture", "space", "hsvadjust", "hue", "saturation", "value"}) ||
        !source.exactly_one(kinds) || !goes_together(source))
      return {};
    if (source.has("ramp")) return ramp(source, level);
    if (source.has("root")) return from_root_to_tip(source, level);
    if (source.has("attribute"))
      return {.kind = Source::Kind::attribute, .value = unit_, .attribute = source.text("attribute").value_or("")};
    if (source.has("texture"))
      return {.kind = Source::Kind::texture,
              .value = unit_,
              .file = source.text("texture").value_or(""),
              .is_encoded = source.choice("space") != "linear"};
    if (source.has("sum")) return sum(source, level);
    const Parameter* parameter = json.parameter_of(key);
    if (source.has("normal")) {
      if (parameter != nullptr && parameter->kind == ValueKind::choice)
        source.fail("normal", "it at a key of numbers (\"mix\" has a share that may be one)", "names");
      return normal(source, level);
    }
    if (source.has("hsvadjust")) {
      using enum ValueKind;
      if (parameter == nullptr || parameter->range.most > 1 ||
          !(parameter->kind == triple || parameter->kind == either || parameter->kind == triples_by_name))
        source.fail("hsvadjust", "it at a key whose value is a color", "another");
      return hsv(source, level);
    }
    return of_two(source, level);
  }

 private:
  static bool goes_together(const JsonReader& source) {
    const auto beside = [&](const char* key, bool fits, const char* others) {
      if (source.has(key) && !fits) source.fail(key, fmt::format("this key beside {} only", others), "it without");
      return !source.failed();
    };
    if (source.has("root") && !source.need({"tip"})) return false;
    return beside("tip", source.has("root"), "\"root\"") && beside("along", source.has("ramp"), "\"ramp\"") &&
           beside("interpolation", source.has("ramp") || source.has("root"), "\"ramp\" or \"root\"") &&
           beside("space", source.has("texture"), "\"texture\"") &&
           beside("seed", source.has("random") || source.has("normal"), "\"random\" or \"normal\"") &&
           beside("deviation", source.has("normal"), "\"normal\"") &&
           beside("hue", source.has("hsvadjust"), "\"hsvadjust\"") &&
           beside("saturation", source.has("hsvadjust"), "\"hsvadjust\"") &&
           beside("value", source.has("hsvadjust"), "\"hsvadjust\"") &&
           beside("share", source.has("random") || source.has("mix"), "\"random\" or \"mix\"");
  }

  static bool is_smooth(const JsonReader& source) { return source.choice("interpolation") == "smooth"; }

  /// Reads the short form of a ramp with two stops.
  Source from_root_to_tip(const JsonReader& source, int level) const {
    return simplified({.kind = Source::Kind::ramp,
                       .parts = {read(source, "root", level + 1), read(source, "tip", level + 1)},
                       .places = {0, 1},
                       .is_smooth = is_smooth(source)});
  }

  Source ramp(const JsonReader& source, int level) const {
    Source ramp{.kind = Source::Kind::ramp};
    ramp.along = static_cast<Source::Along>(source.choice_number("along").value_or(0));
    ramp.is_smooth = is_smooth(source);
    const std::vector<JsonReader> stops = source.items("ramp", most_stops);
    if (stops.empty()) source.fail("ramp", "one stop or more, [place, value] each", "none");
    for (const JsonReader& stop : stops) {
      if (stop.size() != 2) stop.fail("", "a stop, [place, value]", "something else");
      if (stop.failed()) return {};
      const auto place = static_cast<float>(stop.number("0").value_or(0));
      if (ramp.along == Source::Along::share && place > 1)
        stop.fail("0", "a share of the length, 0..1 (\"along\": \"root_cm\" takes centimetres)",
                  fmt::format("{:g}", place));
      if (!ramp.places.empty() && !(place > ramp.places.back()))
        stop.fail("0", fmt::format("a place beyond that of the stop before, {:g}", ramp.places.back()),
                  fmt::format("{:g}", place));
      ramp.places.push_back(place);
      ramp.parts.push_back(read(stop, "1", level + 1));
    }
    return simplified(std::move(ramp));
  }

  Source sum(const JsonReader& source, int level) const {
    const JsonReader parts = source.child("sum");
    if (parts.size() < 2 || parts.size() > most_terms)
      source.fail("sum", fmt::format("2 to {} values, [A, B, ...]", most_terms), "something else");
    Source sum{.kind = Source::Kind::sum};
    for (std::size_t i = 0; i < parts.size() && !source.failed(); ++i)
      sum.parts.push_back(read(parts, std::to_string(i), level + 1));
    return source.failed() ? Source{} : sum;  // where it is used it is held to the value's range
  }

  Source normal(const JsonReader& source, int level) const {
    if (!source.need({"deviation"})) return {};
    Source normal{.kind = Source::Kind::normal, .parts = {read(source, "normal", level + 1)}};
    normal.parts.push_back({.value = static_cast<float>(source.number("deviation").value_or(0)) * unit_});
    normal.seed = static_cast<std::uint64_t>(source.integer("seed").value_or(0));
    return simplified(std::move(normal));
  }

  Source hsv(const JsonReader& source, int level) const {
    const auto number = [&](const char* key, float usual) {
      return source.has(key) ? numbers().read(source, key, level + 1) : Source{.value = glm::vec3(usual)};
    };
    return simplified({.kind = Source::Kind::hsv,
                       .parts = {read(source, "hsvadjust", level + 1), number("hue", 0), number("saturation", 1),
                                 number("value", 1)}});
  }

  /// Reads a random source or a mix.
  Source of_two(const JsonReader& source, int level) const {
    const bool is_mix = source.has("mix");
    const std::string key = is_mix ? "mix" : "random";
    const JsonReader parts = source.child(key);
    if (parts.size() != 2) source.fail(key, "two values, [A, B]", "something else");
    if (is_mix && !source.need({"share"})) return {};
    if (source.failed()) return {};
    Source two{.kind = is_mix ? Source::Kind::mix : Source::Kind::random,
               .parts = {read(parts, "0", level + 1), read(parts, "1", level + 1)}};
    if (is_mix)
      two.parts.push_back(numbers().read(source, "share", level + 1));
    else if (const auto chance = source.number("share"))
      two.chance = static_cast<float>(*chance);
    two.seed = static_cast<std::uint64_t>(source.integer("seed").value_or(0));
    return simplified(std::move(two));
  }

  static SourceReader numbers() {
    static const ReadValue read = read_number(glm::vec3(1.0f));
    return {read, glm::vec3(1.0f)};
  }

  const ReadValue& read_;
  const glm::vec3 unit_;
};

bool needs_file(const Source& source) {
  return source.kind == Source::Kind::texture || source.kind == Source::Kind::attribute ||
         std::ranges::any_of(source.parts, needs_file);
}

}  // namespace

ReadValue read_triple() {
  return [](const JsonReader& json, const std::string& key) { return json.triple(key); };
}

ReadValue read_number(const glm::vec3& unit) {
  return [unit](const JsonReader& json, const std::string& key) -> std::optional<glm::vec3> {
    const auto x = json.number(key);
    return x ? std::optional(static_cast<float>(*x) * unit) : std::nullopt;
  };
}

Source read_source(const JsonReader& json, const std::string& key, const ReadValue& read, const glm::vec3& unit) {
  return SourceReader(read, unit).read(json, key);
}

float middle_of(const Source& source) {
  if (source.kind == Source::Kind::constant) return source.value.x;
  if (source.parts.empty()) return source.value.x / 2;
  const bool is_of_one = source.kind == Source::Kind::normal || source.kind == Source::Kind::hsv;
  const std::size_t count = is_of_one ? 1 : source.kind == Source::Kind::mix ? 2 : source.parts.size();
  float sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += middle_of(source.parts[i]);
  return source.kind == Source::Kind::sum ? sum : sum / static_cast<float>(count);
}

Source read_color_source(const JsonReader& json) {
  if (!json.is_text("color")) return read_source(json, "color", read_triple());
  return json.choice("color") ? Source{.kind = Source::Kind::attribute, .value = glm::vec3(1.0f)} : Source{};
}

Result<Source> parse_color(const std::string& json) {
  const std::string material = "/materials/0", key = "color";
  const nlohmann::json document{{key, nlohmann::json::parse(json, nullptr, false)}};
  std::optional<Error> error;
  Source source = read_source(JsonReader(document, material, "", &error), key, read_triple());
  if (!error && needs_file(source))
    error = Error{"", material + "/" + key, "a color without textures and attributes", json.substr(0, 64)};
  if (!error) return source;
  error->place.replace(0, material.size() + 1 + key.size(), "--color");
  return *error;
}

std::optional<glm::vec3> take_pigment(Source source, Absorption sigma_a, Material* material) {
  if (source.kind == Source::Kind::constant) return source.value;
  material->pigment = {std::move(source), std::move(sigma_a)};
  return std::nullopt;
}

std::optional<glm::vec3> take_dyed(Pigment pigment, const fiber::FiberParameters& fiber, Material* material) {
  const auto is_constant = [](const Source& source) { return source.kind == Source::Kind::constant; };
  if (is_constant(pigment.source) && (!pigment.dye || is_constant(*pigment.dye))) return pigment.at({}, fiber);
  material->pigment = std::move(pigment);
  return std::nullopt;
}

}  // namespace tress::scene
