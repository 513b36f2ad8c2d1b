#include "scene/read/scene_strands.h"

#include <algorithm>

namespace tress::scene {
namespace {

void append(const Groom& groom, bool with_color, GroomFile* all) {
  const auto before = static_cast<std::uint32_t>(all->points.size());
  for (std::size_t s = 1; s < groom.first_point.size(); ++s) all->first_point.push_back(before + groom.first_point[s]);
  all->points.insert(all->points.end(), groom.points.begin(), groom.points.end());
  for (const float radius : groom.radius_cm) all->width.push_back(2 * radius);
  if (with_color) all->color.insert(all->color.end(), groom.color.begin(), groom.color.end());
  all->parts.push_back({groom.name, groom.strand_count(), groom.points.size()});
}

}  // namespace

Result<GroomFile> strands_of(const Scene& scene) {
  GroomFile all{.format = "the strands of a scene", .first_point = {0}, .points = {}};
  const auto has_color = [](const Groom& groom) { return groom.color.size() == groom.strand_count(); };
  all.has_color = std::ranges::all_of(scene.grooms, has_color);
  std::uint64_t points = 0;
  for (const Groom& groom : scene.grooms) {
    if (groom.basis != scene.grooms.front().basis)
      return Error{scene.source, "/grooms", "curves of one basis", "grooms of several: " + groom.name + " has another"};
    points += groom.points.size();
  }
  if (points == 0) return Error{scene.source, "/grooms", "strands", "none"};
  if (points > most_groom_points) return Error{scene.source, "/grooms", "2^32 points at most", std::to_string(points)};
  for (const Groom& groom : scene.grooms) append(groom, all.has_color, &all);
  all.basis = scene.grooms.front().basis;
  all.cm_per_unit = 1;
  all.y_up = false;
  return all;
}

}  // namespace tress::scene
