// Reads a layer of USD as a crate. Values are the crate's own references to them: a type, and a place or the value
// itself.
//
// A crate of version 0.4 to 0.12, little endian, begins with `PXR-USDC`, 8 bytes of version and the i64 place of the
// table of contents: a u64 number of rows, each a name of 16 characters, i64 place, i64 size. `TOKENS` are texts,
// `STRINGS` numbers of tokens, `FIELDS` a token and a value each, `FIELDSETS` lists of fields up to -1, `PATHS` a tree,
// `SPECS` a path, its fields and what it is. Integers are packed as differences, of 0, 1, 2 or 4 bytes by a code of 2
// bits (those of 8 bytes: 0, 2, 4, 8), then by LZ4. A value is 64 bits: array, in the bits themselves, packed; its type
// in 8 bits, and in 48 its place or itself. Lists of floats are packed as integers (`i`) or as a table and places in it
// (`t`). Assets, splines and path expressions are named and not read.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "scene/read/grooms/crate_cursor.h"
#include "scene/read/grooms/number_formats.h"
#include "scene/read/grooms/usd_layer.h"

namespace tress::scene {
namespace {

constexpr std::size_t header_bytes = 88;
constexpr int oldest = 4, newest = 12;          ///< minor versions; 4 packs the tables
constexpr std::uint32_t no_index = 0xffffffff;  ///< ends the fields of a spec
constexpr std::size_t most_fields = 256;        ///< limit for one spec, which may share them with others
/// Elements of a path below its prims: a property, a target, and that one's attribute.
constexpr std::uint32_t deepest_path = deepest_prim + 8;
constexpr std::size_t least_packed = 16;  ///< arrays below are never packed
/// Least bytes of a file for each entry of a table, and of a list of fields. In 200 files of other programs, a path or
/// a spec has at least 33, a field 40 and an entry of a list 14.
constexpr std::uint64_t bytes_of_entry = 4, bytes_of_listed = 1;
constexpr std::size_t longest_name = 256;  ///< longer ones are cut
/// No valid file has more bytes of names than most_sharing times its own and these.
constexpr std::uint64_t most_text = 65536;

/// A reference to a value.
struct ValueRep {
  std::uint64_t bits;
  bool is_array() const { return bits >> 63; }
  bool is_inlined() const { return bits >> 62 & 1; }
  bool is_packed() const { return bits >> 61 & 1; }
  std::uint8_t type() const { return static_cast<std::uint8_t>(bits >> 48); }
  std::uint64_t payload() const { return bits & ((std::uint64_t{1} << 48) - 1); }
};

constexpr std::uint8_t path_list_op = 34, reference_list_op = 35, i64_list_op = 37, time_samples = 46,
                       payload_value = 47, value_block = 51, payload_list_op = 55;

/// The types of values that are read, by their codes in a crate.
struct ValueType {
  enum class Kind : std::uint8_t { numbers, vector, matrix, quaternion, token, string, nothing };
  std::uint8_t code;
  Kind kind;
  NumberFormat format = NumberFormat::u32;
  std::uint8_t numbers = 1;
  bool is_list = false;  ///< a list behind its number, without the bit of arrays
};
using enum NumberFormat;
using Kind = ValueType::Kind;
constexpr ValueType types[] = {
    {1, Kind::numbers, boolean},
    {2, Kind::numbers, u8},
    {3, Kind::numbers, i32},
    {4, Kind::numbers, u32},
    {5, Kind::numbers, i64},
    {6, Kind::numbers, u64},
    {7, Kind::numbers, f16},
    {8, Kind::numbers, f32},
    {9, Kind::numbers, f64},
    {10, Kind::string},
    {11, Kind::token},
    {13, Kind::matrix, f64, 4},
    {14, Kind::matrix, f64, 9},
    {15, Kind::matrix, f64, 16},
    {16, Kind::quaternion, f64, 4},
    {17, Kind::quaternion, f32, 4},
    {18, Kind::quaternion, f16, 4},
    {19, Kind::vector, f64, 2},
    {20, Kind::vector, f32, 2},
    {21, Kind::vector, f16, 2},
    {22, Kind::vector, i32, 2},
    {23, Kind::vector, f64, 3},
    {24, Kind::vector, f32, 3},
    {25, Kind::vector, f16, 3},
    {26, Kind::vector, i32, 3},
    {27, Kind::vector, f64, 4},
    {28, Kind::vector, f32, 4},
    {29, Kind::vector, f16, 4},
    {30, Kind::vector, i32, 4},
    {41, Kind::token, u32, 1, true},
    {42, Kind::numbers, u32},
    {48, Kind::numbers, f64, 1, true},
    {50, Kind::string, u32, 1, true},
    {value_block, Kind::nothing},
    {56, Kind::numbers, f64},
};

/// The kind of the object at a path of the crate.
enum class SpecType : std::uint32_t { attribute = 1, prim = 6, stage = 7, relation = 8, variant = 10, variants = 11 };

/// Numbers of a value as the file has them, or unpacked.
struct PackedNumbers {
  NumberFormat format;
  std::span<const unsigned char> stored = {};
  std::vector<unsigned char> own = {};
  std::span<const unsigned char> bytes() const { return own.empty() ? stored : own; }
};

class UsdcLayer final : public UsdLayer {
 public:
  explicit UsdcLayer(const GroomInput& input) : cursor_(input.bytes, input.name), done_with_(input.done_with) {}

