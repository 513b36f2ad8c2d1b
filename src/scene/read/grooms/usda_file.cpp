// Reads USD as text: the curves of one layer, with the transforms, states and primvars above them (README.md). The
// layer is first read as a tree of prims, in which values are places in the text; those that the picture needs are then
// read from there.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/usda_values.h"

namespace tress::scene {
namespace {

constexpr int deepest_prim = 200, deepest_arc = 16;
/// Prims may share what they refer to, but no valid layer unfolds to this many times its prims and its bytes.
constexpr std::uint64_t most_sharing = 16, least_bytes_of_vertex = 8;
constexpr const char* flat_stage = "a flat stage (usdcat --flatten IN -o OUT.usda writes one)";

/// Attributes of curves. Those without effect on the picture are listed as used.
constexpr FormatItem usda_table[] = {
    {"type", ""},
    {"basis", ""},
    {"wrap", ""},
    {"curveVertexCounts", ""},
    {"points", ""},
    {"velocities", ""},
    {"widths", ""},
    {"normals", ""},
    {"primvars:widths", ""},
    {"primvars:normals", ""},
    {"primvars:displayColor", ""},
    {"primvars:id", ""},
    {"primvars:ids", ""},
    {"ids", ""},
    {"primvars:groom_id", ""},
    {"primvars:st", ""},
    {"primvars:uv", ""},
    {"primvars:groom_root_uv", ""},
    {"visibility", ""},
    {"purpose", ""},
    {"extent", ""},
    {"doubleSided", ""},
    {"orientation", ""},
    {"accelerations", "points go straight on by their velocities"},
    {"primvars:displayOpacity", "hair is not transparent by an attribute"},
    {"primvars:skel:jointIndices", "skeletons do not move curves"},
    {"primvars:skel:jointWeights", "skeletons do not move curves"},
    {"primvars:skel:geomBindTransform", "skeletons do not move curves"},
    {"model:drawMode", "curves are drawn, not cards in their place"},
};

/// Types of prims that do not affect the picture themselves.
constexpr std::string_view quiet_types[] = {"",         "Xform",      "Scope",    "Material", "Shader",     "NodeGraph",
                                            "SkelRoot", "GeomSubset", "Skeleton", "Camera",   "BasisCurves"};

bool is_arc(std::string_view key) {
  static constexpr std::string_view keys[] = {"references", "payload", "inherits", "specializes"};
  return std::ranges::find(keys, key) != std::end(keys);
}

bool composes_otherwise(std::string_view key) { return key == "subLayers" || key == "variantSets"; }

bool is_of_transform(std::string_view name) { return name.starts_with("xformOp:") || name == "xformOpOrder"; }

UsdaNumbers usda_numbers_of(std::string_view name) {
  const bool is_id = name.ends_with("id") || name.ends_with("ids") || name.ends_with(":indices");
  if (is_of_transform(name) || is_id) return UsdaNumbers::doubles;
  const bool is_vector = name == "points" || name == "normals" || name == "primvars:normals" || name == "velocities";
  return is_vector || name == "primvars:displayColor" ? UsdaNumbers::triples : UsdaNumbers::floats;
}

/// Whether the value is constant after each time sample, not interpolated.
bool is_held(std::string_view name) {
  return name == "curveVertexCounts" || name == "visibility" || name.ends_with(":indices") || name.ends_with("id") ||
         name.ends_with("ids") || name == "velocities";
}

/// The place of an attribute's values in the text.
struct UsdaAttribute {
  std::optional<std::size_t> value = {}, samples = {};
  std::optional<AttributeScope> scope = {};
  bool is_triple = false;  ///< whether its type has three numbers
};

struct UsdaPrim {
  std::string name, type;
  bool is_defined = true, is_active = true;
  std::vector<std::string> arcs = {};  ///< paths of prims with weaker opinions
  std::map<std::string, UsdaAttribute, std::less<>> attributes = {};
  std::vector<UsdaPrim> children = {};

  const UsdaPrim* child(std::string_view named) const {
    const auto found = std::ranges::find(children, named, &UsdaPrim::name);
    return found == children.end() ? nullptr : &*found;
  }
};

/// Builds the tree of a layer from its text.
class UsdaLayer {
 public:
  UsdaLayer(TextCursor* text, GroomFile* file) : text_(*text), file_(*file) {}

