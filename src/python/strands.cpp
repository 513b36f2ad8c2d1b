#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.h"
#include "python/arrays_in.h"
#include "python/bindings.h"
#include "scene/read/assembly.h"
#include "scene/read/environment_file.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/obj_file.h"
#include "scene/read/shared_strands.h"

namespace py = pybind11;

namespace tress::python {
namespace {

/// The names of scene::StrandBasis.
constexpr std::array<const char*, 4> drawn_names{"bspline", "linear", "open_bspline", "bezier"};

scene::CurveKind kind_of(const py::dict& from, const std::string& place) {
  const std::string name = from.contains("basis") ? std::string(py::str(from["basis"])) : drawn_names[0];
  const std::vector<std::string>& known = scene::basis_names();
  if (std::ranges::find(known, name) != known.end()) return scene::kind_of_basis(name);
  throw Raised({"", place + ".basis", fmt::format("one of {}", fmt::join(known, ", ")), "\"" + name + "\""});
}

/// The numbers of `key`, every one within +-most; empty if the key is missing.
template <class Item>
std::vector<Item> numbers(const py::dict& from, const char* key, const std::string& place, float least, float most) {
  constexpr std::size_t columns = sizeof(Item) / sizeof(float);
  std::vector<Item> items;
  if (!from.contains(key)) return items;
  const auto array = py::cast<py::array>(from[key]);
  const std::string where = place + "." + key;
  const std::span<const float> values = view<float>(array, columns == 1 ? 0 : columns, where);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] >= least && values[i] <= most) continue;
    throw Raised({"", fmt::format("{}[{}]", where, i / columns),
                  fmt::format("numbers within {:g} and {:g}", least, most), fmt::format("{:g}", values[i])});
  }
  const auto* begin = reinterpret_cast<const Item*>(values.data());
  items.assign(begin, begin + values.size() / columns);
  return items;
}

scene::GroomFile groom_of(const py::dict& from, const std::string& place) {
  constexpr float far = scene::largest_coordinate;
  scene::GroomFile groom;
  groom.format = "strands in memory";
  const scene::CurveKind kind = kind_of(from, place);
  groom.points = numbers<glm::vec3>(from, "points", place, -far, far);
  const auto counts_array = py::cast<py::array>(from["counts"]);
  const std::span<const std::uint32_t> counts = view<std::uint32_t>(counts_array, 0, place + ".counts");
  groom.first_point.reserve(counts.size() + 1);
  groom.first_point.push_back(0);
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (const std::string fault = scene::fault_of(kind, counts[s]); !fault.empty())
      throw Raised({"", fmt::format("{}.counts[{}]", place, s),
                    fmt::format("{} points, as {} has them", fault, scene::words(kind)), fmt::format("{}", counts[s])});
    sum += counts[s];
    if (sum <= groom.points.size()) groom.first_point.push_back(static_cast<std::uint32_t>(sum));
  }
  if (sum != groom.points.size() || sum >= scene::most_groom_points || counts.empty())
    throw Raised({"", place + ".counts", fmt::format("the {} points of one strand or more", groom.points.size()),
                  fmt::format("{} strands of {} points", counts.size(), sum)});
  groom.parts = {{.name = "", .strands = counts.size(), .points = sum}};
  groom.width = numbers<float>(from, "width", place, 0, far);
  groom.color = numbers<glm::vec3>(from, "color", place, 0, 1);
  groom.has_color = !groom.color.empty();
  const auto fits = [&](const char* key, std::size_t size, bool a_strand) {
    if (size == 0 || size == groom.points.size() || (a_strand && size == counts.size())) return;
    throw Raised({"", place + "." + key,
                  fmt::format("{} values, one a point{}", groom.points.size(),
                              a_strand ? fmt::format(", or {}, one a strand", counts.size()) : std::string()),
                  fmt::format("{}", size)});
  };
  groom.normal = numbers<glm::vec3>(from, "normal", place, -far, far);
  for (glm::vec3& normal : groom.normal)
    if (const float length = glm::length(normal); length > 0) normal /= length;
  fits("normal", groom.normal.size(), false);
  fits("width", groom.width.size(), false);
  fits("color", groom.color.size(), true);
  groom.root_uv = numbers<glm::vec2>(from, "root_uv", place, -1e6f, 1e6f);
  if (from.contains("id")) {
    const auto ids = py::cast<py::array_t<std::int64_t, py::array::c_style>>(from["id"]);
    groom.id.assign(ids.data(), ids.data() + ids.size());
  }
  for (const auto& [key, size] : {std::pair{"id", groom.id.size()}, std::pair{"root_uv", groom.root_uv.size()}})
    if (size != 0 && size != counts.size())
      throw Raised(
          {"", place + "." + key, fmt::format("{} values, one a strand", counts.size()), fmt::format("{}", size)});
  if (auto error = scene::take_points_as(kind, place, &groom)) throw Raised(std::move(*error));
  groom.cm_per_unit = py::cast<double>(from["cm_per_unit"]);
  groom.y_up = std::string(py::str(from["up"])) == "y";
  return groom;
}

