#include "scene/read/groom_writers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <functional>
#include <iterator>

#include "base/file_replacement.h"
#include "scene/read/grooms/curve_bases.h"

namespace tress::scene {
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 20;

/// Collects output into blocks, and keeps the first failure.
class BlockWriter {
 public:
  explicit BlockWriter(const std::filesystem::path& file) : error_(out_.begin(file)) {}

  fmt::memory_buffer& buffer() {
    if (buffer_.size() >= block_bytes) flush();
    return buffer_;
  }
  template <class T>
  void raw(const T& value) {
    const auto* bytes = reinterpret_cast<const char*>(&value);
    buffer().append(bytes, bytes + sizeof value);
  }
  template <class... Arguments>
  void print(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(buffer()), format, std::forward<Arguments>(arguments)...);
  }
  std::optional<Error> finish() {
    flush();
    return error_ ? error_ : out_.finish();
  }

 private:
  void flush() {
    if (!error_) error_ = out_.write({buffer_.data(), buffer_.size()});
    buffer_.clear();
  }

  FileReplacement out_;
  std::optional<Error> error_;
  fmt::memory_buffer buffer_;
};

/// Strands by points alone: the file's points, or points on its curves.
struct Sampled {
  std::vector<std::uint32_t> first_point;
  std::vector<glm::vec3> points;
  std::vector<float> width;
  std::vector<glm::vec3> color;
};

template <class T>
T on_bezier(std::span<const T> p, std::size_t segment, float t) {
  const T *b = p.data() + 3 * segment, a = b[0];
  const float s = 1 - t;
  return s * s * s * a + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
}

template <class T>
std::vector<T> sampled(const GroomFile& groom, std::span<const T> values, int a_segment,
                       std::vector<std::uint32_t>* first_point) {
  const std::vector<T> bezier = as_bezier<T>(*groom.basis, groom.first_point, values);
  const std::uint32_t ends = groom.basis == StrandBasis::open_bspline ? 3 : 1;
  std::vector<T> out;
  std::size_t begin = 0;
  if (first_point) *first_point = {0};
  for (std::size_t s = 0; s < groom.strand_count(); ++s) {
    const std::uint32_t count = groom.first_point[s + 1] - groom.first_point[s];
    if (count > 0) {
      const std::size_t segments = *groom.basis == StrandBasis::bezier ? (count - 1) / 3 : count - ends;
      const std::span<const T> strand(bezier.data() + begin, 3 * segments + 1);
      for (std::size_t i = 0; i < segments; ++i)
        for (int k = 0; k < a_segment; ++k)
          out.push_back(on_bezier(strand, i, static_cast<float>(k) / static_cast<float>(a_segment)));
      out.push_back(strand.back());
      begin += strand.size();
    }
    if (first_point) first_point->push_back(static_cast<std::uint32_t>(out.size()));
  }
  return out;
}

std::optional<Error> write_hair(const GroomFile& groom, const std::filesystem::path& file,
                                std::vector<std::string>* notes) {
  constexpr int points_a_segment = 4;
  const bool is_curved = groom.basis == StrandBasis::bezier || groom.basis == StrandBasis::open_bspline;
  Sampled s;
  if (is_curved) {
    notes->push_back(fmt::format(".hair has points alone: {} points on each segment of the curves; .usda keeps them",
                                 points_a_segment));
    s.points = sampled<glm::vec3>(groom, groom.points, points_a_segment, &s.first_point);
    if (!groom.width.empty()) s.width = sampled<float>(groom, groom.width, points_a_segment, nullptr);
    if (groom.color.size() == groom.points.size())
      s.color = sampled<glm::vec3>(groom, groom.color, points_a_segment, nullptr);
  } else if (groom.basis == StrandBasis::linear) {
    notes->push_back(".hair cannot say that strands are straight from point to point: \"basis\": \"linear\" does");
  }
  const auto& first_point = is_curved ? s.first_point : groom.first_point;
  const auto& points = is_curved ? s.points : groom.points;
  const auto& width = is_curved ? s.width : groom.width;
  const auto& color = is_curved ? s.color : groom.color;
  const double scale = groom.cm_per_unit.value_or(1);
  if (groom.cm_per_unit)
    notes->push_back(fmt::format("written in centimetres{}: --cm-per-unit 1{}", groom.y_up ? ", z up" : "",
                                 groom.y_up ? " --up z" : ""));
  if (!groom.id.empty()) notes->push_back(".hair has no ids");
  if (!groom.root_uv.empty()) notes->push_back(".hair has no root uv");
  if (!groom.normal.empty()) notes->push_back(".hair has no normals");

  std::uint32_t strands = 0;
  for (std::size_t i = 0; i + 1 < first_point.size(); ++i) {
    const std::uint32_t count = first_point[i + 1] - first_point[i];
    if (count > 65536)
      return Error{file.string(), "", "strands of at most 65536 points in a .hair file", fmt::format("{}", count)};
    strands += count > 0 ? 1 : 0;
  }
  const bool has_widths = !width.empty(), has_colors = !color.empty();
  BlockWriter out(file);
  std::array<unsigned char, 128> header{};
  const auto put = [&](std::size_t at, auto value) { std::memcpy(header.data() + at, &value, sizeof value); };
  std::memcpy(header.data(), "HAIR", 4);
  put(4, strands);
  put(8, static_cast<std::uint32_t>(points.size()));
  put(12, std::uint32_t{1u | 2u | (has_widths ? 4u : 0u) | (has_colors ? 16u : 0u)});
  put(20, to_float(groom.default_width * scale));
  for (int c = 0; c < 3; ++c) put(28 + 4 * static_cast<std::size_t>(c), groom.default_color[c]);
  out.raw(header);
  for (std::size_t i = 0; i + 1 < first_point.size(); ++i)
    if (const std::uint32_t count = first_point[i + 1] - first_point[i]; count > 0)
      out.raw(static_cast<std::uint16_t>(count - 1));
  for (const glm::vec3& point : points) {
    const glm::vec3 x = point * static_cast<float>(scale);
    out.raw(groom.y_up.value_or(false) ? glm::vec3(x.x, -x.z, x.y) : x);
  }
  for (const float w : width) out.raw(to_float(w * scale));
  if (has_colors)
    for (std::size_t i = 0; i + 1 < first_point.size(); ++i)
      for (std::uint32_t k = first_point[i]; k < first_point[i + 1]; ++k)
        out.raw(color[color.size() == points.size() ? k : i]);
  return out.finish();
}

