#include "scene/read/grooms/groom_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

namespace tress::scene {
namespace {

/// Makes room for that many more at once; by half at least, so that many small sets do not copy all again each time.
template <class T>
void make_room(std::vector<T>* values, std::size_t more) {
  const std::size_t needed = values->size() + more;
  if (needed > values->capacity()) values->reserve(std::max(needed, values->size() + values->size() / 2));
}

template <class T>
void pad(std::vector<T>* values, std::size_t size, const T& value) {
  values->resize(std::max(values->size(), size), value);
}

/// Calls visit(curve, first vertex, number of vertices, first varying value, number of varying values).
template <class Visit>
void for_each_curve(const CurveSet& set, Visit&& visit) {
  std::size_t vertex = 0, varying = 0;
  for (std::size_t c = 0; c < set.vertex_counts.size(); ++c) {
    const std::size_t count = set.vertex_counts[c], knots = varying_of(set.kind, count);
    visit(c, vertex, count, varying, knots);
    vertex += count;
    varying += knots;
  }
}

/// An attribute at every point that is drawn.
template <class T>
void append_attribute(const CurveSet& set, StrandBasis drawn, AttributeScope scope, std::span<const T> values,
                      std::vector<T>* out) {
  for_each_curve(set,
                 [&](std::size_t c, std::size_t vertex, std::size_t count, std::size_t varying, std::size_t knots) {
                   const std::size_t points = drawn_points(set.kind, drawn, count);
                   if (points == 0) return;
                   if (scope == AttributeScope::vertex) {
                     append_vertex_values(set.kind, drawn, values.subspan(vertex, count), out);
                   } else if (scope == AttributeScope::varying) {
                     append_varying_values(set.kind, drawn, values.subspan(varying, knots), out);
                   } else {
                     out->insert(out->end(), points, values[scope == AttributeScope::uniform ? c : 0]);
                   }
                 });
}

/// A color in [0, 1]; what is no number is 0.
glm::vec3 clamped(glm::vec3 color) {
  for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], 1.0f) : 0.0f;
  return color;
}

}  // namespace

std::string words(AttributeScope scope) {
  static constexpr const char* names[] = {"constant", "uniform", "varying", "vertex"};
  return names[static_cast<std::size_t>(scope)];
}

GroomBuilder::GroomBuilder(std::string name, std::string format) : name_(std::move(name)) {
  file_.format = std::move(format);
  file_.first_point.push_back(0);
}

std::optional<Error> GroomBuilder::check(const CurveSet& set) const {
  const auto wrong = [&](std::string expected, std::string found) {
    return Error{name_, set.name, std::move(expected), std::move(found)};
  };
  std::uint64_t vertices = 0, points = file_.points.size();
  const StrandBasis drawn = file_.basis.value_or(drawn_as(set.kind));
  for (std::size_t c = 0; c < set.vertex_counts.size(); ++c) {
    const std::uint64_t count = set.vertex_counts[c];
    if (const std::string fault = fault_of(set.kind, count); !fault.empty())
      return wrong(fmt::format("{} vertices in curve {} ({})", fault, c, words(set.kind)), fmt::format("{}", count));
    vertices += count;
    points += drawn_points(set.kind, drawn == drawn_as(set.kind) ? drawn : StrandBasis::bezier, count);
  }
  if (vertices != set.vertices.size())
    return wrong(fmt::format("{} vertices, as {} curves have them", vertices, set.vertex_counts.size()),
                 fmt::format("{}", set.vertices.size()));
  if (points > most_groom_points || file_.strand_count() + set.vertex_counts.size() > most_groom_points)
    return wrong(fmt::format("at most {} points in a file", most_groom_points), fmt::format("{}", points));
  return std::nullopt;
}

