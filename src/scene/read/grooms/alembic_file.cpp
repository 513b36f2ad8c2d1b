// Alembic archives (Ogawa): the curves of all objects with the transforms above them (README.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/ext/matrix_transform.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/ogawa.h"

namespace tress::scene {
namespace {

constexpr int deepest_object = 200;
/// Objects may share their data, but no honest archive has this many times its bytes.
constexpr std::uint64_t most_sharing = 16;

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
        seconds_(input.frame ? std::optional(*input.frame / input.frames_per_second) : std::nullopt),
        builder_(input.name, "an Alembic archive (Ogawa)"),
        most_vertices_(most_sharing * input.bytes.size() / sizeof(glm::vec3)) {}

  Result<GroomFile> read() {
    visit(file_.top(), "", glm::dmat4(1.0), 0);
    if (file_.error()) return *file_.error();
    if (error_) return *error_;
    return builder_.finish();
  }

 private:
  /// An attribute of a geometry: a property, or a compound of values and indices.
  struct Param {
    std::vector<float> numbers;
    std::optional<AttributeScope> scope;
    std::uint32_t extent = 1;
  };

  bool failed() const { return error_ || file_.error(); }

  OgawaMoment moment_of(const OgawaProperty& property) {
    if (property.samples > 1) is_animated_ = true;
    return seconds_ ? file_.around(property, *seconds_) : OgawaMoment{};
  }

  /// Linear between two samples, which must have as many numbers.
  template <class T>
  std::vector<T> between(const OgawaProperty& property,
                         std::vector<T> (OgawaFile::*read)(const OgawaProperty&, std::uint64_t)) {
    const OgawaMoment moment = moment_of(property);
    std::vector<T> numbers = (file_.*read)(property, moment.before);
    if (moment.share == 0) return numbers;
    const std::vector<T> after = (file_.*read)(property, moment.after);
    if (after.size() != numbers.size()) return numbers;  // held; where it matters, points tell
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += static_cast<T>(moment.share) * (after[i] - numbers[i]);
    return numbers;
  }

  std::vector<std::int64_t> held(const OgawaProperty& property) {
    return file_.integers(property, moment_of(property).before);
  }

  void ignore(const std::string& name, const std::string& why) {
    if (ignored_.size() < 200 && ignored_.insert(name).second) builder_.file().ignored.push_back({name, why});
  }

