#include "farm/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tress/base/replace_file.h"

namespace tress::farm {
namespace {

constexpr int format = 1;
constexpr std::size_t most_frames = 1'000'000;

std::string text_of(const nlohmann::json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json to_json(const Plan& plan) {
  nlohmann::json json{
      {"tress_farm", format},         {"program", plan.program.string()}, {"directory", plan.directory.string()},
      {"scene", plan.scene.string()}, {"output", plan.output.string()},   {"frames", plan.frames},
      {"frozen", plan.frozen},        {"calibrates", plan.calibrates},    {"chunk", plan.chunk},
      {"split", plan.split},          {"samples", plan.samples},          {"retries", plan.retries},
      {"options", plan.options}};
  if (plan.warm_cache) json["warm_cache"] = plan.warm_cache->string();
  return json;
}

/// Whether every value has the type and range that tasks_of() relies on.
bool is_plan(const nlohmann::json& json) {
  const auto is_count = [&](const char* name, std::int64_t least, std::int64_t most) {
    return json.contains(name) && json[name].is_number_integer() && json[name] >= least && json[name] <= most;
  };
  const auto is_list = [&](const char* name, const auto& is_good) {
    return json.contains(name) && json[name].is_array() && json[name].size() <= most_frames &&
           std::ranges::all_of(json[name], is_good);
  };
  for (const char* name : {"program", "directory", "scene", "output"}) {
    if (!json.contains(name) || !json[name].is_string()) return false;
  }
  for (const char* name : {"frozen", "calibrates"}) {
    if (!json.contains(name) || !json[name].is_boolean()) return false;
  }
  if (json.contains("warm_cache") && !json["warm_cache"].is_string()) return false;
  constexpr std::int64_t most = 1 << 20;
  const bool counts = is_count("chunk", 1, most) && is_count("split", 0, most) && is_count("samples", 0, most) &&
                      is_count("retries", 0, most);
  const auto is_frame = [](const nlohmann::json& x) { return x.is_number_unsigned() && x <= most_frames; };
  return counts && json["split"] <= json["samples"] && is_list("frames", is_frame) &&
         is_list("options", [](const nlohmann::json& x) { return x.is_string(); });
}

}  // namespace

std::vector<Task> tasks_of(const Plan& plan) {
  std::vector<Task> tasks;
  if (plan.split > 0) {
    std::vector<std::vector<int>> pictures;
    for (const int frame : plan.frames) pictures.push_back({frame});
    if (pictures.empty()) pictures.emplace_back();
    for (const std::vector<int>& picture : pictures) {
      for (std::int64_t part = 0; part < plan.split; ++part) {
        tasks.push_back({picture, int(plan.samples * part / plan.split), int(plan.samples * (part + 1) / plan.split)});
      }
    }
    return tasks;
  }
  if (plan.frames.empty()) return {Task{}};
  const auto begin = plan.frames.begin(), end = plan.frames.end();
  auto at = begin;
  while (at != end) {
    const std::ptrdiff_t most = plan.calibrates && at == begin ? 1 : plan.chunk;
    const auto next = at + std::min(most, end - at);
    tasks.push_back({std::vector<int>(at, next), 0, 0});
    at = next;
  }
  return tasks;
}

std::string frames_text(const std::vector<int>& frames) {
  std::string text;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t last = i;
    while (last + 1 < frames.size() && frames[last + 1] == frames[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", frames[i]);
    if (last > i) text += fmt::format("-{}", frames[last]);
    i = last + 1;
  }
  return text;
}

std::string ranges_text(const std::vector<std::size_t>& numbers) {
  return frames_text(std::vector<int>(numbers.begin(), numbers.end()));
}

Result<Plan> read_plan(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "farm.json";
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{file.string(), "", "a farm as tress farm writes it", "no such file"};
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("tress_farm")) return Error{file.string(), "", "a farm", "another file"};
  if (json["tress_farm"] != format)
    return Error{file.string(), "tress_farm", std::to_string(format), text_of(json["tress_farm"])};
  if (!is_plan(json)) return Error{file.string(), "", "the values of a farm", "others, or none"};
  Plan plan;
  plan.program = json["program"].get<std::string>();
  plan.directory = json["directory"].get<std::string>();
  plan.scene = json["scene"].get<std::string>();
  plan.output = json["output"].get<std::string>();
  plan.frames = json["frames"].get<std::vector<int>>();
  if (json.contains("warm_cache")) plan.warm_cache = json["warm_cache"].get<std::string>();
  plan.frozen = json["frozen"].get<bool>();
  plan.calibrates = json["calibrates"].get<bool>();
  plan.chunk = json["chunk"].get<int>();
  plan.split = json["split"].get<int>();
  plan.samples = json["samples"].get<int>();
  plan.retries = json["retries"].get<int>();
  plan.options = json["options"].get<std::vector<std::string>>();
  return plan;
}

std::optional<Error> write_plan(const std::filesystem::path& folder, const Plan& plan) {
  return replace_file(folder / "farm.json", text_of(to_json(plan), 2) + "\n");
}

std::string differences(const Plan& expected, const Plan& found) {
  const nlohmann::json a = to_json(expected), b = to_json(found);
  const auto shown = [](const nlohmann::json& json, const std::string& name) {
    if (!json.contains(name)) return std::string("nothing");
    return name == "frames" ? frames_text(json[name].get<std::vector<int>>()) : text_of(json[name]);
  };
  std::string text;
  // These may change without changing the result: how often a task is tried, and where the program is.
  for (const char* name : {"directory", "scene", "output", "frames", "warm_cache", "frozen", "calibrates", "chunk",
                           "split", "samples", "options"}) {
    const std::string wanted = shown(a, name), there = shown(b, name);
    if (wanted != there)
      text += fmt::format("{}{}: expected {}, found {}", text.empty() ? "" : "; ", name, wanted, there);
  }
  return text;
}

}  // namespace tress::farm
