#include "scene/read/assembly.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>

#include "scene/model/parameters.h"

namespace tress::scene {
namespace {

constexpr float usual_radius_cm = 0.004f;
constexpr double usual_longest_side_cm = 30;
/// Radii outside are taken for a wrong unit; a human hair has .0008 to .009 cm.
constexpr double smallest_radius_cm = 5e-4, largest_radius_cm = 0.05;
constexpr float thinnest_cm = 1e-4f;

/// The points of one strand without those equal to the one before.
void append_distinct(const HairFile& hair, std::uint32_t strand, std::vector<std::uint32_t>* kept) {
  kept->clear();
  for (std::uint32_t i = hair.first_point[strand]; i < hair.first_point[strand + 1]; ++i)
    if (kept->empty() || hair.points[i] != hair.points[kept->back()]) kept->push_back(i);
}

/// What a reader of the note can do about the axis that was taken for up.
std::string up_note(const std::string& name, const GroomPlacement& placement, bool falls) {
  if (placement.guess_up)
    return fmt::format("{}: {} taken for up, by how the strands fall; --up {} if it lies on its side", name,
                       falls ? "y" : "z", falls ? "z" : "y");
  return fmt::format("{}: z taken for up, but the strands fall along y; --up y or \"up\": \"y\" turns them", name);
}

}  // namespace

bool falls_along_y(const HairFile& hair) {
  constexpr double least_fall = 0.1;
  glm::dvec3 fall(0.0);
  std::size_t counted = 0;
  for (std::size_t s = 0; s + 1 < hair.first_point.size(); ++s) {
    double length = 0;
    for (std::uint32_t i = hair.first_point[s] + 1; i < hair.first_point[s + 1]; ++i)
      length += glm::distance(glm::dvec3(hair.points[i - 1]), glm::dvec3(hair.points[i]));
    if (!(length > 0)) continue;
    const glm::dvec3 root(hair.points[hair.first_point[s]]), tip(hair.points[hair.first_point[s + 1] - 1]);
    fall += (tip - root) / length;
    ++counted;
  }
  const auto strands = static_cast<double>(counted);
  return fall.y < -least_fall * strands && fall.y < 2 * fall.z;
}

Result<Groom> assemble_groom(const HairFile& hair, const GroomPlacement& placement, const std::string& name,
                             std::vector<std::string>* notes, std::vector<std::string>* warnings) {
  glm::vec3 low(1e30f), high(-1e30f);
  float thickest = hair.thickness.empty() ? hair.default_thickness : 0.0f;
  for (float thickness : hair.thickness) thickest = std::max(thickest, thickness);
  for (const auto& p : hair.points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const auto sides = high - low;
  const double longest = std::max({sides.x, sides.y, sides.z, 0.0f});
  double scale = 1;
  if (placement.cm_per_unit) {
    scale = *placement.cm_per_unit;
  } else if (longest > 0) {
    scale = usual_longest_side_cm / longest;
    notes->push_back(fmt::format("{}: no unit given, longest side {:g} units taken for {:g} cm ({:g} cm per unit)",
                                 name, longest, usual_longest_side_cm, scale));
  }
  const double extent = std::max(
      {std::abs(low.x), std::abs(low.y), std::abs(low.z), std::abs(high.x), std::abs(high.y), std::abs(high.z)});
  if (!(extent * scale <= world_cm))
    return Error{name, "points", fmt::format("coordinates within {:g} cm", world_cm),
                 fmt::format("{:g} cm at {:g} cm per unit", extent * scale, scale)};

  const double file_radius = thickest / 2 * scale;
  const bool use_file = !placement.radius_cm && file_radius >= smallest_radius_cm && file_radius <= largest_radius_cm;
  const auto one_radius = static_cast<float>(placement.radius_cm.value_or(usual_radius_cm));
  if (!placement.radius_cm && !use_file)
    notes->push_back(thickest > 0
                         ? fmt::format("{}: thickness of the file gives a radius of {:g} cm, {:g} cm used", name,
                                       file_radius, usual_radius_cm)
                         : fmt::format("{}: no thickness in the file, radius {:g} cm used", name, usual_radius_cm));
  const bool falls = !placement.y_up && falls_along_y(hair),
             y_up = placement.y_up.value_or(placement.guess_up && falls);
  if (!placement.y_up && (placement.guess_up || falls)) notes->push_back(up_note(name, placement, falls));
  Groom groom;
  groom.name = name;
  groom.first_point.push_back(0);
  std::size_t degenerate = 0;
  std::vector<std::uint32_t> kept;
  const auto strands = static_cast<std::uint32_t>(hair.first_point.size() - 1);
  for (std::uint32_t s = 0; s < strands; ++s) {
    append_distinct(hair, s, &kept);
    glm::vec3 color(0.0f);
    const std::size_t begin = groom.points.size();
    for (std::uint32_t i : kept) {
      const glm::vec3 file = hair.points[i] * static_cast<float>(scale);
      const glm::vec3 point = y_up ? glm::vec3(file.x, -file.z, file.y) : file;
      if (groom.points.size() > begin && point == groom.points.back()) continue;
      const float thickness = hair.thickness.empty() ? hair.default_thickness : hair.thickness[i];
      color += hair.color.empty() ? hair.default_color : hair.color[i];
      groom.points.push_back(point);
      groom.radius_cm.push_back(use_file ? std::max(static_cast<float>(thickness / 2 * scale), thinnest_cm)
                                         : one_radius);
    }
    if (groom.points.size() - begin < 2) {
      ++degenerate;
      groom.points.resize(begin);
      groom.radius_cm.resize(begin);
    } else {
      if (placement.colors) groom.color.push_back(color / static_cast<float>(groom.points.size() - begin));
      groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
    }
  }
  if (degenerate)
    warnings->push_back(fmt::format("{}: {} of {} strands are degenerate (one point or no length) and left out", name,
                                    degenerate, strands));
  return groom;
}

void apply_taper(const Taper& taper, Groom* groom) {
  if (taper.root == 1 && taper.tip == 1) return;
  for (std::uint32_t s = 0; s < groom->strand_count(); ++s) {
    const std::size_t begin = groom->first_point[s], end = groom->first_point[s + 1];
    double whole = 0, along = 0;
    for (std::size_t i = begin + 1; i < end; ++i) whole += glm::distance(groom->points[i - 1], groom->points[i]);
    for (std::size_t i = begin; i < end; ++i) {
      if (i > begin) along += glm::distance(groom->points[i - 1], groom->points[i]);
      const double factor = whole > 0 ? taper.root + (taper.tip - taper.root) * along / whole : taper.root;
      float& radius = groom->radius_cm[i];
      radius = std::max(static_cast<float>(factor * radius), std::min(thinnest_cm, radius));
    }
  }
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
  for (const auto& n : file.normals) {
    const glm::dvec3 turned = description.y_up ? glm::dvec3(n.x, -n.z, n.y) : glm::dvec3(n);
    const double length = glm::length(turned);
    mesh.normals.emplace_back(length > 0 ? turned / length : glm::dvec3(0.0));
  }
  mesh.triangles.reserve(file.triangles.size());
  for (std::size_t i = 0; i < file.triangles.size(); ++i) {
    const glm::uvec3 t = file.triangles[i];
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    if (!(glm::length(glm::cross(b - a, c - a)) > 0)) continue;
    mesh.triangles.push_back(t);
    if (!file.corner_normals.empty()) mesh.corner_normals.push_back(file.corner_normals[i]);
  }
  const auto left_out = file.triangles.size() - mesh.triangles.size();
  if (left_out)
    warnings->push_back(
        fmt::format("{}: {} of {} triangles have no area and are left out", name, left_out, file.triangles.size()));
  return mesh;
}

}  // namespace tress::scene
