// tress farm: makes tasks for a scheduler from a shot.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>

#include "base/save_lock.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/farm/farm_commands.h"
#include "cli/farm/farm_scripts.h"
#include "cli/frame_list.h"
#include "cli/options.h"
#include "cli/warm_cache_session.h"
#include "scene/model/scene.h"

namespace tress::cli {
namespace {

struct SubmitSettings {
  farm::Plan plan;
  std::filesystem::path folder;  ///< empty: beside the output
  std::string scheduler = "none";
  std::string program;  ///< empty: this program
  farm::SlurmOptions slurm;
};

/// The options that a farm sets itself for each task.
const std::set<std::string>& options_of_tasks() {
  static const std::set<std::string> names{"-o",           "--output",       "--frames",     "--frame",
                                           "--warm-cache", "--cache-mode",   "--part",       "--checkpoint",
                                           "--telemetry",  "--samples-from", "--samples-to", "--progress"};
  return names;
}

/// Checks the options with the parser of a render, before any machine starts a task. Throws WrongUsage.
void check_render_options(const farm::Plan& plan) {
  for (const std::string& word : plan.options) {
    if (options_of_tasks().contains(word.substr(0, word.find('='))))
      throw WrongUsage(
          fmt::format("after --: expected options that all tasks share, found {}, which each has its own", word));
  }
  CLI::App app("", "tress");
  const Command render = add_render(app, {});  // owns the settings that the parser fills
  std::vector<std::string> words{"render", plan.scene.string(), "-o", "a.exr", "--checkpoint", "a.checkpoint"};
  if (plan.split > 0) words.insert(words.end(), {"--part", "a.part"});
  words.insert(words.end(), plan.options.begin(), plan.options.end());
  std::ranges::reverse(words);
  try {
    app.parse(words);
  } catch (const CLI::Success&) {
    throw WrongUsage("after --: expected options of tress render, found a question for help");
  } catch (const CLI::ParseError& error) {
    throw WrongUsage(std::string("after --: ") + error.what());
  }
}

/// Samples a pixel: from --spp, or from the scene.
int samples_of(const farm::Plan& plan) {
  for (std::size_t i = 0; i < plan.options.size(); ++i) {
    const std::string& word = plan.options[i];
    if (word == "--spp" && i + 1 < plan.options.size()) return int(parse_unsigned(plan.options[i + 1]).value_or(0));
    if (word.starts_with("--spp=")) return int(parse_unsigned(word.substr(6)).value_or(0));
  }
  std::ifstream in(plan.scene, std::ios::binary);
  const nlohmann::json scene = nlohmann::json::parse(in, nullptr, false);
  const nlohmann::json::json_pointer place("/image/samples");
  if (scene.is_object() && scene.contains(place) && scene[place].is_number_unsigned() && scene[place] <= (1 << 20))
    return scene[place].get<int>();
  return scene::Image{}.samples;
}

/// "out/shot.####.exr" is rendered in out/shot.farm; if the name is only a number, the folder has the scene's name.
std::filesystem::path usual_folder(const farm::Plan& plan) {
  std::string stem = plan.output.stem().string();
  const auto is_rest = [](char c) { return c == '#' || c == '.' || c == '_' || c == '-'; };
  while (!stem.empty() && is_rest(stem.back())) stem.pop_back();
  if (stem.empty()) stem = plan.scene.stem().string();
  return plan.output.parent_path() / (stem + ".farm");
}

/// Makes names absolute and fills in what was not given. Error if the scene or the folder of the output does not exist.
std::optional<Error> complete(SubmitSettings* settings) {
  farm::Plan& plan = settings->plan;
  std::error_code error;
  plan.directory = std::filesystem::current_path(error);
  // weakly_canonical() does not make a relative name absolute if its first part does not exist.
  const auto whole = [&](const std::filesystem::path& file) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error);
  };
  for (std::filesystem::path* file : {&plan.scene, &plan.output, &settings->folder}) {
    if (!file->empty()) *file = whole(*file);
  }
  if (plan.warm_cache) plan.warm_cache = whole(*plan.warm_cache);
  if (!std::filesystem::is_regular_file(plan.scene, error))
    return Error{plan.scene.string(), "", "a scene", "no such file"};
  if (!std::filesystem::is_directory(plan.output.parent_path(), error))
    return Error{plan.output.string(), "", "a folder that is there", "none"};
  if (plan.frozen && !std::filesystem::is_regular_file(*plan.warm_cache, error))
    return Error{plan.warm_cache->string(), "", "a cache to use as it is", "no such file"};
  plan.program = settings->program.empty() ? std::filesystem::read_symlink("/proc/self/exe", error)
                                           : std::filesystem::path(settings->program);
  if (plan.split > 0) {
    plan.samples = samples_of(plan);
    if (plan.samples < plan.split)
      return Error{"", "--split-samples", fmt::format("at most {}, the samples of a pixel", plan.samples),
                   std::to_string(plan.split)};
  }
  if (settings->folder.empty()) settings->folder = usual_folder(plan);
  settings->slurm.name = settings->folder.stem().string();
  return std::nullopt;
}

