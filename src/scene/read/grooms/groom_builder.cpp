#include "scene/read/grooms/groom_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <type_traits>
#include <utility>

namespace tress::scene {
namespace {

/// Makes room for this many more at once, but at least for half as many as there are, so that many small sets do not
/// copy everything each time.
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

/// Expands an attribute to every point that is drawn.
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

}  // namespace

bool is_similarity(const glm::dmat4& matrix) {
  constexpr double rounding = 1e-5, smallest = 1e-6, largest = 1e6;  // scales, as those of a scene's instances
  const glm::dmat3 linear(matrix), square = glm::transpose(linear) * linear;
  const double size = (square[0][0] + square[1][1] + square[2][2]) / 3;
  if (!(size >= smallest * smallest && size <= largest * largest && glm::determinant(linear) > 0)) return false;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(square[c][r] - (c == r ? size : 0)) <= rounding * size)) return false;
  for (int c = 0; c < 3; ++c)
    if (!(std::abs(matrix[3][c]) <= double{largest_coordinate})) return false;
  return matrix[0][3] == 0 && matrix[1][3] == 0 && matrix[2][3] == 0 && matrix[3][3] == 1;
}

std::string words(AttributeScope scope) {
  static constexpr const char* names[] = {"constant", "uniform", "varying", "vertex"};
  return names[static_cast<std::size_t>(scope)];
}

glm::vec3 clamped_color(glm::vec3 color, std::uint64_t* changed) {
  constexpr float rounding = 1e-4f;  // less than half a step of 12 bits
  bool is_good = true;
  for (int c = 0; c < 3; ++c) {
    is_good = is_good && color[c] >= -rounding && color[c] <= 1 + rounding;
    color[c] = color[c] > 0 ? std::min(color[c], 1.0f) : 0.0f;
  }
  *changed += is_good ? 0 : 1;
  return color;
}

GroomBuilder::GroomBuilder(std::string name, std::string format) : name_(std::move(name)) {
  file_.format = std::move(format);
  file_.first_point.push_back(0);
}

std::optional<Error> GroomBuilder::check(const CurveSet& set) const {
  const auto wrong = [&](std::string expected, std::string found) {
    return Error{name_, set.name, std::move(expected), std::move(found)};
  };
  std::uint64_t vertices = 0;
  for (std::size_t c = 0; c < set.vertex_counts.size(); ++c) {
    const std::uint64_t count = set.vertex_counts[c];
    if (const std::string fault = fault_of(set.kind, count); !fault.empty())
      return wrong(fmt::format("{} vertices in curve {} ({})", fault, c, words(set.kind)), fmt::format("{}", count));
    vertices += count;
  }
  if (vertices != set.vertices.size())
    return wrong(fmt::format("{} vertices, as {} curves have them", vertices, set.vertex_counts.size()),
                 fmt::format("{}", set.vertices.size()));
  return std::nullopt;
}

std::optional<Error> GroomBuilder::check_size(const CurveSet& set) const {
  std::uint64_t points = file_.points.size();
  const StrandBasis drawn = file_.basis.value_or(drawn_as(set.kind));
  for (const std::uint64_t count : set.vertex_counts)
    points += drawn_points(set.kind, drawn == drawn_as(set.kind) ? drawn : StrandBasis::bezier, count);
  if (points <= most_groom_points && file_.strand_count() + set.vertex_counts.size() <= most_groom_points)
    return std::nullopt;
  return Error{name_, set.name, fmt::format("at most {} points in a file", most_groom_points),
               fmt::format("{}", points)};
}

void GroomBuilder::ignore(const std::string& name, const std::string& why) {
  if (ignored_.size() < 200 && ignored_.insert(name).second) file_.ignored.push_back({name, why});
}

