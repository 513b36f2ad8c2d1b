#include "scene/read/assembly.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_double4x4.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "scene/model/framed_points.h"
#include "scene/model/groom_bounds.h"
#include "scene/model/parameters.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/shared_strands.h"

namespace tress::scene {
namespace {

constexpr CurveKind usual_basis{CurveBasis::bspline, CurveWrap::pinned};

/// Advice for the user about the axis that was assumed to be up.
std::string up_note(const std::string& name, const GroomPlacement& placement, bool falls) {
  if (placement.guess_up)
    return fmt::format("{}: {} taken for up, by how the strands fall; --up {} if it lies on its side", name,
                       falls ? "y" : "z", falls ? "z" : "y");
  return fmt::format("{}: z taken for up, but the strands fall along y; --up y or \"up\": \"y\" turns them", name);
}

}  // namespace

bool falls_along_y(const GroomFile& hair) {
  constexpr double least_fall = 0.1;
  glm::dvec3 fall(0.0);
  double strands = 0;
  auto shared = hair.shared.begin();
  for (std::size_t s = 0; s + 1 < hair.first_point.size(); ++s) {
    while (shared != hair.shared.end() && s >= shared->end) ++shared;
    double length = 0;
    for (std::uint32_t i = hair.first_point[s] + 1; i < hair.first_point[s + 1]; ++i)
      length += glm::distance(glm::dvec3(hair.points[i - 1]), glm::dvec3(hair.points[i]));
    if (!(length > 0)) continue;
    const glm::dvec3 root(hair.points[hair.first_point[s]]), tip(hair.points[hair.first_point[s + 1] - 1]);
    const glm::dvec3 way = (tip - root) / length;
    if (shared == hair.shared.end() || s < shared->first) {
      fall += way;
      ++strands;
      continue;
    }
    for (const std::vector<glm::dmat4>& place : shared->places) {
      const glm::dmat3 linear(place.front());
      fall += linear * way / std::cbrt(glm::determinant(linear));
      ++strands;
    }
  }
  return fall.y < -least_fall * strands && fall.y < 2 * fall.z;
}

std::optional<WidthUse> width_use_of(std::string_view text) {
  if (text == "file") return WidthUse{WidthUse::Kind::file};
  if (text == "clamp") return WidthUse{WidthUse::Kind::clamp};
  constexpr std::string_view scale = "scale=";
  if (!text.starts_with(scale)) return std::nullopt;
  WidthUse use{WidthUse::Kind::file};
  const auto [end, fault] = std::from_chars(text.data() + scale.size(), text.data() + text.size(), use.scale);
  const bool is_number = fault == std::errc() && end == text.data() + text.size();
  return is_number && use.scale > 0 && use.scale <= 1e6 ? std::optional(use) : std::nullopt;
}

float WidthPlan::radius_of(float width) const {
  if (width < 0) return usual_radius_cm;  // the width is not given
  const double radius = double{width} / 2 * cm_per_unit;
  return static_cast<float>(clamps && radius > 0 ? std::clamp(radius, smallest_radius_cm, largest_radius_cm) : radius);
}

WidthPlan plan_widths(const GroomFile& file, const WidthUse& use, double cm_per_unit, bool is_unit_said) {
  constexpr std::size_t most_looked_at = 100'000;
  WidthPlan plan{.cm_per_unit = use.scale * cm_per_unit, .clamps = use.kind == WidthUse::Kind::clamp};
  std::vector<float> some;
  const std::size_t step = file.width.size() / most_looked_at + 1;
  for (std::size_t i = 0; i < file.width.size(); i += step)
    if (file.width[i] > 0) some.push_back(file.width[i]);
  if (file.width.empty() && file.default_width > 0) some.push_back(file.default_width);
  if (some.empty()) {
    plan.are_used = !file.width.empty();
    return plan;
  }
  const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
  std::ranges::nth_element(some, middle);
  plan.typical_radius_cm = double{*middle} / 2 * plan.cm_per_unit;
  constexpr double rounding = 1e-6;
  const bool is_of_hair = plan.typical_radius_cm >= smallest_radius_cm * (1 - rounding) &&
                          plan.typical_radius_cm <= largest_radius_cm * (1 + rounding);
  plan.are_used = is_unit_said || is_of_hair || use.kind != WidthUse::Kind::usual;
  return plan;
}

void say_widths(GroomFile* file) {
  const double usual = 2 * usual_radius_cm / file->cm_per_unit.value_or(1);
  std::ranges::replace_if(file->width, [](float width) { return width < 0; }, to_float(usual));
}

namespace {

/// Adds notes of the file about its materials, which the scene's replace.
void note_materials(const GroomFile& file, const std::string& name, std::vector<std::string>* notes) {
  constexpr std::size_t most_named = 3;
  for (std::size_t i = 0; i < std::min(file.materials.size(), most_named); ++i)
    notes->push_back(fmt::format("{}: material of the file, not used: {}", name, file.materials[i]));
  if (file.materials.size() > most_named)
    notes->push_back(fmt::format("{}: {} more materials of the file, not used: tress info lists them", name,
                                 file.materials.size() - most_named));
}

/// The largest absolute coordinate.
double extent_of(const std::vector<glm::vec3>& points) {
  double extent = 0;
  for (const glm::vec3& p : points)
    extent = std::max({extent, std::abs(double{p.x}), std::abs(double{p.y}), std::abs(double{p.z})});
  return extent;
}

struct Scale {
  double cm_per_unit = 1;
  std::optional<Error> error = {};
};

/// The given unit, or the file's, or one that gives the groom a usual size. The file has its basis.
Scale scale_of(const GroomFile& file, const GroomPlacement& placement, const std::string& name,
               std::vector<std::string>* notes, std::vector<std::string>* warnings) {
  Scale scale;
  if (const auto stray = stray_strands(file.first_point, file.points); !stray.empty())
    warnings->push_back(fmt::format(
        "{}: {} of {} strands lie far from all others (strand {} is the first): neither the unit nor the automatic "
        "camera goes by them",
        name, stray.size(), file.strand_count(), stray.front()));
  if (placement.cm_per_unit || file.cm_per_unit) {
    scale.cm_per_unit = placement.cm_per_unit ? *placement.cm_per_unit : *file.cm_per_unit;
  } else if (placement.usual_cm_per_unit) {
    scale.cm_per_unit = *placement.usual_cm_per_unit;
    notes->push_back(
        fmt::format("{}: no unit given, {:g} cm taken for one, as for all parts of a folder", name, scale.cm_per_unit));
  } else if (const auto box = box_of_instances(file, *file.basis); box && box->longest_side() > 0) {
    const double longest = box->longest_side();
    scale.cm_per_unit = usual_longest_side_cm / longest;
    notes->push_back(fmt::format("{}: no unit given, longest side {:g} units taken for {:g} cm ({:g} cm per unit)",
                                 name, longest, usual_longest_side_cm, scale.cm_per_unit));
  }
  double extent = extent_of(file.points);
  for (const std::vector<glm::vec3>& points : file.later) extent = std::max(extent, extent_of(points));
  if (!file.points.empty() && !(extent * scale.cm_per_unit <= world_cm))
    scale.error = Error{name, "points", fmt::format("coordinates within {:g} cm", world_cm),
                        fmt::format("{:g} cm at {:g} cm per unit", extent * scale.cm_per_unit, scale.cm_per_unit)};
  return scale;
}

/// Radii at the points: one for all, if it was given or the file's widths are not used. Widths of later moments become
/// radii, or are dropped if the file's are not used.
std::vector<float> radii_of(GroomFile* file, const GroomPlacement& placement, double scale, const std::string& name,
                            std::vector<std::string>* notes) {
  const bool is_unit_said = placement.cm_per_unit || file->cm_per_unit;
  const WidthPlan plan = plan_widths(*file, placement.widths, scale, is_unit_said);
  const bool use_file = !placement.radius_cm && plan.are_used, has_widths = plan.typical_radius_cm > 0;
  if (!placement.radius_cm && !use_file)
    notes->push_back(
        has_widths ? fmt::format("{}: widths of the file give a radius of {:g} cm in a unit that is guessed, {:g} cm "
                                 "used; --widths file takes them as they are",
                                 name, plan.typical_radius_cm, usual_radius_cm)
                   : fmt::format("{}: no thickness in the file, radius {:g} cm used", name, usual_radius_cm));
  if (!use_file || file->width.empty()) {
    file->later_width.clear();
    return std::vector<float>(file->points.size(),
                              use_file ? plan.radius_of(file->default_width)
                                       : static_cast<float>(placement.radius_cm.value_or(usual_radius_cm)));
  }
  for (float& width : file->width) width = plan.radius_of(width);
  for (std::vector<float>& widths : file->later_width)
    for (float& width : widths) width = plan.radius_of(width);
  return std::move(file->width);
}

/// Moves the strands that are kept to the front, in place. If the basis allows it, a point that equals the one before
/// at every moment is removed. Strands in a single place, or with width 0 everywhere, are removed. Colors stay at
/// points if they differ along a kept strand. set: per strand, or empty.
struct LeftOut {
  std::size_t degenerate = 0, hidden = 0;
};
LeftOut compact(bool repeats_stay, const std::vector<std::uint32_t>& broken, Groom* groom,
                std::vector<glm::vec3>* color, std::vector<std::uint32_t>* set) {
  std::vector<std::vector<glm::vec3>*> moments{&groom->points};
  for (StrandMoment& moment : groom->later) moments.push_back(&moment.points);
  const auto differ = [&](std::size_t a, std::size_t b) {
    return std::ranges::any_of(moments, [&](const auto* points) { return (*points)[a] != (*points)[b]; });
  };
  const bool color_a_point = color->size() == groom->points.size();
  std::vector<std::vector<float>*> radii{&groom->radius_cm};
  for (StrandMoment& moment : groom->later)
    if (!moment.radius_cm.empty()) radii.push_back(&moment.radius_cm);
  std::size_t kept_points = 0, kept_strands = 0, begin = 0;
  const std::size_t strands = groom->first_point.size() - 1;
  LeftOut left_out;
  std::vector<glm::vec3> mean;
  if (!color->empty()) mean.reserve(strands);
  bool color_varies = false;
  for (std::size_t s = 0; s < strands; ++s) {
    const std::size_t end = groom->first_point[s + 1], start = kept_points;
    glm::vec3 sum(0.0f);
    bool has_length = false, is_seen = false, has_colors = false;
    for (std::size_t i = begin; i < end; ++i) {
      const bool moves = kept_points > start && differ(i, kept_points - 1);
      has_length = has_length || moves;
      if (kept_points > start && !moves && !repeats_stay) continue;
      if (!color->empty()) sum += (*color)[color_a_point ? i : s];
      if (color_a_point) {
        (*color)[kept_points] = (*color)[i];
        has_colors = has_colors || (*color)[kept_points] != (*color)[start];
      }
      for (auto* points : moments) (*points)[kept_points] = (*points)[i];
      if (!groom->minor_axis.empty()) groom->minor_axis[kept_points] = groom->minor_axis[i];
      for (auto* radius : radii) {
        (*radius)[kept_points] = (*radius)[i];
        is_seen = is_seen || (*radius)[i] > 0;
      }
      ++kept_points;
    }
    begin = end;
    if (std::ranges::binary_search(broken, static_cast<std::uint32_t>(s))) has_length = false;
    if (!has_length || !is_seen) {
      ++(has_length ? left_out.hidden : left_out.degenerate);
      kept_points = start;
      continue;
    }
    if (!color->empty()) mean.push_back(sum / static_cast<float>(kept_points - start));
    if (!groom->id.empty()) groom->id[kept_strands] = groom->id[s];
    if (!groom->root_uv.empty()) groom->root_uv[kept_strands] = groom->root_uv[s];
    if (!set->empty()) (*set)[kept_strands] = (*set)[s];
    color_varies = color_varies || has_colors;
    groom->first_point[++kept_strands] = static_cast<std::uint32_t>(kept_points);
  }
  for (auto* points : moments) points->resize(kept_points);
  for (auto* radius : radii) radius->resize(kept_points);
  if (!groom->minor_axis.empty()) groom->minor_axis.resize(kept_points);
  groom->first_point.resize(kept_strands + 1);
  if (!groom->id.empty()) groom->id.resize(kept_strands);
  if (!groom->root_uv.empty()) groom->root_uv.resize(kept_strands);
  if (!set->empty()) set->resize(kept_strands);
  color->resize(color_varies ? kept_points : 0);
  groom->color = color_varies ? std::move(*color) : std::move(mean);
  return left_out;
}

/// The error if the curves do not have an attribute that a material names.
std::optional<Error> fault_of_attribute(const GroomFile& file, const std::string& attribute, const std::string& name) {
  constexpr std::size_t most_named = 12;
  if (attribute.empty() || (file.has_color && file.attribute == attribute)) return std::nullopt;
  std::vector<std::string> others;
  if (file.has_color && file.attribute != attribute) others.push_back(file.attribute);
  for (const IgnoredAttribute& ignored : file.ignored)
    if (others.size() < most_named) others.push_back(ignored.name);
  return Error{name, fmt::format("attribute \"{}\"", attribute), "one of the curves, of one or three numbers",
               others.empty() ? "no other that is not used for something else"
                              : fmt::format("beside what is used: {}", fmt::join(others, ", "))};
}

}  // namespace

Result<Groom> assemble_groom(GroomFile file, const GroomPlacement& placement, const std::string& name,
                             std::vector<std::string>* notes, std::vector<std::string>* warnings,
                             FileInstances* instances) {
  settle(&file);
  const bool says_basis = file.basis.has_value();
  if (!says_basis)
    if (auto error = take_points_as(placement.basis.value_or(usual_basis), name, &file)) return *error;
  if (placement.strict && !file.ignored.empty())
    return Error{name, "--strict", "a file of which everything is used",
                 fmt::format("{} ({}){}", file.ignored[0].name, file.ignored[0].why,
                             file.ignored.size() > 1 ? fmt::format(" and {} more", file.ignored.size() - 1) : "")};
  if (auto error = fault_of_attribute(file, placement.attribute, name)) return *error;
  const Scale scale = scale_of(file, placement, name, notes, warnings);
  if (scale.error) return *scale.error;
  const bool is_said = placement.y_up || file.y_up, falls = !is_said && falls_along_y(file),
             y_up = placement.y_up ? *placement.y_up : file.y_up.value_or(placement.guess_up && falls);
  if (!is_said && (placement.guess_up || falls)) notes->push_back(up_note(name, placement, falls));
  for (const std::string& remark : file.remarks) notes->push_back(name + ": " + remark);
  note_materials(file, name, notes);
  for (const IgnoredAttribute& ignored : file.ignored)
    notes->push_back(fmt::format("{}: not used: {} ({})", name, ignored.name, ignored.why));
  Groom groom;
  groom.name = name;
  if (says_basis && placement.basis)
    notes->push_back(name + ": \"basis\" is not used, the file says what its points are");
  groom.basis = *file.basis;
  groom.radius_cm = radii_of(&file, placement, scale.cm_per_unit, name, notes);
  const auto turned = [&]<class Vector>(const Vector& x) { return y_up ? Vector(x.x, -x.z, x.y) : x; };
  const auto placed = [&](std::vector<glm::vec3>& points) {
    for (glm::vec3& point : points) point = turned(static_cast<float>(scale.cm_per_unit) * point);
    return std::move(points);
  };
  groom.is_animated = file.is_animated;
  groom.origin = turned(scale.cm_per_unit * file.origin);
  groom.first_point = std::move(file.first_point);
  groom.points = placed(file.points);
  for (std::vector<glm::vec3>& points : file.later) groom.later.push_back({placed(points)});
  for (std::size_t i = 0; i < file.later_width.size(); ++i) groom.later[i].radius_cm = std::move(file.later_width[i]);
  if (placement.normals && !file.normal.empty()) {
    notes->push_back(name +
                     ": normals of the file give the minor axes of the fibers; \"normals\": false leaves them out");
    groom.minor_axis = std::move(file.normal);
    for (glm::vec3& axis : groom.minor_axis) axis = turned(axis);
  }
  if (file.id.size() == groom.strand_count()) groom.id = std::move(file.id);
  if (file.root_uv.size() == groom.strand_count()) groom.root_uv = std::move(file.root_uv);
  if (placement.colors && file.color.empty()) file.color.assign(groom.strand_count(), file.default_color);
  if (!placement.colors) file.color.clear();
  const std::size_t strands = groom.strand_count();
  FileInstances shared;
  if (!file.shared.empty()) shared.set.assign(strands, 0);
  const glm::dmat4 to_world =
      glm::scale(y_up ? glm::dmat4({1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}) : glm::dmat4(1.0),
                 glm::dvec3(scale.cm_per_unit));
  const glm::dmat4 to_file = glm::inverse(to_world);
  for (SharedStrands& each : file.shared) {
    std::fill(shared.set.begin() + each.first, shared.set.begin() + each.end, shared.places.size() + 1);
    for (std::vector<glm::dmat4>& moments : each.places)
      for (glm::dmat4& place : moments) place = to_world * place * to_file;
    shared.places.push_back(std::move(each.places));
  }
  const bool repeats_stay = groom.basis != StrandBasis::linear;  // a repeated control point makes a corner
  const LeftOut left_out = compact(repeats_stay, file.broken, &groom, &file.color, &shared.set);
  if (left_out.degenerate > 0)
    warnings->push_back(fmt::format(
        "{}: {} of {} strands are degenerate (one point, no length or a point that is not finite) and left out", name,
        left_out.degenerate, strands));
  if (left_out.hidden > 0)
    notes->push_back(fmt::format("{}: {} of {} strands are hidden, their width is 0", name, left_out.hidden, strands));
  if (instances != nullptr) *instances = std::move(shared);
  return groom;
}

glm::dmat3 ObjectTransform::turn() const {
  glm::dmat4 turn(1.0);
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 about(0.0);
    about[axis] = 1;
    turn = glm::rotate(glm::dmat4(1.0), double{rotate_deg[axis]} * std::numbers::pi / 180, about) * turn;
  }
  return glm::dmat3(turn);
}

