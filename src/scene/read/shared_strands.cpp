#include "scene/read/shared_strands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <utility>

namespace tress::scene {
namespace {

double scale_of(const glm::dmat4& place) { return std::cbrt(glm::determinant(glm::dmat3(place))); }

glm::vec3 point_at(const glm::dmat4& place, const glm::vec3& point, const glm::dvec3& origin = glm::dvec3(0.0)) {
  const glm::dvec3 placed = glm::dvec3(place * glm::dvec4(glm::dvec3(point), 1.0)) - origin;
  return {to_float(placed.x), to_float(placed.y), to_float(placed.z)};
}

/// The part of values per point, or of another moment, that belongs to a range of points; empty if there are none.
template <class T>
std::span<T> part_of(std::vector<T>& values, std::size_t begin, std::size_t end) {
  return values.empty() ? std::span<T>() : std::span<T>(values).subspan(begin, end - begin);
}

void scale_widths(std::span<float> widths, double scale) {
  for (float& width : widths)
    if (width > 0) width = static_cast<float>(std::min(scale * double{width}, double{largest_coordinate}));
}

/// Gives points widths of their own, if one width for all would not do once it is scaled.
void spread_width(double scale, GroomFile* file) {
  if (file->width.empty() && file->default_width > 0 && static_cast<float>(scale) != 1)
    file->width.assign(file->points.size(), file->default_width);
}

/// Calls visit(first strand, end, shared) for all strands in their order; shared is null for those that are drawn once.
template <class Visit>
void for_each_run(const GroomFile& file, Visit&& visit) {
  std::uint32_t at = 0;
  const auto strands = static_cast<std::uint32_t>(file.strand_count());
  for (const SharedStrands& shared : file.shared) {
    if (at < shared.first) visit(at, shared.first, static_cast<const SharedStrands*>(nullptr));
    visit(shared.first, shared.end, &shared);
    at = shared.end;
  }
  if (at < strands) visit(at, strands, static_cast<const SharedStrands*>(nullptr));
}

}  // namespace

void settle(GroomFile* file) {
  for (SharedStrands& shared : file->shared) {
    if (std::exchange(shared.is_settled, true)) continue;
    const std::vector<glm::dmat4> first = shared.places.front();
    const bool is_one = shared.places.size() == 1;
    spread_width(scale_of(first.front()), file);
    const std::size_t begin = file->first_point[shared.first], end = file->first_point[shared.end];
    const auto place = [&](std::size_t moment, std::vector<glm::vec3>& points, std::vector<float>* width) {
      const glm::dmat4& at = first[is_one ? std::min(moment, first.size() - 1) : 0];
      for (glm::vec3& point : part_of(points, begin, end)) point = point_at(at, point, file->origin);
      if (width != nullptr) scale_widths(part_of(*width, begin, end), scale_of(at));
    };
    place(0, file->points, &file->width);
    for (std::size_t i = 0; i < file->later.size(); ++i)
      place(i + 1, file->later[i], file->later_width.empty() ? nullptr : &file->later_width[i]);
    const glm::dmat3 turn = glm::dmat3(first.front()) / scale_of(first.front());
    for (glm::vec3& normal : part_of(file->normal, begin, end)) normal = glm::vec3(turn * glm::dvec3(normal));
    const glm::dmat4 back = glm::inverse(first.front());
    for (std::vector<glm::dmat4>& moments : shared.places)
      for (glm::dmat4& each : moments) each = each == first.front() ? glm::dmat4(1.0) : each * back;
  }
  std::erase_if(file->shared, [](const SharedStrands& shared) { return shared.places.size() == 1; });
}

std::optional<Error> write_out(const std::string& name, GroomFile* file) {
  settle(file);
  if (file->shared.empty()) return std::nullopt;
  std::uint64_t points = 0;
  for_each_run(*file, [&](std::uint32_t first, std::uint32_t end, const SharedStrands* shared) {
    points += (shared ? shared->places.size() : 1) * std::uint64_t{file->first_point[end] - file->first_point[first]};
    for (std::size_t i = 0; shared && i < shared->places.size(); ++i)
      spread_width(scale_of(shared->places[i][0]), file);
  });
  if (points > most_groom_points)
    return Error{name, "instances", fmt::format("at most {} points once they are written out", most_groom_points),
                 fmt::format("{}", points)};
  GroomFile all{.format = file->format, .first_point = {0}, .points = {}};
  const auto append = [&](std::uint32_t first, std::uint32_t end, const glm::dmat4& place) {
    const std::size_t begin = file->first_point[first], last = file->first_point[end], old = all.points.size(),
                      old_strands = all.strand_count();
    const auto take = [&](const auto& from, auto* to) {
      const bool is_per_point = from.size() == file->points.size();
      if (!from.empty())
        to->insert(to->end(), from.begin() + static_cast<std::ptrdiff_t>(is_per_point ? begin : first),
                   from.begin() + static_cast<std::ptrdiff_t>(is_per_point ? last : end));
    };
    for (std::uint32_t s = first; s < end; ++s)
      all.first_point.push_back(static_cast<std::uint32_t>(old + file->first_point[s + 1] - begin));
    take(file->points, &all.points);
    take(file->width, &all.width);
    take(file->color, &all.color);
    take(file->normal, &all.normal);
    take(file->id, &all.id);
    take(file->root_uv, &all.root_uv);
    for (const std::uint32_t broken : file->broken)
      if (broken >= first && broken < end)
        all.broken.push_back(static_cast<std::uint32_t>(old_strands + broken - first));
    if (place == glm::dmat4(1.0)) return;
    const glm::dmat3 turn = glm::dmat3(place) / scale_of(place);
    for (glm::vec3& point : part_of(all.points, old, all.points.size())) point = point_at(place, point);
    for (glm::vec3& normal : part_of(all.normal, old, all.normal.size())) normal = glm::vec3(turn * glm::dvec3(normal));
    scale_widths(part_of(all.width, old, all.width.size()), scale_of(place));
  };
  for_each_run(*file, [&](std::uint32_t first, std::uint32_t end, const SharedStrands* shared) {
    if (shared == nullptr) return append(first, end, glm::dmat4(1.0));
    for (const std::vector<glm::dmat4>& place : shared->places) append(first, end, place.front());
  });
  for (GroomPart& part : file->parts) {
    if (part.instances > 1) part.name += fmt::format(", {} instances", part.instances);
    part.strands *= part.instances;
    part.points *= std::exchange(part.instances, 1);
  }
  file->shared.clear();
  file->first_point = std::move(all.first_point);
  file->points = std::move(all.points);
  file->width = std::move(all.width);
  file->color = std::move(all.color);
  file->normal = std::move(all.normal);
  file->id = std::move(all.id);
  file->root_uv = std::move(all.root_uv);
  file->broken = std::move(all.broken);
  return std::nullopt;
}

std::optional<Box> box_of_instances(const GroomFile& file, StrandBasis basis) {
  std::optional<Box> box;
  const auto include = [&box](const glm::vec3& point) {
    if (!box) box = Box{point, point};
    box->include(point);
  };
  for_each_run(file, [&](std::uint32_t first, std::uint32_t end, const SharedStrands* shared) {
    const auto strands = std::span(file.first_point).subspan(first, end - first + 1);
    for_each_framed_point(basis, strands, file.points, [&](const glm::vec3& point) {
      if (shared == nullptr) return include(point);
      for (const std::vector<glm::dmat4>& place : shared->places) include(point_at(place.front(), point));
    });
  });
  return box;
}

}  // namespace tress::scene