namespace {

/// The value of a cubic B-spline with these control points, whose span begins at knot 3, for three arguments at once
/// (its blossom), from which the Bezier points of every span follow.
template <class T>
T blossom(const T* control, const double* knots, const std::array<double, 3>& at) {
  std::array<T, 4> p{control[0], control[1], control[2], control[3]};
  for (std::size_t level = 1; level <= 3; ++level)
    for (std::size_t i = 3; i >= level; --i) {
      const double from = knots[i], to = knots[i + 4 - level];
      const auto share = static_cast<float>(to > from ? (at[level - 1] - from) / (to - from) : 0);
      p[i] = (1 - share) * p[i - 1] + share * p[i];
    }
  return p[3];
}

/// The Bezier points of one curve, span by span; spans without length have none.
template <class T>
void append_by_knots(std::span<const T> control, std::span<const double> knots, std::vector<T>* out) {
  bool is_first = true;
  for (std::size_t i = 3; i < control.size(); ++i) {
    const double a = knots[i], b = knots[i + 1];
    if (!(b > a)) continue;
    const T* from = control.data() + i - 3;
    const double* around = knots.data() + i - 3;
    if (is_first) out->push_back(blossom(from, around, {a, a, a}));
    is_first = false;
    for (const auto& at : {std::array{a, a, b}, std::array{a, b, b}, std::array{b, b, b}})
      out->push_back(blossom(from, around, at));
  }
}

/// All knots of a curve with this number of vertices; empty if they never rise, or fall somewhere.
std::vector<double> whole_knots(std::span<const double> given, std::size_t vertices) {
  std::vector<double> knots(given.begin(), given.end());
  if (knots.size() == vertices + 2) {
    knots.insert(knots.begin(), knots.front());
    knots.push_back(knots.back());
  }
  const bool are_good =
      std::ranges::is_sorted(knots) && std::ranges::all_of(knots, [](double k) { return std::abs(k) < 1e12; });
  if (!are_good || !(knots[3] < knots[vertices])) knots.clear();
  return knots;
}

bool is_uniform(std::span<const double> knots) {
  const double step = knots[1] - knots[0];
  for (std::size_t i = 1; i < knots.size(); ++i)
    if (!(std::abs(knots[i] - knots[i - 1] - step) <= 1e-5 * step)) return false;
  return step > 0;
}

}  // namespace

/// Converts curves with non-uniform knots into Bezier segments. False, with a remark, if the set has no valid knots.
bool GroomBuilder::bend_by_knots(CurveSet* set) {
  if (set->knots.empty() || set->kind.basis != CurveBasis::bspline) return false;
  std::size_t vertices = 0;
  for (const std::uint32_t count : set->vertex_counts) vertices += count;
  const std::size_t curves = set->vertex_counts.size(), more = set->knots.size() == vertices + 2 * curves ? 2 : 4;
  const auto refuse = [&](const char* why) {
    ignore(set->name + ": knots", fmt::format("{}; curves are taken as uniform", why));
    return false;
  };
  if (set->kind.wrap != CurveWrap::nonperiodic) return refuse("they are those of periodic curves");
  if (set->knots.size() != vertices + more * curves || set->vertices.size() != vertices)
    return refuse("their number is not that of the vertices and 4 more a curve");
  std::vector<std::vector<double>> knots;
  bool are_uniform = true;
  std::size_t at = 0;
  for (const std::uint32_t count : set->vertex_counts) {
    if (count < 4) return refuse("a curve has fewer than 4 vertices");
    knots.push_back(whole_knots(std::span(set->knots).subspan(at, count + more), count));
    if (knots.back().empty()) return refuse("they do not rise");
    are_uniform = are_uniform && is_uniform(std::span(knots.back()).subspan(more == 2 ? 1 : 0, count + more));
    at += count + more;
  }
  if (are_uniform) return false;
  const auto bend = [&](auto* values) {
    using T = std::remove_cvref_t<decltype((*values)[0])>;
    if (values->size() != vertices) return;
    std::vector<T> out;
    std::size_t first = 0;
    for (std::size_t c = 0; c < curves; ++c) {
      append_by_knots<T>(std::span<const T>(*values).subspan(first, set->vertex_counts[c]), knots[c], &out);
      first += set->vertex_counts[c];
    }
    *values = std::move(out);
  };
  const auto bend_attribute = [&](auto* attribute) {
    const bool is_vertex = attribute->scope.value_or(AttributeScope::vertex) == AttributeScope::vertex;
    if (is_vertex) bend(&attribute->values);
  };
  bend_attribute(&set->width);
  bend_attribute(&set->color);
  bend_attribute(&set->normal);
  bend(&set->vertices);
  for (std::size_t c = 0; c < curves; ++c) {
    std::uint32_t spans = 0;
    for (std::size_t i = 3; i < set->vertex_counts[c]; ++i) spans += knots[c][i + 1] > knots[c][i] ? 1 : 0;
    set->vertex_counts[c] = 3 * spans + 1;
  }
  set->kind = {CurveBasis::bezier, CurveWrap::nonperiodic};
  set->knots.clear();
  return true;
}

