#include "farm/slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace tress::farm {
namespace {

std::string command_of(const Plan& plan, const std::filesystem::path& folder, const char* command) {
  return shell_words({plan.program.string(), "farm", command, folder.string()});
}

std::string after_text(const std::vector<std::string>& jobs) {
  std::string text = "--dependency=afterok";
  for (const std::string& job : jobs) text += ":" + job;
  return text;
}

std::vector<std::string> command_with(const SlurmOptions& options, const std::vector<std::string>& after) {
  std::vector<std::string> words{"sbatch", "--parsable", "--job-name=" + options.name, "--requeue",
                                 "--open-mode=append"};
  // A merge whose tasks have failed for good must not wait for ever.
  if (!after.empty()) words.insert(words.end(), {after_text(after), "--kill-on-invalid-dep=yes"});
  return words;
}

/// Slurm takes % in the name of a log as the start of a pattern, so one in the folder's name is escaped.
std::string log_option(const std::filesystem::path& folder, const char* pattern) {
  std::string logs = (folder / "logs").string();
  for (std::size_t at = 0; (at = logs.find('%', at)) != std::string::npos; at += 2) logs.insert(at, 1, '%');
  return "--output=" + logs + "/" + pattern;
}

}  // namespace

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) || std::string_view("-_./,:=+@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string shell_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += ' ';
    text += shell_word(word);
  }
  return text;
}

std::string slurm_task_script(const Plan& plan, const std::filesystem::path& folder) {
  return fmt::format(R"sh(#!/bin/bash
# One task of a farm of tress, started by sbatch --array; its number is that in the array and the first argument.
near_limit= cancelled= child=
trap 'near_limit=1; [ -z "$child" ] || kill -TERM $child' USR1
trap 'cancelled=1; [ -z "$child" ] || kill -TERM $child' TERM INT
{} --task "$((SLURM_ARRAY_TASK_ID + ${{1:-0}}))" &
child=$!
[ -z "$near_limit$cancelled" ] || kill -TERM $child
while kill -0 $child 2>/dev/null; do wait $child; done
wait $child
status=$?
again=
if [ $status -eq 75 ]; then again=1; fi
if [ $status -ne 0 ] && [ -n "$near_limit" ]; then again=1; fi
if [ $status -gt 128 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {} ]; then again=1; fi
if [ -n "$again" ] && [ -z "$cancelled" ]; then
  echo "exit status $status: this task goes back into the queue"
  scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}" && sleep 60
fi
exit $status
)sh",
                     command_of(plan, folder, "run"), plan.retries);
}

std::string slurm_merge_script(const Plan& plan, const std::filesystem::path& folder) {
  return fmt::format(
      "#!/bin/bash\n# The merge of a farm of tress, started by sbatch when all tasks are done.\nexec {}\n",
      command_of(plan, folder, "merge"));
}

std::vector<std::string> slurm_array_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::size_t>& tasks,
                                             const std::vector<std::string>& after, std::size_t offset) {
  std::vector<std::string> words = command_with(options, after);
  std::vector<std::size_t> in_array;
  for (const std::size_t task : tasks) in_array.push_back(task - offset);
  std::string array = "--array=" + ranges_text(in_array);
  if (options.at_most > 0) array += fmt::format("%{}", options.at_most);
  // Sent two minutes before the time limit: enough to end a pass and to write a checkpoint.
  words.insert(words.end(), {array, "--signal=B:USR1@120", log_option(folder, "%A_%a.log")});
  words.insert(words.end(), options.extra.begin(), options.extra.end());
  words.push_back((folder / "slurm" / "task.sh").string());
  if (offset > 0) words.push_back(fmt::format("{}", offset));
  return words;
}

std::vector<std::string> slurm_merge_command(const std::filesystem::path& folder, const SlurmOptions& options,
                                             const std::vector<std::string>& after) {
  std::vector<std::string> words = command_with(options, after);
  words.push_back(log_option(folder, "merge-%j.log"));
  words.insert(words.end(), options.extra.begin(), options.extra.end());
  words.push_back((folder / "slurm" / "merge.sh").string());
  return words;
}

}  // namespace tress::farm