/// Makes or finds the farm of this folder. Error if it exists with other settings.
Result<Farm> make_farm(const SubmitSettings& settings) {
  if (const auto error = farm::make_folders(settings.folder)) return *error;
  std::error_code ignored;
  if (std::filesystem::exists(settings.folder / "farm.json", ignored)) {
    const Result<farm::Plan> there = farm::read_plan(settings.folder);
    if (!there) return there.error();
    if (const std::string text = farm::differences(settings.plan, *there); !text.empty())
      return Error{settings.folder.string(), "", "", "a farm of other settings: " + text + "; name another --folder"};
  }
  if (const auto error = farm::write_plan(settings.folder, settings.plan)) return *error;
  return open_farm(settings.folder);
}

/// The tasks that are left; those that have failed start again.
Result<std::vector<std::size_t>> tasks_to_do(const Farm& opened) {
  std::vector<std::size_t> left;
  for (std::size_t task = 0; task < opened.tasks.size(); ++task) {
    if (opened.is_done(task)) continue;
    left.push_back(task);
    const std::filesystem::path file = opened.files(task).state;
    farm::TaskState state = farm::read_state(file);
    if (farm::is_held(file) || state.phase == farm::Phase::waiting) continue;
    state.phase = farm::Phase::waiting;
    state.attempts = 0;
    if (const auto error = farm::write_state(file, state)) return *error;
  }
  return left;
}

int submit(SubmitSettings settings) {
  const auto refused = [](const Error& error) {
    log_error(error.message());
    return 1;
  };
  if (settings.plan.scene.empty()) throw WrongUsage("tress farm: expected a scene, or run|merge|status");
  if (settings.plan.output.empty()) throw WrongUsage("-o: expected a picture, found none");
  if (!settings.plan.frames.empty() && !names_frames(settings.plan.output))
    throw WrongUsage("-o: expected a name with #### for the number of the frame with --frames, found " +
                     settings.plan.output.string());
  check_render_options(settings.plan);
  if (const auto error = complete(&settings)) return refused(*error);
  const Result<Farm> opened = make_farm(settings);
  if (!opened) return refused(opened.error());
  SaveLock lock;
  if (const auto error = lock.acquire(opened->folder / "farm.json", opened->folder.string())) return refused(*error);
  if (const std::string jobs = jobs_in_queue(opened->folder); !jobs.empty()) {
    log_note(fmt::format("{}: submitted before, jobs {} are in the queue; nothing is submitted again",
                         opened->folder.string(), jobs));
    return 0;
  }
  const Result<std::vector<std::size_t>> left = tasks_to_do(*opened);
  if (!left) return refused(left.error());
  if (left->empty() && opened->is_merged()) {
    log_note(fmt::format("{}: all {} tasks are done and merged", opened->folder.string(), opened->tasks.size()));
    return 0;
  }
  if (const auto error = write_scripts(*opened, settings.slurm, *left)) return refused(*error);
  log_note(fmt::format("{}: {} of {} tasks to do; see tress farm status", opened->folder.string(), left->size(),
                       opened->tasks.size()));
  if (settings.scheduler == "slurm") return submit_to_slurm(*opened, settings.slurm, *left);
  print_commands(*opened, settings.scheduler);
  return 0;
}