CurveSet part_of(const CurveSet& set, std::span<const unsigned char> keep) {
  CurveSet part;
  part.name = set.name;
  part.kind = set.kind;
  part.to_file = set.to_file;
  std::size_t vertices = 0;
  for (const std::uint32_t count : set.vertex_counts) vertices += count;
  const auto take = [&](const auto& values, auto* out) {
    const bool is_vertex = values.size() == vertices, is_curve = values.size() == set.vertex_counts.size();
    std::size_t first = 0;
    for (std::size_t c = 0; c < set.vertex_counts.size(); ++c) {
      const std::size_t count = set.vertex_counts[c], begin = is_vertex ? first : c, size = is_vertex ? count : 1;
      if (keep[c] && (is_vertex || is_curve))
        out->insert(out->end(), values.begin() + static_cast<std::ptrdiff_t>(begin),
                    values.begin() + static_cast<std::ptrdiff_t>(begin + size));
      first += count;
    }
  };
  const auto take_attribute = [&](const auto& attribute, auto* out) {
    out->name = attribute.name;
    out->scope = attribute.scope;
    if (attribute.values.size() == 1)
      out->values = attribute.values;
    else
      take(attribute.values, &out->values);
  };
  take(set.vertices, &part.vertices);
  take(set.vertex_counts, &part.vertex_counts);
  take_attribute(set.width, &part.width);
  take_attribute(set.color, &part.color);
  take_attribute(set.normal, &part.normal);
  take(set.id, &part.id);
  take(set.root_uv, &part.root_uv);
  return part;
}

/// If this set needs another basis than those before it, all are converted to Bezier segments.
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
  ignore(fmt::format("{}: {}", set.name, attribute),
         fmt::format("{} values, which fit neither its {} vertices nor its {} curves", values, vertices,
                     set.vertex_counts.size()));
  return std::nullopt;
}

/// as_given: whether every vertex is a point that is drawn.
void GroomBuilder::add_widths(CurveSet* given, std::size_t old_points, bool as_given) {
  const CurveSet& set = *given;
  const auto scope = scope_of(set, set.width.values.size(), set.width.scope, set.width.name);
  const double size = std::cbrt(std::abs(glm::determinant(glm::dmat3(set.to_file))));
  std::size_t wrong = 0;
  const auto placed = [&](float width) {
    const double x = width * size;
    if (!(x >= 0)) ++wrong;
    return x >= 0 ? static_cast<float>(std::min(x, double{largest_coordinate})) : 0.0f;  // NaN too
  };
  const bool is_one = !scope || *scope == AttributeScope::constant;
  const float one = !scope ? width_not_said : is_one ? placed(set.width.values[0]) : 0.0f;
  if (file_.points.size() == old_points) return;  // no segment in the set
  const float before = file_.default_width > 0 ? file_.default_width : width_not_said;
  if (is_one && one != 0 && file_.width.empty() && (old_points == 0 || one == before)) {
    file_.default_width = std::max(one, 0.0f);
    return;
  }
  if (as_given && !is_one && *scope == AttributeScope::vertex) {
    file_.width = std::move(given->width.values);
  } else {
    make_room(&file_.width, file_.points.size() - file_.width.size());
    pad(&file_.width, old_points, before);
    if (is_one) return pad(&file_.width, file_.points.size(), one);
    append_attribute<float>(set, *file_.basis, *scope, set.width.values, &file_.width);
  }
  const bool overshoots =
      *scope == AttributeScope::vertex && !as_given;  // smooth widths may pass below 0 by themselves
  for (std::size_t i = old_points; i < file_.width.size(); ++i) file_.width[i] = placed(file_.width[i]);
  if (wrong > 0 && !overshoots)
    ignore(fmt::format("{}: {} of {} widths", set.name, wrong, file_.width.size() - old_points),
           "they are negative or no numbers and taken for 0");
}

