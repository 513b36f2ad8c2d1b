// Reads scenes of pbrt-v4: their curves with the transforms around them, and remarks on their hair materials
// (README.md).
#include "scene/read/grooms/pbrt_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/text_cursor.h"

namespace tress::scene {
namespace {

constexpr int deepest_include = 16, most_includes = 4096;
constexpr std::size_t deepest_attributes = 1024, most_saved_words = 100'000;

/// Between blanks.
constexpr std::string_view directives =
    " Accelerator ActiveTransform AreaLightSource Attribute AttributeBegin AttributeEnd Camera ColorSpace "
    "ConcatTransform CoordSysTransform CoordinateSystem Film Identity Import Include Integrator LightSource "
    "LookAt MakeNamedMaterial MakeNamedMedium Material MediumInterface NamedMaterial ObjectBegin ObjectEnd "
    "ObjectInstance Option PixelFilter ReverseOrientation Rotate Sampler Scale Shape Texture Transform "
    "TransformBegin TransformEnd TransformTimes Translate WorldBegin WorldEnd ";

bool is_directive(std::string_view word) {
  return directives.find(fmt::format(" {} ", word)) != std::string_view::npos;
}

/// Directives other than transforms, curves and their materials.
constexpr FormatItem pbrt_table[] = {
    {"Shape", "only curves are read"},
    {"LightSource", "only curves are read"},
    {"AreaLightSource", "only curves are read"},
    {"Attribute", "parameters for all shapes that follow are not read"},
    {"TransformTimes", "strands stand still: they are where the shutter opens"},
    {"ColorSpace", "colors are taken for linear Rec. 709"},
    {"MakeNamedMedium", "only curves are read"},
};

/// Parameters of curves.
constexpr FormatItem pbrt_curve_table[] = {
    {"P", ""},
    {"N", ""},
    {"basis", ""},
    {"degree", ""},
    {"type", ""},  // fibers are round, and ribbons have normals
    {"width", ""},
    {"width0", ""},
    {"width1", ""},
    {"splitdepth", ""},
    {"alpha", "hair is not transparent by an attribute"},
};

const char* why_of(std::string_view directive) {
  const auto found = std::ranges::find(pbrt_table, directive, &FormatItem::name);
  return found == std::end(pbrt_table) ? "" : found->why;
}

/// The values of one parameter: "float width0" [ .01 ].
struct Values {
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

struct Parameters {
  std::vector<std::string> first;  ///< texts that are no parameter, such as "curve"
  std::map<std::string, Values, std::less<>> by_name;

  double number(std::string_view name, double usual) const {
    const auto found = by_name.find(name);
    return found == by_name.end() || found->second.numbers.empty() ? usual : found->second.numbers[0];
  }
  std::string text(std::string_view name, const char* usual) const {
    const auto found = by_name.find(name);
    return found == by_name.end() || found->second.texts.empty() ? usual : found->second.texts[0];
  }
};

class PbrtReader {
 public:
  explicit PbrtReader(const GroomInput& input) : input_(input), builder_(input.name, "a pbrt scene") {}

  Result<GroomFile> read() {
    read_text(input_.bytes, input_.name, 0);
    flush();
    if (error_) return *error_;
    return builder_.finish();
  }

 private:
  struct ObjectCurve {
    Parameters parameters;
    glm::dmat4 to_world;
    std::string material;
  };

  struct Object {
    std::vector<ObjectCurve> curves = {};
    std::optional<std::size_t> prototype = {};  ///< its number, once it has an instance
  };

  void ignore(const std::string& name, const std::string& why) { builder_.ignore(name, why); }

  void read_text(std::span<const unsigned char> bytes, const std::string& name, int depth) {
    TextCursor text(bytes, name);
    while (!error_ && !text.error() && !text.at_end()) {
      const std::string directive(text.word());
      if (!is_directive(directive)) {
        text.fail("a directive of pbrt", fmt::format("\"{}\"", directive.substr(0, 32)));
      } else if (directive == "Include" || directive == "Import") {
        include(&text, depth);
      } else {
        obey(directive, &text);
      }
    }
    if (text.error() && !error_) error_ = text.error();
  }

