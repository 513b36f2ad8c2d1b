// Reads Alembic archives (Ogawa): the curves of all objects, with the transforms above them (README.md).
#include "scene/read/grooms/alembic_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/ext/matrix_transform.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/ogawa.h"

namespace tress::scene {
namespace {

constexpr int deepest_object = 200;
constexpr double usual_frames_per_second = 24;

/// The properties of curves, and of their objects and those above.
constexpr FormatItem alembic_table[] = {
    {"P", ""},
    {"nVertices", ""},
    {"curveBasisAndType", ""},
    {"width", ""},
    {"widths", ""},
    {"N", ""},
    {"uv", ""},
    {".knots", ""},
    {".orders", ""},
    {".velocities", ""},
    {".arbGeomParams", ""},
    {"groom_guide", ""},
    {"groom_width", ""},
    {"groom_id", ""},
    {"id", ""},
    {"groom_root_uv", ""},
    {"groom_color", ""},
    {"displayColor", ""},
    {"Cd", ""},
    {"color", ""},
    {".selfBnds", ""},  // bounds follow from points
    {".childBnds", ""},
    {".userProperties", ""},
    {"groom_version_major", ""},
    {"groom_version_minor", ""},
    {"groom_tool", ""},
    {".geom", ""},
    {".xform", ""},
    {".instanceSource", ""},
    {"visible", ""},
    {"guid", ""},      // XGen
    {"ItemName", ""},  // XGen
    {".material", "a scene's material says it"},
    {".material.assign", "a scene's material says it"},
    {"w", "curves are not rational: weights of points are not read"},
    {"pscale", "no width but a factor of one"},
    {"groom_group_id", "all groups are one groom"},
    {"groom_group_name", "all groups are one groom"},
    {"groom_roughness", "a scene's material says it"},
    {"groom_closest_guides", "hair is not interpolated from guides"},
    {"groom_guide_weights", "hair is not interpolated from guides"},
};

using Properties = std::vector<OgawaProperty>;

const OgawaProperty* find(const Properties& properties, std::string_view name) {
  const auto found = std::ranges::find(properties, name, &OgawaProperty::name);
  return found == properties.end() ? nullptr : &*found;
}

std::vector<glm::vec3> triples(const std::vector<float>& numbers) {
  std::vector<glm::vec3> out(numbers.size() / 3);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  return out;
}

class AlembicReader {
 public:
  explicit AlembicReader(const GroomInput& input)
      : name_(input.name),
        file_(input.bytes, input.name, input.done_with),
        done_with_(input.done_with),
        attribute_(input.attribute),
        builder_(input.name, "an Alembic archive (Ogawa)"),
        most_vertices_(most_sharing * input.bytes.size() / sizeof(glm::vec3)) {
    if (!attribute_.empty()) builder_.file().attribute = attribute_;
    builder_.file().origin = input.origin;
    const auto own = file_.frames_per_second();
    if (input.frame) seconds_ = *input.frame / input.frames_per_second.value_or(own.value_or(usual_frames_per_second));
    if (input.frame && own && !input.frames_per_second)
      builder_.file().remarks.push_back(fmt::format("{:g} frames a second, as the archive has them", *own));
  }

  Result<GroomFile> read() {
    find_sources(file_.top(), 0);
    visit(file_.top(), {"", glm::dmat4(1.0), true, 0});
    if (file_.error()) return *file_.error();
    if (error_) return *error_;
    return builder_.finish();
  }

 private:
  /// An attribute of a geometry: a property, or a compound of values and indices.
  template <class T>
  struct Param {
    std::vector<T> numbers = {};
    std::optional<AttributeScope> scope = {};
    std::uint32_t extent = 1;
    std::string name = {};
    double most = 1;  ///< for whole numbers that stand for shares: the largest of their type
  };

  /// The transform of an object, and whether it is visible.
  struct Place {
    std::string path;
    glm::dmat4 to_file;
    bool is_seen;
    int depth;
  };