void GroomBuilder::add_vectors(const CurveSet& set, const CurveAttribute<glm::vec3>& attribute, std::size_t old_points,
                               bool is_color) {
  std::vector<glm::vec3>& out = is_color ? file_.color : file_.normal;
  const auto scope = scope_of(set, attribute.values.size(), attribute.scope, attribute.name);
  if ((!scope && out.empty()) || file_.points.size() == old_points) return;
  std::uint64_t changed = 0, overshot = 0;
  for (const glm::vec3& color : attribute.values)
    if (is_color) clamped_color(color, &changed);
  if (changed > 0)
    ignore(fmt::format("{}{}{} of {} colors", set.name, set.name.empty() ? "" : ": ", changed, attribute.values.size()),
           why_clamped);
  const glm::vec3 before = is_color ? file_.default_color : glm::vec3(0.0f);
  if (is_color && scope == AttributeScope::constant && out.empty()) {
    const glm::vec3 one = clamped_color(attribute.values[0], &overshot);
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
      out[i] = clamped_color(out[i], &overshot);  // smooth colors may pass beyond by themselves
      continue;
    }
    const glm::dvec3 turned = turn * glm::dvec3(out[i]);
    const double length = glm::length(turned);
    out[i] = length > 0 && std::isfinite(length) ? glm::vec3(turned / length) : glm::vec3(0.0f);
  }
  if (is_color) file_.has_color = true;
}

std::optional<IgnoredAttribute> leave_out_broken(const std::string& set, std::size_t from, GroomFile* file) {
  const auto is_good = [](const glm::vec3& point) {
    return std::abs(point.x) <= largest_coordinate && std::abs(point.y) <= largest_coordinate &&
           std::abs(point.z) <= largest_coordinate;
  };
  const std::size_t before = file->broken.size();
  for (std::size_t s = from; s < file->strand_count(); ++s) {
    const auto begin = file->points.begin() + file->first_point[s],
               end = file->points.begin() + file->first_point[s + 1];
    if (std::all_of(begin, end, is_good)) continue;
    const auto any = std::ranges::find_if(file->points, is_good);
    std::fill(begin, end, any == file->points.end() ? glm::vec3(0.0f) : *any);
    file->broken.push_back(static_cast<std::uint32_t>(s));
  }
  if (file->broken.size() == before) return std::nullopt;
  return IgnoredAttribute{
      fmt::format("{}{} of {} strands, the first {}", set.empty() ? "" : set + ": ", file->broken.size() - before,
                  file->strand_count() - from, file->broken[before] - from),
      fmt::format("they have points that are not finite and within {:g}", largest_coordinate)};
}

void GroomBuilder::place(const CurveSet& set, std::size_t old_points, std::size_t old_strands) {
  const glm::dvec3 origin = is_in_prototype() ? glm::dvec3(0.0) : file_.origin;  // that of a prototype is its own
  const bool moves = set.to_file != glm::dmat4(1.0) || origin != glm::dvec3(0.0);
  for (std::size_t i = old_points; moves && i < file_.points.size(); ++i) {
    glm::vec3& point = file_.points[i];
    const glm::dvec3 placed = glm::dvec3(set.to_file * glm::dvec4(glm::dvec3(point), 1.0)) - origin;
    for (int c = 0; c < 3; ++c) point[c] = to_float(placed[c]);
  }
  if (const auto broken = leave_out_broken(set.name, old_strands, &file_)) ignore(broken->name, broken->why);
}

