// Compiles a job as Flamenco's Manager does: its `author` and `job` in their simplest form. Arguments: the job type and
// the job; prints the tasks, their commands and what they wait for as JSON.
"use strict";
const fs = require("fs");
const vm = require("vm");
const [, , typeFile, jobFile] = process.argv;
const submitted = JSON.parse(fs.readFileSync(jobFile, "utf8"));

class Task {
    constructor(name, type) { Object.assign(this, { name, type, commands: [], after: [] }); }
    addCommand(command) { this.commands.push(command); }
    addDependency(task) {
        if (!(task instanceof Task)) throw new Error("a dependency that is no task");
        this.after.push(task.name);
    }
}
const tasks = [];
const context = vm.createContext({
    print: () => {},
    author: { Task: (name, type) => new Task(name, type), Command: (name, parameters) => ({ name, parameters }) },
});
vm.runInContext(fs.readFileSync(typeFile, "utf8") + "\nthis.result = { JOB_TYPE, compileJob };", context);
const { JOB_TYPE, compileJob } = context.result;

const known = new Map(JOB_TYPE.settings.map((setting) => [setting.key, setting]));
const types = { string: "string", int32: "number", float: "number", bool: "boolean" };
for (const [key, value] of Object.entries(submitted.settings)) {
    if (!known.has(key)) throw new Error(`no setting ${key}`);
    if (typeof value !== types[known.get(key).type]) throw new Error(`setting ${key} of another type`);
}
for (const setting of known.values()) {
    if (setting.required && !(setting.key in submitted.settings)) throw new Error(`setting ${setting.key} is missing`);
}
compileJob({ settings: submitted.settings, addTask: (task) => tasks.push(task) });
console.log(JSON.stringify({ label: JOB_TYPE.label, tasks }));
