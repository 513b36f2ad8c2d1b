#include "cli/part_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "cli/picture_files.h"
#include "scene/model/light.h"
#include "scene/model/parameters.h"

namespace tress::cli {
namespace {

using nlohmann::json;

constexpr std::size_t most_groups = 64, most_names = 4096, most_objects = std::size_t{1} << 20;
constexpr int most = 1 << 24;

const json& member(const json& header, const char* name) {
  static const json none;
  const auto found = header.find(name);
  return found == header.end() ? none : *found;
}

/// Reads N whole numbers of a JSON array, each in [0, 2^24].
template <std::size_t N>
bool read_numbers(const json& value, std::array<int, N>* numbers) {
  if (!value.is_array() || value.size() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    if (!value[i].is_number_unsigned() || value[i].get<std::uint64_t>() > most) return false;
    (*numbers)[i] = value[i].get<int>();
  }
  return true;
}

template <std::size_t N>
bool read_floats(const json& value, std::array<float, N>* numbers) {
  if (!value.is_array() || value.size() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    const double x = value[i].is_number() ? value[i].get<double>() : std::numeric_limits<double>::infinity();
    if (!(std::abs(x) <= double{std::numeric_limits<float>::max()})) return false;
    (*numbers)[i] = static_cast<float>(x);
  }
  return true;
}

bool read_names(const json& value, std::size_t most_of_them, std::vector<std::string>* names) {
  if (!value.is_array() || value.size() > most_of_them) return false;
  for (const json& name : value) {
    if (!name.is_string()) return false;
    names->push_back(name.get<std::string>());
  }
  return true;
}

bool read_flag(const json& value, bool* flag) {
  if (!value.is_boolean()) return false;
  *flag = value.get<bool>();
  return true;
}

/// The bytes of a name, which need not be UTF-8: ids of mattes are made from its bytes.
std::string hex_of(const std::string& bytes) {
  std::string digits;
  for (const char c : bytes) {
    digits += "0123456789abcdef"[static_cast<unsigned char>(c) >> 4];
    digits += "0123456789abcdef"[static_cast<unsigned char>(c) & 15];
  }
  return digits;
}

std::optional<std::string> bytes_of_hex(const std::string& digits) {
  if (digits.size() % 2 != 0) return std::nullopt;
  const auto value_of = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  std::string bytes;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    const int high = value_of(digits[i]), low = value_of(digits[i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes += static_cast<char>(high << 4 | low);
  }
  return bytes;
}

bool read_mattes(const json& value, std::vector<integrate::MatteKind>* mattes) {
  if (value.is_null()) return true;
  if (!value.is_object()) return false;
  for (const auto& [kind, names] : value.items()) {
    std::vector<std::string> all_digits;
    integrate::MatteKind read{kind, {}};
    if (!read_names(names, most_objects, &all_digits)) return false;
    for (const std::string& digits : all_digits) {
      std::optional<std::string> name = bytes_of_hex(digits);
      if (!name) return false;
      read.names.push_back(std::move(*name));
    }
    mattes->push_back(std::move(read));
  }
  return std::ranges::all_of(*mattes,
                             [&](const auto& kind) { return kind.names.size() == mattes->front().names.size(); });
}

bool read_look(const json& value, image::Preview* look) {
  if (value.is_null()) return true;
  const json& stops = member(value, "exposure_stops");
  const json& view = member(value, "view");
  if (!stops.is_number() || !(std::abs(stops.get<double>()) <= 1000) || !view.is_string()) return false;
  const std::optional<image::View> known = image::view_of(view.get<std::string>());
  look->exposure_stops = stops.get<double>();
  if (known) look->view = *known;
  return known.has_value() && read_flag(member(value, "alpha"), &look->alpha);
}

bool read_request(const json& value, image::Picture* request) {
  if (value.is_null()) return true;
  const json& texts = member(value, "texts");
  const json& matrices = member(value, "matrices");
  if (!texts.is_object() || !matrices.is_object() || texts.size() > most_names || matrices.size() > most_names)
    return false;
  for (const auto& [name, text] : texts.items()) {
    if (!text.is_string()) return false;
    request->metadata[name] = text.get<std::string>();
  }
  for (const auto& [name, matrix] : matrices.items()) {
    if (!read_floats(matrix, &request->matrices[name])) return false;
  }
  std::array<float, 3> screen{};
  if (!read_floats(member(value, "screen"), &screen)) return false;
  request->screen_width = screen[0];
  request->screen_center = {screen[1], screen[2]};
  return true;
}

json request_json(const image::Picture& request) {
  json matrices = json::object();
  for (const auto& [name, matrix] : request.matrices) matrices[name] = matrix;
  return {{"texts", request.metadata},
          {"matrices", matrices},
          {"screen", {request.screen_width, request.screen_center[0], request.screen_center[1]}}};
}

json mattes_json(const std::vector<integrate::MatteKind>& mattes) {
  json header = json::object();
  for (const integrate::MatteKind& kind : mattes) {
    json& names = header[kind.name] = json::array();
    for (const std::string& name : kind.names) names.push_back(hex_of(name));
  }
  return header;
}

bool are_same(const std::vector<integrate::MatteKind>& a, const std::vector<integrate::MatteKind>& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return x.name == y.name && x.names == y.names; });
}

}  // namespace