  void include(TextCursor* text, int depth) {
    const std::string path(text->quoted());
    if (text->error()) return;
    if (!input_.other_file) return text->fail("no other files", path.substr(0, 64));
    if (depth >= deepest_include || ++includes_ > most_includes)
      return text->fail(fmt::format("at most {} includes in one another, {} in all", deepest_include, most_includes),
                        "more");
    const auto bytes = input_.other_file(path);
    if (!bytes)
      error_ = bytes.error();
    else
      read_text(without_byte_order_mark(*bytes), path, depth + 1);
  }

  std::vector<double> numbers(TextCursor* text, std::size_t count) {
    std::vector<double> out;
    const bool has_brackets = text->take('[');
    while (out.size() < count && !text->error()) out.push_back(text->number());
    if (has_brackets) text->expect(']', "behind numbers");
    return out;
  }

  void obey(const std::string& directive, TextCursor* text) {
    if (directive == "AttributeBegin" || directive == "TransformBegin") {
      if (stack_.size() >= deepest_attributes) return text->fail("fewer blocks in one another", "more");
      stack_.push_back({to_world_, directive == "AttributeBegin", material_, at_start_});
    } else if (directive == "AttributeEnd" || directive == "TransformEnd") {
      if (stack_.empty()) return text->fail("a block that began", directive);
      to_world_ = stack_.back().to_world;
      at_start_ = stack_.back().at_start;
      if (stack_.back().has_material) material_ = stack_.back().material;
      stack_.pop_back();
    } else if (directive == "ActiveTransform") {
      const std::string_view which = text->word();
      at_start_ = which != "EndTime";
      if (which != "All") ignore("ActiveTransform", "strands stand still: they are where the shutter opens");
    } else if (directive == "CoordinateSystem") {
      const std::string name(text->quoted());
      if (named_systems_.size() < most_saved_words) named_systems_[name] = to_world_;
    } else if (directive == "CoordSysTransform") {
      const std::string name(text->quoted());
      const auto found = named_systems_.find(name);
      if (found != named_systems_.end())
        transform(found->second, false);
      else
        ignore("CoordSysTransform \"" + printable(name.substr(0, 64)) + "\"", "no CoordinateSystem has the name");
    } else if (directive == "WorldBegin" || directive == "Identity") {
      if (directive == "WorldBegin") at_start_ = true;
      transform(glm::dmat4(1.0), false);
      if (directive == "WorldBegin") named_systems_["world"] = to_world_;
    } else if (directive == "Translate" || directive == "Scale") {
      const auto n = numbers(text, 3);
      if (text->error()) return;
      const glm::dvec3 by(n[0], n[1], n[2]);
      transform(directive == "Scale" ? glm::scale(glm::dmat4(1.0), by) : glm::translate(glm::dmat4(1.0), by), true);
    } else if (directive == "Rotate") {
      const auto n = numbers(text, 4);
      const glm::dvec3 axis = text->error() ? glm::dvec3(0.0) : glm::dvec3(n[1], n[2], n[3]);
      if (axis != glm::dvec3(0.0)) transform(glm::rotate(glm::dmat4(1.0), n[0] * std::numbers::pi / 180, axis), true);
    } else if (directive == "LookAt") {
      const auto n = numbers(text, 9);
      if (!text->error()) look_at({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]});
    } else if (directive == "Transform" || directive == "ConcatTransform") {
      const auto n = numbers(text, 16);
      if (text->error()) return;
      glm::dmat4 matrix;
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) matrix[c][r] = n[static_cast<std::size_t>(4 * c + r)];
      transform(matrix, directive == "ConcatTransform");
    } else if (directive == "ObjectBegin") {
      object_ = std::string(text->quoted());
      if (stack_.size() >= deepest_attributes) return text->fail("fewer blocks in one another", "more");
      stack_.push_back({to_world_, true, material_, at_start_});
    } else if (directive == "ObjectEnd") {
      if (!object_ || stack_.empty()) return text->fail("an object that began", directive);
      object_.reset();
      to_world_ = stack_.back().to_world;
      at_start_ = stack_.back().at_start;
      material_ = stack_.back().material;
      stack_.pop_back();
    } else if (directive == "ObjectInstance") {
      add_instance(std::string(text->quoted()), text);
    } else if (directive == "Camera") {
      if (glm::determinant(to_world_) != 0) named_systems_["camera"] = glm::inverse(to_world_);
      with_parameters(directive, parameters(text), text);
    } else {
      with_parameters(directive, parameters(text), text);
    }
  }