  UsdPrim read() override {
    read_tables();
    UsdPrim root;
    if (error()) return root;
    for (std::uint32_t path = 0; path < paths_.size(); ++path)
      if (paths_[path].spec != no_index && paths_[path].parent != no_index)
        paths_[paths_[path].parent].children.push_back(path);
    if (root_ == no_index || paths_[root_].spec == no_index)
      cursor_.fail_at("PATHS", "the root of the prims", "none");
    else
      root = prim_at(root_);
    return root;
  }

  std::vector<UsdSample> samples(std::uint64_t at) override {
    std::vector<UsdSample> all;
    const ValueRep rep{at};
    cursor_.go_to(rep.payload(), "time samples");
    if (rep.type() != time_samples) cursor_.fail("time samples", fmt::format("a value of type {}", rep.type()));
    follow();
    const auto times_at = cursor_.number<std::uint64_t>();
    const std::uint64_t next = cursor_.at();
    const std::vector<double> times = value(times_at, UsdNumbers::doubles).precise;
    cursor_.go_to(next, "time samples");
    follow();
    const std::uint64_t count = cursor_.count(sizeof(std::uint64_t));
    if (count != times.size() && !error())
      cursor_.fail(fmt::format("{} values, as there are times", times.size()), fmt::format("{}", count));
    for (const double time : times)
      if (!error()) all.push_back({time, cursor_.number<std::uint64_t>()});
    return error() ? std::vector<UsdSample>() : all;
  }

  UsdValue value(std::uint64_t at, UsdNumbers kept_as) override {
    UsdValue value;
    const ValueRep rep{at};
    if (rep.type() == i64_list_op && !error()) {
      cursor_.go_to(rep.payload(), "a list of numbers");
      for_list(sizeof(std::int64_t), [&](bool is_used) {
        const auto number = static_cast<double>(cursor_.number<std::int64_t>());
        if (is_used) value.precise.push_back(number);
      });
      return value;
    }
    const auto type = std::ranges::find(types, rep.type(), &ValueType::code);
    if (type == std::end(types)) {
      value.not_read = fmt::format("values of the crate's type {} are not read", rep.type());
      return value;
    }
    value.is_blocked = type->kind == Kind::nothing;
    if (error() || value.is_blocked) return value;
    cursor_.go_to(rep.is_inlined() ? 0 : rep.payload(), "a value");
    const PackedNumbers numbers =
        rep.is_inlined() ? inlined(*type, static_cast<std::uint32_t>(rep.payload())) : stored(*type, rep);
    if (error()) return value;
    if (type->kind == Kind::token || type->kind == Kind::string)
      value.texts = texts(type->kind, numbers.bytes());
    else if (type->format == boolean)
      for (const unsigned char is_true : numbers.bytes()) value.texts.emplace_back(is_true ? "true" : "false");
    else
      keep(numbers, type->kind == Kind::quaternion, kept_as, &value);
    return value;
  }

