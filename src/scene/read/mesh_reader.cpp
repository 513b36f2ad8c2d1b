#include "scene/read/mesh_reader.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>

#include "scene/model/parameters.h"

namespace tress::scene {

MeshDescription read_mesh(const JsonReader& json) {
  MeshDescription mesh;
  if (!json.object({"file", "up", "cm_per_unit", "translate", "albedo"}) || !json.need({"file"})) return mesh;
  mesh.file = json.text("file").value_or("");
  if (const auto up = json.choice("up", {"y", "z"})) mesh.y_up = *up == "y";
  mesh.cm_per_unit = json.number("cm_per_unit").value_or(mesh.cm_per_unit);
  mesh.translate = json.triple("translate").value_or(mesh.translate);
  mesh.albedo = json.triple("albedo").value_or(mesh.albedo);
  return mesh;
}

Result<Mesh> place_mesh(const ObjFile& file, const MeshDescription& description, const std::string& name,
                        std::vector<std::string>* warnings) {
  Mesh mesh;
  mesh.name = name;
  mesh.albedo = description.albedo;
  mesh.positions.reserve(file.positions.size());
  for (const auto& p : file.positions) {
    const glm::dvec3 turned = description.y_up ? glm::dvec3(p.x, -p.z, p.y) : glm::dvec3(p);
    const glm::dvec3 placed = turned * description.cm_per_unit + glm::dvec3(description.translate);
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(placed[c]) <= world_cm))
        return Error{name, fmt::format("vertex {}", mesh.positions.size() + 1),
                     fmt::format("coordinates within {:g} cm", world_cm),
                     fmt::format("{:g} cm at {:g} cm per unit", placed[c], description.cm_per_unit)};
    mesh.positions.emplace_back(placed);
  }
  mesh.triangles.reserve(file.triangles.size());
  for (const auto& t : file.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    if (glm::length(glm::cross(b - a, c - a)) > 0) mesh.triangles.push_back(t);
  }
  const auto left_out = file.triangles.size() - mesh.triangles.size();
  if (left_out)
    warnings->push_back(
        fmt::format("{}: {} of {} triangles have no area and are left out", name, left_out, file.triangles.size()));
  return mesh;
}

}  // namespace tress::scene