  bool failed() const { return error_ || file_.error(); }

  OgawaMoment moment_of(const OgawaProperty& property) {
    if (property.samples > 1) is_animated_ = true;
    return seconds_ ? file_.around(property, *seconds_) : OgawaMoment{};
  }

  /// Interpolates linearly between two samples, which must have as many numbers.
  template <class T>
  std::vector<T> between(const OgawaProperty& property,
                         std::vector<T> (OgawaFile::*read)(const OgawaProperty&, std::uint64_t)) {
    const OgawaMoment moment = moment_of(property);
    std::vector<T> numbers = (file_.*read)(property, moment.before);
    if (moment.share == 0) return numbers;
    const std::vector<T> after = (file_.*read)(property, moment.after);
    if (after.size() != numbers.size()) return numbers;  // constant; a mismatch that matters is found in the points
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += static_cast<T>(moment.share) * (after[i] - numbers[i]);
    return numbers;
  }

  std::vector<std::int64_t> held(const OgawaProperty& property) {
    return file_.integers(property, moment_of(property).before);
  }

  void ignore(const std::string& name, const std::string& why) { builder_.ignore(name, why); }

  /// The object at a path such as "/a/b".
  std::optional<OgawaObject> object_at(std::string_view path) {
    OgawaObject here = file_.top();
    while (!path.empty() && !failed()) {
      path.remove_prefix(path[0] == '/' ? 1 : 0);
      const std::string_view name = path.substr(0, path.find('/'));
      path.remove_prefix(name.size());
      const auto children = file_.children(here);
      const auto found = std::ranges::find(children, name, &OgawaObject::name);
      if (found == children.end()) return std::nullopt;
      here = *found;
    }
    return here;
  }

  /// Finds the objects that others are instances of.
  void find_sources(const OgawaObject& object, int depth) {
    if (failed() || depth > deepest_object) return;
    const Properties properties = file_.properties(object);
    if (const OgawaProperty* source = find(properties, ".instanceSource"))
      sources_.insert(file_.text(*source));
    else
      for (const OgawaObject& child : file_.children(object)) find_sources(child, depth + 1);
  }

  void visit(const OgawaObject& object, const Place& here) {
    if (!failed() && sources_.contains(here.path))
      share(here.path, here);
    else
      draw(object, here);
  }

  void draw(const OgawaObject& object, Place here) {
    if (failed()) return;
    const std::string path = here.path;
    if (here.depth > deepest_object) {
      error_ =
          Error{name_, path.substr(0, 256), fmt::format("at most {} objects in one another", deepest_object), "more"};
      return;
    }
    const Properties properties = file_.properties(object);
    if (const OgawaProperty* visible = find(properties, "visible")) {
      const std::vector<std::int64_t> says = held(*visible);  // 0 hidden, 1 shown, whatever the parent is; -1 inherited
      const bool was_seen = here.is_seen;
      if (!says.empty() && says[0] >= 0) here.is_seen = says[0] > 0;
      if (was_seen && !here.is_seen) ignore(path, "it is hidden (visible)");
    }
    const auto has_schema = [&](std::string_view schema) { return object.metadata.find(schema) != std::string::npos; };
    const bool is_xform = has_schema("AbcGeom_Xform_");
    if (is_xform || (has_schema("AbcGeom_Curve_") && here.is_seen)) name_what_is_left(properties);
    if (is_xform) {
      if (const OgawaProperty* xform = find(properties, ".xform")) here.to_file = transform(*xform, path, here.to_file);
    } else if (has_schema("AbcGeom_Curve_")) {
      if (const OgawaProperty* geometry = find(properties, ".geom"); geometry && here.is_seen)
        add_curves(*geometry, path, here.to_file);
    } else if (const std::size_t at = object.metadata.find("schema=Abc"); at != std::string::npos) {
      const std::size_t name = object.metadata.find('_', at) + 1;  // schema=AbcGeom_PolyMesh_v1
      ignore(printable(object.metadata.substr(name, object.metadata.find('_', name) - name).substr(0, 64)),
             "objects of this kind are not read");
    }
    ++here.depth;
    if (const OgawaProperty* source = find(properties, ".instanceSource")) return share(file_.text(*source), here);
    for (const OgawaObject& child : file_.children(object)) {
      here.path = path + "/" + child.name.substr(0, 128);
      visit(child, here);
    }
  }