  const std::optional<Error>& error() const override { return cursor_.error(); }

 private:
  struct Path {
    std::uint32_t parent = no_index, token = 0, depth = 0;
    std::uint32_t spec = no_index;  ///< its first field in field_sets_
    SpecType type = {};
    bool is_read = false;
    std::vector<std::uint32_t> children = {};
  };

  // ---- the tables --------------------------------------------------------------------------------------------------

  void read_tables() {
    if (cursor_.size() < header_bytes)
      return cursor_.fail(fmt::format("a header of {} bytes", header_bytes), fmt::format("{}", cursor_.size()));
    cursor_.go_to(8, "the version");
    const auto major = cursor_.number<std::uint8_t>(), minor = cursor_.number<std::uint8_t>();
    if (major != 0 || minor < oldest || minor > newest)
      return cursor_.fail(
          fmt::format("version 0.{} to 0.{} of the crate (usdcat IN -o OUT.usda writes a text)", oldest, newest),
          fmt::format("{}.{}", major, minor));
    minor_ = minor;
    cursor_.go_to(16, "the place of the table of contents");
    cursor_.go_to(cursor_.number<std::uint64_t>(), "the table of contents");
    constexpr std::size_t name_bytes = 16, row_bytes = 32;
    std::map<std::string, std::uint64_t, std::less<>> sections;
    for (std::uint64_t left = cursor_.count(row_bytes); left > 0 && !error(); --left) {
      const auto name = cursor_.take(name_bytes);
      const auto at = cursor_.number<std::uint64_t>(), size = cursor_.number<std::uint64_t>();
      if (at > cursor_.size() || size > cursor_.size() - at)
        cursor_.fail(fmt::format("a section within the {} bytes of the file", cursor_.size()),
                     fmt::format("{} bytes from {}", size, at));
      sections.emplace(std::string(name.begin(), std::ranges::find(name, 0)), at);
    }
    const auto read = [&](const char* name, void (UsdcLayer::*table)()) {
      const auto found = sections.find(name);
      if (found == sections.end() && !error()) cursor_.fail(fmt::format("a section {}", name), "none");
      if (error()) return;
      cursor_.go_to(found->second, name);
      (this->*table)();
    };
    read("TOKENS", &UsdcLayer::read_tokens);
    read("STRINGS", &UsdcLayer::read_strings);
    read("FIELDS", &UsdcLayer::read_fields);
    read("FIELDSETS", &UsdcLayer::read_field_sets);
    read("PATHS", &UsdcLayer::read_paths);
    read("SPECS", &UsdcLayer::read_specs);
  }

  std::uint64_t packed_count(std::uint64_t bytes_each) {
    return cursor_.packed_count(cursor_.number<std::uint64_t>(), bytes_each);
  }

  void read_tokens() {
    const auto count = cursor_.number<std::uint64_t>(), size = cursor_.number<std::uint64_t>();
    characters_ = cursor_.unpacked(size);
    const std::string_view all(reinterpret_cast<const char*>(characters_.data()), characters_.size());
    if (!cursor_.hold(count, static_cast<std::uint64_t>(std::ranges::count(all, '\0')), "tokens, as they end")) return;
    tokens_.reserve(static_cast<std::size_t>(count));
    for (std::size_t at = 0; tokens_.size() < count; at = all.find('\0', at) + 1)
      tokens_.push_back(all.substr(at, std::min(all.find('\0', at) - at, longest_name)));
  }