/// Where this set needs another basis than those before it, all become Bezier segments.
void GroomBuilder::choose_basis(const CurveSet& set) {
  const StrandBasis drawn = drawn_as(set.kind);
  if (!file_.basis) file_.basis = drawn;
  if (*file_.basis == drawn || *file_.basis == StrandBasis::bezier) return;
  const std::span<const std::uint32_t> first = file_.first_point;
  if (!file_.width.empty()) file_.width = as_bezier<float>(*file_.basis, first, file_.width);
  if (!file_.color.empty()) file_.color = as_bezier<glm::vec3>(*file_.basis, first, file_.color);
  if (!file_.normal.empty()) file_.normal = as_bezier<glm::vec3>(*file_.basis, first, file_.normal);
  file_.points = as_bezier<glm::vec3>(*file_.basis, first, file_.points);
  std::vector<std::uint32_t> moved{0};
  for (std::size_t s = 0; s + 1 < first.size(); ++s) {
    const std::uint32_t count = first[s + 1] - first[s], ends = *file_.basis == StrandBasis::open_bspline ? 3 : 1;
    moved.push_back(moved.back() + (count == 0 ? 0 : 3 * (count - ends) + 1));
  }
  file_.first_point = std::move(moved);
  file_.basis = StrandBasis::bezier;
}

std::optional<AttributeScope> GroomBuilder::scope_of(const CurveSet& set, std::size_t values,
                                                     std::optional<AttributeScope> said, const std::string& attribute) {
  if (values == 0) return std::nullopt;
  std::size_t varying = 0, vertices = 0;
  for (const std::uint32_t count : set.vertex_counts) {
    varying += varying_of(set.kind, count);
    vertices += count;
  }
  const auto size_of = [&](AttributeScope scope) {
    return scope == AttributeScope::vertex    ? vertices
           : scope == AttributeScope::varying ? varying
           : scope == AttributeScope::uniform ? set.vertex_counts.size()
                                              : 1;
  };
  if (said && size_of(*said) == values) return said;
  for (const auto scope :
       {AttributeScope::vertex, AttributeScope::varying, AttributeScope::uniform, AttributeScope::constant})
    if (size_of(scope) == values) {
      if (said)
        file_.remarks.push_back(fmt::format("{}: {} is said to be {}, its {} values are taken for {}", set.name,
                                            attribute, words(*said), values, words(scope)));
      return scope;
    }
  file_.ignored.push_back({fmt::format("{}: {}", set.name, attribute),
                           fmt::format("{} values, which fit neither its {} vertices nor its {} curves", values,
                                       vertices, set.vertex_counts.size())});
  return std::nullopt;
}

/// as_given: every vertex is a point that is drawn.
void GroomBuilder::add_widths(CurveSet* given, std::size_t old_points, bool as_given) {
  const CurveSet& set = *given;
  const auto scope = scope_of(set, set.width.values.size(), set.width.scope, set.width.name);
  const double size = std::cbrt(std::abs(glm::determinant(glm::dmat3(set.to_file))));
  const auto placed = [&](float width) {
    const double x = width * size;
    return x >= 0 ? static_cast<float>(std::min(x, double{largest_coordinate})) : 0.0f;  // NaN too
  };
  const bool is_one = !scope || *scope == AttributeScope::constant;
  const float one = scope && is_one ? placed(set.width.values[0]) : 0.0f;
  if (file_.points.size() == old_points) return;  // no segment in the set
  if (is_one && file_.width.empty() && (old_points == 0 || one == file_.default_width)) {
    file_.default_width = one;
    return;
  }
  if (as_given && !is_one && *scope == AttributeScope::vertex) {
    file_.width = std::move(given->width.values);
  } else {
    make_room(&file_.width, file_.points.size() - file_.width.size());
    pad(&file_.width, old_points, file_.default_width);
    if (is_one) return pad(&file_.width, file_.points.size(), one);
    append_attribute<float>(set, *file_.basis, *scope, set.width.values, &file_.width);
  }
  for (std::size_t i = old_points; i < file_.width.size(); ++i) file_.width[i] = placed(file_.width[i]);
}

