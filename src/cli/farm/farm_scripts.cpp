#include "cli/farm/farm_scripts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/console.h"
#include "cli/options.h"
#include "farm/job_files.h"
#include "tress/base/replace_file.h"

namespace tress::cli {
namespace {

constexpr std::size_t usual_max_array_size = 1001;

/// The tasks of one array, by their numbers; the first has index 0 in it.
struct TaskArray {
  std::vector<std::size_t> tasks;
  std::size_t offset = 0;
  bool is_first = false;  ///< whether all others wait for it
};

/// Divides the tasks into arrays of fewer than `most` indices. All of them can start at once, or wait for the first
/// task.
std::vector<TaskArray> arrays_of(const Farm& opened, const std::vector<std::size_t>& left, std::size_t most) {
  std::vector<TaskArray> arrays;
  if (left.empty()) return arrays;
  const bool has_first = opened.plan.calibrates && left.front() == 0 && left.size() > 1;
  if (has_first) arrays.push_back({{0}, 0, true});
  for (auto task = left.begin() + (has_first ? 1 : 0); task != left.end(); ++task) {
    const std::size_t offset = *task / most * most;
    if (arrays.empty() || arrays.back().is_first || arrays.back().offset != offset) arrays.push_back({{}, offset});
    arrays.back().tasks.push_back(*task);
  }
  return arrays;
}

/// The largest array index + 1 from the controller's configuration.
std::size_t max_array_size() {
  const ProgramResult shown = run_program({"scontrol", "show", "config"});
  const std::size_t at = shown.out.find("MaxArraySize");
  if (shown.status != 0 || at == std::string::npos) return usual_max_array_size;
  const std::size_t begin = shown.out.find_first_of("0123456789", at);
  const std::size_t end = shown.out.find_first_not_of("0123456789", begin);
  if (begin == std::string::npos) return usual_max_array_size;
  return std::size_t(parse_unsigned(shown.out.substr(begin, end - begin)).value_or(usual_max_array_size));
}

/// The script that submits the tasks and the merge by hand; ids of jobs are variables of the shell.
std::string slurm_submit_script(const Farm& opened, const farm::SlurmOptions& options,
                                const std::vector<std::size_t>& left) {
  std::string text = "#!/bin/bash\n# Submits a farm of tress by hand; tress farm --submit slurm does it too.\nset -e\n";
  std::vector<std::string> first, all;
  const auto add = [&](const std::string& name, const std::vector<std::string>& words) {
    std::string line = farm::shell_words(words);
    for (std::size_t at = 0; (at = line.find(":@")) != std::string::npos;) line.replace(at, 2, ":$");
    text += fmt::format("{}=$({})\necho \"{}: job ${}\"\n", name, line, name, name);
  };
  for (const TaskArray& array : arrays_of(opened, left, max_array_size())) {
    const std::string name = array.is_first      ? "first"
                             : array.offset == 0 ? "tasks"
                                                 : fmt::format("tasks_{}", array.offset);
    add(name, farm::slurm_array_command(opened.folder, options, array.tasks, first, array.offset));
    if (array.is_first)
      first = {"@" + name};
    else
      all.push_back("@" + name);
  }
  add("merge", farm::slurm_merge_command(opened.folder, options, all));
  return text;
}

std::string local_script(const Farm& opened, const std::vector<std::size_t>& left) {
  const std::string program = farm::shell_word(opened.plan.program.string());
  const std::string folder = farm::shell_word(opened.folder.string());
  std::string text = "#!/bin/sh\n# The tasks one after the other on this machine.\nset -e\n";
  for (const std::size_t task : left) text += fmt::format("{} farm run {} --task {}\n", program, folder, task);
  return text + fmt::format("{} farm merge {}\n", program, folder);
}

/// The id in the output of sbatch --parsable, "12" or "12;cluster". Empty if the job was refused, which sbatch has
/// reported.
std::string submitted_id(const std::vector<std::string>& command) {
  const ProgramResult submitted = run_program(command);
  if (submitted.status == 127) log_error("sbatch: expected Slurm's program on the PATH, found none");
  if (submitted.status != 0) return {};
  std::string id = submitted.out.substr(0, submitted.out.find_first_of(";\n"));
  const bool is_number = !id.empty() && std::ranges::all_of(id, [](unsigned char c) { return std::isdigit(c) != 0; });
  return is_number ? id : std::string();
}

std::optional<Error> note_jobs(const std::filesystem::path& folder, const std::vector<std::string>& jobs) {
  const nlohmann::ordered_json json{{"scheduler", "slurm"}, {"jobs", jobs}};
  return replace_file(folder / "submitted.json", json.dump() + "\n");
}

}  // namespace

std::optional<Error> write_scripts(const Farm& opened, const farm::SlurmOptions& options,
                                   const std::vector<std::size_t>& left) {
  const std::filesystem::path& folder = opened.folder;
  for (const char* name : {"slurm", "flamenco"}) {
    std::error_code error;
    std::filesystem::create_directories(folder / name, error);
    if (error) return Error{(folder / name).string(), "", "a folder that can be made", error.message()};
  }
  const std::vector<std::pair<std::filesystem::path, std::string>> files{
      {folder / "slurm" / "task.sh", farm::slurm_task_script(opened.plan, folder)},
      {folder / "slurm" / "merge.sh", farm::slurm_merge_script(opened.plan, folder)},
      {folder / "slurm" / "submit.sh", slurm_submit_script(opened, options, left)},
      {folder / "local.sh", local_script(opened, left)},
      {folder / "openjd.json", farm::openjd_template(opened.plan, folder, options.name)},
      {folder / "flamenco" / "tress.js", farm::flamenco_job_type()},
      {folder / "flamenco" / "job.json", farm::flamenco_job(opened.plan, folder, options.name)}};
  for (const auto& [file, text] : files) {
    if (const auto error = replace_file(file, text)) return error;
  }
  return std::nullopt;
}

int submit_to_slurm(const Farm& opened, const farm::SlurmOptions& options, const std::vector<std::size_t>& left) {
  std::vector<std::string> jobs, first, all;
  const auto submit = [&](const std::vector<std::string>& command, const std::string& what) {
    const std::string id = submitted_id(command);
    if (id.empty()) {
      log_error("sbatch: expected the number of a job, found none; what was submitted: " +
                (jobs.empty() ? "nothing" : joined(jobs, ",")));
      return false;
    }
    jobs.push_back(id);
    fmt::print("{} {}\n", what, id);
    // Written at once, so that the next submission finds the jobs if this one is killed here.
    const auto error = note_jobs(opened.folder, jobs);
    if (error) log_error(error->message());
    return !error;
  };
  for (const TaskArray& array : arrays_of(opened, left, max_array_size())) {
    if (!submit(farm::slurm_array_command(opened.folder, options, array.tasks, first, array.offset), "tasks")) return 1;
    if (array.is_first)
      first = {jobs.back()};
    else
      all.push_back(jobs.back());
  }
  return submit(farm::slurm_merge_command(opened.folder, options, all), "merge") ? 0 : 1;
}

std::string jobs_in_queue(const std::filesystem::path& folder) {
  std::ifstream in(folder / "submitted.json", std::ios::binary);
  const nlohmann::json submitted = nlohmann::json::parse(in, nullptr, false);
  if (!submitted.is_object() || !submitted.contains("jobs") || !submitted["jobs"].is_array()) return {};
  std::string queued;
  // The jobs are looked up one by one, because Slurm refuses a list with a job that it has forgotten.
  for (const nlohmann::json& job : submitted["jobs"]) {
    if (!job.is_string()) continue;
    const ProgramResult shown =
        run_program({"squeue", "--noheader", "--format=%i", "--jobs=" + job.get<std::string>()});
    if (shown.status == 0 && shown.out.find_first_not_of(" \n") != std::string::npos)
      queued += (queued.empty() ? "" : ",") + job.get<std::string>();
  }
  return queued;
}

void print_commands(const Farm& opened, const std::string& scheduler) {
  const auto word = [&](const char* name) { return farm::shell_word((opened.folder / name).string()); };
  const bool all = scheduler == "none";
  if (all) fmt::print("here      sh {}\n", word("local.sh"));
  if (all) fmt::print("Slurm     bash {}\n", word("slurm/submit.sh"));
  if (all || scheduler == "openjd") {
    fmt::print("OpenJD    openjd run {0}\n          a farm takes the same file: {0}\n", word("openjd.json"));
  }
  if (all || scheduler == "flamenco") {
    fmt::print("Flamenco  once: cp {} scripts/ of the Manager\n", word("flamenco/tress.js"));
    fmt::print(
        "          curl -X POST -H 'Content-Type: application/json' --data @{} http://MANAGER:8080/api/v3/jobs\n",
        word("flamenco/job.json"));
  }
}

}  // namespace tress::cli
