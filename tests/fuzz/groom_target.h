// What the fuzz targets of strands share: any bytes to one reader; refused, or strands whose every number is finite,
// that a groom can be made of.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>

#include "fuzz/fuzz.h"
#include "scene/read/assembly.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/grooms/groom_formats.h"

namespace tress::fuzz {

inline int run_groom_reader(const std::uint8_t* data, std::size_t size,
                            Result<scene::GroomFile> (*read)(const scene::GroomInput&)) {
  const auto groom = read({.bytes = bytes_of(data, size), .name = "some.groom"});
  if (!groom) {
    require_message(groom, "some.groom");
    return 0;
  }
  require(groom->first_point.size() > 1 && groom->first_point[0] == 0);
  require(groom->first_point.back() == groom->points.size());
  for (std::size_t s = 0; s + 1 < groom->first_point.size(); ++s)
    require(groom->first_point[s] <= groom->first_point[s + 1]);
  for (const glm::vec3& p : groom->points) require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  require(groom->width.empty() || groom->width.size() == groom->points.size());
  require(groom->color.empty() || groom->color.size() == groom->points.size() ||
          groom->color.size() == groom->strand_count());
  require(groom->normal.empty() || groom->normal.size() == groom->points.size());
  require(groom->id.empty() || groom->id.size() == groom->strand_count());
  require(groom->root_uv.empty() || groom->root_uv.size() == groom->strand_count());
  for (const glm::vec3& n : groom->normal) require(glm::dot(n, n) <= 1.001f);  // NaN fails
  for (const float width : groom->width)
    require(std::isfinite(width) && (width >= 0 || width < 0.9f * scene::width_not_said));
  scene::GroomPlacement placement;
  placement.guess_up = true;
  placement.colors = true;
  placement.basis = scene::kind_of_basis(scene::basis_names()[size % scene::basis_names().size()]);
  std::vector<std::string> notes, warnings;
  const auto made = scene::assemble_groom(*groom, placement, "some.groom", &notes, &warnings);
  if (!made) require_message(made, "some.groom");
  return 0;
}

}  // namespace tress::fuzz