  void read_strings() {
    strings_.resize(static_cast<std::size_t>(cursor_.count(sizeof(std::uint32_t))));
    for (std::uint32_t& token : strings_) token = cursor_.number<std::uint32_t>();
  }

  void read_fields() {
    const std::uint64_t count = packed_count(bytes_of_entry);
    field_tokens_ = cursor_.integers<std::uint32_t>(count);
    const std::vector<unsigned char> values = cursor_.unpacked(count * sizeof(std::uint64_t));
    field_values_.resize(values.size() / sizeof(std::uint64_t));
    if (!values.empty()) std::memcpy(field_values_.data(), values.data(), values.size());
  }

  void read_field_sets() { field_sets_ = cursor_.integers<std::uint32_t>(packed_count(bytes_of_listed)); }

  /// Reads the tree of paths: for each its number, its token (negative for a property), and where its child and its
  /// sibling are: -2 neither, -1 a child next, 0 a sibling next, else a child next and a sibling so much further.
  void read_paths() {
    paths_.resize(static_cast<std::size_t>(packed_count(bytes_of_entry)));
    const std::uint64_t count = packed_count(bytes_of_entry);
    const std::vector<std::uint32_t> numbers = cursor_.integers<std::uint32_t>(count);
    const std::vector<std::int32_t> tokens = cursor_.integers<std::int32_t>(count),
                                    jumps = cursor_.integers<std::int32_t>(count);
    struct Next {
      std::uint64_t row;
      std::uint32_t parent;
    };
    std::vector<Next> next;
    if (count > 0 && !error()) next.push_back({0, no_index});
    while (!next.empty()) {
      auto [row, parent] = next.back();
      next.pop_back();
      for (;;) {
        if (row >= count || numbers[row] >= paths_.size() || paths_[numbers[row]].is_read)
          return cursor_.fail("paths that are each there once",
                              row < count ? fmt::format("path {} at row {}", numbers[row], row) : "a row outside");
        Path& path = paths_[numbers[row]];
        path.is_read = true;
        path.parent = parent;
        path.token = static_cast<std::uint32_t>(tokens[row] < 0 ? -std::int64_t{tokens[row]} : tokens[row]);
        path.depth = parent == no_index ? 0 : paths_[parent].depth + 1;
        if (path.depth > deepest_path)
          return cursor_.fail(fmt::format("at most {} prims in one another", deepest_prim), "more");
        if (parent == no_index) root_ = numbers[row];
        const std::int32_t jump = jumps[row];
        if (jump == -2) break;
        if (jump > 0) next.push_back({row + static_cast<std::uint64_t>(jump), parent});
        if (jump > 0 || jump == -1) parent = numbers[row];
        ++row;
      }
    }
  }

  void read_specs() {
    const std::uint64_t count = packed_count(bytes_of_entry);
    const std::vector<std::uint32_t> paths = cursor_.integers<std::uint32_t>(count),
                                     fields = cursor_.integers<std::uint32_t>(count),
                                     kinds = cursor_.integers<std::uint32_t>(count);
    for (std::size_t i = 0; i < count && !error(); ++i) {
      if (paths[i] >= paths_.size() || fields[i] >= field_sets_.size())
        return cursor_.fail(fmt::format("specs of the {} paths and {} fields", paths_.size(), field_sets_.size()),
                            fmt::format("path {}, field {}", paths[i], fields[i]));
      paths_[paths[i]].spec = fields[i];
      paths_[paths[i]].type = SpecType{kinds[i]};
    }
  }

  // ---- the tree ----------------------------------------------------------------------------------------------------

  /// Calls take(name, value) for each field of a path.
  template <class Take>
  void for_fields(const Path& path, const Take& take) {
    for (std::size_t i = path.spec, left = most_fields; !error(); ++i, --left) {
      if (i < field_sets_.size() && field_sets_[i] == no_index) return;
      if (i >= field_sets_.size() || field_sets_[i] >= field_values_.size() || left == 0)
        return cursor_.fail_at(
            "FIELDSETS", fmt::format("at most {} fields of the {}, and an end", most_fields, field_values_.size()),
            i < field_sets_.size() ? fmt::format("field {}", field_sets_[i]) : "none");
      take(token(field_tokens_[field_sets_[i]]), field_values_[field_sets_[i]]);
    }
  }