  /// Draws the object at a path, as an instance of it where that can share strands.
  void share(const std::string& from, Place here) {
    constexpr std::size_t is_open = SIZE_MAX;
    const glm::dmat4 to_file = here.to_file;
    std::optional<std::size_t>& prototype = prototypes_[{from, here.is_seen}];
    const bool shares = prototype != is_open && builder_.can_share(to_file);
    if (!shares || !prototype) {
      const auto original = object_at(from);
      if (!original || failed())
        return ignore(here.path, "what it is an instance of is not there: " + printable(from.substr(0, 128)));
      if (!shares) return draw(*original, std::move(here));
      prototype = is_open;
      builder_.begin_prototype();
      here.to_file = glm::dmat4(1.0);
      draw(*original, std::move(here));
      prototype = builder_.end_prototype();
    }
    if (std::exchange(is_animated_, false)) builder_.file().is_animated = true;
    if (auto error = builder_.add_instance(*prototype, to_file); error && !error_) error_ = error;
  }

  glm::dmat4 transform(const OgawaProperty& xform, const std::string& path, const glm::dmat4& parent) {
    const Properties properties = file_.properties(xform);
    const OgawaProperty *ops = find(properties, ".ops"), *vals = find(properties, ".vals"),
                        *inherits = find(properties, ".inherits");
    glm::dmat4 own(1.0);
    if (ops && vals) {
      const std::vector<std::int64_t> codes = file_.integers(*ops);
      const std::vector<double> values = between<double>(*vals, &OgawaFile::doubles);
      std::size_t at = 0;
      for (const std::int64_t code : codes) {
        const auto type = static_cast<std::size_t>((code >> 4) & 15);
        static constexpr std::size_t needs[] = {3, 3, 4, 16, 1, 1, 1};
        if (type >= std::size(needs) || values.size() - at < needs[type]) {
          error_ = Error{name_, path, "operations of a transform with their values",
                         fmt::format("operation {} with {} values", type, values.size() - at)};
          return parent;
        }
        own = own * operation(type, values.data() + at);
        at += needs[type];
      }
    }
    if (inherits) {
      const std::vector<std::int64_t> flag = file_.integers(*inherits);
      const bool is_free = !flag.empty() && flag[0] == 0;
      if (is_free && builder_.is_in_prototype()) ignore(path + ": .inherits", "an instance moves all that is in it");
      if (is_free && !builder_.is_in_prototype()) return own;
    }
    return parent * own;
  }

  static glm::dmat4 operation(std::size_t type, const double* v) {
    const glm::dmat4 one(1.0);
    const double degree = std::numbers::pi / 180;
    switch (type) {
      case 0:
        return glm::scale(one, glm::dvec3(v[0], v[1], v[2]));
      case 1:
        return glm::translate(one, glm::dvec3(v[0], v[1], v[2]));
      case 2: {
        const glm::dvec3 axis(v[0], v[1], v[2]);
        return axis == glm::dvec3(0.0) ? one : glm::rotate(one, v[3] * degree, axis);
      }
      case 3: {
        glm::dmat4 matrix;
        for (int c = 0; c < 4; ++c)
          for (int r = 0; r < 4; ++r) matrix[c][r] = v[4 * c + r];
        return matrix;
      }
      default: {
        glm::dvec3 axis(0.0);
        axis[static_cast<int>(type) - 4] = 1;
        return glm::rotate(one, v[0] * degree, axis);
      }
    }
  }

  /// The largest number of a type, which stands for 1 in colors.
  static double most_of(std::uint8_t pod) {
    static constexpr double most[] = {1, 255, 127, 65535, 32767};
    return pod < std::size(most) ? most[pod] : 1;
  }