/// Writes name = [item, item]; each call of `item` gives one value.
void write_list(BlockWriter* out, const char* name, std::size_t count, const std::function<void(std::size_t)>& item,
                const char* interpolation) {
  out->print("        {} = [", name);
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) out->print(", ");
    item(i);
  }
  if (interpolation[0] == 0)
    out->print("]\n");
  else
    out->print("] (\n            interpolation = \"{}\"\n        )\n", interpolation);
}

std::optional<Error> write_usda(const GroomFile& groom, const std::filesystem::path& file,
                                std::vector<std::string>* notes) {
  const StrandBasis basis = groom.basis.value_or(StrandBasis::bspline);
  std::vector<std::size_t> kept;
  for (std::size_t s = 0; s < groom.strand_count(); ++s)
    if (groom.first_point[s + 1] > groom.first_point[s]) kept.push_back(s);
  if (!groom.cm_per_unit)
    notes->push_back("the file gives no unit: 1 cm is written for one; --cm-per-unit says otherwise");
  BlockWriter out(file);
  out.print("#usda 1.0\n(\n    defaultPrim = \"Groom\"\n    metersPerUnit = {}\n    upAxis = \"{}\"\n)\n\n",
            groom.cm_per_unit.value_or(1) / 100, groom.y_up.value_or(false) ? 'Y' : 'Z');
  out.print("def Xform \"Groom\"\n{{\n    def BasisCurves \"Hair\"\n    {{\n");
  out.print("        uniform token type = \"{}\"\n", basis == StrandBasis::linear ? "linear" : "cubic");
  if (basis != StrandBasis::linear)
    out.print("        uniform token basis = \"{}\"\n", basis == StrandBasis::bezier ? "bezier" : "bspline");
  out.print("        uniform token wrap = \"{}\"\n", basis == StrandBasis::bspline ? "pinned" : "nonperiodic");
  write_list(
      &out, "int[] curveVertexCounts", kept.size(),
      [&](std::size_t i) { out.print("{}", groom.first_point[kept[i] + 1] - groom.first_point[kept[i]]); }, "");
  const auto triples = [&](const char* name, const std::vector<glm::vec3>& values, const char* interpolation) {
    write_list(
        &out, name, values.size(),
        [&](std::size_t i) { out.print("({}, {}, {})", values[i].x, values[i].y, values[i].z); }, interpolation);
  };
  triples("point3f[] points", groom.points, "");
  if (!groom.width.empty())
    write_list(
        &out, "float[] widths", groom.width.size(), [&](std::size_t i) { out.print("{}", groom.width[i]); }, "vertex");
  else if (groom.default_width > 0)
    write_list(&out, "float[] widths", 1, [&](std::size_t) { out.print("{}", groom.default_width); }, "constant");
  if (groom.color.size() == groom.points.size() && groom.has_color) {
    triples("color3f[] primvars:displayColor", groom.color, "vertex");
  } else if (groom.has_color) {
    std::vector<glm::vec3> color;
    for (const std::size_t s : kept) color.push_back(groom.color_at(s, 0));
    if (groom.color.empty()) color.resize(1);
    triples("color3f[] primvars:displayColor", color, groom.color.empty() ? "constant" : "uniform");
  }
  if (!groom.normal.empty()) triples("normal3f[] normals", groom.normal, "vertex");
  if (!groom.id.empty())
    write_list(
        &out, "int[] primvars:id", kept.size(), [&](std::size_t i) { out.print("{}", groom.id[kept[i]]); }, "uniform");
  if (!groom.root_uv.empty())
    write_list(
        &out, "texCoord2f[] primvars:groom_root_uv", kept.size(),
        [&](std::size_t i) { out.print("({}, {})", groom.root_uv[kept[i]].x, groom.root_uv[kept[i]].y); }, "uniform");
  out.print("    }}\n}}\n");
  return out.finish();
}

}  // namespace

const std::vector<std::string>& groom_output_endings() {
  static const std::vector<std::string> endings{".hair", ".usda"};
  return endings;
}

std::optional<Error> write_groom_file(const GroomFile& groom, const std::filesystem::path& file,
                                      std::vector<std::string>* notes) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".hair") return write_hair(groom, file, notes);
  if (ending == ".usda") return write_usda(groom, file, notes);
  return Error{file.string(), "", "a name that ends with .hair or .usda", ending.empty() ? "none" : ending};
}

}  // namespace tress::scene
