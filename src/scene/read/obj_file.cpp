#include "scene/read/obj_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "scene/model/scene.h"
#include "scene/read/grooms/text_cursor.h"
#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

/// Statements without effect on polygons.
constexpr std::array<std::string_view, 14> read_over{
    "vp", "o", "g", "s", "mg", "usemtl", "l", "mtllib", "usemap", "maplib", "lod", "p", "shadow_obj", "trace_obj"};

constexpr float furthest_uv = 1e6f;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Words of a statement, in turn.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  /// Empty at the end.
  std::string_view next() {
    while (!text_.empty() && is_blank(text_.front())) text_.remove_prefix(1);
    std::size_t size = 0;
    while (size < text_.size() && !is_blank(text_[size])) ++size;
    const auto word = text_.substr(0, size);
    text_.remove_prefix(size);
    return word;
  }

 private:
  std::string_view text_;
};

/// The whole word as a number; empty if it is no number or out of the range of T.
template <class T>
std::optional<T> number(std::string_view word) {
  T value{};
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

class ObjReader {
 public:
  explicit ObjReader(const std::string& name) : name_(name) {}

  /// Reads one statement without its comment; an error ends the reading.
  std::optional<Error> statement(std::string_view text, std::size_t line) {
    line_ = line;
    Words words(text);
    const auto keyword = words.next();
    if (keyword.empty()) return std::nullopt;
    if (keyword == "v") return vertex(words);
    if (keyword == "vn") return normal(words);
    if (keyword == "vt") return uv(words);
    if (keyword == "f") return face(words);
    if (std::find(read_over.begin(), read_over.end(), keyword) != read_over.end()) return std::nullopt;
    return error("v, f or another statement of polygons", shown(keyword));
  }

  Result<ObjFile> finish() {
    if (file_.triangles.empty()) return Error{name_, "", "a face or more", fmt::format("none in {} lines", line_)};
    if (!any_normal_) file_.corner_normals.clear();
    if (!any_uv_) file_.corner_uvs.clear();
    return std::move(file_);
  }

 private:
  Error error(std::string expected, std::string found) const {
    return {name_, fmt::format("line {}", line_), std::move(expected), std::move(found)};
  }

  /// The word, printable and short enough for a message.
  static std::string shown(std::string_view word) {
    std::string text(word.substr(0, 40));
    for (char& c : text)
      if (c < ' ' || c > '~') c = '?';
    return text.empty() ? "the end of the line" : text;
  }

  std::optional<Error> vertex(Words& words) {
    glm::vec3 position;
    for (int c = 0; c < 3; ++c) {
      const auto word = words.next();
      const auto x = number<float>(word);
      if (!x || !std::isfinite(*x)) return error("a finite coordinate", shown(word));
      position[c] = *x;
    }
    if (file_.positions.size() == UINT32_MAX) return error("fewer vertices", "2^32 of them");
    file_.positions.push_back(position);
    return std::nullopt;
  }

  /// Reads a normal. An invalid one becomes a normal of length 0, so that those after it keep their numbers.
  std::optional<Error> normal(Words& words) {
    glm::vec3 direction;
    for (int c = 0; c < 3; ++c) {
      const auto x = number<float>(words.next());
      direction[c] = x && std::isfinite(*x) ? *x : std::numeric_limits<float>::quiet_NaN();
    }
    if (file_.normals.size() == no_normal) return error("fewer normals", "2^32 of them");
    const bool whole = !std::isnan(direction.x) && !std::isnan(direction.y) && !std::isnan(direction.z);
    file_.normals.push_back(whole ? direction : glm::vec3(0.0f));
    return std::nullopt;
  }

  /// Reads texture coordinates. Invalid ones are marked, so that those after them keep their numbers.
  std::optional<Error> uv(Words& words) {
    glm::vec2 place(std::numeric_limits<float>::quiet_NaN());
    for (int c = 0; c < 2; ++c) {
      const auto x = number<float>(words.next());
      if (x && std::abs(*x) <= furthest_uv) place[c] = *x;
    }
    if (file_.uvs.size() == no_uv) return error("fewer texture coordinates", "2^32 of them");
    const bool whole = !std::isnan(place.x) && !std::isnan(place.y);
    file_.uvs.push_back(whole ? place : glm::vec2(0.0f));
    bad_uv_.push_back(!whole);
    return std::nullopt;
  }

  /// Converts a number from 1 on, or from -1 backwards, to an index; no_normal if it is not among the `size` so far.
  static std::uint32_t index_of(std::int64_t number, std::size_t size) {
    const auto count = static_cast<std::int64_t>(size);
    const std::int64_t from_zero = number > 0 ? number - 1 : number + count;
    return number == 0 || from_zero < 0 || from_zero >= count ? no_normal : static_cast<std::uint32_t>(from_zero);
  }

  std::uint32_t uv_at(std::int64_t number) const {
    const std::uint32_t index = index_of(number, file_.uvs.size());
    return index != no_uv && bad_uv_[index] ? no_uv : index;
  }

  struct Corner {
    std::uint32_t vertex = 0, uv = no_uv, normal = no_normal;
  };

  /// Reads the vertex, then up to two numeric indices: of the texture coordinates, which may be left out, and of the
  /// normal.
  std::optional<Error> corner(std::string_view word, Corner* corner) const {
    const auto whole = word;
    for (int part = 0; part < 3; ++part) {
      const auto slash = word.find('/');
      const auto index = number<std::int64_t>(word.substr(0, slash));
      const bool left_out = part == 1 && slash == 0;
      if (!index && !left_out) return error("a corner as v, v/vt, v//vn or v/vt/vn", shown(whole));
      if (part == 0) {
        corner->vertex = index_of(*index, file_.positions.size());
        if (corner->vertex == no_normal)
          return error(fmt::format("an index of one of the {} vertices so far", file_.positions.size()), shown(whole));
      }
      if (part == 1 && index) corner->uv = uv_at(*index);
      if (part == 2) corner->normal = index_of(*index, file_.normals.size());
      if (slash == std::string_view::npos) return std::nullopt;
      word.remove_prefix(slash + 1);
    }
    return error("a corner as v, v/vt, v//vn or v/vt/vn", shown(whole));
  }

  std::optional<Error> face(Words& words) {
    Corner first, last;
    std::uint32_t corners = 0;
    for (auto word = words.next(); !word.empty(); word = words.next(), ++corners) {
      Corner next;
      if (auto error = corner(word, &next)) return error;
      if (corners == 0) first = next;
      if (corners > 1) {
        file_.triangles.emplace_back(first.vertex, last.vertex, next.vertex);
        file_.corner_normals.emplace_back(first.normal, last.normal, next.normal);
        file_.corner_uvs.emplace_back(first.uv, last.uv, next.uv);
      }
      any_normal_ = any_normal_ || next.normal != no_normal;
      any_uv_ = any_uv_ || next.uv != no_uv;
      last = next;
    }
    if (corners < 3) return error("a face of three corners or more", fmt::format("{}", corners));
    return std::nullopt;
  }

  const std::string& name_;
  std::size_t line_ = 0;
  bool any_normal_ = false, any_uv_ = false;
  std::vector<bool> bad_uv_;
  ObjFile file_;
};

}  // namespace

Result<ObjFile> parse_obj_file(std::span<const unsigned char> bytes, const std::string& name) {
  bytes = without_byte_order_mark(bytes);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  ObjReader reader(name);
  std::string joined;  // lines that end with a backslash, joined
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto end = text.find('\n');
    auto piece = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    while (!piece.empty() && is_blank(piece.back())) piece.remove_suffix(1);
    piece = piece.substr(0, piece.find('#'));
    const bool goes_on = piece.ends_with('\\') && !text.empty();
    if (goes_on) piece.remove_suffix(1);
    if (goes_on || !joined.empty()) {
      joined.append(piece).push_back(' ');
      if (goes_on) continue;
      piece = joined;
    }
    if (auto error = reader.statement(piece, line)) return *error;
    joined.clear();
  }
  return reader.finish();
}

}  // namespace tress::scene
