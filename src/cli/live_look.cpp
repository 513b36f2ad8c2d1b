#include "cli/live_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "base/bands.h"
#include "scene/model/absorption.h"
#include "scene/model/parameters.h"
#include "scene/read/source_reader.h"
#include "tress/fiber/lock_color.h"
#include "tress/fiber/parameters.h"

namespace tress::cli {
namespace {

using Slider = live::RenderServer::Slider;

/// A slider, its option, and what that option sets.
struct Knob {
  const char *name, *label, *option;
  double least, most, step;
  double (*shown)(const RenderSettings&, const scene::Material&);
  void (*set)(scene::Overrides&, double);
  bool of_nodes = true;  ///< whether it also affects the round fiber of a node, whose widths and shape are fixed
};

double to_step(double x) { return std::round(1000 * x) / 1000; }

/// The eumelanin that absorbs as much green light as the fiber does, whatever colors it.
double melanin_of(const scene::Material& material) {
  return double(material.fiber.sigma_a.g) / double(scene::AbsorptionOf(material.spectral).melanin(1, 0).g);
}

constexpr Knob knobs[] = {
    {"melanin", "Melanin", "--melanin", 0, 8, 0.05,
     [](const RenderSettings& s, const scene::Material& material) {
       return s.overrides.melanin ? double(s.overrides.melanin->first) : melanin_of(material);
     },
     [](scene::Overrides& o, double x) {
       o.color.reset();
       o.color_source.reset();
       o.sigma_a.reset();
       o.hair.reset();
       o.melanin = {float(x), o.melanin ? o.melanin->second : 0.0f};
     }},
    {"roughness", "Roughness", "--roughness", 0.05, 0.6, 0.01,
     [](const RenderSettings&, const scene::Material& material) { return double(material.fiber.roughness); },
     [](scene::Overrides& o, double x) { o.roughness = float(x); }, false},
    {"eccentricity", "Eccentricity", "--eccentricity", 0.5, 1, 0.01,
     [](const RenderSettings&, const scene::Material& material) { return double(material.fiber.eccentricity); },
     [](scene::Overrides& o, double x) { o.eccentricity = float(x); }, false},
    {"tilt", "Tilt, degrees", "--cuticle-tilt", 0, 10, 0.25,
     [](const RenderSettings&, const scene::Material& material) {
       return double(material.fiber.tilt) * 180 / std::numbers::pi;
     },
     [](scene::Overrides& o, double x) { o.tilt_deg = x; }},
    {"lights", "Light", "--light-scale", 0, 8, 0.05,
     [](const RenderSettings& s, const scene::Material&) { return s.overrides.light_scale.value_or(1); },
     [](scene::Overrides& o, double x) { o.light_scale = x; }},
};

}  // namespace

std::vector<Slider> sliders_of(const RenderSettings& settings, const scene::Scene& scene) {
  std::vector<Slider> sliders;
  if (settings.checkpoint || settings.part || settings.samples_from || settings.samples_to || settings.telemetry ||
      scene.materials.empty())
    return sliders;
  const bool of_nodes = std::ranges::all_of(scene.materials, &scene::Material::has_node_widths);
  for (const Knob& knob : knobs) {
    if (of_nodes && !knob.of_nodes) continue;
    const double shown = to_step(knob.shown(settings, scene.materials.front()));
    sliders.push_back(
        {knob.name, knob.label, std::min(knob.least, shown), std::max(knob.most, shown), knob.step, shown});
  }
  return sliders;
}

live::RenderServer::Json color_of(const scene::Scene& scene) {
  using Json = live::RenderServer::Json;
  if (scene.materials.empty()) return {};
  const scene::Material& material = scene.materials.front();
  const auto shown = [&](const glm::vec3& sigma_a) {
    glm::vec3 color;
    for (int c = 0; c < 3; ++c) {
      double least = 0.001, most = 0.999;  // a color falls as its absorption rises
      for (int halving = 0; halving < 20; ++halving) {
        const double middle = (least + most) / 2;
        const bool is_darker = sigma_a_of_lock(glm::vec3(float(middle)), material.fiber)[c] > sigma_a[c];
        (is_darker ? least : most) = middle;
      }
      color[c] = static_cast<float>(most);
    }
    if (material.spectral) color = rgb_of_bands(color);
    return Json{to_step(double{color.r}), to_step(double{color.g}), to_step(double{color.b})};
  };
  if (!material.pigment) return shown(material.fiber.sigma_a);
  const scene::Source& source = material.pigment->source;
  const auto at = [&](float share) { return shown(material.pigment->at({.share = share}, material.fiber)); };
  if (source.kind != scene::Source::Kind::ramp || source.along != scene::Source::Along::share) return at(0.5f);
  Json stops = Json::array();
  for (const float place : source.places) stops.push_back({to_step(place), at(place)});
  return {{"ramp", stops}, {"interpolation", source.is_smooth ? "smooth" : "linear"}};
}

std::string fault_of_color(const std::string& json) {
  const auto source = scene::parse_color(json);
  return source ? std::string() : source.error().message();
}

RenderSettings with_look(const RenderSettings& settings, const live::RenderServer::Look& look) {
  RenderSettings changed = settings;
  std::string words;
  for (const Knob& knob : knobs) {
    const auto moved = look.values.find(knob.name);
    if (moved == look.values.end()) continue;
    knob.set(changed.overrides, moved->second);
    std::string text = fmt::format("{}", moved->second);
    if (changed.overrides.melanin && std::string(knob.name) == "melanin") {
      for (const char* other : {"--color", "--sigma-a", "--hair"}) changed.given_options.erase(other);
      if (changed.overrides.melanin->second > 0) text += fmt::format(",{}", changed.overrides.melanin->second);
    }
    changed.given_options[knob.option] = text;
    words += fmt::format(" {} {}", knob.option, text);
  }
  if (!look.color.empty()) {
    scene::Overrides& o = changed.overrides;
    o.melanin.reset();
    o.color.reset();
    o.sigma_a.reset();
    o.hair.reset();
    o.color_source = look.color;
    for (const char* other : {"--melanin", "--sigma-a", "--hair"}) changed.given_options.erase(other);
    std::string& text = changed.given_options["--color"];
    text = look.color.front() == '[' ? look.color.substr(1, look.color.size() - 2) : look.color;
    words += fmt::format(" --color '{}'", text);
  }
  if (!words.empty()) changed.command += " (by the live page:" + words + ")";
  return changed;
}

}  // namespace tress::cli
