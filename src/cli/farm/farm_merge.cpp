// tress farm merge: merges pictures and table of a farm whose tasks are all done.
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <string>
#include <system_error>

#include "base/save_lock.h"
#include "cli/console.h"
#include "cli/farm/farm_commands.h"
#include "cli/frame_list.h"
#include "cli/options.h"

namespace tress::cli {
namespace {

/// Logs the tasks that are not done; returns whether all are.
bool is_whole(const Farm& opened) {
  std::vector<std::size_t> missing;
  for (std::size_t task = 0; task < opened.tasks.size(); ++task) {
    if (!opened.is_done(task)) missing.push_back(task);
  }
  if (missing.empty()) return true;
  log_error(Error{opened.folder.string(), "", fmt::format("{} tasks that are done", opened.tasks.size()),
                  fmt::format("{} that {} not: {}; nothing is merged", missing.size(),
                              missing.size() == 1 ? "is" : "are", farm::ranges_text(missing))}
                .message());
  return false;
}

/// The --precision of the renders, which a merge has too.
std::vector<std::string> precision_of(const std::vector<std::string>& options) {
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (options[i] == "--precision" && i + 1 < options.size()) return {options[i], options[i + 1]};
    if (options[i].starts_with("--precision=")) return {options[i]};
  }
  return {};
}

/// Merges the parts of each picture, which are consecutive tasks.
int merge_pictures(const Farm& opened) {
  const farm::Plan& plan = opened.plan;
  if (plan.split == 0) return 0;
  const std::vector<std::filesystem::path> pictures = opened.pictures();
  for (std::size_t picture = 0; picture < pictures.size(); ++picture) {
    std::vector<std::string> words{"merge"};
    for (std::size_t part = 0; part < std::size_t(plan.split); ++part) {
      const std::size_t task = picture * std::size_t(plan.split) + part;
      words.push_back(opened.outputs(task).back().string());
    }
    words.insert(words.end(), {"-o", pictures[picture].string()});
    for (const std::string& word : precision_of(plan.options)) words.push_back(word);
    if (const int status = run_command(words); status != 0) return status;
  }
  return 0;
}

int merge_caches(const Farm& opened) {
  const farm::Plan& plan = opened.plan;
  if (!plan.warm_cache || plan.frozen) return 0;
  std::vector<std::string> words{"cache", "merge"};
  std::error_code error;
  for (std::size_t task = 0; task < opened.tasks.size(); ++task) {
    const std::filesystem::path cache = opened.files(task).cache;
    // A task of a model without rows has no cache.
    if (std::filesystem::exists(cache, error)) words.push_back(cache.string());
  }
  if (words.size() == 2) return 0;
  if (std::filesystem::exists(*plan.warm_cache, error)) words.push_back(plan.warm_cache->string());
  words.insert(words.end(), {"-o", plan.warm_cache->string()});
  return run_command(words);
}

int merge_farm(const std::filesystem::path& folder) {
  const Result<Farm> opened = open_farm(folder);
  if (!opened) {
    log_error(opened.error().message());
    return 1;
  }
  const std::filesystem::path file = farm::merge_state_file(opened->folder);
  SaveLock lock;
  if (const auto refused = lock.acquire(file, file.string())) {
    log_error(refused->message());
    return 1;
  }
  if (!is_whole(*opened)) return 1;
  if (opened->is_merged()) {
    log_note(fmt::format("{}: merged before", opened->folder.string()));
    return 0;
  }
  farm::TaskState state;
  state.attempts = farm::read_state(file).attempts + 1;
  state.status = merge_pictures(*opened);
  if (state.status == 0) state.status = merge_caches(*opened);
  state.phase = state.status == 0 ? farm::Phase::done : farm::Phase::failed;
  if (const auto error = farm::write_state(file, state)) {
    log_error(error->message());
    return 1;
  }
  if (state.status == 0)
    log_note(fmt::format("{}: {} pictures of {} tasks", opened->folder.string(), opened->pictures().size(),
                         opened->tasks.size()));
  return state.status;
}

}  // namespace

CLI::App* add_farm_merge(CLI::App& farm, std::function<int()>* run) {
  const auto folder = std::make_shared<std::filesystem::path>();
  CLI::App* command =
      farm.add_subcommand("merge", "Parts to pictures and caches to one, once all tasks are done; nothing before");
  add_farm_folder(command, folder.get());
  add_quiet(command);
  *run = [folder] { return merge_farm(*folder); };
  return command;
}

}  // namespace tress::cli