  template <class T>
  std::vector<T> numbers_of(const OgawaProperty& property) {
    if constexpr (std::is_same_v<T, float>)
      return between<float>(property, &OgawaFile::floats);
    else
      return held(property);
  }

  template <class T>
  Param<T> param(const OgawaProperty* property) {
    Param<T> out;
    if (!property) return out;
    const OgawaProperty* values = property;
    Properties inside;
    std::vector<std::int64_t> indices;
    if (property->kind == OgawaProperty::Kind::compound) {
      inside = file_.properties(*property);
      values = find(inside, ".vals");
      if (const OgawaProperty* at = find(inside, ".indices")) indices = held(*at);
      if (!values) return out;
    }
    if (values->is_text()) {
      ignore(property->name.substr(0, 64), "it is a text, where numbers are read");
      return out;
    }
    out.name = property->name;
    out.numbers = numbers_of<T>(*values);
    out.extent = values->extent;
    out.most = most_of(values->pod);
    if (!indices.empty()) {
      std::vector<T> all;
      all.reserve(indices.size() * out.extent);
      const std::uint64_t count = out.numbers.size() / out.extent;
      for (const std::int64_t index : indices) {
        if (index < 0 || static_cast<std::uint64_t>(index) >= count) {
          ignore(property->name, "its indices point outside");
          return {};
        }
        const auto first = out.numbers.begin() + static_cast<std::ptrdiff_t>(index * out.extent);
        all.insert(all.end(), first, first + out.extent);
      }
      out.numbers = std::move(all);
    }
    std::string_view scope = property->value_of("geoScope");
    if (scope.empty()) scope = values->value_of("geoScope");
    if (scope == "con") out.scope = AttributeScope::constant;
    if (scope == "uni") out.scope = AttributeScope::uniform;
    if (scope == "var") out.scope = AttributeScope::varying;
    if (scope == "vtx") out.scope = AttributeScope::vertex;
    return out;
  }

  /// Finds the first of the names that exists, in the parameters or, if it begins with a dot, in the geometry itself,
  /// and names the others.
  template <class T>
  Param<T> first_of(const Properties& geometry, const Properties& params, std::initializer_list<const char*> names) {
    Param<T> first;
    for (const std::string_view name : names) {
      const OgawaProperty* property = name[0] == '.' ? find(geometry, name.substr(1)) : find(params, name);
      if (first.numbers.empty())
        first = param<T>(property);
      else if (property)
        ignore((property->name == first.name ? ".arbGeomParams/" : "") + property->name.substr(0, 64),
               first.name + " is in its place");
    }
    return first;
  }

  /// Returns one tuple for each curve, from an attribute that has one per curve or per vertex; the root's vertex is
  /// used. Empty, with a remark, if it has neither.
  template <class T>
  std::vector<T> at_roots(const Param<T>& given, std::uint32_t extent, const CurveSet& set) {
    const std::size_t curves = set.vertex_counts.size(), tuples = given.numbers.size() / given.extent;
    const bool is_curve = tuples == curves, is_vertex = tuples == set.vertices.size();
    std::vector<T> out;
    if (given.numbers.empty()) return out;
    if (given.extent != extent || !(is_curve || is_vertex)) {
      ignore(given.name, fmt::format("it is not {} a curve", extent == 1 ? "one number" : "one pair"));
      return out;
    }
    std::size_t first = 0;
    for (std::size_t c = 0; c < curves; ++c) {
      const std::size_t at = extent * (is_curve ? c : std::min(first, tuples - 1));
      for (std::uint32_t k = 0; k < extent; ++k) out.push_back(given.numbers[at + k]);
      first += set.vertex_counts[c];
    }
    return out;
  }