  /// Builds a prim with its children. The depth of this recursion is that of the paths, which is limited.
  UsdPrim prim_at(std::uint32_t number) {
    const Path& path = paths_[number];
    UsdPrim prim;
    prim.is_defined = false;  // the default of USD without a specifier
    if (path.parent != no_index) prim.name = printable(std::string(token(path.token)));
    std::vector<std::string> order;
    for_fields(path, [&](std::string_view key, std::uint64_t rep) {
      const auto text = [&] {
        UsdValue one = value(rep, UsdNumbers::floats);
        return one.texts.empty() ? std::string() : std::move(one.texts[0]);
      };
      if (key == "specifier") {
        prim.is_defined = ValueRep{rep}.payload() == 0;
      } else if (key == "typeName") {
        prim.type = text();
      } else if (key == "active") {
        prim.is_active = text() != "false";
      } else if (key == "primChildren") {
        order = value(rep, UsdNumbers::floats).texts;
      } else if (key == "defaultPrim" && path.type == SpecType::stage) {
        default_prim = text();
      } else if (key == "subLayers" && follows) {
        sub_layers = value(rep, UsdNumbers::floats).texts;
      } else if (key == "subLayerOffsets" && follows) {
        name_offsets(ValueRep{rep});
      } else if (key == "subLayers" || key == "variantSetNames" || key == "variantSetChildren" || key == "relocates" ||
                 key == "layerRelocates") {
        cursor_.fail_at(path_of(number), flat_stage, std::string(key));
      } else if (is_usd_arc(key)) {
        read_arcs(number, key, ValueRep{rep}, &prim.arcs);
      } else if (key == "inactiveIds") {
        prim.attributes[std::string(key)] = {.layer = this, .value = rep};
      } else if (is_usd_clip(key)) {
        ignored.push_back({prim.name + ": " + std::string(key), why_no_clips});
      } else if (path.type == SpecType::stage && UsdStage::has(key)) {
        if (auto fault = stage.take(key, value(rep, UsdNumbers::doubles)))
          cursor_.fail_at(std::string(key), std::move(fault->expected), std::move(fault->found));
      }
    });
    std::unordered_map<std::string_view, std::size_t> rank;
    for (const std::string& name : order) rank.emplace(name, rank.size());
    std::vector<std::pair<std::size_t, std::uint32_t>> children;
    for (const std::uint32_t child : path.children) {
      const auto found = rank.find(token(paths_[child].token));
      children.emplace_back(found == rank.end() ? rank.size() : found->second, child);
    }
    std::ranges::sort(children);
    for (const auto& [place, child] : children) {
      if (error()) break;
      switch (paths_[child].type) {
        case SpecType::prim:
          prim.children.push_back(prim_at(child));
          ++prims;
          break;
        case SpecType::attribute:
        case SpecType::relation:
          read_property(child, &prim);
          break;
        case SpecType::variant:
        case SpecType::variants:
          cursor_.fail_at(path_of(number), flat_stage, "variantSet");
          break;
        default:
          break;
      }
    }
    return prim;
  }

