// USD as text: the curves of a stage that is flat, with the transforms above them (README.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/usda_values.h"

namespace tress::scene {
namespace {

constexpr int deepest_prim = 200;
constexpr const char* flat_stage = "a flat stage (usdcat --flatten IN -o OUT.usda writes one)";

using Attributes = std::map<std::string, UsdaValue, std::less<>>;

/// What makes a stage more than its text.
bool composes(std::string_view key) {
  static constexpr std::string_view keys[] = {"references",  "payload",   "inherits",
                                              "specializes", "subLayers", "variantSets"};
  return std::ranges::find(keys, key) != std::end(keys);
}

bool is_of_transform(std::string_view name) { return name.starts_with("xformOp:") || name == "xformOpOrder"; }

UsdaNumbers usda_numbers_of(std::string_view name) {
  if (is_of_transform(name)) return UsdaNumbers::doubles;
  const bool is_vector = name == "points" || name == "normals" || name == "primvars:normals";
  return is_vector || name == "primvars:displayColor" ? UsdaNumbers::triples : UsdaNumbers::floats;
}

/// What is as it was at the time sample before a frame.
bool is_held(std::string_view name) {
  return name == "curveVertexCounts" || name.ends_with(":indices") || name.ends_with("id") || name.ends_with("ids");
}

/// Stands in the attributes of a prim where an attribute had time samples, which win over its value.
std::string samples_of(const std::string& name) { return name + ".timeSamples"; }

/// Attributes of curves that are read, and those that say nothing about the picture.
bool is_read(std::string_view name) {
  static constexpr std::string_view names[] = {"type",
                                               "basis",
                                               "wrap",
                                               "curveVertexCounts",
                                               "points",
                                               "widths",
                                               "normals",
                                               "primvars:widths",
                                               "primvars:normals",
                                               "primvars:displayColor",
                                               "primvars:displayColor:indices",
                                               "primvars:id",
                                               "primvars:ids",
                                               "ids",
                                               "primvars:groom_id",
                                               "primvars:st",
                                               "primvars:uv",
                                               "primvars:groom_root_uv",
                                               "visibility",
                                               "purpose"};
  return std::ranges::find(names, name) != std::end(names);
}

bool says_nothing(std::string_view name) {
  return name == "extent" || name == "doubleSided" || name == "orientation" || name.starts_with("userProperties:") ||
         name.starts_with("material:binding");
}

class UsdaReader {
 public:
  explicit UsdaReader(const GroomInput& input)
      : text_(input.bytes, input.name, input.done_with), builder_(input.name, "a USD text"), frame_(input.frame) {}

  Result<GroomFile> read() {
    read_stage_metadata();
    while (!failed() && !text_.at_end()) read_prim_statement({"", glm::dmat4(1.0), true, 0});
    if (text_.error()) return *text_.error();
    if (error_) return *error_;
    return builder_.finish();
  }

 private:
  struct Parent {
    std::string path;
    glm::dmat4 to_file;
    bool is_seen;
    int depth;
  };

  struct Prim {
    std::string type;
    Attributes attributes = {};
    bool is_active = true;
  };

  bool failed() const { return text_.error().has_value() || error_.has_value(); }

  void refuse_composition(std::string_view key) {
    if (composes(key)) text_.fail(flat_stage, std::string(key));
  }

  void ignore(const std::string& name, const std::string& why) {
    if (ignored_.size() < 200 && ignored_.insert(name).second) builder_.file().ignored.push_back({name, why});
  }

  void read_stage_metadata() {
    GroomFile& file = builder_.file();
    file.cm_per_unit = 1;  // where it says nothing a unit is .01 m, and y is up
    file.y_up = true;
    read_metadata("a key of the stage, or \")\"", [&](const std::string& key) {
      if (key == "metersPerUnit") {
        const double metres = text_.number();
        if (!(metres > 0 && metres < 1e9)) return text_.fail("metersPerUnit > 0", fmt::format("{:g}", metres));
        file.cm_per_unit = 100 * metres;
      } else if (key == "upAxis") {
        const std::string_view axis = text_.quoted();
        if (axis != "Y" && axis != "Z" && !failed())
          return text_.fail("upAxis \"Y\" or \"Z\"", "\"" + std::string(axis.substr(0, 32)) + "\"");
        file.y_up = axis == "Y";
      } else {
        text_.skip_value();
      }
    });
  }