  UsdaPrim read() {
    UsdaPrim root;
    read_stage_metadata();
    while (!text_.error() && !text_.at_end()) read_prim_statement(&root, 0);
    return root;
  }

  double time_codes_per_second() const { return time_codes_per_second_; }
  std::uint64_t prims() const { return prims_; }

 private:
  void read_stage_metadata() {
    file_.cm_per_unit = 1;  // the defaults of USD: a unit of 0.01 m, and y up
    file_.y_up = true;
    read_metadata("a key of the stage, or \")\"", [&](const std::string& key) {
      if (key == "metersPerUnit") {
        const double metres = text_.number();
        if (!(metres > 0 && metres < 1e9)) return text_.fail("metersPerUnit > 0", fmt::format("{:g}", metres));
        file_.cm_per_unit = 100 * metres;
      } else if (key == "timeCodesPerSecond") {
        const double rate = text_.number();
        if (rate > 0 && rate < 1e9) time_codes_per_second_ = rate;
      } else if (key == "upAxis") {
        const std::string_view axis = text_.quoted();
        if (axis != "Y" && axis != "Z" && !text_.error())
          return text_.fail("upAxis \"Y\" or \"Z\"", "\"" + std::string(axis.substr(0, 32)) + "\"");
        file_.y_up = axis == "Y";
      } else {
        text_.skip_value();
      }
    });
  }

  /// Reads ( "comment" key = value ... ), if it is there. read: takes a key, and reads its value from the text.
  template <class Read>
  void read_metadata(const char* expected, const Read& read) {
    if (!text_.take('(')) return;
    while (!text_.error() && !text_.take(')')) {
      if (text_.peek() == '"' || text_.peek() == '\'') {
        text_.quoted();
        continue;
      }
      if (text_.take(';') || text_.take(',')) continue;
      const std::string key(text_.word());
      if (key.empty()) return text_.fail_here(expected);
      if (composes_otherwise(key)) return text_.fail(flat_stage, key);
      if (text_.take('=')) read(key);
    }
  }

  /// Reads def, over or class with its body, or another statement of the level.
  void read_prim_statement(UsdaPrim* parent, int depth) {
    const std::string keyword(text_.word());
    if (keyword == "reorder") {
      text_.word();
      text_.expect('=', "behind reorder");
      return text_.skip_value();
    }
    if (keyword != "def" && keyword != "over" && keyword != "class") return text_.fail_here("def, over or class");
    UsdaPrim prim{.name = {}, .type = std::string(text_.word())};
    prim.name = printable(std::string(text_.quoted().substr(0, 256)));
    if (depth >= deepest_prim) return text_.fail(fmt::format("at most {} prims in one another", deepest_prim), "more");
    prim.is_defined = keyword == "def";
    read_metadata("a key of a prim, or \")\"", [&](const std::string& key) {
      if (key == "active") {
        prim.is_active = text_.peek_word() != "false" && text_.peek_word() != "0";
        text_.word();
      } else if (is_arc(key)) {
        read_arcs(key, &prim);
      } else {
        text_.skip_value();
      }
    });
    read_body(&prim, depth);
    if (!text_.error()) parent->children.push_back(std::move(prim));
    ++prims_;
  }

  /// Reads </Path>, [</Path>, </Path>] or None: references within the same layer.
  void read_arcs(const std::string& key, UsdaPrim* prim) {
    const bool is_list = text_.take('[');
    while (!text_.error() && !(is_list && text_.take(']'))) {
      if (text_.peek() == '@') return text_.fail(flat_stage, key + " of another file");
      if (text_.take('<')) {
        prim->arcs.emplace_back(text_.until('>'));
        if (text_.peek() == '(') text_.skip_value();  // skips a layer offset
      } else {
        text_.skip_value();
      }
      if (!is_list) return;
      text_.take(',');
    }
  }

  void read_body(UsdaPrim* prim, int depth) {
    if (!text_.expect('{', "before the body of a prim")) return;
    while (!text_.error() && !text_.take('}')) {
      const std::string_view word = text_.peek_word();
      if (word == "def" || word == "over" || word == "class")
        read_prim_statement(prim, depth + 1);
      else if (word == "variantSet")
        text_.fail(flat_stage, "variantSet");
      else if (!text_.take(';'))
        read_property(prim);
    }
  }

