// Reads strands in PLY: vertices in the order of the strands (README.md).
#include "scene/read/grooms/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "scene/read/grooms/groom_builder.h"
#include "scene/read/grooms/text_cursor.h"

namespace tress::scene {
namespace {

constexpr std::uint32_t usual_points_per_strand = 100;

enum class Number { i8, u8, i16, u16, i32, u32, f32, f64 };

/// The properties of vertices.
constexpr FormatItem ply_table[] = {
    {"x", ""},
    {"y", ""},
    {"z", ""},
    {"red", ""},
    {"green", ""},
    {"blue", ""},
    {"r", ""},
    {"g", ""},
    {"b", ""},
    {"width", ""},
    {"diameter", ""},
    {"radius", ""},
    {"strand_id", ""},
    {"strand", ""},
    {"curve_id", ""},
    {"alpha", "hair is not transparent by a color"},
    {"nx", "normals of vertices are those of surfaces"},
    {"ny", "normals of vertices are those of surfaces"},
    {"nz", "normals of vertices are those of surfaces"},
};

struct Property {
  std::string name;
  Number type;
};

std::size_t bytes_of(Number type) {
  static constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

std::optional<Number> number_type(std::string_view word) {
  static constexpr std::pair<std::string_view, Number> types[] = {
      {"char", Number::i8},   {"int8", Number::i8},     {"uchar", Number::u8},   {"uint8", Number::u8},
      {"short", Number::i16}, {"int16", Number::i16},   {"ushort", Number::u16}, {"uint16", Number::u16},
      {"int", Number::i32},   {"int32", Number::i32},   {"uint", Number::u32},   {"uint32", Number::u32},
      {"float", Number::f32}, {"float32", Number::f32}, {"double", Number::f64}, {"float64", Number::f64}};
  const auto found = std::ranges::find(types, word, &std::pair<std::string_view, Number>::first);
  return found == std::end(types) ? std::nullopt : std::optional(found->second);
}

template <class T>
double value_at(const unsigned char* bytes, bool is_big) {
  std::array<unsigned char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (is_big) std::ranges::reverse(raw);
  return static_cast<double>(std::bit_cast<T>(raw));
}

double value_of(Number type, const unsigned char* bytes, bool is_big) {
  switch (type) {
    case Number::i8:
      return value_at<std::int8_t>(bytes, is_big);
    case Number::u8:
      return value_at<std::uint8_t>(bytes, is_big);
    case Number::i16:
      return value_at<std::int16_t>(bytes, is_big);
    case Number::u16:
      return value_at<std::uint16_t>(bytes, is_big);
    case Number::i32:
      return value_at<std::int32_t>(bytes, is_big);
    case Number::u32:
      return value_at<std::uint32_t>(bytes, is_big);
    case Number::f32:
      return value_at<float>(bytes, is_big);
    default:
      return value_at<double>(bytes, is_big);
  }
}

class PlyReader {
 public:
  explicit PlyReader(const GroomInput& input)
      : input_(input),
        text_(reinterpret_cast<const char*>(input.bytes.data()), input.bytes.size()),
        builder_(input.name, "PLY strands") {}

  Result<GroomFile> read() {
    read_header();
    if (!error_) read_vertices();
    if (!error_) read_edges();
    if (!error_) cut_strands();
    if (error_) return *error_;
    if (auto error = builder_.add(std::move(set_))) return *error;
    builder_.file().basis.reset();
    return builder_.finish();
  }

 private:
  void fail(std::string expected, std::string found) {
    if (!error_) error_ = Error{input_.name, fmt::format("byte {}", at_), std::move(expected), std::move(found)};
  }

  /// The words of the next line of the header.
  std::vector<std::string_view> line() {
    const std::size_t end = text_.find('\n', at_);
    std::vector<std::string_view> words;
    if (end == text_.npos) {
      fail("a header that ends with end_header", "the end of the file");
      return words;
    }
    std::string_view rest = text_.substr(at_, end - at_);
    at_ = end + 1;
    while (!rest.empty() && words.size() < 8) {
      const std::size_t begin = std::min(rest.find_first_not_of(" \t\r"), rest.size());
      rest.remove_prefix(begin);
      const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r"));
      if (!word.empty()) words.push_back(word);
      rest.remove_prefix(word.size());
    }
    return words;
  }

  void read_header() {
    line();  // ply
    std::string element;
    while (!error_) {
      const auto words = line();
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() >= 2) {
        is_ascii_ = words[1] == "ascii";
        is_big_ = words[1] == "binary_big_endian";
        if (!is_ascii_ && !is_big_ && words[1] != "binary_little_endian")
          fail("a format of PLY", std::string(words[1].substr(0, 32)));
      } else if (words[0] == "element" && words.size() >= 3) {
        begin_element(words[1], words[2], &element);
      } else if (words[0] == "property" && element == "vertex") {
        const auto type = words.size() >= 3 ? number_type(words[1]) : std::nullopt;
        if (!type)
          fail("a property of one number a vertex", words.size() >= 2 ? std::string(words[1].substr(0, 32)) : "none");
        else if (properties_.size() >= 256)
          fail("at most 256 properties", "more");
        else
          properties_.push_back({printable(std::string(words[2].substr(0, 64))), *type});
      } else if (words[0] == "property" && element == "edge" && has_edges_) {
        const auto type = words.size() >= 3 ? number_type(words[1]) : std::nullopt;
        if (type && edge_properties_.size() < 256)
          edge_properties_.push_back({printable(std::string(words[2].substr(0, 64))), *type});
        else
          fail("a property of one number an edge", words.size() >= 2 ? std::string(words[1].substr(0, 32)) : "none");
      } else if (words[0] != "property") {
        fail("a line of a PLY header", std::string(words[0].substr(0, 32)));
      }
    }
    if (count_ == 0) fail("an element vertex", "none");
    for (const char* name : {"x", "y", "z"})
      if (!place_of({name})) fail(fmt::format("a property {} of vertices", name), "none");
  }

  void begin_element(std::string_view name, std::string_view count, std::string* element) {
    std::uint64_t number = 0;
    const auto [end, fault] = std::from_chars(count.data(), count.data() + count.size(), number);
    if (fault != std::errc() || end != count.data() + count.size())
      return fail("a number of elements", std::string(count.substr(0, 32)));
    if (name == "vertex") {
      if (!element->empty()) fail("vertices before other elements", *element);
      count_ = number;
    } else if (name == "face" && number > 0) {
      fail("strands: vertices alone", fmt::format("{} faces, a mesh", number));
    } else if (name == "edge" && *element == "vertex") {
      edge_count_ = number;
      has_edges_ = number > 0;
    } else if (number > 0) {
      builder_.file().ignored.push_back(
          {fmt::format("element {}", name.substr(0, 64)), "vertices, and edges right behind them, are read"});
    }
    *element = name.substr(0, 64);
  }

  std::optional<std::size_t> place_of(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names)
      for (std::size_t i = 0; i < properties_.size(); ++i)
        if (properties_[i].name == name) return i;
    return std::nullopt;
  }