  /// ( "comment" key = value ... ), if it is there. read: takes a key, and its value off the text.
  template <class Read>
  void read_metadata(const char* expected, const Read& read) {
    if (!text_.take('(')) return;
    while (!failed() && !text_.take(')')) {
      if (text_.peek() == '"' || text_.peek() == '\'') {
        text_.quoted();
        continue;
      }
      if (text_.take(';') || text_.take(',')) continue;
      const std::string key(text_.word());
      if (key.empty()) return text_.fail_here(expected);
      refuse_composition(key);
      if (text_.take('=')) read(key);
    }
  }

  /// def, over or class with its body, or another statement of the top level.
  void read_prim_statement(const Parent& parent) {
    const std::string keyword(text_.word());
    if (keyword == "reorder") {
      text_.word();
      text_.expect('=', "behind reorder");
      return text_.skip_value();
    }
    if (keyword != "def" && keyword != "over" && keyword != "class") return text_.fail_here("def, over or class");
    Prim prim{.type = std::string(text_.word())};
    Parent here = parent;
    here.path += fmt::format("/{}", printable(std::string(text_.quoted().substr(0, 256))));
    if (++here.depth > deepest_prim)
      return text_.fail(fmt::format("at most {} prims in one another", deepest_prim), "more");
    if (keyword != "def") here.is_seen = false;
    read_prim_metadata(&prim);
    if (!prim.is_active || prim.type == "PointInstancer") here.is_seen = false;
    if (prim.type == "PointInstancer") ignore("PointInstancer", "instances are not made");
    read_body(&prim, here);
  }

  void read_prim_metadata(Prim* prim) {
    read_metadata("a key of a prim, or \")\"", [&](const std::string& key) {
      if (key == "active") {
        prim->is_active = text_.peek_word() != "false";
        text_.word();
      } else {
        text_.skip_value();
      }
    });
  }

  /// Children may stand before the attributes of their prim: they wait until its transform is known.
  void read_body(Prim* prim, Parent here) {
    if (!text_.expect('{', "before the body of a prim")) return;
    bool is_placed = false;
    while (!failed() && !text_.take('}')) {
      const std::string_view word = text_.peek_word();
      if (word == "def" || word == "over" || word == "class") {
        if (!is_placed) place(*prim, &here);
        is_placed = true;
        read_prim_statement(here);
      } else if (word == "variantSet") {
        text_.fail(flat_stage, "variantSet");
      } else if (text_.take(';')) {
        continue;
      } else {
        read_property(prim, here, is_placed);
      }
    }
    if (!is_placed) place(*prim, &here);
    if (!failed()) use(*prim, here);
  }