  /// Reads an attribute or a relationship, with any words before it.
  void read_property(UsdaPrim* prim) {
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
    const bool is_relation = word == "rel", is_triple = word.find('3') != std::string_view::npos;
    if (!is_relation && text_.take('[')) text_.expect(']', "of an array's type");
    std::string name(text_.word());
    if (name.empty()) return text_.fail_here("the name of an attribute");
    const bool samples = name.ends_with(".timeSamples"), is_connection = name.ends_with(".connect");
    if (samples) name.resize(name.size() - 12);
    const bool has_value = text_.take('=');
    const std::size_t at = text_.at();
    if (has_value) text_.skip_value();
    UsdaValue metadata;
    read_usda_attribute_metadata(&text_, &metadata);
    if (is_connection || text_.error()) return;
    UsdaAttribute& attribute = prim->attributes[name];
    if (metadata.scope) attribute.scope = metadata.scope;
    attribute.is_triple = is_triple;
    if (has_value) (samples ? attribute.samples : attribute.value) = at;
  }

  TextCursor& text_;
  GroomFile& file_;
  double time_codes_per_second_ = 24;
  std::uint64_t prims_ = 0;
};

class UsdaReader {
 public:
  explicit UsdaReader(const GroomInput& input)
      : text_(input.bytes, input.name, input.done_with),
        builder_(input.name, "a USD text"),
        frame_(input.frame),
        attribute_(input.attribute.empty() ? "primvars:displayColor" : "primvars:" + input.attribute),
        most_vertices_(most_sharing * (input.bytes.size() / least_bytes_of_vertex + 1)) {
    if (!input.attribute.empty()) builder_.file().attribute = input.attribute;
  }

  Result<GroomFile> read() {
    UsdaLayer layer(&text_, &builder_.file());
    root_ = layer.read();
    time_codes_per_second_ = layer.time_codes_per_second();
    prims_ = layer.prims();
    if (!failed()) visit_children({&root_}, {});
    if (text_.error()) return *text_.error();
    if (error_) return *error_;
    return builder_.finish();
  }

 private:
  /// What a prim inherits from above.
  struct Place {
    std::string path = {};
    glm::dmat4 to_file{1.0};
    std::string purpose = "default";  ///< from the nearest prim that sets one
    int depth = 0, arcs = 0;
    /// Primvars of prims above that have a single value.
    std::map<std::string, const UsdaAttribute*, std::less<>> primvars = {};
  };

  /// The places in the layer that have opinions on one prim, the strongest first.
  using Opinions = std::vector<const UsdaPrim*>;

  bool failed() const { return text_.error().has_value() || error_.has_value(); }

  const UsdaPrim* prim_at(std::string_view path) const {
    const UsdaPrim* here = &root_;
    while (here && !path.empty()) {
      path.remove_prefix(path[0] == '/' ? 1 : 0);
      const std::string_view name = path.substr(0, path.find('/'));
      path.remove_prefix(name.size());
      if (!name.empty()) here = here->child(name);
    }
    return here;
  }

  /// Adds to each prim, after it, the prims to which it refers.
  Opinions with_arcs(const Opinions& direct, Place* here) {
    Opinions all;
    const auto add = [&](const auto& self, const UsdaPrim* prim, int depth) -> void {
      if (std::ranges::find(all, prim) != all.end()) return;
      all.push_back(prim);
      for (const std::string& path : prim->arcs) {
        const UsdaPrim* to = prim_at(path);
        if (!to || depth >= deepest_arc)
          builder_.ignore(here->path, to ? "what it refers to refers on and on"
                                         : "what it refers to is not there: " + printable(path.substr(0, 128)));
        else
          self(self, to, depth + 1);
      }
    };
    for (const UsdaPrim* prim : direct) add(add, prim, 0);
    return all;
  }

  static const UsdaAttribute* find(const Opinions& prims, std::string_view name) {
    for (const UsdaPrim* prim : prims)
      if (const auto found = prim->attributes.find(name); found != prim->attributes.end())
        if (found->second.value || found->second.samples) return &found->second;
    return nullptr;
  }

