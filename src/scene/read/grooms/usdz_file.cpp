#include "scene/read/grooms/usdz_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/text_cursor.h"
#include "scene/read/grooms/usd_layer.h"

namespace tress::scene {
namespace {

constexpr std::uint32_t entry_mark = 0x04034b50, row_mark = 0x02014b50, end_mark = 0x06054b50;
constexpr std::size_t entry_bytes = 30, row_bytes = 46, end_bytes = 22, most_remark = 65535;

std::uint32_t number_at(std::span<const unsigned char> bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i) value |= std::uint32_t{bytes[at + static_cast<std::size_t>(i)]} << (8 * i);
  return value;
}

std::string text_at(std::span<const unsigned char> bytes, std::size_t at, std::size_t size) {
  const auto part = bytes.subspan(at, std::min(size, bytes.size() - at));
  return printable({part.begin(), part.end()});
}

bool is_layer(std::string_view name) {
  return name.ends_with(".usd") || name.ends_with(".usda") || name.ends_with(".usdc");
}

}  // namespace

bool is_usdz(std::span<const unsigned char> bytes) {
  return bytes.size() >= entry_bytes && number_at(bytes, 0, 4) == entry_mark &&
         is_layer(text_at(bytes, entry_bytes, number_at(bytes, 26, 2)));
}

/// The table of the entries is near the end of the archive. A record after it gives its place, and may end with a
/// comment.
Result<UsdzFile> read_usdz_file(std::span<const unsigned char> bytes, const std::string& name) {
  const auto fail = [&](std::size_t at, std::string expected, std::string found) {
    return Error{name, fmt::format("byte {}", at), std::move(expected), std::move(found)};
  };
  std::size_t end = bytes.size() < end_bytes ? 0 : bytes.size() - end_bytes + 1;
  const std::size_t first = end > most_remark ? end - most_remark - 1 : 0;
  while (end > first && number_at(bytes, end - 1, 4) != end_mark) --end;
  if (end == first) return fail(bytes.size(), "the table of a zip archive at its end", "none");
  --end;
  struct Row {
    std::string name;
    std::size_t row_at, at;
    std::uint32_t method, size;
  };
  std::vector<Row> entries;
  std::size_t at = number_at(bytes, end + 16, 4);
  const std::uint32_t rows = number_at(bytes, end + 10, 2);
  for (std::uint32_t row = 0; row < rows; ++row) {
    if (at > end || end - at < row_bytes || number_at(bytes, at, 4) != row_mark)
      return fail(std::min(at, bytes.size()), fmt::format("entry {} of {} in the table of the archive", row + 1, rows),
                  "none");
    entries.push_back({text_at(bytes, at + row_bytes, number_at(bytes, at + 28, 2)), at, number_at(bytes, at + 42, 4),
                       number_at(bytes, at + 10, 2), number_at(bytes, at + 24, 4)});
    at += row_bytes + number_at(bytes, at + 28, 2) + number_at(bytes, at + 30, 2) + number_at(bytes, at + 32, 2);
  }
  if (rows == 0) return fail(end, "a layer of USD in the archive", "no entries");
  std::ranges::sort(entries, {}, [](const Row& entry) { return std::pair(entry.at, entry.row_at); });
  UsdzFile file;
  for (const Row& entry : entries) {
    const bool is_first = &entry == entries.data();
    std::optional<Error> fault;
    if (!is_layer(entry.name))
      fault = fail(entry.at, "a layer of USD (.usd, .usda, .usdc) as the first entry", entry.name);
    else if (entry.method != 0)
      fault = fail(entry.row_at, "entries that are stored, as .usdz has them (zip -0)",
                   fmt::format("{}, packed by method {}", entry.name, entry.method));
    else if (entry.at > end || end - entry.at < entry_bytes || number_at(bytes, entry.at, 4) != entry_mark)
      fault = fail(std::min(entry.at, bytes.size()), fmt::format("the entry {}", entry.name), "none");
    else if (const std::size_t data_at =
                 entry.at + entry_bytes + number_at(bytes, entry.at + 26, 2) + number_at(bytes, entry.at + 28, 2);
             data_at > end || entry.size > end - data_at)
      fault = fail(entry.at, fmt::format("{} bytes of {}", entry.size, entry.name),
                   fmt::format("{}", data_at > end ? 0 : end - data_at));
    else
      file.layers.push_back({entry.name, bytes.subspan(data_at, entry.size)});
    if (fault && is_first) return *fault;
    if (fault) file.others.push_back(entry.name);
  }
  return file;
}

// Reads the layers of a .usdz as one tree. Sublayers are merged into the layer that names them. Layers that prims refer
// to become children of the root that are not part of the stage, where those prims find them.
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
