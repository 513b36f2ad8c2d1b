#include "cli/render_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <system_error>

#include "base/content_hash.h"
#include "base/numbered_file.h"
#include "cli/options.h"
#include "cli/telemetry_lines.h"
#include "scene/read/groom_files.h"
#include "scene/read/input_files.h"
#include "scene/read/set_keys.h"
#include "scene/read/texture_file.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

constexpr std::size_t most_named = 8;
constexpr std::uintmax_t most_scene_bytes = std::uintmax_t{1} << 28;

/// The content of a file and of those that it includes; empty if it cannot be read.
std::optional<std::string> content_of(const std::filesystem::path& file) {
  std::optional<std::string> content = file_content_name(file);
  for (const std::filesystem::path& other : scene::included_files(file))
    if (content) *content += " including " + file_content_name(other).value_or("nothing");
  return content;
}

/// The text, with the content of the file of that name if there is one.
std::string with_content(const std::string& text, const std::filesystem::path& folder) {
  if (text.empty() || text.size() > 4096) return text;
  const std::optional<std::string> content = content_of(folder / text);
  std::string all = content ? text + " with content " + *content : text;
  for (const auto& [number, tile] : scene::udim_files(folder / text))
    all += fmt::format(" with content {} in tile {}", content_of(tile).value_or("none"), number);
  return all;
}

/// Whether the value at this place of a scene names a file: its key is `file` or `texture`, or ends in `_file`.
bool names_a_file(const std::string& place) {
  const std::string key = place.substr(place.rfind('/') + 1);
  return key == "file" || key == "texture" || key.ends_with("_file");
}

/// The whole frames that are read for a picture: those around its open shutter.
struct FrameRange {
  int first = 0, last = 0;
};

FrameRange frames_of(const nlohmann::json& document, const std::map<std::string, std::string>& options) {
  const auto number = [&](const char* place) {
    const nlohmann::json::json_pointer at(place);
    return document.contains(at) && document[at].is_number() ? document[at].get<double>() : 0.0;
  };
  double frame = number("/camera/frames/0/frame");
  for (const char* name : {"--frame", "frame"})
    if (const auto given = options.find(name); given != options.end())
      frame = parse_number(given->second).value_or(frame);
  const auto whole = [](double x) { return static_cast<int>(std::clamp(x, -1e7, 1e7)); };
  return {whole(std::floor(frame + number("/camera/shutter/open"))),
          whole(std::ceil(frame + number("/camera/shutter/close")))};
}

/// The same for a name with ####: the content of the files of these frames.
std::string with_numbered_content(const std::string& text, const std::filesystem::path& folder,
                                  const FrameRange& frames) {
  if (!names_frames(text) || text.size() > 4096) return with_content(text, folder);
  std::string all = with_content(text, folder);
  for (int frame = frames.first; frame <= frames.last; ++frame)
    if (const auto content = content_of(of_frame(folder / text, frame)))
      all += fmt::format(" with content {} at frame {}", *content, frame);
  return all;
}

/// The scene file as JSON; null if it is not.
nlohmann::json document_of(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::file_size(file, error) > most_scene_bytes || error) return nullptr;
  std::ifstream in(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  return document.is_object() ? std::move(document) : nullptr;
}

/// Adds the values of a scene by their paths. Numbers that are equal have the same text.
void add_values(const nlohmann::json& document, const std::filesystem::path& folder,
                const std::map<std::string, std::string>& options, Identity* identity) {
  const FrameRange frames = frames_of(document, options);
  const nlohmann::json values = document.flatten();
  for (const auto& [place, value] : values.items()) {
    if (place.starts_with("/$schema") || place.starts_with("/expected")) continue;
    if (value.is_number_float())
      (*identity)[place] = fmt::format("{}", value.get<double>());
    else if (!value.is_string())
      (*identity)[place] = json_text(value);
    else if (names_a_file(place))
      (*identity)[place] = with_numbered_content(value.get<std::string>(), folder, frames);
    else
      (*identity)[place] = value.get<std::string>();
  }
}

}  // namespace

Identity identity_of(const std::filesystem::path& scene, const std::map<std::string, std::string>& options,
                     std::span<const std::string> settings) {
  Identity identity;
  identity["version"] = version();
  for (const auto& [name, value] : options) identity[name] = name == "--environment" ? with_content(value, ".") : value;
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(scene, error);
  const std::filesystem::path file = is_folder ? scene / "scene.json" : scene;
  nlohmann::json document = document_of(file);
  if (scene == "-") {  // standard input can be read only once, so it is the scene of this picture alone
    std::random_device random;
    identity["scene"] = fmt::format("standard input, {:08x}{:08x}", random(), random());
  } else if (is_folder && !std::filesystem::exists(file, error)) {
    for (std::filesystem::directory_iterator at(scene, error), end; !error && at != end; at.increment(error))
      if (at->is_regular_file())
        identity["part " + at->path().filename().string()] = content_of(at->path()).value_or("unknown");
  } else if (document.is_null()) {
    identity["scene"] = "content " + content_of(scene).value_or("unknown");
  }
  if (document.is_null() && !settings.empty()) document["grooms"][0] = nlohmann::json::object();
  if (const auto set = scene::set_keys(settings, &document); !set) {  // elements that a folder alone has
    for (const std::string& text : settings) identity["--set " + text] = "given";
  }
  if (document.is_object()) add_values(document, file.parent_path(), options, &identity);
  if (const auto samples = identity.extract("--spp")) identity["/image/samples"] = samples.mapped();
  if (const auto size = identity.extract("--resolution")) {
    const std::size_t by = size.mapped().find('x');
    identity["/image/width"] = size.mapped().substr(0, by);
    identity["/image/height"] = size.mapped().substr(by + 1);
  }
  return identity;
}

std::string identity_text(const Identity& identity) { return json_text(identity); }

std::optional<Identity> parse_identity(const std::string& text) {
  const nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  if (!document.is_object()) return std::nullopt;
  Identity identity;
  for (const auto& [name, value] : document.items()) {
    if (!value.is_string()) return std::nullopt;
    identity[name] = value.get<std::string>();
  }
  return identity;
}

std::string differences(const Identity& expected, const Identity& found, const std::vector<std::string>& ignored) {
  std::set<std::string> names;
  for (const Identity* one : {&expected, &found}) {
    for (const auto& [name, value] : *one) names.insert(name);
  }
  for (const std::string& name : ignored) names.erase(name);
  const auto value_in = [](const Identity& identity, const std::string& name) {
    const auto at = identity.find(name);
    return at == identity.end() ? std::string("nothing") : at->second.substr(0, 120);
  };
  std::string text;
  std::size_t differing = 0;
  for (const std::string& name : names) {
    const auto a = expected.find(name), b = found.find(name);
    if (a != expected.end() && b != found.end() && a->second == b->second) continue;
    if (++differing > most_named) continue;
    text += fmt::format("{}{}: expected {}, found {}", text.empty() ? "" : "; ", name, value_in(expected, name),
                        value_in(found, name));
  }
  return differing > most_named ? fmt::format("{}; and {} more", text, differing - most_named) : text;
}

}  // namespace tress::cli