void GroomBuilder::add_vectors(const CurveSet& set, const CurveAttribute<glm::vec3>& attribute, std::size_t old_points,
                               bool is_color) {
  std::vector<glm::vec3>& out = is_color ? file_.color : file_.normal;
  const auto scope = scope_of(set, attribute.values.size(), attribute.scope, attribute.name);
  if ((!scope && out.empty()) || file_.points.size() == old_points) return;
  const glm::vec3 before = is_color ? file_.default_color : glm::vec3(0.0f);
  if (is_color && scope == AttributeScope::constant && out.empty()) {
    const glm::vec3 one = clamped(attribute.values[0]);
    if (old_points == 0 || (file_.has_color && one == before)) {
      file_.default_color = one;
      file_.has_color = true;
      return;
    }
  }
  make_room(&out, file_.points.size() - out.size());
  pad(&out, old_points, before);
  if (!scope) return pad(&out, file_.points.size(), glm::vec3(0.0f));
  append_attribute<glm::vec3>(set, *file_.basis, *scope, attribute.values, &out);
  const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(set.to_file)));
  for (std::size_t i = old_points; i < out.size(); ++i) {
    if (is_color) {
      out[i] = clamped(out[i]);
      continue;
    }
    const glm::dvec3 turned = turn * glm::dvec3(out[i]);
    const double length = glm::length(turned);
    out[i] = length > 0 && std::isfinite(length) ? glm::vec3(turned / length) : glm::vec3(0.0f);
  }
  if (is_color) file_.has_color = true;
}

std::optional<Error> GroomBuilder::place(const CurveSet& set, std::size_t old_points) {
  const bool moves = set.to_file != glm::dmat4(1.0);
  for (std::size_t i = old_points; i < file_.points.size(); ++i) {
    glm::vec3& point = file_.points[i];
    if (moves) {
      const glm::dvec3 placed(set.to_file * glm::dvec4(glm::dvec3(point), 1.0));
      for (int c = 0; c < 3; ++c)
        point[c] = std::abs(placed[c]) <= largest_coordinate ? static_cast<float>(placed[c]) : NAN;
    }
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(point[c]) <= largest_coordinate))
        return Error{
            name_, set.name, fmt::format("point {} finite and within {:g}", i - old_points, largest_coordinate),
            moves ? "one that is not, or is not once its transform is applied" : fmt::format("{:g}", point[c])};
  }
  return std::nullopt;
}

std::optional<Error> GroomBuilder::add(CurveSet set) {
  if (auto error = check(set)) return error;
  choose_basis(set);
  const std::size_t old_points = file_.points.size(), old_strands = file_.strand_count(),
                    strands = set.vertex_counts.size();
  std::uint64_t points = 0;
  make_room(&file_.first_point, strands);
  for (const std::uint32_t count : set.vertex_counts) {
    points += drawn_points(set.kind, *file_.basis, count);
    file_.first_point.push_back(static_cast<std::uint32_t>(old_points + points));
  }
  file_.parts.push_back({set.name, strands, set.vertices.size(), words(set.kind)});
  const bool as_given = old_points == 0 && points == set.vertices.size() && set.kind.wrap != CurveWrap::periodic &&
                        *file_.basis == drawn_as(set.kind) && *file_.basis != StrandBasis::bezier;
  if (as_given) {
    file_.points = std::move(set.vertices);
  } else {
    make_room(&file_.points, points);
    append_attribute<glm::vec3>(set, *file_.basis, AttributeScope::vertex, set.vertices, &file_.points);
  }
  if (auto error = place(set, old_points)) return error;
  add_widths(&set, old_points, as_given);
  add_vectors(set, set.color, old_points, true);
  add_vectors(set, set.normal, old_points, false);
  const bool has_id = set.id.size() == strands, has_uv = set.root_uv.size() == strands;
  if (has_id || !file_.id.empty()) {
    pad(&file_.id, old_strands, std::int64_t{-1});
    if (has_id) file_.id.insert(file_.id.end(), set.id.begin(), set.id.end());
    pad(&file_.id, file_.strand_count(), std::int64_t{-1});
  }
  if (has_uv || !file_.root_uv.empty()) {
    pad(&file_.root_uv, old_strands, glm::vec2(0.0f));
    if (has_uv) file_.root_uv.insert(file_.root_uv.end(), set.root_uv.begin(), set.root_uv.end());
    pad(&file_.root_uv, file_.strand_count(), glm::vec2(0.0f));
  }
  return std::nullopt;
}

Result<GroomFile> GroomBuilder::finish() {
  if (file_.strand_count() == 0) return Error{name_, "", "curves", "none"};
  return std::move(file_);
}

}  // namespace tress::scene