glm::dmat4 ObjectTransform::matrix() const {
  glm::dmat4 matrix(scale * turn());
  matrix[3] = glm::dvec4(glm::dvec3(translate) - origin, 1);
  return matrix;
}

ObjectTransform ObjectPath::at(double frame) const {
  if (keys.empty()) return still;
  const auto next = std::ranges::find_if(keys, [frame](const TransformKey& key) { return key.frame >= frame; });
  if (next == keys.end()) return keys.back().transform;
  if (next == keys.begin() || next->frame == frame) return next->transform;
  const TransformKey& before = *(next - 1);
  const double t = (frame - before.frame) / (double(next->frame) - before.frame);
  const ObjectTransform &a = before.transform, &b = next->transform;
  const auto share = static_cast<float>(t);
  return {a.scale + t * (b.scale - a.scale), a.rotate_deg + share * (b.rotate_deg - a.rotate_deg),
          a.translate + share * (b.translate - a.translate)};
}

namespace {

/// A coordinate outside of the world; empty if all are inside.
std::optional<double> beyond_world(const glm::dvec3& point) {
  for (int c = 0; c < 3; ++c)
    if (!(std::abs(point[c]) <= world_cm)) return point[c];
  return std::nullopt;
}

/// from: has been subtracted from the points.
std::optional<Error> move_points(const ObjectTransform& transform, const glm::dvec3& from, const std::string& name,
                                 std::vector<glm::vec3>* points) {
  if (transform == ObjectTransform{} && from == glm::dvec3(0.0)) return std::nullopt;
  const glm::dmat3 turn = transform.turn();
  for (glm::vec3& point : *points) {
    const glm::dvec3 placed = transform.of(glm::dvec3(point) + from, turn);
    if (const auto beyond = beyond_world(placed))
      return Error{name, "points", fmt::format("coordinates within {:g} cm", world_cm),
                   fmt::format("{:g} cm once it is scaled, turned and moved", *beyond)};
    point = glm::vec3(placed);
  }
  return std::nullopt;
}

/// The points of a mesh in world coordinates.
Result<std::vector<glm::vec3>> placed_positions(const MeshAtMoment& moment, const MeshDescription& description,
                                                const std::string& name) {
  const glm::dmat3 turn = moment.transform.turn();
  std::vector<glm::vec3> positions;
  positions.reserve(moment.file->positions.size());
  for (const auto& p : moment.file->positions) {
    const glm::dvec3 raised = description.y_up ? glm::dvec3(p.x, -p.z, p.y) : glm::dvec3(p);
    const glm::dvec3 placed = moment.transform.of(raised * description.cm_per_unit, turn);
    if (const auto beyond = beyond_world(placed))
      return Error{name, fmt::format("vertex {}", positions.size() + 1),
                   fmt::format("coordinates within {:g} cm", world_cm),
                   fmt::format("{:g} cm at {:g} cm per unit", *beyond, description.cm_per_unit)};
    positions.emplace_back(placed);
  }
  return positions;
}

std::vector<glm::vec3> placed_normals(const MeshAtMoment& moment, const MeshDescription& description) {
  const glm::dmat3 turn = moment.transform.turn();
  std::vector<glm::vec3> normals;
  normals.reserve(moment.file->normals.size());
  for (const auto& n : moment.file->normals) {
    const glm::dvec3 turned = turn * (description.y_up ? glm::dvec3(n.x, -n.z, n.y) : glm::dvec3(n));
    const double length = glm::length(turned);
    normals.emplace_back(length > 0 ? turned / length : glm::dvec3(0.0));
  }
  return normals;
}

float scaled_radius(float radius, double factor) { return static_cast<float>(factor * double{radius}); }

/// Multiplies radii by the scale of each moment.
void scale_radii(std::span<const ObjectTransform> moments, Groom* groom) {
  const double first = moments.front().scale;
  const bool differ = std::ranges::any_of(moments, [&](const ObjectTransform& each) { return each.scale != first; });
  for (std::size_t i = 0; i < groom->later.size(); ++i) {
    std::vector<float>& radii = groom->later[i].radius_cm;
    if (differ && radii.empty()) radii = groom->radius_cm;
    const double scale = moments[std::min(i + 1, moments.size() - 1)].scale;
    for (float& radius : radii)
      if (scale != 1) radius = scaled_radius(radius, scale);
  }
  for (float& radius : groom->radius_cm)
    if (first != 1) radius = scaled_radius(radius, first);
}

}  // namespace