  void read_vertices() {
    std::size_t stride = 0;
    std::vector<std::size_t> offsets;
    for (const Property& property : properties_) {
      offsets.push_back(stride);
      stride += is_ascii_ ? 2 : bytes_of(property.type);  // at least a digit and a blank
    }
    const std::uint64_t left = text_.size() - at_ + (is_ascii_ ? 1 : 0);
    if (count_ > left / stride)
      return fail(fmt::format("at most {} vertices, as the bytes allow", left / stride), fmt::format("{}", count_));
    TextCursor cursor(input_.bytes.subspan(at_), input_.name);
    std::vector<double> row(properties_.size());
    const auto x = *place_of({"x"}), y = *place_of({"y"}), z = *place_of({"z"});
    const std::string& attribute = input_.attribute;
    const auto one = place_of({attribute});
    const auto red = attribute.empty() ? place_of({"red", "r"}) : one,
               green = attribute.empty() ? place_of({"green", "g"}) : one,
               blue = attribute.empty() ? place_of({"blue", "b"}) : one;
    const auto width = place_of({"width", "diameter"}), radius = place_of({"radius"}),
               strand = place_of({"strand_id", "strand", "curve_id"});
    const bool has_color = red && green && blue;
    const std::size_t color_bytes = has_color ? bytes_of(properties_[*red].type) : 0;
    const double most_color = color_bytes == 1 ? 255 : color_bytes == 2 ? 65535 : 1;
    set_.vertices.reserve(count_);
    for (std::uint64_t i = 0; i < count_; ++i) {
      for (std::size_t k = 0; k < row.size(); ++k)
        row[k] = is_ascii_
                     ? cursor.number()
                     : value_of(properties_[k].type, input_.bytes.data() + at_ + i * stride + offsets[k], is_big_);
      if (cursor.error()) return fail(fmt::format("{} vertices", count_), fmt::format("no number in vertex {}", i));
      set_.vertices.emplace_back(to_float(row[x]), to_float(row[y]), to_float(row[z]));
      if (width || radius) set_.width.values.push_back(to_float(width ? row[*width] : 2 * row[*radius]));
      if (has_color)
        set_.color.values.emplace_back(to_float(row[*red] / most_color), to_float(row[*green] / most_color),
                                       to_float(row[*blue] / most_color));
      if (strand) ids_.push_back(row[*strand]);
    }
    at_ = is_ascii_ ? at_ + cursor.at() : at_ + static_cast<std::size_t>(count_) * stride;
    set_.width.name = "width";
    set_.color.name = attribute.empty() ? "red, green, blue" : attribute;
    if (!attribute.empty()) builder_.file().attribute = attribute;
    set_.width.scope = set_.color.scope = AttributeScope::vertex;
    std::set<std::size_t> used{x, y, z};
    for (const auto& place : {width ? width : radius, strand}) used.insert(place.value_or(x));
    if (has_color || !attribute.empty())
      for (const auto& place : {place_of({"red", "r"}), place_of({"green", "g"}), place_of({"blue", "b"})})
        used.insert(place.value_or(x));
    for (std::size_t i = 0; i < properties_.size(); ++i) name_what_is_left(properties_[i].name, used.contains(i));
  }