  /// An attribute or a relationship, whichever words stand before it.
  void read_property(Prim* prim, const Parent& here, bool is_placed) {
    std::string_view word = text_.word();
    if (word.empty()) return text_.fail_here("an attribute, a prim or \"}\"");
    if (word == "reorder") {
      text_.word();
      text_.expect('=', "behind reorder");
      return text_.skip_value();
    }
    while (word == "custom" || word == "uniform" || word == "varying" || word == "config" || word == "prepend" ||
           word == "append" || word == "add" || word == "delete")
      word = text_.word();
    const bool is_relation = word == "rel";
    if (!is_relation && text_.take('[')) text_.expect(']', "of an array's type");
    std::string name(text_.word());
    if (name.empty()) return text_.fail_here("the name of an attribute");
    const bool samples = name.ends_with(".timeSamples"), is_connection = name.ends_with(".connect");
    if (samples) name.resize(name.size() - 12);
    const bool is_transform = is_of_transform(name), is_curves = prim->type == "BasisCurves";
    if (is_transform && is_placed) return text_.fail("the transform of a prim before its children", name);
    UsdaValue value;
    const bool has_value = text_.take('=');
    const bool wanted = here.is_seen && !is_relation && !is_connection &&
                        (is_transform || (is_curves && is_read(name)) || name == "visibility" || name == "purpose");
    if (has_value && wanted) {
      value = read_usda_value(&text_, samples, usda_numbers_of(name), frame_, is_held(name));
    } else if (has_value) {
      text_.skip_value();
    }
    read_usda_attribute_metadata(&text_, &value);
    if (!has_value || failed()) return;
    if (wanted) {
      const std::string there = samples_of(name);
      const bool has_default = prim->attributes.contains(name) && samples && !frame_;
      const bool has_samples = prim->attributes.contains(there) && !samples;
      if (samples) prim->attributes[there];
      if (samples && value.is_animated) animated_ = true;
      if (!value.changed.empty() && name == "points")
        return text_.fail("as many points in the samples around the frame, since curves move from one to the other",
                          value.changed);
      if (!has_default && !has_samples) prim->attributes[name] = std::move(value);
    } else if (here.is_seen && is_curves && !is_connection) {
      if (name == "material:binding")
        builder_.file().materials.push_back(here.path + ": bound to a USD material, which is not read");
      else if (!says_nothing(name))
        ignore(name, "nothing here has a use for it");
    }
  }

  void place(const Prim& prim, Parent* here) {
    const UsdaTransform transform = usda_transform(prim.attributes);
    if (!transform.fault.empty() && here->is_seen)
      text_.fail("an xformOp that USD has, with as many numbers as it needs", transform.fault.substr(0, 64));
    here->to_file = transform.resets ? transform.to_parent : here->to_file * transform.to_parent;
    const auto is = [&](const char* name, const char* word) {
      const auto found = prim.attributes.find(name);
      return found != prim.attributes.end() && !found->second.texts.empty() && found->second.texts[0] == word;
    };
    const bool is_hidden = is("visibility", "invisible"), is_aside = is("purpose", "guide") || is("purpose", "proxy");
    if (here->is_seen && (is_hidden || is_aside))
      ignore(here->path, is_hidden ? "it is invisible" : "its purpose is guide or proxy");
    here->is_seen = here->is_seen && !is_hidden && !is_aside;
  }

  static CurveKind kind_of(const Attributes& attributes, std::string* fault) {
    const auto text_of = [&](const char* name, const char* usual) {
      const auto found = attributes.find(name);
      return found == attributes.end() || found->second.texts.empty() ? std::string(usual) : found->second.texts[0];
    };
    const std::string type = text_of("type", "cubic"), basis = text_of("basis", "bezier"),
                      wrap = text_of("wrap", "nonperiodic");
    CurveKind kind;
    if (wrap == "periodic")
      kind.wrap = CurveWrap::periodic;
    else if (wrap == "pinned")
      kind.wrap = CurveWrap::pinned;
    else if (wrap != "nonperiodic")
      *fault = "wrap nonperiodic, periodic or pinned, found " + wrap;
    if (type == "linear") return kind;
    if (type != "cubic") *fault = "type linear or cubic, found " + type;
    if (basis == "bezier")
      kind.basis = CurveBasis::bezier;
    else if (basis == "bspline")
      kind.basis = CurveBasis::bspline;
    else if (basis == "catmullRom")
      kind.basis = CurveBasis::catmull_rom;
    else if (basis == "hermite")
      kind.basis = CurveBasis::hermite;
    else
      *fault = "basis bezier, bspline or catmullRom, found " + basis;
    return kind;
  }