  /// Applies a transform directive, unless it belongs only to the end of a motion.
  void transform(const glm::dmat4& by, bool concatenates) {
    if (at_start_) to_world_ = concatenates ? to_world_ * by : by;
  }

  /// The transform from the world to a camera that looks along its z; empty if it has no direction.
  void look_at(const glm::dvec3& eye, const glm::dvec3& at, const glm::dvec3& up) {
    const glm::dvec3 along = at - eye, right = glm::cross(up, along);
    if (!(glm::length(along) > 0) || !(glm::length(right) > 0)) return;
    const glm::dvec3 z = glm::normalize(along), x = glm::normalize(right), y = glm::cross(z, x);
    transform(glm::inverse(glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(eye, 1))), true);
  }

  /// Draws an object once more. Instances share its strands; where they cannot, they are copies, which may take most
  /// bytes so often.
  void add_instance(const std::string& name, TextCursor* text) {
    const auto found = objects_.find(name);
    if (found == objects_.end())
      return ignore("ObjectInstance \"" + printable(name.substr(0, 64)) + "\"", "no object with curves has the name");
    Object& object = found->second;
    flush();
    if (!builder_.can_share(to_world_)) {
      for (const ObjectCurve& curve : object.curves) {
        const auto points = curve.parameters.by_name.find("P");
        copied_ += points == curve.parameters.by_name.end() ? 0 : points->second.numbers.size();
      }
      if (copied_ > most_sharing * std::max<std::size_t>(input_.bytes.size(), 1 << 16))
        return text->fail("fewer instances that are copies", "more than the bytes allow");
      return add_curves(object, to_world_, text);
    }
    if (!object.prototype) {
      builder_.begin_prototype();
      add_curves(object, glm::dmat4(1.0), text);
      flush();
      object.prototype = builder_.end_prototype();
    }
    if (auto error = builder_.add_instance(*object.prototype, to_world_); error && !error_) error_ = error;
  }

  void add_curves(const Object& object, const glm::dmat4& place, TextCursor* text) {
    const glm::dmat4 here = to_world_;
    const std::string material = material_;
    for (const ObjectCurve& curve : object.curves) {
      if (text->error()) break;
      to_world_ = place * curve.to_world;
      material_ = curve.material;
      add_curve(curve.parameters, text);
    }
    to_world_ = here;
    material_ = material;
  }

  Parameters parameters(TextCursor* text) {
    Parameters out;
    while (!text->error()) {
      const char c = text->peek();
      if (c != '"') {
        if (c == 0 || is_directive(text->peek_word())) break;
        if (text->is_number())
          text->number();  // skips TransformTimes
        else if (text->word().empty())
          text->fail_here("a parameter or a directive");
        continue;
      }
      const std::string declared(text->quoted());
      const std::size_t blank = declared.find_last_of(" \t");
      if (blank == std::string::npos) {
        if (out.first.size() < 8) out.first.push_back(declared);
        continue;
      }
      Values& values = out.by_name[declared.substr(blank + 1)];
      values = {};
      const bool has_brackets = text->take('[');
      do {
        const char next = text->peek();
        if (next == '"')
          values.texts.emplace_back(text->quoted());
        else if (next == 't' || next == 'f')
          values.texts.emplace_back(text->word());  // true, false
        else if (next == ']' && has_brackets)
          break;
        else
          values.numbers.push_back(text->number());
      } while (has_brackets && !text->error());
      if (has_brackets) text->expect(']', "behind values");
    }
    return out;
  }