  /// The value at the frame: samples win over the default.
  UsdaValue value_of(const UsdaAttribute& attribute, std::string_view name) {
    UsdaValue value;
    const std::optional<std::size_t> at = attribute.samples ? attribute.samples : attribute.value;
    if (!at || failed()) return value;
    text_.go_to(*at);
    const UsdaNumbers kept_as =
        name == attribute_ && attribute.is_triple ? UsdaNumbers::triples : usda_numbers_of(name);
    value = read_usda_value(&text_, attribute.samples.has_value(), kept_as, frame_, is_held(name));
    value.scope = attribute.scope;
    animated_ = animated_ || value.is_animated;
    return value;
  }

  UsdaValue value_of(const Opinions& prims, std::string_view name) {
    const UsdaAttribute* found = find(prims, name);
    return found ? value_of(*found, name) : UsdaValue{};
  }

  std::string word_of(const Opinions& prims, std::string_view name, const char* usual) {
    const UsdaValue value = value_of(prims, name);
    return value.texts.empty() ? usual : value.texts[0];
  }

  void visit_children(const Opinions& prims, const Place& here) {
    std::vector<std::string> names;
    for (const UsdaPrim* prim : prims)
      for (const UsdaPrim& child : prim->children)
        if (std::ranges::find(names, child.name) == names.end()) names.push_back(child.name);
    for (const std::string& name : names) {
      Opinions children;
      for (const UsdaPrim* prim : prims)
        if (const UsdaPrim* child = prim->child(name)) children.push_back(child);
      Place below = here;
      below.path += "/" + name;
      visit(children, std::move(below));
    }
  }

  void visit(const Opinions& direct, Place here) {
    if (failed()) return;
    if (++here.depth > deepest_prim || ++visited_ > most_sharing * (prims_ + 64)) {
      error_ = Error{text_.name(), here.path.substr(0, 256),
                     fmt::format("at most {} prims in one another, and {} times those of the layer in all",
                                 deepest_prim, most_sharing),
                     "more"};
      return;
    }
    const Opinions prims = with_arcs(direct, &here);
    const bool is_defined = std::ranges::any_of(direct, &UsdaPrim::is_defined);
    const bool is_active = std::ranges::all_of(direct, &UsdaPrim::is_active);
    if (!is_defined || !is_active) return;
    std::string type;
    for (const UsdaPrim* prim : prims)
      if (type.empty()) type = prim->type;
    if (type == "PointInstancer") return builder_.ignore(type + " " + here.path, "instances of points are not made");
    if (!place(prims, &here)) return;
    if (word_of(prims, "visibility", "inherited") == "invisible") return builder_.ignore(here.path, "it is invisible");
    here.purpose = word_of(prims, "purpose", here.purpose.c_str());
    if (type == "BasisCurves") {
      if (here.purpose == "guide" || here.purpose == "proxy")
        builder_.ignore(here.path, "its purpose is guide or proxy");
      else
        use(prims, here);
    } else if (std::ranges::find(quiet_types, type) == std::end(quiet_types)) {
      builder_.ignore(fmt::format("{} {}", type, here.path), "prims of this type are not read");
    }
    for (auto prim = prims.rbegin(); prim != prims.rend(); ++prim)
      for (const auto& [name, attribute] : (*prim)->attributes)
        if (name.starts_with("primvars:") && (attribute.value || attribute.samples) &&
            attribute.scope.value_or(AttributeScope::constant) == AttributeScope::constant)
          here.primvars[name] = &attribute;
    visit_children(prims, here);
  }

  bool place(const Opinions& prims, Place* here) {
    std::map<std::string, UsdaValue, std::less<>> transforms;
    for (const UsdaPrim* prim : prims)
      for (const auto& [name, attribute] : prim->attributes)
        if (is_of_transform(name) && !transforms.contains(name)) transforms.emplace(name, value_of(attribute, name));
    const UsdaTransform transform = usda_transform(transforms);
    if (!transform.fault.empty() && !failed())
      error_ = Error{text_.name(), here->path, "an xformOp that USD has, with as many numbers as it needs",
                     transform.fault.substr(0, 64)};
    here->to_file = transform.resets ? transform.to_parent : here->to_file * transform.to_parent;
    return !failed();
  }

