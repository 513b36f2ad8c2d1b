#include "scene/read/scene_strands.h"

#include <fmt/format.h>

#include <algorithm>

namespace tress::scene {
namespace {

bool has_color_a_point(const Groom& groom) { return groom.color.size() == groom.points.size(); }

/// Appends the strands of a groom at a place. color_a_point: one color for each point, else one for each strand.
/// origin: of the scene's points.
void append(const Groom& groom, const Similarity& place, const glm::dvec3& origin, bool color_a_point, GroomFile* all) {
  const auto before = static_cast<std::uint32_t>(all->points.size());
  for (std::size_t s = 1; s < groom.first_point.size(); ++s) all->first_point.push_back(before + groom.first_point[s]);
  for (const glm::vec3& point : groom.points) all->points.emplace_back(glm::dvec3(place.point(point)) + origin);
  for (const float radius : groom.radius_cm) all->width.push_back(2 * place.scale * radius);
  for (std::uint32_t s = 0; all->has_color && s < groom.strand_count(); ++s)
    for (std::uint32_t i = groom.first_point[s];
         i < (color_a_point ? groom.first_point[s + 1] : groom.first_point[s] + 1); ++i)
      all->color.push_back(groom.color[has_color_a_point(groom) ? i : s]);
}

}  // namespace

Result<GroomFile> strands_of(const Scene& scene) {
  GroomFile all{.format = "the strands of a scene", .first_point = {0}, .points = {}};
  all.has_color = std::ranges::none_of(scene.grooms, [](const Groom& groom) { return groom.color.empty(); });
  const bool color_a_point = std::ranges::any_of(scene.grooms, has_color_a_point);
  std::uint64_t points = 0;
  for (const Groom& groom : scene.grooms) {
    if (groom.basis != scene.grooms.front().basis)
      return Error{scene.source, "/grooms", "curves of one basis", "grooms of several: " + groom.name + " has another"};
    points += groom.points.size() * groom.times();
  }
  if (points == 0) return Error{scene.source, "/grooms", "strands", "none"};
  if (points > most_groom_points) return Error{scene.source, "/grooms", "2^32 points at most", std::to_string(points)};
  for (const Groom& groom : scene.grooms) {
    const std::size_t times = groom.times();
    for (std::size_t i = 0; i < times; ++i) append(groom, groom.place(i), scene.origin, color_a_point, &all);
    all.parts.push_back({groom.instances.empty() ? groom.name : fmt::format("{}, {} instances", groom.name, times),
                         times * groom.strand_count(), times * groom.points.size()});
  }
  all.basis = scene.grooms.front().basis;
  all.cm_per_unit = 1;
  all.y_up = false;
  return all;
}

}  // namespace tress::scene