  void read_property(std::uint32_t number, UsdPrim* prim) {
    const Path& path = paths_[number];
    const std::string name = printable(std::string(token(path.token)));
    UsdAttribute& attribute = prim->attributes[name];
    attribute.layer = this;
    if (path.type == SpecType::relation) {
      for_fields(path, [&](std::string_view key, std::uint64_t rep) {
        if (name == "prototypes" && key == "targetPaths") read_arcs(number, key, ValueRep{rep}, &prim->prototypes);
      });
      return;
    }
    for_fields(path, [&](std::string_view key, std::uint64_t rep) {
      if (key == "default") attribute.value = rep;
      if (key == "timeSamples") attribute.samples = rep;
      if (key == "spline") ignored.push_back({path_of(number), why_no_splines});
      if (key != "interpolation" && key != "typeName" && key != "colorSpace") return;
      const UsdValue text = value(rep, UsdNumbers::floats);
      if (text.texts.empty()) return;
      if (key == "colorSpace") {
        if (name.starts_with("primvars:") && !is_taken_space(text.texts[0]))
          ignored.push_back({prim->name + "." + name + ": colorSpace " + printable(text.texts[0]), why_one_space});
      } else if (key == "interpolation")
        attribute.scope = usd_scope(text.texts[0]);
      else
        attribute.is_triple = text.texts[0].find('3') != std::string::npos;
    });
  }

  /// Reads the prims of this layer that a prim refers to, from a list of paths, references or payloads, or one payload.
  void read_arcs(std::uint32_t number, std::string_view key, ValueRep rep, std::vector<std::string>* arcs) {
    const std::uint8_t type = rep.type();
    const bool is_path = type == path_list_op, is_reference = type == reference_list_op;
    if (type == value_block) return;
    if (rep.is_inlined() || (!is_path && !is_reference && type != payload_value && type != payload_list_op))
      return cursor_.fail_at(path_of(number), "a list of what it refers to",
                             fmt::format("a value of type {} in {}", type, key));
    cursor_.go_to(rep.payload(), "what a prim refers to");
    const auto read_one = [&](bool is_used) {
      const std::string_view file = is_path ? std::string_view() : string(cursor_.number<std::uint32_t>());
      const auto to = cursor_.number<std::uint32_t>();
      if (is_reference || (!is_path && minor_ >= 8)) {
        const bool is_offset = cursor_.number<double>() != 0, is_scaled = cursor_.number<double>() != 1;
        if ((is_offset || is_scaled) && is_used)
          ignored.push_back({printable(std::string(token(paths_[number].token))) + (is_offset ? ": offset" : ": scale"),
                             why_no_offset});
      }
      for (std::uint64_t left = is_reference ? cursor_.count(12) : 0; left > 0 && !error(); --left) {
        cursor_.number<std::uint32_t>();  // custom data: a name and a value
        follow();
        cursor_.number<std::uint64_t>();
      }
      if (error() || !is_used) return;
      if (!file.empty() && !follows)
        return cursor_.fail_at(path_of(number), flat_stage, std::string(key) + " of another file");
      const bool has_path = to < paths_.size() && paths_[to].is_read && to != root_;
      if (!has_path && file.empty()) return;  // it refers to nothing
      arcs->push_back((file.empty() ? "" : fmt::format("@{}@", file)) + (has_path ? path_of(to) : ""));
      hold_text(arc_bytes_ += arcs->back().size());
    };
    if (type == payload_value) return read_one(true);
    for_list(sizeof(std::uint32_t), read_one);
  }

  /// Calls read(is_used) for each item of a list with edits, which reads it. Those that are deleted, or only ordered,
  /// are not used.
  template <class Read>
  void for_list(std::uint64_t bytes_each, const Read& read) {
    const auto lists = cursor_.number<std::uint8_t>();
    // In the file's order, with the bit that says that it is there: explicit, added, prepended, appended, deleted,
    // ordered.
    static constexpr unsigned bits[] = {2, 4, 32, 64, 8, 16};
    for (const unsigned bit : bits) {
      if (!(lists & bit)) continue;
      for (std::uint64_t left = cursor_.count(bytes_each); left > 0 && !error(); --left) read(bit != 8 && bit != 16);
    }
  }

  /// Names the sublayers' offsets and scales of time, other than 0 and 1.
  void name_offsets(ValueRep rep) {
    cursor_.go_to(rep.payload(), "offsets of sublayers");
    for (std::uint64_t left = cursor_.count(2 * sizeof(double)); left > 0 && !error(); --left) {
      const auto offset = cursor_.number<double>(), scale = cursor_.number<double>();
      if (offset != 0 || scale != 1) ignored.push_back({"subLayers: offset", why_no_offset});
    }
  }