  CurveKind kind_of(const Opinions& prims, std::string* fault) {
    const std::string type = word_of(prims, "type", "cubic"), basis = word_of(prims, "basis", "bezier"),
                      wrap = word_of(prims, "wrap", "nonperiodic");
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

  void use(const Opinions& prims, const Place& here) {
    const auto fail = [&](std::string expected, std::string found) {
      if (!failed()) error_ = Error{text_.name(), here.path, std::move(expected), std::move(found)};
    };
    std::string fault;
    CurveSet set;
    set.name = here.path;
    set.kind = kind_of(prims, &fault);
    if (!fault.empty()) {
      const std::size_t comma = fault.rfind(", found ");
      return fail(fault.substr(0, comma), "\"" + fault.substr(comma + 8, 64) + "\"");
    }
    set.to_file = here.to_file;
    for (const float count : value_of(prims, "curveVertexCounts").numbers) {
      if (!(count >= 0 && count <= 16777216.0f) || count != std::floor(count))
        return fail("whole curveVertexCounts of at most 2^24", fmt::format("{:g}", count));
      set.vertex_counts.push_back(static_cast<std::uint32_t>(count));
    }
    UsdaValue points = value_of(prims, "points");
    if (const std::size_t over = points.numbers.size())
      return fail("points of three numbers", fmt::format("{} numbers", 3 * points.triples.size() + over));
    go_on(prims, &points);
    set.vertices = std::move(points.triples);
    vertices_ += set.vertices.size();
    if (vertices_ > most_vertices_)
      return fail(fmt::format("at most {} vertices, as the bytes allow", most_vertices_), "more");
    if (failed()) return;
    name_what_is_left(prims, here);
    if (set.vertex_counts.empty()) return builder_.ignore(here.path, "it has no curves");
    take_attributes(prims, here, &set);
    if (failed()) return;
    if (auto error = builder_.add(std::move(set))) error_ = error;
    if (animated_ && !frame_) builder_.file().remarks.push_back("it is animated: the first time sample is used");
    builder_.file().is_animated = builder_.file().is_animated || animated_;
  }

  /// Moves points by their velocities if they come from one sample only, because the next sample has another number of
  /// points or there is none.
  void go_on(const Opinions& prims, UsdaValue* points) {
    const UsdaAttribute* velocities = find(prims, "velocities");
    if (!velocities || !frame_ || !points->held_since) return;
    const UsdaValue way = value_of(*velocities, "velocities");
    if (way.triples.size() != points->triples.size()) return builder_.ignore("velocities", "they are not one a point");
    animated_ = true;
    const auto seconds = static_cast<float>((*frame_ - *points->held_since) / time_codes_per_second_);
    for (std::size_t i = 0; i < way.triples.size(); ++i) points->triples[i] += seconds * way.triples[i];
  }

  void name_what_is_left(const Opinions& prims, const Place& here) {
    for (const UsdaPrim* prim : prims)
      for (const auto& [name, attribute] : prim->attributes) {
        if (name == "material:binding")
          builder_.file().materials.push_back(here.path + ": bound to a USD material, which is not read");
        const std::string_view base =
            std::string_view(name).substr(0, name.ends_with(":indices") ? name.size() - 8 : name.size());
        if (name.starts_with("userProperties:") || name.starts_with("material:binding") || is_of_transform(name))
          continue;
        if (const char* why = why_not_used(usda_table, base); *why != 0 && base != attribute_)
          builder_.ignore(name.substr(0, 128), why);
      }
  }

  /// The value of a primvar at every place where it is given, by its indices if it has some.
  UsdaValue primvar(const Opinions& prims, const Place& here, const std::string& name) {
    const UsdaAttribute *found = find(prims, name), *at = find(prims, name + ":indices");
    if (!found) {
      const auto above = here.primvars.find(name), its = here.primvars.find(name + ":indices");
      found = above == here.primvars.end() ? nullptr : above->second;
      at = found && its != here.primvars.end() ? its->second : nullptr;
    }
    if (!found) return {};
    UsdaValue value = value_of(*found, name);
    if (!at) return value;
    const std::vector<double> indices = value_of(*at, name + ":indices").precise;
    const bool fits = !indices.empty() && look_up(indices, 1, &value.triples) &&
                      look_up(indices, name.ends_with("st") || name.ends_with("uv") ? 2 : 1, &value.numbers) &&
                      look_up(indices, 1, &value.precise);
    if (fits) return value;
    builder_.ignore(name, "its indices point outside");
    return {};
  }

  /// size: number of numbers in a value.
  template <class T>
  static bool look_up(const std::vector<double>& indices, std::size_t size, std::vector<T>* values) {
    if (values->empty()) return true;
    std::vector<T> out;
    out.reserve(indices.size() * size);
    for (const double index : indices) {
      if (!(index >= 0 && index < static_cast<double>(values->size() / size))) return false;
      const auto first = values->begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(index) * size);
      out.insert(out.end(), first, first + static_cast<std::ptrdiff_t>(size));
    }
    *values = std::move(out);
    return true;
  }

