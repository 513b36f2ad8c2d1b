#include "scene/read/object_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/ext/matrix_transform.hpp>
#include <iterator>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/numbered_file.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/given_basis.h"
#include "scene/read/input_files.h"
#include "scene/read/obj_file.h"
#include "scene/read/shared_strands.h"
#include "scene/read/texture_file.h"

namespace tress::scene {
namespace {

constexpr std::uintmax_t most_obj_bytes = std::uintmax_t{2} << 30;

/// The whole frames around the moments, and what `read` returns for their numbers.
template <class File>
Result<std::map<int, File>> files_around(const FrameMoments& moments, const std::function<Result<File>(int)>& read) {
  std::map<int, File> files;
  for (const double frame : moments.frames)
    for (const double whole : {std::floor(frame), std::ceil(frame)}) {
      const int number = static_cast<int>(whole);
      if (files.contains(number)) continue;
      auto file = read(number);
      if (!file) return file.error();
      files.emplace(number, std::move(*file));
    }
  return files;
}

/// Interpolates points, or other values, at a frame, linearly between the files of the whole frames around it.
template <class File, class Value>
std::vector<Value> values_between(const std::map<int, File>& files, double frame, std::vector<Value> File::* values) {
  std::vector<Value> at = files.at(static_cast<int>(std::floor(frame))).*values;
  const auto share = static_cast<float>(frame - std::floor(frame));
  if (share == 0) return at;
  const std::vector<Value>& after = files.at(static_cast<int>(std::ceil(frame))).*values;
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = (1 - share) * at[i] + share * after[i];
  return at;
}

/// The index of every strand of `first` in `other`, by their ids; empty if ids do not determine it.
std::optional<std::vector<std::uint32_t>> order_by_id(const GroomFile& first, const GroomFile& other) {
  const std::size_t strands = first.strand_count();
  if (first.id.size() != strands || other.id.size() != strands) return std::nullopt;
  std::unordered_map<std::int64_t, std::uint32_t> place;
  for (std::uint32_t s = 0; s < strands; ++s)
    if (!place.emplace(other.id[s], s).second) return std::nullopt;
  std::vector<std::uint32_t> order;
  order.reserve(strands);
  for (const std::int64_t id : first.id) {
    const auto found = place.find(id);
    if (found == place.end()) return std::nullopt;
    order.push_back(found->second);
  }
  return order;
}

/// Reorders the points of `other` by the strands of `first`. Fails if they do not match.
std::optional<Error> match_strands(const GroomFile& first, const std::string& first_name, const std::string& name,
                                   GroomFile* other) {
  const std::size_t strands = first.strand_count();
  if (other->strand_count() != strands)
    return Error{name, "strands",
                 fmt::format("the {} of {}, since strands move from one to the other", strands, first_name),
                 fmt::format("{}", other->strand_count())};
  if (first.id != other->id) {
    if (const auto order = order_by_id(first, *other)) {
      GroomFile sorted = *other;
      sorted.points.clear();
      sorted.width.clear();
      sorted.first_point = {0};
      sorted.broken.clear();
      for (const std::uint32_t s : *order) {
        if (std::ranges::binary_search(other->broken, s))
          sorted.broken.push_back(static_cast<std::uint32_t>(sorted.first_point.size() - 1));
        const auto begin = other->points.begin();
        sorted.points.insert(sorted.points.end(), begin + other->first_point[s], begin + other->first_point[s + 1]);
        if (!other->width.empty()) {
          const auto widths = other->width.begin();
          sorted.width.insert(sorted.width.end(), widths + other->first_point[s], widths + other->first_point[s + 1]);
        }
        sorted.first_point.push_back(static_cast<std::uint32_t>(sorted.points.size()));
      }
      *other = std::move(sorted);
    }
  }
  for (std::size_t s = 0; s < strands; ++s) {
    const auto count = [s](const GroomFile& file) { return file.first_point[s + 1] - file.first_point[s]; };
    if (count(first) != count(*other))
      return Error{name, fmt::format("strand {}", s), fmt::format("the {} points of {}", count(first), first_name),
                   fmt::format("{}", count(*other))};
  }
  return std::nullopt;
}

/// A strand that is broken at one moment is not drawn at any.
void add_broken(const std::vector<std::uint32_t>& more, GroomFile* groom) {
  std::vector<std::uint32_t> all;
  std::ranges::set_union(groom->broken, more, std::back_inserter(all));
  groom->broken = std::move(all);
}

/// Sets the widths of each moment, or none.
void set_widths(std::vector<std::vector<float>> widths, GroomFile* groom) {
  if (widths.empty()) return;
  const bool change = std::ranges::any_of(widths, [&](const auto& each) { return each != widths.front(); });
  groom->width = std::move(widths.front());
  widths.erase(widths.begin());
  if (change) groom->later_width = std::move(widths);
}

Result<GroomFile> read_numbered_groom(const std::filesystem::path& pattern, const GroomDescription& description,
                                      const FrameMoments& moments) {
  auto files = files_around<GroomFile>(moments, [&](int frame) {
    const std::string name = of_frame(pattern, frame).string();
    auto file = read_groom_file(name, description.points_per_strand, {}, {}, description.placement.attribute);
    if (!file) return file;
    if (!file->shared.empty()) file->remarks.emplace_back("instances of numbered files are copies of their strands");
    if (auto error = write_out(name, &*file)) return Result<GroomFile>(*error);
    return file;
  });
  if (!files) return files.error();
  const int first = files->begin()->first;
  for (auto& [frame, file] : *files)
    if (frame != first)
      if (auto error = match_strands(files->at(first), of_frame(pattern, first).string(),
                                     of_frame(pattern, frame).string(), &file))
        return *error;
  std::vector<std::vector<glm::vec3>> points;
  for (const double frame : moments.frames) points.push_back(values_between(*files, frame, &GroomFile::points));
  // A file without widths, or with one for all strands, gives no information about the widths in the others.
  const bool has_widths = std::ranges::all_of(*files, [](const auto& file) { return !file.second.width.empty(); });
  std::vector<std::vector<float>> widths;
  for (const double frame : moments.frames)
    if (has_widths) widths.push_back(values_between(*files, frame, &GroomFile::width));
  GroomFile groom = std::move(files->at(static_cast<int>(std::floor(moments.frames.front()))));
  for (const auto& [frame, file] : *files) add_broken(file.broken, &groom);
  groom.points = std::move(points.front());
  for (std::size_t i = 1; i < points.size(); ++i) groom.later.push_back(std::move(points[i]));
  set_widths(std::move(widths), &groom);
  return groom;
}

/// Reads a file that may have samples of many times.
Result<GroomFile> read_timed_groom(const std::filesystem::path& path, const GroomDescription& description,
                                   const FrameMoments& moments) {
  glm::dvec3 origin(0.0);
  const auto read = [&](std::optional<double> frame) {
    return read_groom_file(path, description.points_per_strand, frame, moments.frames_per_second,
                           description.placement.attribute, origin, false);
  };
  const auto first = moments.is_asked ? std::optional(moments.frames.front()) : std::nullopt;
  auto groom = read(first);
  if (groom && moments.origin != glm::dvec3(0.0) && !groom->points.empty()) {  // the scene is far from 0
    settle(&*groom);
    origin = glm::round(glm::dvec3(groom->points.front()));
    groom = read(first);
  }
  if (!groom || !groom->is_animated) return groom;
  const auto name_at = [&](double frame) { return fmt::format("{} at frame {:.10g}", path.string(), frame); };
  std::vector<std::vector<float>> widths{groom->width};
  for (std::size_t i = 1; i < moments.frames.size(); ++i) {
    auto then = read(moments.frames[i]);
    if (!then) return then;
    const bool are_shared_alike = std::ranges::equal(groom->shared, then->shared, [](const auto& a, const auto& b) {
      return a.first == b.first && a.end == b.end && a.places.size() == b.places.size();
    });
    if (!are_shared_alike ||
        match_strands(*groom, name_at(moments.frames.front()), name_at(moments.frames[i]), &*then)) {
      groom->remarks.push_back(fmt::format("strands stand still while the shutter is open, since they are others at {}",
                                           name_at(moments.frames[i])));
      groom->later.clear();
      for (SharedStrands& shared : groom->shared)
        for (auto& places : shared.places) places.resize(1);
      return groom;
    }
    for (std::size_t s = 0; s < groom->shared.size(); ++s)
      for (std::size_t place = 0; place < groom->shared[s].places.size(); ++place)
        groom->shared[s].places[place].push_back(then->shared[s].places[place].front());
    add_broken(then->broken, &*groom);
    groom->later.push_back(std::move(then->points));
    widths.push_back(std::move(then->width));
  }
  if (std::ranges::all_of(widths, [&](const auto& each) { return each.size() == groom->points.size(); }))
    set_widths(std::move(widths), &*groom);
  return groom;
}

Result<ObjFile> read_mesh_file(const std::filesystem::path& file) {
  const auto bytes = read_input_file(file, "an .obj file", most_obj_bytes);
  if (!bytes) return bytes.error();
  return parse_obj_file(*bytes, file.string());
}

/// Gives each corner its own normal, because files may share normals differently.
void number_normals_by_corner(ObjFile* file) {
  if (file->corner_normals.empty()) return;
  std::vector<glm::vec3> normals;
  normals.reserve(3 * file->corner_normals.size());
  for (glm::uvec3& corner : file->corner_normals)
    for (int c = 0; c < 3; ++c) {
      normals.push_back(corner[c] == no_normal ? glm::vec3(0.0f) : file->normals[corner[c]]);
      corner[c] = static_cast<std::uint32_t>(normals.size() - 1);
    }
  file->normals = std::move(normals);
}

Result<std::vector<ObjFile>> read_numbered_mesh(const std::filesystem::path& pattern, const FrameMoments& moments) {
  auto files = files_around<ObjFile>(moments, [&](int frame) { return read_mesh_file(of_frame(pattern, frame)); });
  if (!files) return files.error();
  const ObjFile& first = files->begin()->second;
  bool same_normals = true;
  for (const auto& [frame, file] : *files) {
    const auto refuse = [&, number = frame](const char* what, std::size_t expected, std::size_t found) {
      return Error{of_frame(pattern, number).string(), what,
                   fmt::format("the {} of {}, since they move from one to the other", expected,
                               of_frame(pattern, files->begin()->first).string()),
                   expected == found ? "others" : fmt::format("{}", found)};
    };
    if (file.positions.size() != first.positions.size())
      return refuse("vertices", first.positions.size(), file.positions.size());
    if (file.triangles != first.triangles) return refuse("triangles", first.triangles.size(), file.triangles.size());
    if (file.corner_normals.empty() != first.corner_normals.empty())
      return refuse("normals", first.normals.size(), file.normals.size());
    same_normals =
        same_normals && file.corner_normals == first.corner_normals && file.normals.size() == first.normals.size();
  }
  if (!same_normals)
    for (auto& [frame, file] : *files) number_normals_by_corner(&file);
  std::vector<ObjFile> at;
  for (const double frame : moments.frames) {
    at.push_back(at.empty() ? files->at(static_cast<int>(std::floor(frame))) : ObjFile{});
    at.back().positions = values_between(*files, frame, &ObjFile::positions);
    at.back().normals = values_between(*files, frame, &ObjFile::normals);
  }
  return at;
}

/// If a file of the unchanged name exists, it takes precedence.
bool is_numbered(const std::filesystem::path& file) { return names_frames(file) && !std::filesystem::exists(file); }

Result<Groom> groom_in_its_axes(const GroomDescription& description, const FrameMoments& moments, Sources& from,
                                Scene* scene, FileInstances* instances) {
  if (!description.file) {
    Groom groom = generate_groom(description.recipe);
    if (description.placement.basis) take_points_as(*description.placement.basis, &groom);
    return groom;
  }
  if (auto strands = from.memory.grooms.extract(*description.file))
    return assemble_groom(std::move(strands.mapped()), description.placement, *description.file, &scene->notes,
                          &scene->warnings);
  const auto file = from.folder / *description.file;
  auto strands = is_numbered(file) ? read_numbered_groom(file, description, moments)
                                   : read_timed_groom(file, description, moments);
  if (!strands) return strands.error();
  return assemble_groom(std::move(*strands), description.placement, file.string(), &scene->notes, &scene->warnings,
                        instances);
}

/// Appends strands of a groom to another that is like it.
void append_strands(const Groom& from, std::uint32_t first, std::uint32_t end, Groom* to) {
  const std::size_t begin = from.first_point[first], last = from.first_point[end], points = from.points.size();
  const auto take = [&](const auto& values, auto* out) {
    const bool is_per_point = values.size() == points;
    if (!values.empty())
      out->insert(out->end(), values.begin() + static_cast<std::ptrdiff_t>(is_per_point ? begin : first),
                  values.begin() + static_cast<std::ptrdiff_t>(is_per_point ? last : end));
  };
  const std::size_t before = to->points.size();
  for (std::uint32_t s = first; s < end; ++s)
    to->first_point.push_back(static_cast<std::uint32_t>(before + from.first_point[s + 1] - begin));
  take(from.points, &to->points);
  take(from.radius_cm, &to->radius_cm);
  take(from.color, &to->color);
  take(from.id, &to->id);
  take(from.root_uv, &to->root_uv);
  take(from.minor_axis, &to->minor_axis);
  to->later.resize(from.later.size());
  for (std::size_t i = 0; i < from.later.size(); ++i) {
    take(from.later[i].points, &to->later[i].points);
    take(from.later[i].radius_cm, &to->later[i].radius_cm);
  }
}

/// The strands of a groom that are drawn once, and each set of those that instances share, apart. Empty ones are left
/// out.
std::vector<Groom> apart(Groom groom, const FileInstances& instances) {
  if (groom.id.empty())
    for (std::uint32_t s = 0; s < groom.strand_count(); ++s) groom.id.push_back(s);
  std::vector<Groom> sets(instances.places.size() + 1);
  for (std::uint32_t s = 0, end = 0; s < groom.strand_count(); s = end) {
    while (end < groom.strand_count() && instances.set[end] == instances.set[s]) ++end;
    Groom& set = sets[instances.set[s]];
    if (set.first_point.empty()) set.first_point.push_back(0);
    append_strands(groom, s, end, &set);
  }
  for (Groom& set : sets) {
    set.name = groom.name;
    set.basis = groom.basis;
    set.origin = groom.origin;
    set.is_animated = groom.is_animated;
  }
  return sets;
}

/// Whether no strand moves by itself.
bool rests(const Groom& groom) {
  return std::ranges::all_of(groom.later, [&](const StrandMoment& moment) {
    return moment.points == groom.points && (moment.radius_cm.empty() || moment.radius_cm == groom.radius_cm);
  });
}

}  // namespace

std::vector<ObjectTransform> transforms(const ObjectPath& path, const FrameMoments& moments) {
  std::vector<ObjectTransform> all;
  for (const double frame : moments.frames) {
    all.push_back(path.at(frame));
    all.back().origin = moments.origin;
  }
  return all;
}

Result<std::vector<Groom>> make_grooms(const GroomDescription& description, const FrameMoments& moments, Sources& from,
                                       Scene* scene) {
  FileInstances shared;
  auto groom = groom_in_its_axes(description, moments, from, scene, &shared);
  if (!groom) return groom.error();
  std::vector<ObjectTransform> placed = transforms(description.path, moments);
  if (!description.instances.empty())  // these move it to the scene's origin
    for (ObjectTransform& transform : placed) transform.origin = glm::dvec3(0.0);
  std::vector<std::vector<glm::dmat4>> instances;
  for (const ObjectPath& path : description.instances) {
    std::vector<glm::dmat4>& places = instances.emplace_back();
    for (const ObjectTransform& transform : transforms(path, moments)) places.push_back(transform.matrix());
  }
  std::vector<Groom> grooms;
  if (shared.places.empty())
    grooms.push_back(std::move(*groom));
  else
    grooms = apart(std::move(*groom), shared);
  if (!grooms.front().first_point.empty()) {
    if (auto error = move_groom(placed, &grooms.front())) return *error;
    if (auto error = add_instances(instances, moments.origin, &grooms.front())) return *error;
  }
  auto numbered = static_cast<std::uint32_t>(grooms.front().instances.size());
  if (instances.empty()) instances.emplace_back(moments.frames.size(), glm::dmat4(1.0));
  for (std::size_t i = 1; i < grooms.size(); ++i) {
    Groom& set = grooms[i];
    const auto& places = shared.places[i - 1];
    if (set.first_point.empty()) continue;
    if (places.size() * instances.size() > most_instances)
      return Error{set.name, "instances",
                   fmt::format("at most {}, those of the file in those of the scene", most_instances),
                   fmt::format("{} in {}", places.size(), instances.size())};
    const glm::dmat4 from_origin = glm::translate(glm::dmat4(1.0), set.origin);
    std::vector<std::vector<glm::dmat4>> all;
    for (const std::vector<glm::dmat4>& instance : instances)
      for (const std::vector<glm::dmat4>& place : places) {
        std::vector<glm::dmat4>& at = all.emplace_back();
        for (std::size_t m = 0; m < moments.frames.size(); ++m)
          at.push_back(instance[m] * placed[m].matrix() * place[std::min(m, place.size() - 1)] * from_origin);
      }
    if (rests(set)) set.later.clear();
    set.origin = glm::dvec3(0.0);
    if (auto error = add_instances(all, moments.origin, &set)) return *error;
    set.first_instance = numbered;
    numbered += static_cast<std::uint32_t>(all.size());
  }
  std::erase_if(grooms, [&](const Groom& set) { return set.first_point.empty(); });
  return grooms;
}

Result<Mesh> make_mesh(const MeshDescription& description, const FrameMoments& moments, const Sources& from,
                       Scene* scene) {
  const auto in_memory = from.memory.meshes.find(description.file);
  const bool is_read = in_memory == from.memory.meshes.end();
  const auto file = is_read ? from.folder / description.file : std::filesystem::path(description.file);
  std::vector<ObjFile> files;
  if (is_read && is_numbered(file)) {
    auto numbered = read_numbered_mesh(file, moments);
    if (!numbered) return numbered.error();
    files = std::move(*numbered);
  } else {
    auto obj = is_read ? read_mesh_file(file) : Result<ObjFile>(in_memory->second);
    if (!obj) return obj.error();
    files.push_back(std::move(*obj));
  }
  std::vector<MeshAtMoment> at;
  for (const ObjectTransform& transform : transforms(description.path, moments))
    at.push_back({&files[std::min(at.size(), files.size() - 1)], transform});
  auto mesh = place_mesh(at, description, file.string(), &scene->warnings);
  if (!mesh || !description.albedo_file) return mesh;
  auto texture = load_texture(from.folder / *description.albedo_file, &scene->warnings);
  if (!texture) return texture.error();
  if (mesh->corner_uvs.empty())
    return Error{file.string(), "", "faces with texture coordinates (v/vt) under \"albedo_file\"", "none"};
  mesh->texture = std::move(*texture);
  return mesh;
}

}  // namespace tress::scene