  void with_parameters(const std::string& directive, Parameters p, TextCursor* text) {
    if (text->error()) return;
    const std::string kind = p.first.empty() ? "" : printable(p.first[0]);
    if (directive == "Shape" && kind == "curve") {
      if (!object_) return add_curve(p, text);
      Object& object = objects_[*object_];
      object.prototype.reset();
      object.curves.push_back({std::move(p), to_world_, material_});
    } else if (const char* why = why_of(directive); *why != 0) {
      if (directive == "ColorSpace" && kind == "srgb") return;
      ignore(directive + " \"" + kind.substr(0, 32) + "\"", why);
    } else if (directive == "Material") {
      material_ = hair_of(kind, p);
    } else if (directive == "MakeNamedMaterial" && named_.size() < most_saved_words) {
      named_[kind] = hair_of(p.text("type", ""), p);
    } else if (directive == "NamedMaterial") {
      const auto found = named_.find(kind);
      material_ = found == named_.end() ? "" : found->second;
      if (found == named_.end())
        ignore("NamedMaterial \"" + kind.substr(0, 32) + "\"", "no MakeNamedMaterial before it has the name");
    }
  }

  /// A hair material as options of the command line, with the parameters that these do not have.
  static std::string hair_of(const std::string& kind, const Parameters& p) {
    if (kind != "hair") return kind.substr(0, 32) + ": a material that is not hair, which is not read";
    const auto triple = [&](std::string_view name, std::string* out, const char* option) {
      const auto found = p.by_name.find(name);
      if (found == p.by_name.end() || found->second.numbers.size() != 3) return false;
      const auto& n = found->second.numbers;
      *out = fmt::format("{} {:g},{:g},{:g}", option, n[0], n[1], n[2]);
      return true;
    };
    std::string color;
    if (!triple("sigma_a", &color, "--sigma-a") && !triple("reflectance", &color, "--color") &&
        !triple("color", &color, "--color")) {
      const auto is_given = [&](std::string_view name) { return p.by_name.contains(name); };
      const bool has_melanin = is_given("eumelanin") || is_given("pheomelanin");
      color = is_given("sigma_a") || is_given("reflectance") || is_given("color")
                  ? "a color that is not rgb, which is not read;"
                  : fmt::format("--melanin {:g},{:g}", p.number("eumelanin", has_melanin ? 0 : 1.3),
                                p.number("pheomelanin", 0));
    }
    std::string others;
    for (const auto& [name, values] : p.by_name)
      if (name != "type" && values.numbers.empty()) others += "; not read: " + printable(name.substr(0, 32));
    return fmt::format(
        "hair: {} --set 'materials/*/eccentricity=1'; eta {:g}, tilt {:g} degrees, beta_m {:g}, beta_n {:g}{}", color,
        p.number("eta", 1.55), p.number("alpha", 2), p.number("beta_m", 0.3), p.number("beta_n", 0.3),
        others.substr(0, 256));
  }

