// Reads USD: the curves of one layer, with the transforms, states and primvars above them (README.md). The layer is
// first read as a tree of prims; the values that the picture needs are then read by their places.
#include "scene/read/grooms/usd_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <iterator>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/text_cursor.h"
#include "scene/read/grooms/usd_layer.h"
#include "scene/read/grooms/usdz_file.h"

namespace tress::scene {
namespace {

constexpr int deepest_arc = 16;
constexpr std::uint64_t least_bytes_of_vertex = 8;
/// Instances that cannot share strands are copies, which take more than the bytes of a file allow otherwise: so many of
/// them, of so many vertices each.
constexpr std::uint64_t most_copies = 4096, vertices_of_copy = 8192;

constexpr const char* why_no_cards = "curves are drawn, not cards in their place";

/// Attributes of curves. Those without effect on the picture are listed as used.
constexpr FormatItem usd_table[] = {
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
    {"colorSpace:name", ""},
    {"accelerations", "points go straight on by their velocities"},
    {"primvars:displayOpacity", "hair is not transparent by an attribute"},
    {"primvars:skel:jointIndices", "skeletons do not move curves"},
    {"primvars:skel:jointWeights", "skeletons do not move curves"},
    {"primvars:skel:geomBindTransform", "skeletons do not move curves"},
    {"model:drawMode", why_no_cards},
};

constexpr const char* why_no_velocities = "instances go straight from one time sample to the next";

/// Attributes of instancers of points, and their `inactiveIds`.
constexpr FormatItem usd_instancer_table[] = {
    {"prototypes", ""},
    {"protoIndices", ""},
    {"positions", ""},
    {"orientations", ""},
    {"orientationsf", ""},
    {"scales", ""},
    {"ids", ""},
    {"invisibleIds", ""},
    {"inactiveIds", ""},
    {"visibility", ""},
    {"purpose", ""},
    {"extent", ""},
    {"colorSpace:name", ""},
    {"velocities", why_no_velocities},
    {"accelerations", why_no_velocities},
    {"angularVelocities", why_no_velocities},
    {"model:drawMode", why_no_cards},
};

/// Types of prims that do not affect the picture themselves.
constexpr std::string_view quiet_types[] = {"",         "Xform",      "Scope",    "Material", "Shader",     "NodeGraph",
                                            "SkelRoot", "GeomSubset", "Skeleton", "Camera",   "BasisCurves"};

constexpr std::initializer_list<const char*> root_uv_names = {"primvars:groom_root_uv", "primvars:st", "primvars:uv"};

bool is_binding(std::string_view name) { return name.starts_with("material:binding"); }

bool is_of_transform(std::string_view name) { return name.starts_with("xformOp:") || name == "xformOpOrder"; }

UsdNumbers usd_numbers_of(std::string_view name) {
  const bool is_id =
      name.ends_with("id") || name.ends_with("ids") || name.ends_with("Ids") || name.ends_with(":indices");
  if (name.starts_with("xformOp:orient") || name.starts_with("orientations")) return UsdNumbers::quaternions;
  if (is_of_transform(name) || is_id) return UsdNumbers::doubles;
  const bool is_vector = name == "points" || name == "normals" || name == "primvars:normals" || name == "velocities" ||
                         name == "positions" || name == "scales";
  return is_vector || name == "primvars:displayColor" ? UsdNumbers::triples : UsdNumbers::floats;
}

/// Whether the value is constant after each time sample, not interpolated.
bool is_held(std::string_view name) {
  return name == "curveVertexCounts" || name == "visibility" || name.ends_with(":indices") || name.ends_with("id") ||
         name.ends_with("ids") || name.ends_with("Ids") || name == "protoIndices" || name == "velocities";
}

class UsdReader {
 public:
  UsdReader(const GroomInput& input, const std::string& format, std::unique_ptr<UsdLayer> layer)
      : name_(input.name),
        layer_(std::move(layer)),
        builder_(input.name, format),
        frame_(input.frame),
        attribute_(input.attribute.empty() ? "primvars:displayColor" : "primvars:" + input.attribute),
        most_vertices_(most_sharing * (input.bytes.size() / least_bytes_of_vertex + 1)) {
    if (!input.attribute.empty()) builder_.file().attribute = input.attribute;
    builder_.file().origin = input.origin;
  }