template <class Index>
std::vector<Index> corners(const py::dict& from, const char* key, const std::string& place, std::size_t items) {
  std::vector<Index> indices;
  if (!from.contains(key)) return indices;
  const auto array = py::cast<py::array>(from[key]);
  const std::span<const std::uint32_t> values = view<std::uint32_t>(array, 3, place + "." + key);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] < items) continue;
    throw Raised({"", fmt::format("{}.{}[{}]", place, key, i / 3), fmt::format("indices below {}", items),
                  fmt::format("{}", values[i])});
  }
  const auto* begin = reinterpret_cast<const Index*>(values.data());
  indices.assign(begin, begin + values.size() / 3);
  return indices;
}

scene::ObjFile mesh_of(const py::dict& from, const std::string& place) {
  constexpr float far = scene::largest_coordinate;
  scene::ObjFile mesh;
  mesh.positions = numbers<glm::vec3>(from, "positions", place, -far, far);
  mesh.triangles = corners<glm::uvec3>(from, "triangles", place, mesh.positions.size());
  if (mesh.triangles.empty()) throw Raised({"", place + ".triangles", "one triangle or more", "none"});
  mesh.normals = numbers<glm::vec3>(from, "normals", place, -far, far);
  mesh.uvs = numbers<glm::vec2>(from, "uvs", place, -1e6f, 1e6f);
  // There is one value for each vertex: corners use the indices of the positions.
  for (const auto& [key, size] : {std::pair{"normals", mesh.normals.size()}, std::pair{"uvs", mesh.uvs.size()}}) {
    if (size != 0 && size != mesh.positions.size())
      throw Raised({"", place + "." + key, fmt::format("{} of them, one a position", mesh.positions.size()),
                    fmt::format("{}", size)});
  }
  if (!mesh.normals.empty()) mesh.corner_normals = mesh.triangles;
  if (!mesh.uvs.empty()) mesh.corner_uvs = mesh.triangles;
  return mesh;
}

scene::HdrPicture environment_of(const py::dict& from, const std::string& place) {
  const auto array = py::cast<py::array>(from["pixels"]);
  constexpr py::ssize_t most_side = 1 << 16;
  if (array.ndim() != 3 || array.shape(2) != 3 || array.size() == 0 || array.shape(0) > most_side ||
      array.shape(1) > most_side || !array.dtype().equal(py::dtype::of<float>()) ||
      (array.flags() & py::array::c_style) == 0)
    throw Raised({"", place, "a C-contiguous array of float32, (height, width, 3)", words(array)});
  const auto* begin = static_cast<const glm::vec3*>(array.data());
  return {static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), {begin, begin + array.size() / 3}};
}

py::dict read_groom(const std::filesystem::path& file, std::optional<std::uint32_t> points_per_strand,
                    std::optional<double> frame) {
  scene::GroomFile groom = [&] {
    const py::gil_scoped_release released;
    scene::GroomFile read = checked(scene::read_groom_file(file, points_per_strand, frame));
    check(scene::write_out(file.string(), &read));
    return read;
  }();
  scene::say_widths(&groom);
  std::vector<std::uint32_t> counts(groom.strand_count());
  for (std::size_t s = 0; s < counts.size(); ++s) counts[s] = groom.first_point[s + 1] - groom.first_point[s];
  py::dict fields;
  fields["points"] = array_of<float>(std::move(groom.points), 3);
  fields["counts"] = array_of<std::uint32_t>(std::move(counts));
  if (!groom.width.empty())
    fields["width"] = array_of<float>(std::move(groom.width));
  else if (groom.default_width > 0)
    fields["width"] = groom.default_width;
  if (!groom.color.empty()) fields["color"] = array_of<float>(std::move(groom.color), 3);
  if (!groom.normal.empty()) fields["normal"] = array_of<float>(std::move(groom.normal), 3);
  if (!groom.id.empty()) fields["id"] = array_of<std::int64_t>(std::move(groom.id));
  if (!groom.root_uv.empty()) fields["root_uv"] = array_of<float>(std::move(groom.root_uv), 2);
  if (groom.cm_per_unit) fields["cm_per_unit"] = *groom.cm_per_unit;
  if (groom.y_up) fields["up"] = *groom.y_up ? "y" : "z";
  if (groom.basis) fields["basis"] = drawn_names[static_cast<std::size_t>(*groom.basis)];
  py::list remarks;
  for (const std::string& remark : groom.remarks) remarks.append(remark);
  for (const scene::IgnoredAttribute& ignored : groom.ignored)
    remarks.append(fmt::format("not used: {} ({})", ignored.name, ignored.why));
  fields["remarks"] = remarks;
  return fields;
}

}  // namespace

scene::FilesInMemory files_of(const py::dict& arrays) {
  scene::FilesInMemory files;
  for (const auto& [key, value] : arrays) {
    const std::string name = py::str(key);
    const auto pair = py::cast<py::tuple>(value);
    const std::string kind = py::str(pair[0]);
    const auto from = py::cast<py::dict>(pair[1]);
    if (kind == "strands") files.grooms.emplace(name, groom_of(from, name));
    if (kind == "mesh") files.meshes.emplace(name, mesh_of(from, name));
    if (kind == "environment") files.environments.emplace(name, environment_of(from, name));
  }
  return files;
}

void bind_strands(py::module_& module) {
  module.def("read_groom", &read_groom, py::arg("file"), py::arg("points_per_strand") = py::none(),
             py::arg("frame") = py::none(),
             "Strands of any format that is read, as the file has them, as arrays that own what was read.");
}

}  // namespace tress::python