  std::string path_of(std::uint32_t number) const {
    std::string text;
    for (; number < paths_.size() && paths_[number].parent != no_index; number = paths_[number].parent)
      text = "/" + std::string(paths_[number].token < tokens_.size() ? tokens_[paths_[number].token] : "") + text;
    return printable(text.empty() ? "/" : text);
  }

  // ---- values ------------------------------------------------------------------------------------------------------

  /// Follows an offset: reads a number and moves that far from its place. Nested values come before their container.
  void follow() {
    const std::uint64_t from = cursor_.at();
    const auto way = cursor_.number<std::uint64_t>();  // negative ones wrap to a place outside
    if (!error()) cursor_.go_to(from + way, "a nested value");
  }

  std::string_view token(std::uint32_t number) {
    if (number < tokens_.size()) return tokens_[number];
    cursor_.fail(fmt::format("one of {} tokens", tokens_.size()), fmt::format("number {}", number));
    return {};
  }

  std::string_view string(std::uint32_t number) {
    if (number < strings_.size()) return token(strings_[number]);
    cursor_.fail(fmt::format("one of {} strings", strings_.size()), fmt::format("number {}", number));
    return {};
  }

  void hold_text(std::uint64_t bytes) {
    cursor_.hold(bytes, most_sharing * cursor_.size() + most_text, "bytes of names, as the file allows");
  }

  std::vector<std::string> texts(Kind kind, std::span<const unsigned char> numbers) {
    std::vector<std::string> all;
    std::uint64_t bytes = 0;
    for (std::size_t at = 0; at + 4 <= numbers.size() && !error(); at += 4) {
      std::uint32_t number = 0;
      std::memcpy(&number, numbers.data() + at, sizeof number);
      all.emplace_back(kind == Kind::token ? token(number) : string(number));
      hold_text(bytes += all.back().size());
    }
    return all;
  }

  /// A value in the 4 bytes of its reference: small vectors and the diagonals of matrices as bytes with a sign, a
  /// double as a float, integers of 8 bytes as those of 4.
  PackedNumbers inlined(const ValueType& type, std::uint32_t bits) {
    std::array<unsigned char, 4> four{};
    std::memcpy(four.data(), &bits, sizeof bits);
    PackedNumbers out{type.format, {}, {four.begin(), four.end()}};
    if (type.kind == Kind::vector || type.kind == Kind::matrix) {
      const std::size_t side = type.numbers == 9 ? 3 : type.numbers == 4 ? 2 : 4;
      out.format = i8;
      if (type.kind == Kind::matrix) {
        out.own.assign(side * side, 0);
        for (std::size_t i = 0; i < side; ++i) out.own[i * side + i] = four[i];
      }
      out.own.resize(type.numbers);
    } else if (type.format == f64) {
      out.format = f32;
    } else if (type.format == i64 || type.format == u64) {
      out.format = type.format == i64 ? i32 : u32;
    } else {
      out.own.resize(bytes_of(type.format));
    }
    return out;
  }

  /// A value at the cursor.
  PackedNumbers stored(const ValueType& type, ValueRep rep) {
    PackedNumbers out{type.format};
    const std::size_t size = bytes_of(type.format);
    if (!rep.is_array() && !type.is_list) {
      out.stored = cursor_.take(type.numbers * size);
      return out;
    }
    if (rep.payload() == 0) return out;                                 // empty
    if (rep.is_array() && minor_ < 5) cursor_.number<std::uint32_t>();  // the number of dimensions
    const std::uint64_t count =
        rep.is_array() && minor_ < 7 ? cursor_.number<std::uint32_t>() : cursor_.number<std::uint64_t>();
    const bool is_packed = rep.is_array() && rep.is_packed() && count >= least_packed && type.kind == Kind::numbers;
    if (!is_packed) {
      cursor_.hold(count, (cursor_.size() - cursor_.at()) / (type.numbers * size), "values, as the bytes allow");
      out.stored = cursor_.take(count * type.numbers * size);
      return out;
    }
    unpack(cursor_.packed_count(count, bytes_of_listed), &out);
    return out;
  }

