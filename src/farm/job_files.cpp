#include "farm/job_files.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tress::farm {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t longest_name = 128;  // longest name of an OpenJD job
constexpr int notice_seconds = 60;         // between the request to stop and the kill

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

/// Removes control characters, which neither scheduler accepts.
std::string plain_name(std::string name) {
  for (char& c : name) c = static_cast<unsigned char>(c) < 32 || c == 127 ? ' ' : c;
  return name.empty() ? "tress" : name.substr(0, longest_name);
}

Json action(const std::vector<std::string>& arguments) {
  return {{"onRun",
           {{"command", "{{Param.Tress}}"},
            {"args", arguments},
            {"cancelation", {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", notice_seconds}}}}}};
}

Json render_step(const char* name, const std::string& tasks) {
  Json step{{"name", name}};
  step["parameterSpace"] = {
      {"taskParameterDefinitions", Json::array({{{"name", "Task"}, {"type", "INT"}, {"range", tasks}}})}};
  step["script"] = {{"actions", action({"farm", "run", "{{Param.FarmFolder}}", "--task", "{{Task.Param.Task}}",
                                        "--progress", "openjd"})}};
  return step;
}

Json depends_on(const char* step) { return Json::array({{{"dependsOn", step}}}); }

constexpr const char* job_type =
    R"js(// The job type of tress for Flamenco 3: put this file into the Manager's folder scripts/.
// Every task is one command, `tress farm run FOLDER --task N`, that is safe to run again.
const JOB_TYPE = {
    label: "tress farm",
    settings: [
        { key: "tress", type: "string", required: true, default: "tress",
          description: "The program, as the Workers find it" },
        { key: "farm_folder", type: "string", subtype: "dir_path", required: true,
          description: "Folder that tress farm has written, on storage that the Workers share" },
        { key: "task_count", type: "int32", required: true, description: "Number of tasks of the farm" },
        { key: "calibrates", type: "bool", default: false,
          description: "Whether the first task calibrates and the others wait for it" },
    ]
};

function authorTask(settings, name, args) {
    const task = author.Task(name, "misc");
    task.addCommand(author.Command("exec", { exe: settings.tress, args: args }));
    return task;
}

function compileJob(job) {
    const settings = job.settings;
    const merge = authorTask(settings, "merge", ["farm", "merge", settings.farm_folder]);
    let first = null;
    for (let number = 0; number < settings.task_count; number++) {
        const task = authorTask(settings, `render-${number}`,
                                ["farm", "run", settings.farm_folder, "--task", `${number}`]);
        if (settings.calibrates && first) task.addDependency(first);
        if (!first) first = task;
        merge.addDependency(task);
        job.addTask(task);
    }
    job.addTask(merge);
}
)js";

}  // namespace

std::string openjd_template(const Plan& plan, const std::filesystem::path& folder, const std::string& name) {
  const std::size_t count = tasks_of(plan).size();
  const bool first_alone = plan.calibrates && count > 1;
  Json steps = Json::array();
  if (first_alone) steps.push_back(render_step("Calibrate", "0"));
  const std::size_t first = first_alone ? 1 : 0;
  Json render =
      render_step("Render", first + 1 == count ? fmt::format("{}", first) : fmt::format("{}-{}", first, count - 1));
  if (first_alone) render["dependencies"] = depends_on("Calibrate");
  steps.push_back(render);
  Json merge{{"name", "Merge"}, {"dependencies", depends_on("Render")}};
  merge["script"] = {{"actions", action({"farm", "merge", "{{Param.FarmFolder}}"})}};
  steps.push_back(merge);
  const Json parameters = Json::array({{{"name", "Tress"},
                                        {"type", "STRING"},
                                        {"description", "The program, as the workers find it"},
                                        {"default", plan.program.string()}},
                                       {{"name", "FarmFolder"},
                                        {"type", "PATH"},
                                        {"objectType", "DIRECTORY"},
                                        {"dataFlow", "INOUT"},
                                        {"description", "Folder that tress farm has written, on shared storage"},
                                        {"default", folder.string()}}});
  return text_of({{"specificationVersion", "jobtemplate-2023-09"},
                  {"name", plain_name(name)},
                  {"parameterDefinitions", parameters},
                  {"steps", steps}});
}

std::string flamenco_job_type() { return job_type; }

std::string flamenco_job(const Plan& plan, const std::filesystem::path& folder, const std::string& name) {
  const Json settings{{"tress", plan.program.string()},
                      {"farm_folder", folder.string()},
                      {"task_count", tasks_of(plan).size()},
                      {"calibrates", plan.calibrates}};
  return text_of({{"name", plain_name(name)},
                  {"type", "tress"},
                  {"priority", 50},
                  {"submitter_platform", "linux"},
                  {"settings", settings},
                  {"metadata", {{"project", plan.scene.stem().string()}}}});
}

}  // namespace tress::farm
