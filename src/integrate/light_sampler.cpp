#include "integrate/light_sampler.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>

#include "base/color.h"
#include "fiber/energy_table.h"

namespace tress::integrate {
namespace {

constexpr float even_share = 0.1f;       ///< share of the draws that chooses evenly among lights
constexpr std::size_t points_kept = 64;  ///< points per groom or mesh
constexpr int draws_per_point = 4;       ///< a sphere or rectangle needs one: their density is even

/// Points of the scene that light falls on.
std::vector<glm::vec3> lit_points(const scene::Scene& scene) {
  std::vector<glm::vec3> points;
  const auto keep_some = [&](std::size_t all, const auto& point) {
    const std::size_t count = std::min(points_kept, all);
    for (std::size_t i = 0; i < count; ++i) points.push_back(point(i * all / count));
  };
  for (const scene::Groom& groom : scene.grooms)
    keep_some(groom.points.size() * groom.times(), [&](std::size_t i) {
      return groom.place(i / groom.points.size()).point(groom.points[i % groom.points.size()]);
    });
  for (const scene::Mesh& mesh : scene.meshes)
    keep_some(mesh.positions.size(), [&](std::size_t i) { return mesh.positions[i]; });
  if (points.empty()) points.emplace_back(0.0f);
  return points;
}

/// Integral of radiance over the directions to a light, its luminance averaged over the points.
double mean_fluence(const scene::LightShape& light, const std::vector<glm::vec3>& points) {
  double sum = 0;
  for (const glm::vec3& point : points) {
    for (int i = 0; i < draws_per_point; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / draws_per_point;
      const scene::LightSample sample = scene::sample_light(light, point, u, u);
      if (sample.pdf_solid_angle > 0) {
        sum += static_cast<double>(luminance(sample.radiance)) / sample.pdf_solid_angle;
      }
    }
  }
  return sum / static_cast<double>(points.size() * draws_per_point);
}

}  // namespace

LightSampler::LightSampler(const scene::Scene& scene) : scene_(scene) {
  std::vector<double> fluence;
  const std::vector<std::string> groups = scene::light_groups(scene);
  if (scene.environment.mean() != glm::vec3(0.0f)) {
    choices_.push_back({nullptr, 0, scene::group_index(groups, scene.environment_group)});
    link(scene.environment_links);
    fluence.push_back(4 * std::numbers::pi * static_cast<double>(luminance(scene.environment.mean())));
  }
  if (!scene.lights.empty()) {
    const std::vector<glm::vec3> points = lit_points(scene);
    const SceneSize size(scene);
    for (const scene::Light& light : scene.lights) {
      const auto is_black = [](const scene::LightShape& shape) { return shape.radiance == glm::vec3(0.0f); };
      if (is_black(light) && std::ranges::all_of(light.later, is_black)) continue;
      choices_.push_back({&light, 0, scene::group_index(groups, light.group), LightClearance(light, scene, size)});
      link(light.links);
      some_seen_ = some_seen_ || light.visible;
      double sum = mean_fluence(light, points);
      for (const scene::LightShape& moment : light.later) sum += mean_fluence(moment, points);
      fluence.push_back(sum / static_cast<double>(1 + light.later.size()));
    }
  }
  double total = 0;
  for (const double each : fluence) total += each;
  const auto count = static_cast<double>(choices_.size());
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    const double share = total > 0 ? fluence[i] / total : 1 / count;
    choices_[i].probability = static_cast<float>((1 - even_share) * share + even_share / count);
  }
  if (choices_.size() == 1) choices_[0].probability = 1;
  if (std::ranges::all_of(choices_, [](const Choice& choice) { return choice.unlit.empty(); })) return;
  lit_share_.resize(scene.grooms.size() + scene.meshes.size(), 0.0f);
  for (std::size_t object = 0; object < lit_share_.size(); ++object)
    for (const Choice& choice : choices_)
      if (choice.unlit.empty() || choice.unlit[object] == 0) lit_share_[object] += choice.probability;
}

/// Links the last light.
void LightSampler::link(const scene::LightLinks& links) {
  Choice& choice = choices_.back();
  choice.unlit = scene::marked_objects(scene_, [&](const auto& object) { return !links.lit.has(object.object); });
  choice.passed = scene::marked_objects(
      scene_, [&](const auto& object) { return !object.visibility.shadow || !links.blocking.has(object.object); });
  choice.needs_shadow_ray =
      choice.passed != scene::marked_objects(scene_, [](const auto& object) { return !object.visibility.indirect; });
}

bool LightSampler::meet_moving(const Choice& choice, const glm::vec3& origin, float time, float distance_cm,
                               Arrival* arrival) {
  const scene::LightShape now = scene::light_during(*choice.light, time);
  if (!meet(now, choice.clearance.at(now), origin, distance_cm, arrival)) return false;
  arrival->way = choice.light->later.back().center - choice.light->center;
  return true;
}

LightSampler::Arrival LightSampler::sample(const glm::vec3& point, float time, float u_light,
                                           const std::array<float, 2>& u, std::uint32_t object) const {
  Arrival arrival;
  if (choices_.empty()) return arrival;
  std::size_t chosen = 0;
  for (float below = probability_at(choices_[0], object); u_light >= below && chosen + 1 < choices_.size();) {
    below += probability_at(choices_[++chosen], object);
  }
  const Choice& choice = choices_[chosen];
  const float probability = probability_at(choice, object);
  arrival.passed = &choice.passed;
  arrival.group = choice.group;
  if (choice.light != nullptr) {
    const auto draw = [&](const scene::LightShape& light, const LightClearance& clearance) {
      const scene::LightSample drawn = scene::sample_light(light, point, u[0], u[1]);
      arrival.direction = drawn.direction;
      arrival.distance_cm = drawn.distance;
      arrival.shadow = clearance.shadow(point, drawn.direction, drawn.distance);
      arrival.radiance = drawn.radiance;
      arrival.density = probability * drawn.pdf_solid_angle;
    };
    if (choice.light->later.empty()) {
      draw(*choice.light, choice.clearance);
    } else {
      const scene::LightShape now = scene::light_during(*choice.light, time);
      draw(now, choice.clearance.at(now));
    }
  } else {
    const scene::Environment::Sample drawn = scene_.environment.sample(u[0], u[1]);
    arrival.direction = scene::turned_with_environment(scene_, drawn.direction, time);
    arrival.shadow = {arrival.direction, arrival.distance_cm};
    arrival.radiance = drawn.radiance;
    arrival.density = probability * drawn.pdf_solid_angle;
  }
  arrival.radiance = carried(arrival.radiance);
  return arrival;
}

LightSampler::Arrival LightSampler::seen(const glm::vec3& origin, const glm::vec3& direction, float time,
                                         float distance_cm) const {
  Arrival nearest;
  if (!some_seen_) return nearest;
  along(origin, direction, time, distance_cm, scene::no_object, [&](const Arrival& light) {
    const bool nearer = !(nearest.density > 0) || light.distance_cm < nearest.distance_cm;
    if (light.is_seen && nearer) nearest = light;
  });
  return nearest;
}

}  // namespace tress::integrate
