// Reads the layers of a .usdz as one tree. Sublayers are merged into the layer that names them. Layers that prims refer
// to become children of the root that are not part of the stage, where those prims find them.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/text_cursor.h"
#include "scene/read/grooms/usd_layer.h"
#include "scene/read/grooms/usdz_file.h"

namespace tress::scene {
namespace {

constexpr int deepest_sub_layer = 16;

class UsdzLayer final : public UsdLayer {
 public:
  UsdzLayer(const GroomInput& input, UsdzFile file) : input_(input), file_(std::move(file)) {
    for (const UsdzFile::Entry& entry : file_.layers) entries_.try_emplace(entry.name, entry.bytes);
  }

  UsdPrim read() override {
    std::string usual;
    UsdPrim root = read_stack(file_.layers[0].name, "", 0, &usual);
    stage = layers_[0]->stage;
    for (std::size_t i = 0; i < grafts_.size() && !error(); ++i) {
      const std::string name = graft(i);
      const std::string file = grafts_[i];  // more of them move these
      UsdPrim tree = read_stack(file, "/" + name, 0, &usual);
      UsdPrim to_usual{.name = name + usdz_graft, .type = {}, .is_defined = false};  // leads to the default prim
      if (!usual.empty())
        to_usual.arcs.push_back("/" + name + "/" + usual);
      else if (by_default_.contains(file))
        ignored.push_back({file, "it has no default prim, which is referred to"});
      tree.name = name;
      tree.is_defined = false;
      root.children.push_back(std::move(tree));
      root.children.push_back(std::move(to_usual));
    }
    const auto say_unused = [&](const std::string& name) {
      ignored.push_back({name.substr(0, 128), "of a .usdz the first layer and those that it needs are read"});
    };
    for (const UsdzFile::Entry& entry : file_.layers)
      if (!read_.contains(entry.name)) say_unused(entry.name);
    for (const std::string& other : file_.others) say_unused(other);
    return root;
  }

  // Every attribute is of one of the layers, which reads it.
  std::vector<UsdSample> samples(std::uint64_t) override { return {}; }
  UsdValue value(std::uint64_t, UsdNumbers) override { return {}; }

  const std::optional<Error>& error() const override {
    for (const auto& layer : layers_)
      if (layer->error()) return layer->error();
    return none_;
  }

 private:
  static std::string graft(std::size_t number) { return usdz_graft + std::to_string(number); }

  /// A file that a layer names, as a name of the archive: beside the layer, else from the top.
  std::string within(const std::string& layer, const std::filesystem::path& file) const {
    const std::string beside = (std::filesystem::path(layer).parent_path() / file).lexically_normal().generic_string();
    const bool is_at_top = !entries_.contains(beside) && !file.generic_string().starts_with('.');
    const std::string from_top = file.lexically_normal().generic_string();
    return is_at_top && entries_.contains(from_top) ? from_top : beside;
  }

  /// Reads a layer with its sublayers. graft: the path where its root is found.
  UsdPrim read_stack(const std::string& name, const std::string& at, int depth, std::string* default_prim) {
    GroomInput one = input_;
    one.bytes = without_byte_order_mark(entries_.at(name));
    one.name = fmt::format("{}[{}]", input_.name, name);  // as USD writes it
    layers_.push_back(is_usdc(one.bytes) ? usdc_layer(one) : usda_layer(one));
    read_.insert(name);
    bytes_read_ += one.bytes.size();
    UsdLayer& layer = *layers_.back();
    layer.follows = true;
    UsdPrim root = layer.read();
    if (error()) return root;
    ignored.insert(ignored.end(), layer.ignored.begin(), layer.ignored.end());
    prims += layer.prims;
    *default_prim = layer.default_prim;
    if (layer.stage.time_codes_per_second != layers_[0]->stage.time_codes_per_second)
      ignored.push_back({name + ": timeCodesPerSecond", why_no_offset});
    settle(&root, name, at);
    for (const std::string& sub : layer.sub_layers) {
      const std::string file = within(name, sub);
      if (!entries_.contains(file) || depth >= deepest_sub_layer || bytes_read_ > most_sharing * input_.bytes.size()) {
        ignored.push_back({printable(file.substr(0, 128)), "this sublayer is not in the archive, or in itself"});
        continue;
      }
      std::string unused;
      merge(&root, read_stack(file, at, depth + 1, &unused));
      if (error()) break;
    }
    return root;
  }

  /// Adds weaker opinions to those on a prim.
  void merge(UsdPrim* strong, UsdPrim weak) {
    if (!strong->arcs.empty() && !weak.arcs.empty())
      ignored.push_back({strong->name, "what a sublayer refers to is added to what the layer above refers to"});
    if (strong->type.empty()) strong->type = weak.type;
    strong->is_defined = strong->is_defined || weak.is_defined;
    if (!strong->is_active) strong->is_active = weak.is_active;
    strong->arcs.insert(strong->arcs.end(), weak.arcs.begin(), weak.arcs.end());
    if (strong->prototypes.empty()) strong->prototypes = std::move(weak.prototypes);
    for (auto& [name, attribute] : weak.attributes) {
      const auto [found, is_new] = strong->attributes.try_emplace(name, attribute);
      UsdAttribute& own = found->second;
      if (is_new || own.value || own.samples) continue;
      const auto scope = own.scope;
      own = attribute;
      if (scope) own.scope = scope;
    }
    std::unordered_map<std::string, std::size_t> places;
    for (std::size_t i = 0; i < strong->children.size(); ++i) places.emplace(strong->children[i].name, i);
    for (UsdPrim& child : weak.children)
      if (const auto found = places.find(child.name); found != places.end())
        merge(&strong->children[found->second], std::move(child));
      else
        strong->children.push_back(std::move(child));
  }

  /// Makes paths of the one tree of what the prims of a layer refer to.
  void settle(UsdPrim* prim, const std::string& layer, const std::string& at) {
    for (std::string& path : prim->prototypes) path = at + path;
    for (std::string& arc : prim->arcs) {
      if (!arc.starts_with('@')) {
        arc = at + arc;
        continue;
      }
      const std::size_t end = arc.find('@', 1);
      const std::string file = within(layer, arc.substr(1, end - 1)), path = arc.substr(end + 1);
      if (!entries_.contains(file)) continue;  // the reader finds nothing at the arc, and says so
      const auto [found, is_new] = numbers_.try_emplace(file, grafts_.size());
      if (is_new) grafts_.push_back(file);
      if (path.empty()) by_default_.insert(file);
      arc = "/" + graft(found->second) + (path.empty() ? std::string(1, usdz_graft) : path);
    }
    for (UsdPrim& child : prim->children) settle(&child, layer, at);
  }

  GroomInput input_;
  UsdzFile file_;
  std::vector<std::unique_ptr<UsdLayer>> layers_;
  std::map<std::string, std::span<const unsigned char>> entries_;
  std::vector<std::string> grafts_;             ///< layers that prims refer to, by their numbers
  std::map<std::string, std::size_t> numbers_;  ///< the numbers of those
  std::set<std::string> read_;                  ///< all layers that were read
  std::set<std::string> by_default_;            ///< layers to whose default prims others refer
  std::size_t bytes_read_ = 0;
  std::optional<Error> none_;
};

}  // namespace

std::unique_ptr<UsdLayer> usdz_layer(const GroomInput& input, UsdzFile file) {
  return std::make_unique<UsdzLayer>(input, std::move(file));
}

}  // namespace tress::scene