std::optional<Error> move_groom(std::span<const ObjectTransform> moments, Groom* groom) {
  const ObjectTransform& first = moments.front();
  const bool moves = std::ranges::any_of(moments, [&](const ObjectTransform& moment) { return moment != first; });
  if (moves && groom->later.empty()) groom->later.assign(moments.size() - 1, {groom->points});
  for (std::size_t i = 0; i < groom->later.size(); ++i) {
    const ObjectTransform& then = moments[std::min(i + 1, moments.size() - 1)];
    if (auto error = move_points(then, groom->origin, groom->name, &groom->later[i].points)) return error;
    groom->later[i].turned = then.turn() * glm::transpose(first.turn());
  }
  if (auto error = move_points(first, groom->origin, groom->name, &groom->points)) return error;
  groom->origin = glm::dvec3(0.0);
  const glm::dmat3 turn = first.turn();
  for (glm::vec3& axis : groom->minor_axis) axis = glm::vec3(turn * glm::dvec3(axis));
  scale_radii(moments, groom);
  return std::nullopt;
}

std::optional<Error> add_instances(std::span<const std::vector<glm::dmat4>> instances, const glm::dvec3& origin,
                                   Groom* groom) {
  const auto place_of = [](const glm::dmat4& place) {
    const glm::dmat3 linear(place);
    const glm::dvec3 x = glm::normalize(linear[0]), y = glm::normalize(linear[1] - glm::dot(linear[1], x) * x);
    return Similarity{glm::mat3(glm::dmat3(x, y, glm::cross(x, y))),
                      static_cast<float>(std::cbrt(glm::determinant(linear))), glm::vec3(place[3])};
  };
  groom->instances.reserve(instances.size());
  for (const std::vector<glm::dmat4>& moments : instances) {
    Instance& instance = groom->instances.emplace_back(Instance{place_of(moments.front())});
    if (std::ranges::all_of(moments, [&](const glm::dmat4& moment) { return moment == moments.front(); })) continue;
    for (const glm::dmat4& moment : std::span(moments).subspan(1)) instance.later.push_back(place_of(moment));
  }
  std::optional<double> beyond;
  if (!instances.empty())
    for_each_bounding_point(*groom, [&](const glm::vec3& point) {
      if (!beyond) beyond = beyond_world(glm::dvec3(point) + origin);
    });
  if (!beyond) return std::nullopt;
  return Error{groom->name, "instances", fmt::format("coordinates within {:g} cm", world_cm),
               fmt::format("{:g} cm once an instance is scaled, turned and moved", *beyond)};
}

