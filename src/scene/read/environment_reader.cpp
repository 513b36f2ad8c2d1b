#include <cmath>
#include <numbers>

#include "scene/model/parameters.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

void read_sky(const JsonReader& json, EnvironmentDescription* environment) {
  if (!json.object({"zenith", "horizon", "ground", "sun"})) return;
  GradientSky& sky = environment->sky;
  sky.zenith = json.triple("zenith").value_or(sky.zenith);
  sky.horizon = json.triple("horizon").value_or(sky.horizon);
  sky.ground = json.triple("ground").value_or(sky.ground);
  if (json.has("sun")) environment->sun = read_distant_light(json.child("sun"));
}

}  // namespace

EnvironmentDescription read_environment(const JsonReader& json) {
  using Kind = EnvironmentDescription::Kind;
  EnvironmentDescription environment;
  if (!json.object({"file", "constant", "studio", "sky", "rotate_deg", "scale", "group"}) ||
      !json.exactly_one({"file", "constant", "studio", "sky"}))
    return environment;
  if (const auto file = json.text("file")) environment.kind = Kind::file, environment.file = *file;
  if (const auto constant = json.triple("constant"))
    environment.kind = Kind::constant, environment.constant = *constant;
  if (json.has("studio") && !json.boolean("studio").value_or(true)) json.fail("studio", "true", "false");
  if (json.has("sky")) {
    environment.kind = Kind::sky;
    read_sky(json.child("sky"), &environment);
  }
  environment.rotate_deg = json.number("rotate_deg").value_or(0);
  environment.scale = static_cast<float>(json.number("scale").value_or(1));
  environment.group = read_light_group(json);
  return environment;
}

std::optional<Light> sun_of(const EnvironmentDescription& environment) {
  if (environment.kind != EnvironmentDescription::Kind::sky || !environment.sun) return std::nullopt;
  Light sun = *environment.sun;
  const double turn = environment.rotate_deg * std::numbers::pi / 180, c = std::cos(turn), s = std::sin(turn);
  const glm::vec3 d = sun.direction;
  sun.direction = glm::vec3(static_cast<float>(c * d.x - s * d.y), static_cast<float>(s * d.x + c * d.y), d.z);
  sun.radiance *= environment.scale;
  sun.group = environment.group;
  return sun;
}

}  // namespace tress::scene