  /// Unpacks numbers: integers as such, fractions as integers or as places in a table.
  void unpack(std::uint64_t count, PackedNumbers* out) {
    const auto own = [&](const auto& integers) {
      const auto* bytes = reinterpret_cast<const unsigned char*>(integers.data());
      out->own.assign(bytes, bytes + integers.size() * sizeof integers[0]);
    };
    if (out->format == i64 || out->format == u64) return own(cursor_.integers<std::int64_t>(count));
    if (out->format == i32 || out->format == u32) return own(cursor_.integers<std::int32_t>(count));
    const auto code = cursor_.number<char>();
    if (code == 'i') {
      out->format = i32;
      return own(cursor_.integers<std::int32_t>(count));
    }
    if (code != 't')
      return cursor_.fail("numbers packed as integers (i) or by a table (t)",
                          fmt::format("code {}", static_cast<int>(code)));
    const std::size_t size = bytes_of(out->format);
    const auto rows = cursor_.number<std::uint32_t>();
    const auto table = cursor_.take(rows * size);
    const std::vector<std::uint32_t> places = cursor_.integers<std::uint32_t>(count);
    if (!std::ranges::all_of(places, [&](std::uint32_t place) { return place < rows; }))
      return cursor_.fail(fmt::format("places in a table of {} numbers", rows), "one outside");
    out->own.resize(places.size() * size);
    for (std::size_t i = 0; i < places.size(); ++i) std::memcpy(&out->own[i * size], &table[places[i] * size], size);
  }

  /// Converts the numbers. Passes parts of a long list that have been read to done_with_.
  template <class To>
  void convert(const PackedNumbers& numbers, To* out) {
    const std::size_t size = bytes_of(numbers.format);
    auto left = numbers.bytes();
    while (!left.empty()) {
      const auto part = left.first(std::min(left.size(), done_block));
      convert_numbers(part, numbers.format, out);
      if (done_with_ && numbers.own.empty() && part.size() == done_block) done_with_(part);
      out += part.size() / size;
      left = left.subspan(part.size());
    }
  }

  void keep(const PackedNumbers& numbers, bool is_quaternion, UsdNumbers kept_as, UsdValue* value) {
    const std::size_t count = numbers.bytes().size() / bytes_of(numbers.format);
    if (kept_as == UsdNumbers::doubles) {
      value->precise.resize(count);
      convert(numbers, value->precise.data());
      // The crate has the real part behind the others, texts have it first.
      for (auto at = value->precise.begin(); is_quaternion && value->precise.end() - at >= 4; at += 4)
        std::rotate(at, at + 3, at + 4);
    } else if (kept_as == UsdNumbers::triples && count % 3 == 0) {
      static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
      value->triples.resize(count / 3);
      if (count > 0) convert(numbers, &value->triples[0].x);
    } else {
      value->numbers.resize(count);
      convert(numbers, value->numbers.data());
    }
  }

  CrateCursor cursor_;
  DoneWith done_with_;
  int minor_ = newest;
  std::vector<unsigned char> characters_;
  std::vector<std::string_view> tokens_;
  std::vector<std::uint32_t> strings_, field_sets_;
  std::vector<std::uint32_t> field_tokens_;
  std::vector<std::uint64_t> field_values_;
  std::vector<Path> paths_;
  std::uint32_t root_ = no_index;
  std::uint64_t arc_bytes_ = 0;  ///< size of the paths that prims refer to
};

}  // namespace

std::unique_ptr<UsdLayer> usdc_layer(const GroomInput& input) { return std::make_unique<UsdcLayer>(input); }

}  // namespace tress::scene