std::optional<Error> GroomBuilder::add(CurveSet set) {
  bend_by_knots(&set);
  if (auto fault = check(set)) {
    ignore(set.name, fmt::format("expected {}, found {}", fault->expected, fault->found));
    if (!fault_) fault_ = std::move(fault);
    return std::nullopt;
  }
  if (auto error = check_size(set)) return error;
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
  if (is_in_prototype()) extend_run(old_strands);
  const bool as_given = old_points == 0 && points == set.vertices.size() && set.kind.wrap != CurveWrap::periodic &&
                        *file_.basis == drawn_as(set.kind) && *file_.basis != StrandBasis::bezier;
  if (as_given) {
    file_.points = std::move(set.vertices);
  } else {
    make_room(&file_.points, points);
    append_attribute<glm::vec3>(set, *file_.basis, AttributeScope::vertex, set.vertices, &file_.points);
  }
  place(set, old_points, old_strands);
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

void GroomBuilder::extend_run(std::size_t old_strands) {
  if (!std::exchange(is_run_open_, true)) {
    open_.back().push_back({runs_.size(), glm::dmat4(1.0)});
    runs_.push_back({old_strands, 0, file_.parts.size() - 1, 0});
  }
  runs_.back().end = file_.strand_count();
  runs_.back().end_part = file_.parts.size();
}

void GroomBuilder::begin_prototype() {
  is_run_open_ = false;
  open_.emplace_back();
}

std::size_t GroomBuilder::end_prototype() {
  is_run_open_ = false;
  prototypes_.push_back(std::move(open_.back()));
  open_.pop_back();
  return prototypes_.size() - 1;
}

bool GroomBuilder::can_share(const glm::dmat4& to_parent) {
  if (is_similarity(to_parent)) return true;
  if (!std::exchange(has_copies_, true))
    file_.remarks.emplace_back("instances that are mirrored, or stretched unevenly, are copies of their strands");
  return false;
}

std::optional<Error> GroomBuilder::add_instance(std::size_t prototype, const glm::dmat4& to_parent) {
  is_run_open_ = false;
  for (const Drawn& drawn : prototypes_[prototype]) {
    if (++instances_ > most_instances)
      return Error{name_, "instances", fmt::format("at most {} in a file", most_instances), "more"};
    open_.back().push_back({drawn.run, to_parent * drawn.place});
  }
  return std::nullopt;
}

Result<GroomFile> GroomBuilder::finish() {
  constexpr std::size_t most_named = 5;
  for (const Run& run : runs_)
    file_.shared.push_back({static_cast<std::uint32_t>(run.first), static_cast<std::uint32_t>(run.end)});
  for (const Drawn& drawn : open_.front()) file_.shared[drawn.run].places.push_back({drawn.place});
  for (std::size_t i = 0; i < runs_.size(); ++i)
    for (std::size_t part = runs_[i].first_part; part < runs_[i].end_part; ++part)
      file_.parts[part].instances = file_.shared[i].places.size();
  if (file_.strand_count() > 0 && file_.broken.size() < file_.strand_count()) return std::move(file_);
  if (fault_) return *fault_;
  std::string found = file_.strand_count() > 0 ? "none that can be drawn" : "none";
  for (std::size_t i = 0; i < std::min(file_.ignored.size(), most_named); ++i)
    found += fmt::format("{} {} ({})", i == 0 ? "; not used:" : ",", file_.ignored[i].name, file_.ignored[i].why);
  if (file_.ignored.size() > most_named) found += fmt::format(" and {} more", file_.ignored.size() - most_named);
  return Error{name_, "", "curves", found};
}

}  // namespace tress::scene