  /// Reads pairs of vertices, if they directly follow the vertices.
  void read_edges() {
    if (!has_edges_) return;
    std::optional<std::size_t> from, to;
    std::size_t stride = 0;
    std::vector<std::size_t> offsets;
    for (std::size_t i = 0; i < edge_properties_.size(); ++i) {
      const Property& property = edge_properties_[i];
      if (property.name == "vertex1") from = i;
      if (property.name == "vertex2") to = i;
      if (property.name != "vertex1" && property.name != "vertex2")
        builder_.ignore("property " + property.name + " of edges", "those of vertices are read");
      offsets.push_back(stride);
      stride += is_ascii_ ? 2 : bytes_of(property.type);
    }
    if (!from || !to) {
      builder_.ignore("element edge", "it has no vertex1 and vertex2");
      return;
    }
    const std::uint64_t left = text_.size() - std::min(at_, text_.size()) + (is_ascii_ ? 1 : 0);
    if (edge_count_ > left / stride)
      return fail(fmt::format("at most {} edges, as the bytes allow", left / stride), fmt::format("{}", edge_count_));
    TextCursor cursor(input_.bytes.subspan(at_), input_.name);
    std::vector<double> row(edge_properties_.size());
    for (std::uint64_t i = 0; i < edge_count_; ++i) {
      for (std::size_t k = 0; k < row.size(); ++k)
        row[k] = is_ascii_
                     ? cursor.number()
                     : value_of(edge_properties_[k].type, input_.bytes.data() + at_ + i * stride + offsets[k], is_big_);
      if (cursor.error()) return fail(fmt::format("{} edges", edge_count_), fmt::format("no number in edge {}", i));
      const double most = static_cast<double>(count_) - 1;
      if (!(row[*from] >= 0 && row[*from] <= most && row[*to] >= 0 && row[*to] <= most))
        return fail(fmt::format("vertices up to {} in edge {}", count_ - 1, i),
                    fmt::format("{:g} and {:g}", row[*from], row[*to]));
      edges_.emplace_back(static_cast<std::uint32_t>(row[*from]), static_cast<std::uint32_t>(row[*to]));
    }
  }

