#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/model/parameters.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

void read_sky(const JsonReader& json, EnvironmentDescription* environment) {
  if (!json.object()) return;
  GradientSky& sky = environment->sky;
  sky.zenith = json.triple("zenith").value_or(sky.zenith);
  sky.horizon = json.triple("horizon").value_or(sky.horizon);
  sky.ground = json.triple("ground").value_or(sky.ground);
  if (json.has("sun")) environment->sun = read_distant_light(json.child("sun"));
}

void read_keys(const JsonReader& json, EnvironmentDescription* environment) {
  std::vector<TurnKey>& keys = environment->keys;
  for (const auto& item : json.items("frames", most_keys)) {
    if (!item.object() || !item.need({"frame", "rotate_deg"})) return;
    const TurnKey key{static_cast<int>(item.integer("frame").value_or(0)), item.number("rotate_deg").value_or(0)};
    check_rising(item, key.frame, keys.empty() ? std::nullopt : std::optional(keys.back().frame));
    keys.push_back(key);
  }
  if (json.has("frames") && keys.empty()) json.fail("frames", "one frame or more", "none");
}

}  // namespace

double EnvironmentDescription::turn_at(double frame) const {
  if (keys.empty()) return rotate_deg;
  const auto next = std::ranges::find_if(keys, [frame](const TurnKey& key) { return key.frame >= frame; });
  if (next == keys.end()) return keys.back().rotate_deg;
  if (next == keys.begin()) return next->rotate_deg;
  const TurnKey& before = *(next - 1);
  const double share = (frame - before.frame) / (double(next->frame) - before.frame);
  return before.rotate_deg + share * (next->rotate_deg - before.rotate_deg);
}

EnvironmentDescription read_environment(const JsonReader& json) {
  using Kind = EnvironmentDescription::Kind;
  EnvironmentDescription environment;
  if (!json.object() || !json.exactly_one({"file", "constant", "studio", "sky"})) return environment;
  if (const auto file = json.text("file")) environment.kind = Kind::file, environment.file = *file;
  if (const auto constant = json.triple("constant"))
    environment.kind = Kind::constant, environment.constant = *constant;
  if (json.has("studio") && !json.boolean("studio").value_or(true)) json.fail("studio", "true", "false");
  if (json.has("sky")) {
    environment.kind = Kind::sky;
    read_sky(json.child("sky"), &environment);
  }
  environment.rotate_deg = json.number("rotate_deg").value_or(0);
  read_keys(json, &environment);
  environment.scale = static_cast<float>(json.number("scale").value_or(1));
  environment.group = read_light_group(json);
  environment.links = read_links(json);
  return environment;
}

std::optional<Light> sun_of(const EnvironmentDescription& environment, double rotate_deg) {
  if (environment.kind != EnvironmentDescription::Kind::sky || !environment.sun) return std::nullopt;
  Light sun = *environment.sun;
  const double turn = rotate_deg * std::numbers::pi / 180, c = std::cos(turn), s = std::sin(turn);
  const glm::vec3 d = sun.direction;
  sun.direction = glm::vec3(static_cast<float>(c * d.x - s * d.y), static_cast<float>(s * d.x + c * d.y), d.z);
  sun.radiance *= environment.scale;
  sun.group = environment.group;
  sun.links = environment.links;
  return sun;
}

}  // namespace tress::scene
