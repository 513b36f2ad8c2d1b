#include "scene/read/parts_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "scene/read/groom_files.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"

namespace tress::scene {
namespace {

constexpr const char* materials_name = "materials.json";
constexpr std::uintmax_t most_materials_bytes = std::uintmax_t{64} << 20;
constexpr double usual_cm_per_unit = 1;

/// Names of the regular files, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code unknown;
    if (at->is_regular_file(unknown)) names.push_back(at->path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

/// The array of the file as JSON; null if it is not JSON, which parse_scene_file() then reports for the bytes.
Result<nlohmann::json> materials_in(const std::filesystem::path& file) {
  const auto bytes = read_input_file(file, "materials (JSON)", most_materials_bytes);
  if (!bytes) return bytes.error();
  nlohmann::json materials = nlohmann::json::parse(bytes->begin(), bytes->end(), nullptr, false);
  if (!materials.is_discarded()) return materials;
  const auto refused = parse_scene_file(*bytes, file.string());
  return refused ? Error{file.string(), "", "JSON", "something else"} : refused.error();
}

}  // namespace

Result<SceneDescription> describe_parts(const std::filesystem::path& folder, const Overrides& overrides) {
  nlohmann::json scene = {{"grooms", nlohmann::json::array()}, {"meshes", nlohmann::json::array()}};
  const std::vector<std::string> names = names_in(folder);
  const bool has_materials = std::ranges::binary_search(names, materials_name);
  if (has_materials) {
    auto materials = materials_in(folder / materials_name);
    if (!materials) return materials.error();
    scene["materials"] = std::move(*materials);
  }
  const auto has_material = [&](const std::string& name) {
    return has_materials && scene["materials"].is_array() &&
           std::ranges::any_of(scene["materials"], [&](const auto& m) {
             return m.is_object() && m.value("name", nlohmann::json()) == name;
           });
  };
  for (const std::string& name : names) {
    const std::filesystem::path file(name);
    if (file.extension() == ".obj") {
      nlohmann::json mesh = {{"file", name}, {"up", overrides.y_up.value_or(false) ? "y" : "z"}};
      if (overrides.cm_per_unit) mesh["cm_per_unit"] = *overrides.cm_per_unit;
      scene["meshes"].push_back(std::move(mesh));
    } else if (file.extension() != ".json" && is_groom_file(folder / file)) {
      nlohmann::json groom = {{"file", name}};
      if (has_material(file.stem().string())) groom["material"] = file.stem().string();
      scene["grooms"].push_back(std::move(groom));
    }
  }
  if (scene["grooms"].empty())
    return Error{folder.string(), "", "a folder with scene.json or grooms (" + groom_endings() + ")",
                 std::to_string(names.size()) + " other files"};
  const std::string text = scene.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  auto description = parse_scene_file(std::vector<unsigned char>(text.begin(), text.end()),
                                      has_materials ? (folder / materials_name).string() : folder.string(), nullptr,
                                      overrides.settings);
  if (!description) return description;
  for (GroomDescription& groom : description->grooms) groom.placement.usual_cm_per_unit = usual_cm_per_unit;
  return description;
}

}  // namespace tress::scene