  CurveKind kind_of(const Properties& geometry, const std::string& path) {
    const OgawaProperty* property = find(geometry, "curveBasisAndType");
    const std::vector<std::int64_t> kind = property ? file_.integers(*property) : std::vector<std::int64_t>();
    CurveKind out;
    if (kind.size() < 3) return out;
    const auto wrong = [&](std::string expected, std::string found) {
      error_ = Error{name_, path + ": curveBasisAndType", std::move(expected), std::move(found)};
    };
    if (kind[1] == 1) out.wrap = CurveWrap::periodic;
    const std::int64_t type = kind[0] == 2 ? 0 : kind[0];  // an order for each curve: see add_by_orders()
    if (type == 1) return out;
    static constexpr CurveBasis bases[] = {CurveBasis::bspline, CurveBasis::bezier, CurveBasis::bspline,
                                           CurveBasis::catmull_rom, CurveBasis::hermite};
    if (type != 0 || kind[2] < 0 || kind[2] > 4) {
      wrong("a type of linear, cubic or variable order and a basis of bezier, bspline, catmullrom or hermite",
            fmt::format("type {}, basis {}{}", kind[0], kind[2], kind[2] == 5 ? " (power)" : ""));
      return out;
    }
    out.basis = bases[kind[2]];
    if (kind[2] == 0)
      builder_.file().remarks.push_back(path + ": cubic curves without a basis are taken for B-splines");
    return out;
  }

  void add_curves(const OgawaProperty& geometry_of, const std::string& path, const glm::dmat4& to_file) {
    const Properties geometry = file_.properties(geometry_of);
    const OgawaProperty *points = find(geometry, "P"), *counts = find(geometry, "nVertices");
    if (failed()) return;
    if (!points || !counts) return ignore(path, "curves without points");
    if (points->extent != 3) {
      error_ = Error{name_, path + ": P", "points of three numbers", fmt::format("{}", points->extent)};
      return;
    }
    CurveSet set;
    set.name = path;
    set.to_file = to_file;
    set.kind = kind_of(geometry, path);
    for (const std::int64_t count : held(*counts)) {
      if (count < 0 || count > (1 << 24)) {
        error_ = Error{name_, path + ": nVertices", "numbers from 0 to 2^24", fmt::format("{}", count)};
        return;
      }
      set.vertex_counts.push_back(static_cast<std::uint32_t>(count));
    }
    read_points_in_between(*points, *counts, find(geometry, ".velocities"), path, &set.vertices);
    vertices_ += set.vertices.size();
    if (vertices_ > most_vertices_ && !failed())
      error_ = Error{name_, path, fmt::format("at most {} vertices, as the bytes allow", most_vertices_), "more"};
    if (failed()) return;
    if (set.vertex_counts.empty())
      return ignore(path, points->samples > 1
                              ? fmt::format("no curves in the {} of {} samples; --frame asks for another",
                                            seconds_ ? "one of that time" : "first", points->samples)
                              : "it has no curves");
    if (!take_attributes(geometry, &set) || failed()) return;
    add_by_orders(find(geometry, ".orders"), find(geometry, "curveBasisAndType"), std::move(set));
    if (is_animated_) {
      builder_.file().is_animated = true;
      if (!seconds_) builder_.file().remarks.push_back(path + ": it is animated, its first sample is used");
      is_animated_ = false;
    }
  }

  /// If every curve has its own order, adds those of 4 and those of 2 as separate sets and leaves out the others.
  void add_by_orders(const OgawaProperty* orders_of, const OgawaProperty* kind_of, CurveSet set) {
    const std::vector<std::int64_t> kind = kind_of ? file_.integers(*kind_of) : std::vector<std::int64_t>();
    const std::vector<std::int64_t> orders = orders_of ? held(*orders_of) : std::vector<std::int64_t>();
    const auto add = [&](CurveSet&& one) {
      if (auto error = builder_.add(std::move(one)); error && !error_) error_ = error;
    };
    if (kind.empty() || kind[0] != 2) return add(std::move(set));
    if (orders.size() != set.vertex_counts.size())
      return ignore(set.name, fmt::format("{} orders for {} curves", orders.size(), set.vertex_counts.size()));
    const CurveKind cubic = set.kind;
    for (const std::int64_t order : std::set<std::int64_t>(orders.begin(), orders.end())) {
      if (order != 2 && order != 4) {
        ignore(fmt::format("{}: curves of order {}", set.name, order), "those of 2 and 4 are read");
        continue;
      }
      std::vector<unsigned char> keep;
      for (const std::int64_t one : orders) keep.push_back(one == order ? 1 : 0);
      CurveSet part = part_of(set, keep);
      part.kind = order == 2 ? CurveKind{CurveBasis::linear, cubic.wrap} : cubic;
      add(std::move(part));
    }
  }