  Result<GroomFile> read() {
    root_ = layer_->read();
    builder_.file().cm_per_unit = layer_->stage.cm_per_unit;
    builder_.file().y_up = layer_->stage.y_up;
    for (const IgnoredAttribute& ignored : layer_->ignored) builder_.ignore(ignored.name, ignored.why);
    if (!failed()) visit_children({&root_}, {});
    if (layer_->error()) return *layer_->error();
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
    bool has_material = false;  ///< whether this prim or one above is bound to a material
    bool is_in_curves = false, is_in_prototype = false;
    /// Primvars of prims above that have a single value.
    std::map<std::string, const UsdAttribute*, std::less<>> primvars = {};
  };

  /// The places in the layer that have opinions on one prim, the strongest first.
  using Opinions = std::vector<const UsdPrim*>;

  /// All that decides the strands of prims, besides their transform. Those that are alike share them.
  struct Alike {
    Opinions opinions;
    std::string type, purpose;
    std::map<std::string, const UsdAttribute*, std::less<>> primvars;
    bool has_transform = false;  ///< whether its strands have one of the prims' own

    auto operator<=>(const Alike&) const = default;
  };

  bool failed() const { return layer_->error().has_value() || error_.has_value(); }

  const UsdPrim* prim_at(std::string_view path) const {
    const UsdPrim* here = &root_;
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
    const auto add = [&](const auto& self, const UsdPrim* prim, int depth) -> void {
      if (std::ranges::find(all, prim) != all.end()) return;
      all.push_back(prim);
      for (const std::string& path : prim->arcs) {
        const UsdPrim* to = prim_at(path);
        if (!to || depth >= deepest_arc)
          builder_.ignore(here->path, to ? "what it refers to refers on and on"
                                         : "what it refers to is not there: " + printable(path.substr(0, 128)));
        else
          self(self, to, depth + 1);
      }
    };
    for (const UsdPrim* prim : direct) add(add, prim, 0);
    return all;
  }

  static const UsdAttribute* find(const Opinions& prims, std::string_view name) {
    for (const UsdPrim* prim : prims)
      if (const auto found = prim->attributes.find(name); found != prim->attributes.end())
        if (found->second.value || found->second.samples) return &found->second;
    return nullptr;
  }

  UsdValue value_of(const UsdAttribute& attribute, std::string_view name) {
    if (failed()) return {};
    const UsdNumbers kept_as = name == attribute_ && attribute.is_triple ? UsdNumbers::triples : usd_numbers_of(name);
    UsdValue value = layer_->value_of(attribute, kept_as, frame_, is_held(name));
    if (!value.not_read.empty()) builder_.ignore(std::string(name), value.not_read);
    animated_ = animated_ || value.is_animated;
    return value;
  }

  UsdValue value_of(const Opinions& prims, std::string_view name) {
    const UsdAttribute* found = find(prims, name);
    return found ? value_of(*found, name) : UsdValue{};
  }

  std::string word_of(const Opinions& prims, std::string_view name, const char* usual) {
    const UsdValue value = value_of(prims, name);
    return value.texts.empty() ? usual : value.texts[0];
  }

  void visit_children(const Opinions& prims, const Place& here) {
    struct Child {
      Opinions opinions = {};
      const UsdPrim* parent = nullptr;  ///< that of the last opinion; it contributes only its first child of a name
    };
    std::vector<Child> children;
    std::unordered_map<std::string_view, std::size_t> places;
    for (const UsdPrim* prim : prims)
      for (const UsdPrim& child : prim->children) {
        if (child.name.starts_with(usdz_graft)) continue;
        const auto [place, is_new] = places.try_emplace(child.name, children.size());
        if (is_new) children.emplace_back();
        Child& found = children[place->second];
        if (std::exchange(found.parent, prim) != prim) found.opinions.push_back(&child);
      }
    for (const Child& child : children) {
      Place below = here;
      below.path += "/" + child.opinions[0]->name;
      visit(child.opinions, std::move(below));
    }
  }

