#include "scene/read/grooms/given_basis.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace tress::scene {
namespace {

struct NamedKind {
  const char* name;
  CurveKind kind;
};

constexpr NamedKind named_kinds[] = {{"bspline", {CurveBasis::bspline, CurveWrap::pinned}},
                                     {"linear", {CurveBasis::linear, CurveWrap::nonperiodic}},
                                     {"catmull_rom", {CurveBasis::catmull_rom, CurveWrap::pinned}},
                                     {"clamped_catmull_rom", {CurveBasis::catmull_rom, CurveWrap::repeated}},
                                     {"open_bspline", {CurveBasis::bspline, CurveWrap::nonperiodic}},
                                     {"open_catmull_rom", {CurveBasis::catmull_rom, CurveWrap::nonperiodic}},
                                     {"bezier", {CurveBasis::bezier, CurveWrap::nonperiodic}},
                                     {"hermite", {CurveBasis::hermite, CurveWrap::nonperiodic}}};

/// Where drawn strands begin, and the attributes of their points.
class Redrawn {
 public:
  Redrawn(const CurveKind& kind, std::vector<std::uint32_t>* first_point) : kind_(kind), given_(*first_point) {
    std::vector<std::uint32_t>& first = *first_point;
    for (std::size_t s = 0; s + 1 < given_.size(); ++s)
      first[s + 1] =
          first[s] + static_cast<std::uint32_t>(drawn_points(kind, drawn_as(kind), given_[s + 1] - given_[s]));
  }

  /// Converts values per point; others stay.
  template <class T>
  void operator()(std::vector<T>* values) const {
    if (values->size() != given_.back()) return;
    std::vector<T> out;
    for (std::size_t s = 0; s + 1 < given_.size(); ++s)
      append_vertex_values<T>(kind_, drawn_as(kind_),
                              std::span<const T>(*values).subspan(given_[s], given_[s + 1] - given_[s]), &out);
    *values = std::move(out);
  }

 private:
  CurveKind kind_;
  std::vector<std::uint32_t> given_;
};

/// Whether such strands are drawn by exactly the points that they have.
bool is_drawn_as_given(const CurveKind& kind, const std::vector<std::uint32_t>& first_point) {
  for (std::size_t s = 0; s + 1 < first_point.size(); ++s) {
    const std::uint32_t count = first_point[s + 1] - first_point[s];
    if (drawn_points(kind, drawn_as(kind), count) != count && count > 1) return false;
  }
  return kind.basis != CurveBasis::catmull_rom && kind.basis != CurveBasis::hermite;
}

}  // namespace

const std::vector<std::string>& basis_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedKind& named : named_kinds) all.emplace_back(named.name);
    return all;
  }();
  return names;
}

CurveKind kind_of_basis(const std::string& name) {
  return std::ranges::find(named_kinds, name, &NamedKind::name)->kind;
}

std::optional<Error> take_points_as(const CurveKind& kind, const std::string& name, GroomFile* file) {
  std::uint64_t points = 0;
  for (std::size_t s = 0; s < file->strand_count(); ++s) {
    const std::uint32_t count = file->first_point[s + 1] - file->first_point[s];
    points += drawn_points(kind, drawn_as(kind), count);
    if (const std::string fault = fault_of(kind, count); !fault.empty())
      return Error{name, fmt::format("strand {}", s), fmt::format("{} points, as {} has them", fault, words(kind)),
                   fmt::format("{}", count)};
  }
  if (points > most_groom_points)
    return Error{name, "points", fmt::format("at most {} once they are drawn", most_groom_points),
                 fmt::format("{}", points)};
  file->basis = drawn_as(kind);
  if (is_drawn_as_given(kind, file->first_point)) return std::nullopt;
  const Redrawn redrawn(kind, &file->first_point);
  for (std::vector<glm::vec3>& later : file->later) redrawn(&later);
  if (file->color.size() == file->points.size()) redrawn(&file->color);
  redrawn(&file->normal);
  file->later_width.push_back(std::move(file->width));
  for (std::vector<float>& widths : file->later_width) {
    redrawn(&widths);
    for (float& width : widths) width = std::max(width, 0.0f);
  }
  file->width = std::move(file->later_width.back());
  file->later_width.pop_back();
  for (glm::vec3& color : file->color)
    for (int c = 0; c < 3; ++c) color[c] = std::clamp(color[c], 0.0f, 1.0f);
  redrawn(&file->points);
  return std::nullopt;
}

void take_points_as(const CurveKind& kind, Groom* groom) {
  groom->basis = drawn_as(kind);
  if (is_drawn_as_given(kind, groom->first_point)) return;
  const Redrawn redrawn(kind, &groom->first_point);
  redrawn(&groom->points);
  redrawn(&groom->radius_cm);
  for (float& radius : groom->radius_cm) radius = std::max(radius, 0.0f);
}

}  // namespace tress::scene