  /// Reads points at the requested time: interpolated between samples of as many curves and points, else moved on from
  /// the sample before by their velocities, if there are any.
  void read_points_in_between(const OgawaProperty& points, const OgawaProperty& counts, const OgawaProperty* velocities,
                              const std::string& path, std::vector<glm::vec3>* out) {
    const OgawaMoment moment = moment_of(points);
    read_points(points, moment.before, out);
    if (!seconds_ || failed()) return;
    const bool is_between = moment.share > 0;
    if (is_between &&
        file_.integers(counts, file_.around(counts, file_.seconds_of(points, moment.after)).before) == held(counts)) {
      std::vector<glm::vec3> after;
      read_points(points, moment.after, &after);
      if (after.size() == out->size()) {
        for (std::size_t i = 0; i < out->size(); ++i)
          (*out)[i] += static_cast<float>(moment.share) * (after[i] - (*out)[i]);
        return;
      }
    }
    if (velocities == nullptr) {
      if (is_between && !failed())
        error_ = Error{name_, path + ": nVertices",
                       fmt::format("those of sample {}, since curves move from one to the next", moment.before),
                       fmt::format("others in sample {}, and no velocities", moment.after)};
      return;
    }
    const std::vector<glm::vec3> way = triples(file_.floats(*velocities, file_.around(*velocities, *seconds_).before));
    if (way.size() != out->size()) return ignore(".velocities", "they are not one a point");
    is_animated_ = true;
    const auto since = static_cast<float>(*seconds_ - file_.seconds_of(points, moment.before));
    for (std::size_t i = 0; i < out->size(); ++i) (*out)[i] += since * way[i];
  }

  void read_points(const OgawaProperty& property, std::uint64_t sample, std::vector<glm::vec3>* out) {
    constexpr std::uint8_t f32 = 10;
    if (property.pod != f32) {
      *out = triples(file_.floats(property, sample));
      return;
    }
    const auto bytes = file_.sample(property, sample);
    if (bytes.size() % sizeof(glm::vec3) != 0)
      return file_.fail(property.group, "points of 12 bytes", fmt::format("{} bytes", bytes.size()));
    out->resize(bytes.size() / sizeof(glm::vec3));
    auto* to = reinterpret_cast<unsigned char*>(out->data());
    for (std::size_t at = 0; at < bytes.size(); at += done_block) {
      const auto block = bytes.subspan(at, std::min(done_block, bytes.size() - at));
      std::memcpy(to + at, block.data(), block.size());
      if (done_with_) done_with_(block);
    }
  }

