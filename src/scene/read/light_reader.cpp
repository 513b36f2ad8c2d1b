#include "scene/read/light_reader.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "base/pi.h"
#include "scene/model/light.h"
#include "scene/model/parameters.h"
#include "scene/read/scene_file.h"

namespace tress::scene {
namespace {

constexpr std::size_t most_linked = 4096;
constexpr double sun_angle_deg = 0.53, usual_cone_deg = 45, usual_softness = 0.15;

void read_distant(const JsonReader& json, Light* light) {
  if (!json.object()) return;
  const bool angles = json.has("azimuth_deg") || json.has("elevation_deg");
  if (json.has("direction") == angles)
    json.fail("", "direction, or azimuth_deg and elevation_deg", angles ? "both" : "neither");
  if (const auto x = json.triple("direction")) {
    if (!(glm::length(*x) > 1e-6f)) return json.fail("direction", "a direction", "one of no length");
    light->direction = glm::normalize(*x);
  }
  const double azimuth_deg = json.number("azimuth_deg").value_or(0);
  const double elevation_deg = json.number("elevation_deg").value_or(0);
  if (angles) light->direction = direction_towards(azimuth_deg * degree, elevation_deg * degree);
  const double half_angle_rad = json.number("angle_deg").value_or(sun_angle_deg) / 2 * degree;
  light->half_angle_rad = static_cast<float>(half_angle_rad);
  if (json.has("radiance") == json.has("irradiance"))
    json.fail("", "one of radiance, irradiance", json.has("radiance") ? "both" : "neither");
  if (const auto x = json.triple("radiance")) light->radiance = *x;
  if (const auto x = json.triple("irradiance")) light->radiance = distant_radiance(*x, half_angle_rad);
}

void read_sphere(const JsonReader& json, Light* light) {
  if (!json.object() || !json.need({"center", "radius_cm", "radiance"})) return;
  if (const auto x = json.triple("center")) light->center = *x;
  if (const auto x = json.number("radius_cm")) light->radius_cm = static_cast<float>(*x);
  if (const auto x = json.triple("radiance")) light->radiance = *x;
}

void read_spot(const JsonReader& json, Light* light) {
  if (!json.object() || !json.need({"center", "look_at"}) || !json.exactly_one({"radiance", "irradiance"})) return;
  if (const auto x = json.triple("center")) light->center = *x;
  const glm::vec3 look_at = json.triple("look_at").value_or(light->center);
  if (const auto x = json.number("radius_cm")) light->radius_cm = static_cast<float>(*x);
  const double half_angle = json.number("cone_deg").value_or(usual_cone_deg) / 2 * degree;
  const double cone = 2 * std::sin(half_angle / 2) * std::sin(half_angle / 2);
  light->cone = static_cast<float>(cone);
  light->core = static_cast<float>((1 - json.number("soft").value_or(usual_softness)) * cone);
  if (const auto x = json.triple("radiance")) light->radiance = *x;
  const auto irradiance = json.triple("irradiance");
  if (json.failed()) return;
  const float distance = glm::distance(look_at, light->center);
  if (!(distance > 1e-5f)) return json.fail("look_at", "a point other than center", "the same point");
  light->direction = glm::normalize(look_at - light->center);
  if (irradiance)
    light->radiance = spot_radiance(*irradiance, static_cast<double>(light->radius_cm), static_cast<double>(distance));
}

/// Sets half edges of a rectangle that faces `look_at`, with its height as far along `up` as possible.
void read_rectangle(const JsonReader& json, Light* light) {
  if (!json.object() || !json.need({"center", "look_at", "width_cm", "height_cm", "radiance"})) return;
  if (const auto x = json.triple("center")) light->center = *x;
  const auto look_at = json.triple("look_at");
  const auto width = json.number("width_cm"), height = json.number("height_cm");
  if (const auto x = json.triple("radiance")) light->radiance = *x;
  const auto up = json.triple("up");
  if (json.failed()) return;
  if (!(glm::distance(*look_at, light->center) > 1e-5f))
    return json.fail("look_at", "a point other than center", "the same point");
  const glm::vec3 normal = glm::normalize(*look_at - light->center);
  glm::vec3 upwards(0, 0, 1);
  if (up) {
    if (!(glm::length(*up) > 1e-6f && glm::length(glm::cross(glm::normalize(*up), normal)) > 1e-4f))
      return json.fail("up", "a direction across the light's", "one along it, or of no length");
    upwards = glm::normalize(*up);
  } else if (glm::length(glm::cross(upwards, normal)) < 1e-4f) {
    upwards = glm::vec3(0, 1, 0);
  }
  const glm::vec3 aside = glm::normalize(glm::cross(upwards, normal));
  light->edge_u = aside * static_cast<float>(*width / 2);
  light->edge_v = glm::cross(normal, aside) * static_cast<float>(*height / 2);
}

ObjectList read_objects(const JsonReader& json, const std::string& key) {
  ObjectList list;
  if (!json.has(key)) return list;
  const JsonReader link = json.child(key);
  if (!link.object() || !link.exactly_one({"include", "exclude"})) return list;
  list.is_only = link.has("include");
  const std::string which = list.is_only ? "include" : "exclude";
  const std::size_t count = link.items(which, most_linked).size();
  for (std::size_t i = 0; i < count; ++i) list.names.push_back(link.child(which).text(std::to_string(i)).value_or(""));
  return list;
}

}  // namespace

LightLinks read_links(const JsonReader& json) {
  return {.lit = read_objects(json, "light_link"), .blocking = read_objects(json, "shadow_link")};
}

std::string read_light_group(const JsonReader& json) {
  const std::string name = json.text("group").value_or("");
  if (json.has("group") && !json.failed() && !is_group_name(name))
    json.fail("group", "1 to 64 letters, digits, _ and -", '"' + name + '"');
  return name;
}

Light read_distant_light(const JsonReader& json) {
  Light light;
  light.kind = Light::Kind::distant;
  read_distant(json, &light);
  return light;
}

LightDescription read_light(const JsonReader& json) {
  LightDescription description;
  Light& light = description.light;
  if (!json.object() || !json.exactly_one({"distant", "sphere", "rectangle", "spot"})) return description;
  if (json.has("distant")) {
    light = read_distant_light(json.child("distant"));
  } else if (json.has("sphere")) {
    light.kind = Light::Kind::sphere;
    read_sphere(json.child("sphere"), &light);
  } else if (json.has("spot")) {
    light.kind = Light::Kind::spot;
    read_spot(json.child("spot"), &light);
  } else {
    light.kind = Light::Kind::rectangle;
    read_rectangle(json.child("rectangle"), &light);
  }
  light.visible = json.boolean("visible").value_or(false);
  light.group = read_light_group(json);
  light.links = read_links(json);
  description.path = read_path(json);
  return description;
}

}  // namespace tress::scene