  void visit(const Opinions& direct, Place here) {
    const bool is_defined = std::ranges::any_of(direct, &UsdPrim::is_defined);
    const Opinions prims = enter(direct, is_defined, &here);
    if (prims.empty()) return;
    // What it refers to is all that decides its strands, unless it has children or attributes of its own.
    const std::string type = type_of(prims);
    const auto decides_strands = [&](const UsdPrim* prim) { return decides(prim, type); };
    Opinions others;
    std::ranges::copy_if(prims, std::back_inserter(others), decides_strands);
    if (others.empty() || std::ranges::any_of(direct, decides_strands)) return draw(prims, std::move(here));
    Alike alike{std::move(others), type, here.purpose, here.primvars};
    share(prims, std::move(here), glm::dmat4(1.0), std::move(alike));
  }

  static std::string type_of(const Opinions& prims) {
    const auto typed = std::ranges::find_if(prims, [](const UsdPrim* prim) { return !prim->type.empty(); });
    return typed == prims.end() ? "" : (*typed)->type;
  }

  /// Whether an opinion on a prim of this type has children, or attributes that matter besides its place.
  static bool decides(const UsdPrim* prim, std::string_view type) {
    const bool is_drawn = type == "BasisCurves" || type == "PointInstancer";
    return !prim->children.empty() || !prim->prototypes.empty() ||
           std::ranges::any_of(prim->attributes, [&](const auto& one) {
             const std::string& name = one.first;
             if (is_of_transform(name) || is_binding(name) || name == "visibility" || name == "purpose") return false;
             return is_drawn || name.starts_with("primvars:") || name == "model:drawMode" || name == "colorSpace:name";
           });
  }

  /// Takes the transform and the state of a prim. Returns all opinions on it, or none if it is not drawn.
  Opinions enter(const Opinions& direct, bool is_defined, Place* here) {
    if (failed()) return {};
    if (++here->depth > deepest_prim || ++visited_ > most_sharing * (layer_->prims + 64 + copies_)) {
      error_ = Error{name_, here->path.substr(0, 256),
                     fmt::format("at most {} prims in one another, and {} times those of the layer in all",
                                 deepest_prim, most_sharing),
                     "more"};
      return {};
    }
    Opinions prims = with_arcs(direct, here);
    const auto active = std::ranges::find_if(prims, [](const UsdPrim* prim) { return prim->is_active.has_value(); });
    if (!is_defined || (active != prims.end() && !*(*active)->is_active) || !place(prims, here)) return {};
    here->purpose = word_of(prims, "purpose", here->purpose.c_str());
    if (word_of(prims, "visibility", "inherited") != "invisible") return prims;
    builder_.ignore(here->path, "it is invisible");
    return {};
  }

  /// Draws prims, as an instance of those that are alike. within: a transform of their own before that of the place.
  void share(const Opinions& prims, Place here, const glm::dmat4& within, Alike alike) {
    constexpr std::size_t is_open = SIZE_MAX;
    const glm::dmat4 to_file = std::exchange(here.to_file, here.to_file * within);
    builder_.file().is_animated = builder_.file().is_animated || animated_;
    const auto [found, is_new] = prototypes_.try_emplace(std::move(alike));
    std::optional<std::size_t>& prototype = found->second;
    const bool shares = is_new ? is_similarity(to_file) : builder_.can_share(to_file);
    if (failed() || !shares || prototype == is_open) {
      if (!is_new && copies_ < most_copies) {
        ++copies_;
        most_vertices_ += vertices_of_copy;
      }
      return draw(prims, std::move(here));
    }
    if (!prototype) {
      prototype = is_open;
      builder_.begin_prototype();
      here.to_file = within;
      here.is_in_prototype = true;
      draw(prims, std::move(here));
      prototype = builder_.end_prototype();
    }
    if (auto error = builder_.add_instance(*prototype, to_file); error && !failed()) error_ = error;
  }