  void use(Prim& prim, const Parent& here) {
    if (!here.is_seen) return;
    if (prim.type != "BasisCurves") {
      static constexpr std::string_view quiet[] = {"", "Xform", "Scope", "Material", "Shader", "NodeGraph"};
      if (std::ranges::find(quiet, prim.type) == std::end(quiet)) ignore(prim.type, "prims of this type are not read");
      return;
    }
    Attributes& a = prim.attributes;
    const auto fail = [&](std::string expected, std::string found) {
      error_ = Error{text_name(), here.path, std::move(expected), std::move(found)};
    };
    std::string fault;
    CurveSet set;
    set.name = here.path;
    set.kind = kind_of(a, &fault);
    if (!fault.empty()) {
      const std::size_t comma = fault.rfind(", found ");
      return fail(fault.substr(0, comma), "\"" + fault.substr(comma + 8, 64) + "\"");
    }
    set.to_file = here.to_file;
    for (const float count : a["curveVertexCounts"].numbers) {
      if (!(count >= 0 && count <= 16777216.0f) || count != std::floor(count))
        return fail("whole curveVertexCounts of at most 2^24", fmt::format("{:g}", count));
      set.vertex_counts.push_back(static_cast<std::uint32_t>(count));
    }
    if (const std::size_t over = a["points"].numbers.size())
      return fail("points of three numbers", fmt::format("{} numbers", 3 * a["points"].triples.size() + over));
    set.vertices = std::exchange(a["points"].triples, {});
    if (set.vertex_counts.empty()) return ignore(here.path, "it has no curves");
    take_attributes(a, &set);
    if (auto error = builder_.add(std::move(set))) error_ = error;
    if (animated_ && !frame_) builder_.file().remarks.push_back("it is animated: the first time sample is used");
    builder_.file().is_animated = builder_.file().is_animated || animated_;
  }

  const std::string& text_name() const { return text_.name(); }

  /// Of two names for one thing the first that is there.
  static UsdaValue* first_of(Attributes& attributes, std::initializer_list<const char*> names, std::string* name) {
    for (const char* candidate : names)
      if (const auto found = attributes.find(candidate);
          found != attributes.end() && !(found->second.numbers.empty() && found->second.triples.empty())) {
        *name = candidate;
        return &found->second;
      }
    return nullptr;
  }

  void take_attributes(Attributes& a, CurveSet* set) {
    std::string name;
    if (UsdaValue* widths = first_of(a, {"primvars:widths", "widths"}, &name))
      set->width = {std::move(widths->numbers), widths->scope, name};
    if (UsdaValue* normals = first_of(a, {"primvars:normals", "normals"}, &name))
      set->normal = {std::move(normals->triples), normals->scope, name};
    if (UsdaValue* colors = first_of(a, {"primvars:displayColor"}, &name)) {
      set->color = {std::move(colors->triples), colors->scope, name};
      if (const auto indices = a.find("primvars:displayColor:indices"); indices != a.end())
        look_up(indices->second.numbers, &set->color);
    }
    const std::size_t curves = set->vertex_counts.size();
    if (UsdaValue* ids = first_of(a, {"primvars:id", "primvars:ids", "ids", "primvars:groom_id"}, &name)) {
      for (const float id : ids->numbers) set->id.push_back(std::abs(id) < 1e15f ? static_cast<std::int64_t>(id) : -1);
      if (set->id.size() != curves) ignore(name, "it is not one number a curve");
    }
    if (UsdaValue* uv = first_of(a, {"primvars:groom_root_uv", "primvars:st", "primvars:uv"}, &name)) {
      if (uv->numbers.size() != 2 * curves) return ignore(name, "it is not one pair a curve");
      for (std::size_t i = 0; i < curves; ++i) set->root_uv.emplace_back(uv->numbers[2 * i], uv->numbers[2 * i + 1]);
    }
  }

  void look_up(const std::vector<float>& indices, CurveAttribute<glm::vec3>* color) {
    std::vector<glm::vec3> values;
    values.reserve(indices.size());
    for (const float index : indices) {
      if (!(index >= 0 && index < static_cast<float>(color->values.size()))) {
        color->values.clear();
        return ignore("primvars:displayColor", "its indices point outside");
      }
      values.push_back(color->values[static_cast<std::size_t>(index)]);
    }
    color->values = std::move(values);
  }

  TextCursor text_;
  GroomBuilder builder_;
  std::optional<Error> error_;
  std::set<std::string> ignored_;
  std::optional<double> frame_;  ///< unset: the first time samples
  bool animated_ = false;        ///< something so far was
};

}  // namespace

Result<GroomFile> read_usda(const GroomInput& input) { return UsdaReader(input).read(); }

}  // namespace tress::scene