  void visit(const OgawaObject& object, const std::string& path, const glm::dmat4& to_file, int depth) {
    if (failed()) return;
    if (depth > deepest_object) {
      error_ =
          Error{name_, path.substr(0, 256), fmt::format("at most {} objects in one another", deepest_object), "more"};
      return;
    }
    glm::dmat4 here = to_file;
    const Properties properties = file_.properties(object);
    const auto has_schema = [&](std::string_view schema) { return object.metadata.find(schema) != std::string::npos; };
    if (has_schema("AbcGeom_Xform_")) {
      if (const OgawaProperty* xform = find(properties, ".xform")) here = transform(*xform, path, to_file);
    } else if (has_schema("AbcGeom_Curve_")) {
      if (const OgawaProperty* geometry = find(properties, ".geom")) add_curves(*geometry, path, here);
    } else if (const std::size_t at = object.metadata.find("schema=AbcGeom_"); at != std::string::npos) {
      ignore(object.metadata.substr(at + 15, object.metadata.find('_', at + 15) - at - 15),
             "objects of this kind are not read");
    }
    if (find(properties, ".instanceSource")) ignore(path, "instances are not made");
    for (const OgawaObject& child : file_.children(object))
      visit(child, path + "/" + child.name.substr(0, 128), here, depth + 1);
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
      if (!flag.empty() && flag[0] == 0) return own;
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

  Param param(const OgawaProperty* property) {
    Param out;
    if (!property) return out;
    const OgawaProperty* values = property;
    Properties inside;
    std::vector<std::int64_t> indices;
    if (property->kind == OgawaProperty::Kind::compound) {
      inside = file_.properties(*property);
      values = find(inside, ".vals");
      if (const OgawaProperty* at = find(inside, ".indices")) indices = file_.integers(*at);
      if (!values) return out;
    }
    out.numbers = between<float>(*values, &OgawaFile::floats);
    out.extent = values->extent;
    if (!indices.empty()) {
      std::vector<float> all;
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

  CurveKind kind_of(const Properties& geometry, const std::string& path) {
    const OgawaProperty* property = find(geometry, "curveBasisAndType");
    const std::vector<std::int64_t> kind = property ? file_.integers(*property) : std::vector<std::int64_t>();
    CurveKind out;
    if (kind.size() < 3) return out;
    const auto wrong = [&](std::string expected, std::string found) {
      error_ = Error{name_, path + ": curveBasisAndType", std::move(expected), std::move(found)};
    };
    if (kind[1] == 1) out.wrap = CurveWrap::periodic;
    std::int64_t type = kind[0];
    if (type == 2) {  // an order for each curve
      const OgawaProperty* property_of_orders = find(geometry, ".orders");
      const std::vector<std::int64_t> orders =
          property_of_orders ? file_.integers(*property_of_orders) : std::vector<std::int64_t>();
      const bool is_one = !orders.empty() && std::ranges::all_of(orders, [&](auto o) { return o == orders[0]; });
      if (!is_one || (orders[0] != 2 && orders[0] != 4)) {
        wrong("curves of one order, 2 or 4", is_one ? fmt::format("order {}", orders[0]) : "several orders");
        return out;
      }
      type = orders[0] == 2 ? 1 : 0;
    }
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
    if (set.vertex_counts.empty()) return ignore(path, "it has no curves");
    if (!take_attributes(geometry, &set) || failed()) return;
    if (auto error = builder_.add(std::move(set))) error_ = error;
    if (is_animated_) {
      builder_.file().is_animated = true;
      if (!seconds_) builder_.file().remarks.push_back(path + ": it is animated, its first sample is used");
      is_animated_ = false;
    }
  }

  /// Points at the time that was asked for: between samples of as many curves and points; else on from the one before
  /// by their velocities, where there are any.
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

  /// False where the curves are guides, which are not drawn.
  bool take_attributes(const Properties& geometry, CurveSet* set) {
    const OgawaProperty* params_of = find(geometry, ".arbGeomParams");
    const Properties params = params_of ? file_.properties(*params_of) : Properties();
    const auto is_vector = [](const Param& p) { return p.extent == 3 && !p.numbers.empty(); };
    const std::size_t curves = set->vertex_counts.size();
    if (const OgawaProperty* guide = find(params, "groom_guide")) {
      const Param flags = param(guide);
      const bool any = std::ranges::any_of(flags.numbers, [](float x) { return x != 0; });
      if (any && std::ranges::all_of(flags.numbers, [](float x) { return x != 0; })) {
        ignore(set->name, "its curves are guides (groom_guide)");
        return false;
      }
      if (any) ignore("groom_guide", "guides and hairs are in one object: all are drawn");
    }
    const bool has_width = find(geometry, "width") != nullptr;
    Param width = param(has_width ? find(geometry, "width") : find(params, "groom_width"));
    set->width = {std::move(width.numbers), width.scope, has_width ? "width" : "groom_width"};
    if (const Param normal = param(find(geometry, "N")); is_vector(normal))
      set->normal = {triples(normal.numbers), normal.scope, "N"};
    for (const char* name : {"groom_color", "displayColor", "Cd", "color"}) {
      if (!set->color.values.empty()) break;
      if (const Param color = param(find(params, name)); is_vector(color))
        set->color = {triples(color.numbers), color.scope, name};
    }
    if (const OgawaProperty* id = find(params, "groom_id"); id && id->kind != OgawaProperty::Kind::compound) {
      set->id = held(*id);
      if (set->id.size() != curves) ignore("groom_id", "it is not one number a curve");
    }
    const bool has_root_uv = find(params, "groom_root_uv") != nullptr;
    if (const Param uv = param(has_root_uv ? find(params, "groom_root_uv") : find(geometry, "uv"));
        !uv.numbers.empty()) {
      if (uv.extent == 2 && uv.numbers.size() == 2 * curves)
        for (std::size_t i = 0; i < curves; ++i) set->root_uv.emplace_back(uv.numbers[2 * i], uv.numbers[2 * i + 1]);
      else
        ignore(has_root_uv ? "groom_root_uv" : "uv", "it is not one pair a curve");
    }
    name_what_is_left(geometry, params);
    return true;
  }

  void name_what_is_left(const Properties& geometry, const Properties& params) {
    static constexpr std::string_view known[] = {"P",
                                                 "nVertices",
                                                 "curveBasisAndType",
                                                 "width",
                                                 "N",
                                                 "uv",
                                                 ".selfBnds",
                                                 ".childBnds",
                                                 ".arbGeomParams",
                                                 ".userProperties",
                                                 ".orders",
                                                 ".velocities",
                                                 "groom_guide",
                                                 "groom_width",
                                                 "groom_id",
                                                 "groom_root_uv",
                                                 "groom_color",
                                                 "displayColor",
                                                 "Cd",
                                                 "color",
                                                 "groom_version_major",
                                                 "groom_version_minor",
                                                 "groom_tool"};
    for (const Properties* properties : {&geometry, &params})
      for (const OgawaProperty& property : *properties) {
        if (std::ranges::find(known, property.name) != std::end(known)) continue;
        ignore(property.name.substr(0, 64),
               property.name == ".knots" ? "curves are taken as uniform" : "nothing here has a use for it");
      }
  }

  std::string name_;
  OgawaFile file_;
  DoneWith done_with_;
  std::optional<double> seconds_;  ///< unset: the first samples
  GroomBuilder builder_;
  std::uint64_t vertices_ = 0, most_vertices_;
  std::optional<Error> error_;
  std::set<std::string> ignored_;
  bool is_animated_ = false;
};

}  // namespace

Result<GroomFile> read_alembic(const GroomInput& input) { return AlembicReader(input).read(); }

}  // namespace tress::scene