  void draw(const Opinions& prims, Place here) {
    const std::string type = type_of(prims), mode = word_of(prims, "model:drawMode", "default");
    if (mode != "default" && mode != "inherited") builder_.ignore(here.path + ": model:drawMode", why_no_cards);
    if (const std::string space = word_of(prims, "colorSpace:name", ""); !is_taken_space(space))
      builder_.ignore(here.path + ": colorSpace:name " + printable(space.substr(0, 64)), why_one_space);
    if (type == "PointInstancer") return instance_points(prims, here);
    const bool is_bound = std::ranges::any_of(prims, [](const UsdPrim* prim) {
      return std::ranges::any_of(prim->attributes, [](const auto& one) { return is_binding(one.first); });
    });
    here.has_material = here.has_material || is_bound;
    if (type == "GeomSubset" && here.is_in_curves && is_bound) note_material(here);
    if (type == "BasisCurves") {
      if (here.purpose == "guide" || here.purpose == "proxy")
        builder_.ignore(here.path, "its purpose is guide or proxy");
      else
        use(prims, here);
      here.is_in_curves = true;
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

  /// The opinions on a prototype of an instancer: below it, or elsewhere in the layer.
  Opinions prototype_at(const std::string& path, const Opinions& instancer, Place here) {
    const std::string above = here.path + "/";
    Opinions at;
    if (!path.starts_with(above)) {
      if (const UsdPrim* prim = prim_at(path)) at.push_back(prim);
      return at;
    }
    at = instancer;
    for (std::string_view left = std::string_view(path).substr(above.size()); !left.empty();) {
      const std::string_view name = left.substr(0, left.find('/'));
      left.remove_prefix(std::min(left.size(), name.size() + 1));
      Opinions below;
      for (const UsdPrim* prim : at)
        if (const UsdPrim* child = prim->child(name)) below.push_back(child);
      at = left.empty() ? below : with_arcs(below, &here);
    }
    return at;
  }

  /// Draws the instances of an instancer. Other prims below it are not drawn.
  void instance_points(const Opinions& prims, const Place& here) {
    const auto fail = [&](const std::string& attribute, std::string expected, std::string found) {
      if (!failed()) error_ = Error{name_, here.path + "." + attribute, std::move(expected), std::move(found)};
    };
    name_what_is_left_of_instancer(prims, here);
    const std::vector<float> indices = value_of(prims, "protoIndices").numbers;
    const std::vector<glm::vec3> positions = value_of(prims, "positions").triples,
                                 scales = value_of(prims, "scales").triples;
    const bool has_floats = find(prims, "orientationsf") != nullptr;
    const std::vector<double> turns = value_of(prims, has_floats ? "orientationsf" : "orientations").precise,
                              ids = value_of(prims, "ids").precise;
    std::set<double> hidden;
    for (const char* name : {"invisibleIds", "inactiveIds"})
      for (const double id : value_of(prims, name).precise) hidden.insert(id);
    const auto check = [&](const char* name, std::size_t found, std::size_t numbers, bool is_needed) {
      if (found != numbers * indices.size() && (found > 0 || is_needed))
        fail(name, fmt::format("{}, as many as protoIndices", numbers * indices.size()), fmt::format("{}", found));
    };
    check("positions", positions.size(), 1, true);
    check("scales", scales.size(), 1, false);
    check(has_floats ? "orientationsf" : "orientations", turns.size(), 4, false);
    check("ids", ids.size(), 1, false);
    if (indices.empty()) builder_.ignore(here.path, "it has no instances");
    std::vector<std::string> targets;
    for (const UsdPrim* prim : prims)
      if (targets.empty()) targets = prim->prototypes;
    std::vector<std::pair<Opinions, Place>> prototypes;
    for (const std::string& target : targets) {
      const Opinions direct = prototype_at(target, prims, here);
      if (direct.empty())
        builder_.ignore(here.path + ": prototypes",
                        "what it refers to is not there: " + printable(target.substr(0, 128)));
      Place inside = here;
      inside.path = target;
      inside.to_file = glm::dmat4(1.0);
      inside.is_in_prototype = true;
      Opinions all = direct.empty() ? Opinions() : enter(direct, true, &inside);
      prototypes.emplace_back(std::move(all), std::move(inside));
    }
    std::size_t flat = 0;
    for (std::size_t i = 0; i < indices.size() && !failed(); ++i) {
      if (!(indices[i] >= 0 && indices[i] < static_cast<float>(prototypes.size())))
        return fail("protoIndices", fmt::format("numbers of the {} prototypes, from 0", prototypes.size()),
                    fmt::format("{:g} at {}", indices[i], i));
      const auto& [its, inside] = prototypes[static_cast<std::size_t>(indices[i])];
      if (its.empty() || hidden.contains(ids.empty() ? static_cast<double>(i) : ids[i])) continue;
      glm::dmat4 to_instancer = glm::translate(glm::dmat4(1.0), glm::dvec3(positions[i]));
      if (!turns.empty()) to_instancer = to_instancer * usd_rotation(&turns[4 * i]);
      if (!scales.empty()) to_instancer = glm::scale(to_instancer, glm::dvec3(scales[i]));
      if (glm::determinant(to_instancer) == 0) {
        ++flat;
        continue;
      }
      // Where a prototype is itself stretched, its strands have that transform; else they rest where it moves.
      const bool is_stretched = !is_similarity(inside.to_file);
      Place at = inside;
      at.to_file = here.to_file * (is_stretched ? to_instancer : to_instancer * inside.to_file);
      share(its, std::move(at), is_stretched ? inside.to_file : glm::dmat4(1.0),
            {its, type_of(its), inside.purpose, inside.primvars, is_stretched});
    }
    if (flat > 0)
      builder_.ignore(fmt::format("{}: {} of {} instances", here.path, flat, indices.size()), "their scale is 0");
    if (targets.empty()) builder_.ignore(here.path, "it has no prototypes");
  }

  void name_what_is_left_of_instancer(const Opinions& prims, const Place& here) {
    for (const UsdPrim* prim : prims)
      for (const auto& [name, attribute] : prim->attributes) {
        if (name.starts_with("userProperties:") || is_binding(name) || is_of_transform(name)) continue;
        const char* why = name.starts_with("primvars:") ? "instances have the attributes of their prototype"
                                                        : why_not_used(usd_instancer_table, name);
        if (*why != 0) builder_.ignore(fmt::format("{}: {}", here.path, name.substr(0, 128)), why);
      }
    if (find(prims, "orientationsf") && find(prims, "orientations"))
      builder_.ignore(here.path + ": orientations", "orientationsf is in its place");
  }

  bool place(const Opinions& prims, Place* here) {
    std::map<std::string, UsdValue, std::less<>> transforms;
    for (const UsdPrim* prim : prims)
      for (const auto& [name, attribute] : prim->attributes)
        if (is_of_transform(name) && !transforms.contains(name)) transforms.emplace(name, value_of(attribute, name));
    const UsdTransform transform = usd_transform(transforms);
    if (!transform.fault.empty() && !failed())
      error_ = Error{name_, here->path, "an xformOp that USD has, with as many numbers as it needs",
                     transform.fault.substr(0, 64)};
    if (!transform.missing.empty())
      builder_.ignore(here->path + ": " + printable(transform.missing.substr(0, 64)), "it has no value");
    const bool resets = transform.resets && !here->is_in_prototype;
    if (transform.resets && !resets)
      builder_.ignore(here->path + ": !resetXformStack!", "an instance moves all that is in it");
    here->to_file = resets ? transform.to_parent : here->to_file * transform.to_parent;
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
      if (!failed()) error_ = Error{name_, here.path, std::move(expected), std::move(found)};
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
    UsdValue points = value_of(prims, "points");
    if (const std::size_t over = points.numbers.size())
      return fail("points of three numbers", fmt::format("{} numbers", 3 * points.triples.size() + over));
    go_on(prims, &points);
    set.vertices = std::move(points.triples);
    vertices_ += set.vertices.size();
    if (vertices_ > most_vertices_)
      return fail(fmt::format("at most {} vertices, as the bytes allow", most_vertices_), "more");
    if (failed()) return;
    name_what_is_left(prims, here);
    if (here.has_material) note_material(here);
    if (set.vertex_counts.empty()) return builder_.ignore(here.path, "it has no curves");
    take_attributes(prims, here, &set);
    if (failed()) return;
    if (auto error = builder_.add(std::move(set))) error_ = error;
    if (animated_ && !frame_) builder_.file().remarks.emplace_back("it is animated: the first time sample is used");
    builder_.file().is_animated = builder_.file().is_animated || animated_;
  }

  /// Moves points by their velocities if they come from one sample only, because the next sample is missing or has
  /// another number of points.
  void go_on(const Opinions& prims, UsdValue* points) {
    const UsdAttribute* velocities = find(prims, "velocities");
    if (!velocities || !frame_ || !points->held_since) return;
    const UsdValue way = value_of(*velocities, "velocities");
    if (way.triples.size() != points->triples.size()) return builder_.ignore("velocities", "they are not one a point");
    animated_ = true;
    const auto seconds = static_cast<float>((*frame_ - *points->held_since) / layer_->stage.time_codes_per_second);
    for (std::size_t i = 0; i < way.triples.size(); ++i) points->triples[i] += seconds * way.triples[i];
  }

  void note_material(const Place& here) {
    builder_.file().materials.push_back(here.path + ": bound to a USD material, which is not read");
  }

  /// Names the attributes of curves, and the primvars that they inherit, that are not used.
  void name_what_is_left(const Opinions& prims, const Place& here) {
    const auto name_one = [&](const std::string& name) {
      const bool says_more = name.ends_with(":indices") || name.starts_with("userProperties:");
      if (says_more || is_binding(name) || is_of_transform(name) || name == attribute_) return;
      if (const char* why = why_not_used(usd_table, name); *why != 0) builder_.ignore(name.substr(0, 128), why);
    };
    for (const UsdPrim* prim : prims)
      for (const auto& [name, attribute] : prim->attributes) name_one(name);
    for (const auto& [name, attribute] : here.primvars) name_one(name);
  }

  /// The value of a primvar at every place where it is given, by its indices if it has some.
  UsdValue primvar(const Opinions& prims, const Place& here, const std::string& name) {
    const UsdAttribute *found = find(prims, name), *at = find(prims, name + ":indices");
    if (!found) {
      const auto above = here.primvars.find(name), its = here.primvars.find(name + ":indices");
      found = above == here.primvars.end() ? nullptr : above->second;
      at = found && its != here.primvars.end() ? its->second : nullptr;
    }
    if (!found) return {};
    UsdValue value = value_of(*found, name);
    const bool is_pair = std::ranges::find(root_uv_names, name) != root_uv_names.end();
    const std::size_t size = !is_pair ? 1 : found->is_triple ? 3 : 2;
    if (const UsdValue indices = at ? value_of(*at, name + ":indices") : UsdValue{}; at && !indices.is_blocked) {
      const std::vector<double>& places = indices.precise;
      const bool fits = !places.empty() && look_up(places, 1, &value.triples) &&
                        look_up(places, size, &value.numbers) && look_up(places, 1, &value.precise);
      if (!fits) {
        builder_.ignore(name, "its indices point outside");
        return {};
      }
    }
    if (size == 3) {  // a third coordinate of a texture has no place on a root
      std::vector<float> pairs;
      for (std::size_t i = 0; i + 2 < value.numbers.size(); i += 3)
        pairs.insert(pairs.end(), {value.numbers[i], value.numbers[i + 1]});
      value.numbers = std::move(pairs);
    }
    return value;
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

  /// Returns the value of the first of these names that exists, and names the others as not used.
  UsdValue first_of(const Opinions& prims, const Place& here, std::initializer_list<const char*> names,
                    std::string* name) {
    name->clear();
    UsdValue first;
    for (const char* candidate : names) {
      if (!name->empty()) {
        if (find(prims, candidate)) builder_.ignore(candidate, *name + " is in its place");
        continue;
      }
      UsdValue value = primvar(prims, here, candidate);
      if (value.numbers.empty() && value.triples.empty() && value.precise.empty()) continue;
      *name = candidate;
      first = std::move(value);
    }
    return first;
  }

  /// Returns one tuple for each curve, from values that are one per curve or per vertex; the root's vertex is used.
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
    UsdValue widths = first_of(prims, here, {"primvars:widths", "widths"}, &name);
    set->width = {std::move(widths.numbers), widths.scope, name};
    UsdValue normals = first_of(prims, here, {"primvars:normals", "normals"}, &name);
    set->normal = {std::move(normals.triples), normals.scope, name};
    if (normals.is_animated && frame_)
      builder_.file().remarks.push_back(here.path +
                                        ": normals change in time; while the shutter is open those of its "
                                        "opening turn with the strands");
    UsdValue colors = first_of(prims, here, {attribute_.c_str()}, &name);
    for (const float number : colors.numbers) colors.triples.emplace_back(number);
    set->color = {std::move(colors.triples), colors.scope, name};
    const UsdValue ids = first_of(prims, here, {"primvars:id", "primvars:ids", "ids", "primvars:groom_id"}, &name);
    for (const double id : at_roots(ids.precise, 1, *set, name))
      set->id.push_back(std::abs(id) < 1e15 ? static_cast<std::int64_t>(id) : -1);
    const UsdValue uv = first_of(prims, here, root_uv_names, &name);
    const std::vector<float> pairs = at_roots(uv.numbers, 2, *set, name);
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) set->root_uv.emplace_back(pairs[i], pairs[i + 1]);
  }

  std::string name_;
  std::unique_ptr<UsdLayer> layer_;
  GroomBuilder builder_;
  UsdPrim root_;
  std::optional<Error> error_;
  std::optional<double> frame_;                             ///< unset: the first time samples
  std::string attribute_;                                   ///< the attribute that is read for the color
  std::map<Alike, std::optional<std::size_t>> prototypes_;  ///< their numbers, once they are read
  std::uint64_t visited_ = 0, vertices_ = 0, most_vertices_, copies_ = 0;
  bool animated_ = false;  ///< whether anything so far was animated
};

}  // namespace

std::span<const FormatItem> usd_items() { return usd_table; }
std::span<const FormatItem> usd_instancer_items() { return usd_instancer_table; }

Result<GroomFile> read_usda(const GroomInput& input) {
  return UsdReader(input, "a USD text", usda_layer(input)).read();
}

Result<GroomFile> read_usdc(const GroomInput& input) {
  return UsdReader(input, "a binary USD file", usdc_layer(input)).read();
}

Result<GroomFile> read_usdz(const GroomInput& input) {
  auto file = read_usdz_file(input.bytes, input.name);
  if (!file) return file.error();
  const auto root = without_byte_order_mark(file->layers[0].bytes);
  GroomInput named = input;
  named.name = fmt::format("{}[{}]", input.name, file->layers[0].name);  // as USD writes it
  if (!is_usdc(root) && !is_usda(root))
    return Error{named.name, "byte 0", "\"PXR-USDC\" or \"#usda 1.0\", the marks of layers of USD", "neither"};
  return UsdReader(named, "a USD archive (usdz)", usdz_layer(input, std::move(*file))).read();
}

}  // namespace tress::scene