bool PartHeader::fits(const PartHeader& other) const {
  return whole_width == other.whole_width && whole_height == other.whole_height && opaque == other.opaque &&
         glint == other.glint && moving == other.moving && groups == other.groups && emission == other.emission &&
         halves == other.halves && deep_light == other.deep_light && data == other.data &&
         are_same(mattes, other.mattes);
}

PartHeader part_header_of(const RenderSettings& settings, const scene::Scene& scene, const Identity& identity,
                          bool counts_objects) {
  const SampleRange samples = samples_of(settings, scene);
  PartHeader part;
  part.whole_width = scene.image.width;
  part.whole_height = scene.image.height;
  part.from = samples.from;
  part.to = samples.to;
  part.opaque = scene.environment_visible && !scene.image.transparent;
  part.glint = std::ranges::any_of(scene.fibers, [](const fiber::FiberParameters& fiber) { return fiber.split_glint; });
  part.moving = scene.next.has_value();
  part.emission = std::ranges::any_of(scene.lights, [](const scene::Light& light) { return light.visible; });
  part.halves = settings.render.halves;
  part.deep_light = scene.integrator.learns_deep_light();
  part.data = settings.render.data;
  part.groups = scene::light_groups(scene);
  if (counts_objects) part.mattes = integrate::matte_kinds(scene);
  part.layers = settings.layers;
  part.look = {scene.image.transparent, scene.image.exposure_stops, scene.image.view};
  describe_request(settings, scene, identity, &part.request);
  return part;
}

json to_json(const PartHeader& part) {
  const image::Window& window = part.window;
  json header{{"window", {window.left, window.top, window.width, window.height}},
              {"whole", {part.whole_width, part.whole_height}},
              {"samples", {part.from, part.to}},
              {"opaque", part.opaque},
              {"glint", part.glint},
              {"moving", part.moving},
              {"emission", part.emission},
              {"halves", part.halves},
              {"deep_light", part.deep_light},
              {"groups", part.groups},
              {"table", part.table},
              {"frozen", part.frozen},
              {"mattes", mattes_json(part.mattes)},
              {"look",
               {{"alpha", part.look.alpha},
                {"exposure_stops", part.look.exposure_stops},
                {"view", image::view_names()[static_cast<std::size_t>(part.look.view)]}}},
              {"request", request_json(part.request)}};
  if (part.layers) header["layers"] = *part.layers;
  if (part.data.has_any()) header["data"] = part.data.names();
  return header;
}

std::optional<PartHeader> parse_part_header(const json& header) {
  PartHeader part;
  std::array<int, 4> window{};
  std::array<int, 2> whole{}, samples{};
  if (!header.is_object() || !read_numbers(member(header, "window"), &window) ||
      !read_numbers(member(header, "whole"), &whole) || !read_numbers(member(header, "samples"), &samples))
    return std::nullopt;
  part.window = {window[0], window[1], window[2], window[3]};
  part.whole_width = whole[0];
  part.whole_height = whole[1];
  part.from = samples[0];
  part.to = samples[1];
  for (const auto& [name, flag] :
       {std::pair{"opaque", &part.opaque}, std::pair{"glint", &part.glint}, std::pair{"frozen", &part.frozen},
        std::pair{"moving", &part.moving}, std::pair{"emission", &part.emission}, std::pair{"halves", &part.halves},
        std::pair{"deep_light", &part.deep_light}}) {
    if (!read_flag(member(header, name), flag)) return std::nullopt;
  }
  if (!member(header, "table").is_string()) return std::nullopt;
  part.table = member(header, "table").get<std::string>();
  if (header.contains("layers") && !read_names(header["layers"], most_names, &part.layers.emplace()))
    return std::nullopt;
  std::vector<std::string> data;
  if (header.contains("data") && !read_names(header["data"], integrate::data_layer_names.size(), &data))
    return std::nullopt;
  if (!std::ranges::all_of(data, [&](const std::string& name) { return part.data.ask(name); })) return std::nullopt;
  const bool good = read_names(member(header, "groups"), most_groups, &part.groups) &&
                    read_mattes(member(header, "mattes"), &part.mattes) &&
                    read_look(member(header, "look"), &part.look) &&
                    read_request(member(header, "request"), &part.request) && window[2] > 0 && window[3] > 0 &&
                    window[0] + window[2] <= whole[0] && window[1] + window[3] <= whole[1] &&
                    std::int64_t{whole[0]} * whole[1] <= scene::most_image_pixels && part.from < part.to;
  return good ? std::optional(std::move(part)) : std::nullopt;
}

}  // namespace tress::cli