void add_pictures(CLI::App* app, farm::Plan* plan) {
  app->add_option_function<std::string>(
         "SCENE", [plan](const std::string& file) { plan->scene = file; }, "scene JSON, or strands")
      ->type_name("SCENE");
  app->add_option_function<std::vector<std::string>>(
         "OPTIONS", [plan](const std::vector<std::string>& words) { plan->options = words; },
         "after --: options of tress render for every task, as in -- --spp 256")
      ->type_name("-- OPTIONS");
  add_file(app, "-o,--output", [plan](const std::string& file) { plan->output = file; },
           "pictures; #### in the name is the number of the frame", {".exr"});
  app->add_option_function<std::string>(
         "--frames", [plan](const std::string& text) { plan->frames = *parse_frames(text); },
         "1-240,250,300-340x2; without it one still")
      ->check(expecting("frames and ranges, 1-240,250,300-340x2, each -1000000..1000000",
                        [](const std::string& text) { return parse_frames(text).has_value(); }))
      ->type_name("LIST");
}

void add_tasks(CLI::App* app, SubmitSettings& s) {
  farm::Plan* plan = &s.plan;
  auto* cache = add_file(
      app, "--warm-cache", [plan](const std::string& file) { plan->warm_cache = file; },
      "table that every task starts from; what they learn is merged into it; a file, not default");
  cache->check(expecting("a file that all machines share, such as ./default",
                         [](const std::string& file) { return !is_default_cache(file); }));
  add_choice(
      app, "--cache-mode", {"append", "frozen"}, [plan](const std::string& mode) { plan->frozen = mode == "frozen"; },
      "append (default): each task learns into a part of its own; frozen: the table is used as it is")
      ->needs(cache);
  auto* calibrate = add_flag(app, "--calibrate-first", [plan] { plan->calibrates = true; })->needs(cache);
  auto* chunk = add_whole(app, "--chunk", [plan](std::uint64_t n) { plan->chunk = int(n); });
  add_whole(app, "--split-samples", [plan](std::uint64_t n) { plan->split = int(n); })
      ->excludes(chunk)
      ->excludes(calibrate);
  add_whole(app, "--retries", [plan](std::uint64_t n) { plan->retries = int(n); });
  app->add_option("--folder", s.folder,
                  "folder of the farm, on storage that all machines share; default: NAME.farm "
                  "beside the pictures")
      ->type_name("FOLDER");
  app->add_option("--program", s.program, "tress as the machines find it; default: this one")->type_name("FILE");
}

}  // namespace

std::vector<Command> add_farm(CLI::App& tress) {
  const auto settings = std::make_shared<SubmitSettings>();
  SubmitSettings& s = *settings;
  CLI::App* app = tress.add_subcommand("farm", "Frames, or the samples of a heavy one, as tasks of a scheduler");
  add_pictures(app, &s.plan);
  add_tasks(app, s);
  add_choice(
      app, "--submit", {"slurm", "openjd", "flamenco", "none"}, [&s](const std::string& name) { s.scheduler = name; },
      "slurm: now, by sbatch; openjd, flamenco, none (default): write the files and print the commands");
  add_whole(app, "--at-most", [&s](std::uint64_t n) { s.slurm.at_most = int(n); });
  app->add_option("--sbatch", s.slurm.extra, "an option of sbatch, as in --sbatch=--partition=render; any number")
      ->type_name("OPTION")
      ->allow_extra_args(false);
  add_quiet(app);
  std::vector<Command> commands;
  for (const auto& add : {add_farm_run, add_farm_merge, add_farm_status}) {
    Command command;
    command.app = add(*app, &command.run);
    commands.push_back(command);
  }
  commands.push_back({app, [settings] { return submit(*settings); }});
  return commands;
}

}  // namespace tress::cli