  /// Converts quadratic curves into cubic Bezier segments, exactly; empty if the number of points does not fit.
  static std::vector<glm::dvec3> cubic_of(const std::vector<glm::dvec3>& p, bool is_bspline) {
    std::vector<glm::dvec3> out;
    const std::size_t segments = p.size() < 3 ? 0 : is_bspline ? p.size() - 2 : (p.size() - 1) / 2;
    for (std::size_t s = 0; s < segments; ++s) {
      const std::size_t i = is_bspline ? s : 2 * s;
      const glm::dvec3 a = is_bspline ? (p[i] + p[i + 1]) / 2.0 : p[i], b = p[i + 1],
                       c = is_bspline ? (p[i + 1] + p[i + 2]) / 2.0 : p[i + 2];
      if (s == 0) out.push_back(a);
      out.insert(out.end(), {(a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c});
    }
    return out;
  }

  void add_curve(const Parameters& p, TextCursor* text) {
    const auto given = p.by_name.find("P");
    const std::vector<double> none;
    const std::vector<double>& n = given == p.by_name.end() ? none : given->second.numbers;
    if (n.empty() || n.size() % 3 != 0)
      return text->fail("points of three numbers, \"point3 P\"", fmt::format("{} numbers", n.size()));
    std::vector<glm::dvec3> points;
    for (std::size_t i = 0; i < n.size(); i += 3)
      points.emplace_back(to_world_ * glm::dvec4(n[i], n[i + 1], n[i + 2], 1.0));
    for (const auto& [name, values] : p.by_name)
      if (const char* why = why_not_used(pbrt_curve_table, name); *why != 0)
        ignore("curve " + printable(name.substr(0, 32)), why);
    const std::string basis = p.text("basis", "bezier");
    const double degree = p.number("degree", 3);
    if ((basis != "bezier" && basis != "bspline") || (degree != 2 && degree != 3))
      return text->fail("basis bezier or bspline of degree 2 or 3",
                        fmt::format("{} of degree {:g}", basis.substr(0, 32), degree));
    CurveKind kind{basis == "bezier" ? CurveBasis::bezier : CurveBasis::bspline, CurveWrap::nonperiodic};
    const bool fits = basis == "bspline"
                          ? static_cast<double>(points.size()) > degree
                          : points.size() > 1 && (points.size() - 1) % static_cast<std::size_t>(degree) == 0;
    if (!fits)
      return text->fail(fmt::format("points as a {} of degree {:g} has them", basis, degree),
                        fmt::format("{}", points.size()));
    if (degree == 2) {
      points = cubic_of(points, basis == "bspline");
      kind.basis = CurveBasis::bezier;
    }
    const double size = std::cbrt(std::abs(glm::determinant(glm::dmat3(to_world_)))), width = p.number("width", 1);
    append(kind, points, size * p.number("width0", width), size * p.number("width1", width), normals_of(p));
    if (!material_.empty() && noted_materials_.insert(material_).second && materials_++ < 100)
      builder_.file().materials.push_back(material_);
  }

  /// The normals of a ribbon at the ends of its segments; empty if it has none.
  std::vector<glm::vec3> normals_of(const Parameters& p) const {
    const auto given = p.by_name.find("N");
    std::vector<glm::vec3> normals;
    if (given == p.by_name.end() || p.text("type", "flat") != "ribbon") return normals;
    const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(to_world_)));
    const std::vector<double>& n = given->second.numbers;
    for (std::size_t i = 0; i + 2 < n.size(); i += 3) {
      const glm::dvec3 turned = turn * glm::dvec3(n[i], n[i + 1], n[i + 2]);
      const double length = glm::length(turned);
      const bool has_direction = length > 0 && std::isfinite(length);
      normals.emplace_back(has_direction ? turned / length : glm::dvec3(0.0));
    }
    return normals;
  }

  /// Appends as many normals as widths; 0 for strands without normals.
  void append_normals(const std::vector<glm::vec3>& normals, std::uint64_t segments, bool goes_on) {
    std::vector<glm::vec3>& all = pending_.normal.values;
    if (normals.empty() && all.empty()) return;
    const bool fits = normals.size() == segments + 1;
    if (!normals.empty() && !fits) ignore("normal N", "there are not as many as the ends of its segments");
    all.resize(pending_.width.values.size() - segments - (goes_on ? 0 : 1), glm::vec3(0.0f));
    for (std::uint64_t i = goes_on ? 1 : 0; i <= segments; ++i) all.push_back(fits ? normals[i] : glm::vec3(0.0f));
    if (goes_on && fits && all[all.size() - segments - 1] == glm::vec3(0.0f))
      all[all.size() - segments - 1] = normals[0];
  }

  /// Appends a Bezier segment. If it continues where the last one ended it belongs to the same strand: cyhair2pbrt
  /// writes a shape for each.
  void append(const CurveKind& kind, const std::vector<glm::dvec3>& points, double width0, double width1,
              const std::vector<glm::vec3>& normals) {
    if (!(kind == pending_.kind)) flush();
    pending_.kind = kind;
    const auto first = vector_of(points[0]);
    const auto width = to_float(width0);
    const bool goes_on = kind.basis == CurveBasis::bezier && !pending_.vertices.empty() &&
                         pending_.vertices.back() == first && pending_.width.values.back() == width;
    for (std::size_t i = goes_on ? 1 : 0; i < points.size(); ++i) pending_.vertices.push_back(vector_of(points[i]));
    const std::uint64_t segments = segments_of(kind, points.size());
    for (std::uint64_t i = goes_on ? 1 : 0; i <= segments; ++i)
      pending_.width.values.push_back(
          to_float(width0 + (width1 - width0) * static_cast<double>(i) / static_cast<double>(segments)));
    append_normals(normals, segments, goes_on);
    const auto count = static_cast<std::uint32_t>(points.size() - (goes_on ? 1 : 0));
    if (goes_on)
      pending_.vertex_counts.back() += count;
    else
      pending_.vertex_counts.push_back(count);
  }

  static glm::vec3 vector_of(const glm::dvec3& p) { return {to_float(p.x), to_float(p.y), to_float(p.z)}; }

  void flush() {
    if (error_ || pending_.vertex_counts.empty()) return;
    pending_.name = "curves";
    pending_.width.scope = pending_.normal.scope = AttributeScope::varying;
    pending_.normal.name = std::string("N");
    pending_.width.name = "width0, width1";
    if (auto error = builder_.add(std::exchange(pending_, {}))) error_ = error;
  }

  struct Block {
    glm::dmat4 to_world;
    bool has_material;
    std::string material;
    bool at_start;
  };

  const GroomInput& input_;
  GroomBuilder builder_;
  CurveSet pending_;
  glm::dmat4 to_world_{1.0};
  std::vector<Block> stack_;
  std::string material_;
  std::map<std::string, std::string> named_;
  std::set<std::string> noted_materials_;
  std::optional<Error> error_;
  int includes_ = 0, materials_ = 0;
  std::map<std::string, glm::dmat4> named_systems_;
  std::optional<std::string> object_;  ///< the object that is being described
  std::map<std::string, Object> objects_;
  std::size_t copied_ = 0;  ///< numbers of points
  bool at_start_ = true;    ///< whether transforms are those at the opening of the shutter
};

}  // namespace

std::vector<std::string> pbrt_includes(std::span<const unsigned char> bytes) {
  std::vector<std::string> names;
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool may_have = all.find("Include") != all.npos || all.find("Import") != all.npos;
  if (!may_have || !is_pbrt(bytes)) return names;
  TextCursor text(bytes, "");
  while (!text.at_end()) {
    if (text.peek() == '"') {
      text.quoted();
      continue;
    }
    const std::string_view word = text.word();
    if (word.empty() && !text.take(text.peek())) break;
    if ((word == "Include" || word == "Import") && text.peek() == '"') names.emplace_back(text.quoted());
  }
  return names;
}

bool is_pbrt(std::span<const unsigned char> bytes) { return is_directive(TextCursor(bytes, "").peek_word()); }

std::span<const FormatItem> pbrt_items() { return pbrt_table; }
std::span<const FormatItem> pbrt_curve_items() { return pbrt_curve_table; }

Result<GroomFile> read_pbrt(const GroomInput& input) { return PbrtReader(input).read(); }

}  // namespace tress::scene