  /// Returns the first that exists of two names for one thing.
  UsdaValue first_of(const Opinions& prims, const Place& here, std::initializer_list<const char*> names,
                     std::string* name) {
    for (const char* candidate : names) {
      UsdaValue value = primvar(prims, here, candidate);
      if (value.numbers.empty() && value.triples.empty() && value.precise.empty()) continue;
      *name = candidate;
      return value;
    }
    return {};
  }

  /// Returns one tuple for each curve, from values that are one a curve or one a vertex; the root's vertex is used.
  template <class T>
  std::vector<T> at_roots(const std::vector<T>& values, std::size_t size, const CurveSet& set,
                          const std::string& name) {
    const std::size_t curves = set.vertex_counts.size(), tuples = values.size() / size;
    std::vector<T> out;
    if (values.empty()) return out;
    if (tuples != curves && tuples != set.vertices.size()) {
      builder_.ignore(name, fmt::format("it is not {} a curve", size == 1 ? "one number" : "one pair"));
      return out;
    }
    std::size_t first = 0;
    for (std::size_t c = 0; c < curves; ++c) {
      const std::size_t at = size * (tuples == curves ? c : std::min(first, tuples - 1));
      for (std::size_t k = 0; k < size; ++k) out.push_back(values[at + k]);
      first += set.vertex_counts[c];
    }
    return out;
  }

  void take_attributes(const Opinions& prims, const Place& here, CurveSet* set) {
    std::string name;
    UsdaValue widths = first_of(prims, here, {"primvars:widths", "widths"}, &name);
    set->width = {std::move(widths.numbers), widths.scope, name};
    UsdaValue normals = first_of(prims, here, {"primvars:normals", "normals"}, &name);
    set->normal = {std::move(normals.triples), normals.scope, name};
    if (normals.is_animated && frame_)
      builder_.file().remarks.push_back(here.path +
                                        ": normals change in time; while the shutter is open those of its "
                                        "opening turn with the strands");
    UsdaValue colors = first_of(prims, here, {attribute_.c_str()}, &name);
    for (const float number : colors.numbers) colors.triples.emplace_back(number);
    set->color = {std::move(colors.triples), colors.scope, name};
    const UsdaValue ids = first_of(prims, here, {"primvars:id", "primvars:ids", "ids", "primvars:groom_id"}, &name);
    for (const double id : at_roots(ids.precise, 1, *set, name))
      set->id.push_back(std::abs(id) < 1e15 ? static_cast<std::int64_t>(id) : -1);
    const UsdaValue uv = first_of(prims, here, {"primvars:groom_root_uv", "primvars:st", "primvars:uv"}, &name);
    const std::vector<float> pairs = at_roots(uv.numbers, 2, *set, name);
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) set->root_uv.emplace_back(pairs[i], pairs[i + 1]);
  }

  TextCursor text_;
  GroomBuilder builder_;
  UsdaPrim root_;
  std::optional<Error> error_;
  std::optional<double> frame_;  ///< unset: the first time samples
  std::string attribute_;        ///< the attribute that is read for the color
  double time_codes_per_second_ = 24;
  std::uint64_t prims_ = 0, visited_ = 0, vertices_ = 0, most_vertices_;
  bool animated_ = false;  ///< whether anything so far was animated
};

}  // namespace

std::span<const FormatItem> usda_items() { return usda_table; }

Result<GroomFile> read_usda(const GroomInput& input) { return UsdaReader(input).read(); }

}  // namespace tress::scene