  /// Orders the vertices strand by strand, as edges join them, root first: the root is the end that comes first in the
  /// file. Empty if edges branch.
  std::vector<std::uint32_t> order_by_edges(std::vector<std::uint32_t>* counts) const {
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::array<std::uint32_t, 2>> beside(count_, {none, none});
    for (const auto& [a, b] : edges_)
      for (const auto& [here, there] : {std::pair{a, b}, std::pair{b, a}}) {
        if (beside[here][1] != none || a == b) return {};
        beside[here][beside[here][0] == none ? 0 : 1] = there;
      }
    std::vector<std::uint32_t> order;
    std::vector<bool> is_placed(count_, false);
    const auto follow = [&](std::uint32_t at) {
      counts->push_back(0);
      while (at != none && !is_placed[at]) {
        is_placed[at] = true;
        order.push_back(at);
        ++counts->back();
        const auto& next = beside[at];
        at = next[0] != none && !is_placed[next[0]] ? next[0] : next[1];
      }
    };
    for (const bool only_ends : {true, false})
      for (std::uint32_t i = 0; i < count_; ++i)
        if (!is_placed[i] && (!only_ends || beside[i][1] == none)) follow(i);
    return order;
  }

  /// The same by the strand id of each vertex, in the order in which strands first occur.
  std::vector<std::uint32_t> order_by_ids(std::vector<std::uint32_t>* counts) const {
    std::unordered_map<double, std::uint32_t> place;
    std::vector<std::uint32_t> strand;
    for (const double id : ids_) {
      const auto [at, is_new] = place.emplace(id, static_cast<std::uint32_t>(counts->size()));
      if (is_new) counts->push_back(0);
      strand.push_back(at->second);
      ++(*counts)[at->second];
    }
    std::vector<std::uint32_t> next(counts->size(), 0), order(ids_.size());
    for (std::size_t s = 1; s < next.size(); ++s) next[s] = next[s - 1] + (*counts)[s - 1];
    for (std::uint32_t i = 0; i < ids_.size(); ++i) order[next[strand[i]]++] = i;
    return order;
  }

  void name_what_is_left(const std::string& name, bool is_used) {
    const char* why = why_not_used(ply_table, name);
    if (is_used || name == input_.attribute) return;
    builder_.ignore("property " + name,
                    *why != 0 ? why : "another is in its place, or what belongs to it is not there");
  }

  void cut_strands() {
    std::vector<std::uint32_t> order;
    if (!ids_.empty())
      order = order_by_ids(&set_.vertex_counts);
    else if (!edges_.empty())
      order = order_by_edges(&set_.vertex_counts);
    if (!ids_.empty() && has_edges_) builder_.ignore("element edge", "strand ids join the vertices");
    if (!order.empty()) {
      const auto sort = [&](auto* values) {
        auto sorted = *values;
        for (std::size_t i = 0; i < values->size(); ++i) sorted[i] = (*values)[order[i]];
        *values = std::move(sorted);
      };
      if (std::ranges::is_sorted(order)) return;
      sort(&set_.vertices);
      sort(&set_.width.values);
      sort(&set_.color.values);
      return;
    }
    set_.vertex_counts.clear();
    if (!edges_.empty()) builder_.ignore("element edge", "edges branch: strands are cut by their number of points");
    const std::uint32_t points = input_.points_per_strand.value_or(usual_points_per_strand);
    if (count_ % points != 0)
      return fail(fmt::format("strands of {} points (\"points_per_strand\" says how many)", points),
                  fmt::format("{} vertices", count_));
    if (!input_.points_per_strand)
      builder_.file().remarks.push_back(
          fmt::format("strands of {} points taken; \"points_per_strand\" says otherwise", points));
    set_.vertex_counts.assign(count_ / points, points);
  }

  const GroomInput& input_;
  std::string_view text_;
  GroomBuilder builder_;
  CurveSet set_;
  std::vector<Property> properties_;
  std::vector<Property> edge_properties_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
  std::vector<double> ids_;  ///< strand ids, one for each vertex
  std::uint64_t count_ = 0, edge_count_ = 0;
  std::size_t at_ = 0;
  bool is_ascii_ = true, is_big_ = false, has_edges_ = false;
  std::optional<Error> error_;
};

}  // namespace

std::span<const FormatItem> ply_items() { return ply_table; }

Result<GroomFile> read_ply(const GroomInput& input) { return PlyReader(input).read(); }

}  // namespace tress::scene
