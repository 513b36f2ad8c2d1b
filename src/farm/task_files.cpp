#include "farm/task_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/descriptor.h"
#include "tress/base/replace_file.h"

namespace tress::farm {
namespace {

constexpr std::array<Phase, 5> phases{Phase::waiting, Phase::running, Phase::interrupted, Phase::failed, Phase::done};

}  // namespace

TaskFiles task_files(const std::filesystem::path& folder, std::size_t task, bool stills) {
  const std::string name = fmt::format("task-{:04}", task);
  const std::string numbered = name + (stills ? "" : ".####");
  return {folder / "state" / (name + ".json"),          folder / "caches" / (name + ".cache"),
          folder / "work" / (numbered + ".checkpoint"), folder / "telemetry" / (name + ".jsonl"),
          folder / "parts" / (numbered + ".exr"),       folder / "parts" / (numbered + ".part")};
}

std::filesystem::path merge_state_file(const std::filesystem::path& folder) { return folder / "state" / "merge.json"; }

std::optional<Error> make_folders(const std::filesystem::path& folder) {
  for (const char* name : {"state", "caches", "work", "telemetry", "parts", "logs"}) {
    std::error_code error;
    std::filesystem::create_directories(folder / name, error);
    if (error) return Error{(folder / name).string(), "", "a folder that can be made", error.message()};
  }
  return std::nullopt;
}

const char* phase_name(Phase phase) {
  switch (phase) {
    case Phase::running:
      return "running";
    case Phase::interrupted:
      return "interrupted";
    case Phase::failed:
      return "failed";
    case Phase::done:
      return "done";
    case Phase::waiting:
      break;
  }
  return "waiting";
}

TaskState read_state(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  TaskState state;
  if (!json.is_object()) return state;
  const auto text_of = [&](const char* name) {
    return json.contains(name) && json[name].is_string() ? json[name].get<std::string>() : std::string();
  };
  const auto count = [&](const char* name) {
    const bool is_good = json.contains(name) && json[name].is_number_unsigned() && json[name] <= 1'000'000;
    return is_good ? json[name].get<int>() : 0;
  };
  for (const Phase phase : phases) {
    if (text_of("state") == phase_name(phase)) state.phase = phase;
  }
  state.attempts = count("attempts");
  state.status = count("status");
  state.host = text_of("host");
  state.job = text_of("job");
  return state;
}

std::optional<Error> write_state(const std::filesystem::path& file, const TaskState& state) {
  const nlohmann::ordered_json json{{"state", phase_name(state.phase)},
                                    {"attempts", state.attempts},
                                    {"status", state.status},
                                    {"host", state.host},
                                    {"job", state.job}};
  return replace_file(file, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

bool is_held(const std::filesystem::path& file) {
  std::filesystem::path lock = file;
  lock += ".lock";
  Descriptor opened;
  opened.reset(::open(lock.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  return opened.is_open() && ::flock(opened.number(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

}  // namespace tress::farm