std::optional<Error> move_light(std::span<const ObjectTransform> moments, const std::string& name,
                                const std::string& place, Light* light) {
  std::vector<LightShape> shapes;
  for (const ObjectTransform& transform : moments) {
    LightShape& shape = shapes.emplace_back(*light);
    if (transform == ObjectTransform{}) continue;
    const glm::dmat3 turn = transform.turn();
    const glm::dvec3 center = transform.of(glm::dvec3(shape.center), turn);
    if (const auto beyond = beyond_world(center))
      return Error{name, place, fmt::format("a light within {:g} cm", world_cm),
                   fmt::format("{:g} cm once it is scaled, turned and moved", *beyond)};
    shape.center = glm::vec3(center);
    shape.direction = glm::vec3(glm::normalize(turn * glm::dvec3(shape.direction)));
    shape.radius_cm = static_cast<float>(double{shape.radius_cm} * transform.scale);
    shape.edge_u = glm::vec3(turn * (transform.scale * glm::dvec3(shape.edge_u)));
    shape.edge_v = glm::vec3(turn * (transform.scale * glm::dvec3(shape.edge_v)));
  }
  static_cast<LightShape&>(*light) = shapes.front();
  const bool moves = std::ranges::any_of(moments, [&](const ObjectTransform& each) { return each != moments.front(); });
  if (moves) light->later.assign(shapes.begin() + 1, shapes.end());
  return std::nullopt;
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
      groom->radius_cm[i] = scaled_radius(groom->radius_cm[i], factor);
      for (StrandMoment& moment : groom->later)
        if (!moment.radius_cm.empty()) moment.radius_cm[i] = scaled_radius(moment.radius_cm[i], factor);
    }
  }
}