  /// False if the curves are guides, which are not drawn.
  bool take_attributes(const Properties& geometry, CurveSet* set) {
    const OgawaProperty* params_of = find(geometry, ".arbGeomParams");
    const Properties params = params_of ? file_.properties(*params_of) : Properties();
    if (const OgawaProperty* guide = find(params, "groom_guide")) {
      const Param<float> flags = param<float>(guide);
      const bool any = std::ranges::any_of(flags.numbers, [](float x) { return x != 0; });
      if (any && std::ranges::all_of(flags.numbers, [](float x) { return x != 0; })) {
        ignore(set->name, "its curves are guides (groom_guide)");
        return false;
      }
      if (any) ignore("groom_guide", "guides and hairs are in one object: all are drawn");
    }
    if (Param<float> width = first_of<float>(geometry, params, {".width", "groom_width", "width", "widths"});
        !width.numbers.empty())
      set->width = {std::move(width.numbers), width.scope, width.name};
    if (const Param<float> normal = first_of<float>(geometry, params, {".N", "N"});
        normal.extent == 3 && !normal.numbers.empty())
      set->normal = {triples(normal.numbers), normal.scope, normal.name};
    else if (!normal.numbers.empty())
      ignore("N", fmt::format("it has {} numbers, where normals have 3", normal.extent));
    if (const OgawaProperty* normals = find(geometry, "N"); normals && normals->samples > 1 && seconds_)
      builder_.file().remarks.push_back(set->name +
                                        ": normals change in time; while the shutter is open those of its "
                                        "opening turn with the strands");
    if (!attribute_.empty())
      set->color = color_of(param<float>(find(params, attribute_)));
    else
      for (const char* name : {"groom_color", "displayColor", "Cd", "color"})
        if (set->color.values.empty())
          set->color = color_of(param<float>(find(params, name)));
        else if (find(params, name))
          ignore(name, set->color.name + " is in its place");
    set->id = at_roots(first_of<std::int64_t>(geometry, params, {"groom_id", "id"}), 1, *set);
    const std::vector<float> uv = at_roots(first_of<float>(geometry, params, {"groom_root_uv", ".uv"}), 2, *set);
    for (std::size_t i = 0; i + 1 < uv.size(); i += 2) set->root_uv.emplace_back(uv[i], uv[i + 1]);
    if (const OgawaProperty* knots = find(geometry, ".knots"))
      set->knots = file_.doubles(*knots, moment_of(*knots).before);
    name_what_is_left(geometry);
    name_what_is_left(params);
    return true;
  }

  /// Reads RGB or RGBA, as floats or as shares of the largest whole number of their type; an attribute may also be a
  /// single number.
  CurveAttribute<glm::vec3> color_of(const Param<float>& given) {
    CurveAttribute<glm::vec3> color{.scope = given.scope, .name = given.name};
    if (given.numbers.empty()) return color;
    const bool is_number = given.extent == 1 && !attribute_.empty();
    if (given.extent != 3 && given.extent != 4 && !is_number) {
      ignore(given.name, fmt::format("it has {} numbers, where colors have 3 or 4", given.extent));
      return color;
    }
    const auto most = static_cast<float>(given.most);
    bool is_opaque = true;
    for (std::size_t i = 0; i + given.extent <= given.numbers.size(); i += given.extent) {
      const float* c = given.numbers.data() + i;
      color.values.push_back(is_number ? glm::vec3(c[0] / most) : glm::vec3(c[0] / most, c[1] / most, c[2] / most));
      is_opaque = is_opaque && (given.extent != 4 || c[3] == most);
    }
    if (!is_opaque) ignore(given.name + ": alpha", "hair is not transparent by a color");
    return color;
  }

  void name_what_is_left(const Properties& properties) {
    for (const OgawaProperty& property : properties) {
      const char* why = why_not_used(alembic_table, property.name);
      if (*why != 0 && property.name != attribute_) ignore(property.name.substr(0, 64), why);
    }
  }

  std::string name_;
  OgawaFile file_;
  DoneWith done_with_;
  std::string attribute_;          ///< read instead of the color; empty: none
  std::optional<double> seconds_;  ///< unset: the first samples
  GroomBuilder builder_;
  std::set<std::string> sources_;  ///< paths of objects that others are instances of
  /// Their numbers, once they are read, by path and whether they are seen there.
  std::map<std::pair<std::string, bool>, std::optional<std::size_t>> prototypes_;
  std::uint64_t vertices_ = 0, most_vertices_;
  std::optional<Error> error_;
  bool is_animated_ = false;
};

}  // namespace

std::span<const FormatItem> alembic_items() { return alembic_table; }

Result<GroomFile> read_alembic(const GroomInput& input) { return AlembicReader(input).read(); }

}  // namespace tress::scene