Result<Mesh> place_mesh(std::span<const MeshAtMoment> moments, const MeshDescription& description,
                        const std::string& name, std::vector<std::string>* warnings) {
  const ObjFile& file = *moments.front().file;
  Mesh mesh;
  mesh.name = name;
  mesh.albedo = description.albedo;
  mesh.coat = description.coat;
  mesh.uvs = file.uvs;
  mesh.visibility = description.visibility;
  mesh.holdout = description.holdout;
  const bool moves = std::ranges::any_of(moments, [&](const MeshAtMoment& moment) {
    return moment.file != &file || moment.transform != moments.front().transform;
  });
  for (const MeshAtMoment& moment : moves ? moments : moments.first(1)) {
    auto positions = placed_positions(moment, description, name);
    if (!positions) return positions.error();
    if (&moment == moments.data()) {
      mesh.positions = std::move(*positions);
      mesh.normals = placed_normals(moment, description);
    } else {
      mesh.later.push_back({std::move(*positions), placed_normals(moment, description)});
    }
  }
  mesh.triangles.reserve(file.triangles.size());
  for (std::size_t i = 0; i < file.triangles.size(); ++i) {
    const glm::uvec3 t = file.triangles[i];
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    if (!(glm::length(glm::cross(b - a, c - a)) > 0)) continue;
    mesh.triangles.push_back(t);
    if (!file.corner_normals.empty()) mesh.corner_normals.push_back(file.corner_normals[i]);
    if (!file.corner_uvs.empty()) mesh.corner_uvs.push_back(file.corner_uvs[i]);
  }
  const auto left_out = file.triangles.size() - mesh.triangles.size();
  if (left_out)
    warnings->push_back(
        fmt::format("{}: {} of {} triangles have no area and are left out", name, left_out, file.triangles.size()));
  return mesh;
}

}  // namespace tress::scene
