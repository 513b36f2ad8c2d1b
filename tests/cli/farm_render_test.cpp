// Farms from the command to the merged pictures, under a scheduler that is a script: what is passed to it, what its
// tasks do when they are killed, fail, or are started twice. tests/farm/slurm_shot runs a real one.
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Farms : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), R"({
      "camera": {"turntable": {"frames": 24}},
      "image": {"width": 32, "height": 32, "samples": 8},
      "environment": {"constant": [1, 0.9, 0.8]},
      "materials": [{"name": "brown"}],
      "grooms": [{"generate": "straight", "strands": 200, "radius_cm": 0.04, "material": "brown"}]
    })");
    fs::create_directories(path("bin"));
    fs::create_directories(path("out"));
    old_path_ = std::getenv("PATH");
    ::setenv("PATH", (path("bin") + ":" + old_path_).c_str(), 1);
    // Each prints the number of the job, and keeps its arguments.
    script("sbatch",
           "echo \"$*\" >> " + path("submitted") + "; n=$(wc -l < " + path("submitted") + "); echo $((100 + n))");
    script("squeue", "cat " + path("queue") + " 2>/dev/null; exit 0");
    script("scontrol", "if [ $1 = show ]; then echo 'MaxArraySize = 20'; else echo \"$*\" >> " + path("controlled") +
                           "; fi; exit 0");
  }
  void TearDown() override {
    ::setenv("PATH", old_path_.c_str(), 1);
    CommandTest::TearDown();
  }
  void script(const std::string& name, const std::string& body) const {
    write_text(path("bin/" + name), "#!/bin/sh\n" + body + "\n");
    fs::permissions(path("bin/" + name), fs::perms::owner_all);
  }
  std::vector<std::string> farm(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"farm",     path("scene.json"), "-o",           path("out/####.exr"),
                                   "--folder", path("shot.farm"),  "--warm-cache", path("hair.cache")};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Outcome task(std::size_t number) const {
    return run({"farm", "run", path("shot.farm"), "--task", std::to_string(number)});
  }
  Outcome merge() const { return run({"farm", "merge", path("shot.farm")}); }
  nlohmann::json status() const {
    return nlohmann::json::parse(run({"farm", "status", path("shot.farm"), "--json"}).out, nullptr, false);
  }
  std::string arguments(const std::string& file) const { return fs::exists(path(file)) ? read_text(path(file)) : ""; }

  std::string old_path_;
};

TEST_F(Farms, AreSubmittedOnceAndWhatIsLeftAgain) {
  const auto words = farm({"--frames", "1-6", "--chunk", "2", "--submit", "slurm", "--at-most", "2",
                           "--sbatch=--partition=render", "--sbatch=--mem=4G", "--", "--spp", "2"});
  Outcome submitted = run(words);
  ASSERT_EQ(submitted.status, 0) << submitted.err;
  EXPECT_EQ(submitted.out, "tasks 101\nmerge 102\n");
  EXPECT_THAT(arguments("submitted"), HasSubstr("--array=0-2%2 "));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--partition=render --mem=4G " + path("shot.farm/slurm/task.sh")));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--dependency=afterok:101 --kill-on-invalid-dep=yes"));

  write_text(path("queue"), "101\n");
  submitted = run(words);
  EXPECT_EQ(submitted.status, 0);
  EXPECT_THAT(submitted.err, HasSubstr("nothing is submitted again"));
  EXPECT_THAT(submitted.out, IsEmpty());

  write_text(path("queue"), "");
  ASSERT_EQ(task(1).status, 0);
  submitted = run(words);
  EXPECT_THAT(submitted.out, HasSubstr("tasks 103"));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--array=0,2%2 "));
  EXPECT_EQ(status()["done"], 1);
  EXPECT_EQ(status()["tasks"][1]["pictures"], 2);
}

TEST_F(Farms, OfOtherSettingsAreRefusedByName) {
  ASSERT_EQ(run(farm({"--frames", "1-6", "--chunk", "2"})).status, 0);
  const Outcome other = run(farm({"--frames", "1-6", "--chunk", "3"}));
  EXPECT_EQ(other.status, 1);
  EXPECT_THAT(other.err, HasSubstr("chunk: expected 3, found 2"));
  const Outcome many = run({"farm", path("scene.json"), "-o", path("out/####.exr"), "--frames", "1-24", "--submit",
                            "slurm", "--folder", path("many.farm")});
  EXPECT_EQ(many.status, 0) << many.err;  // Slurm numbers the tasks of an array from 0 to 19 here: two arrays
  EXPECT_THAT(arguments("submitted"), HasSubstr("--array=0-19 "));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--array=0-3 "));
  EXPECT_THAT(arguments("submitted"), HasSubstr("slurm/task.sh 20\n"));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--dependency=afterok:101:102 "));
}

TEST_F(Farms, WrongWordsAreRefusedBeforeAnythingIsSubmitted) {
  const std::map<std::string, std::vector<std::string>> wrong{
      {"nearest: --spp", {"--frames", "1", "--", "--sppp", "2"}},
      {"which each has its own", {"--frames", "1", "--", "--warm-cache", "x"}},
      {"--split-samples", {"--frames", "1", "--split-samples", "4", "--chunk", "2"}},
      {"--time", {"--frames", "1", "--split-samples", "4", "--", "--time", "3"}},
      {"found 9", {"--frames", "1", "--split-samples", "9"}},
      {"slurm|openjd|flamenco|none", {"--frames", "1", "--submit", "slurn"}}};
  for (const auto& [message, words] : wrong) {
    const Outcome outcome = run(farm(words));
    EXPECT_NE(outcome.status, 0) << message;
    EXPECT_THAT(outcome.err, HasSubstr(message.starts_with("nearest") ? "--sppp" : message));
  }
  EXPECT_EQ(run({"farm", path("scene.json"), "-o", path("out/a.exr"), "--frames", "1-2"}).status, 2);
  EXPECT_EQ(run({"farm", "-o", path("out/a.exr")}).status, 2);
  EXPECT_THAT(arguments("submitted"), IsEmpty());
}

TEST_F(Farms, OfFramesEndWithPicturesAndOneTable) {
  ASSERT_EQ(run(farm({"--frames", "1-3", "--chunk", "2"})).status, 0);
  ASSERT_EQ(task(0).status, 0);
  Outcome early = merge();
  EXPECT_EQ(early.status, 1);
  EXPECT_THAT(early.err, HasSubstr("1 that is not: 1; nothing is merged"));
  EXPECT_FALSE(fs::exists(path("hair.cache")));
  EXPECT_EQ(run({"farm", "status", path("shot.farm")}).status, 3);

  ASSERT_EQ(task(1).status, 0);
  const auto written = fs::last_write_time(path("out/0001.exr"));
  const Outcome again = task(0);
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.err, HasSubstr("done before"));
  EXPECT_EQ(fs::last_write_time(path("out/0001.exr")), written);

  ASSERT_EQ(merge().status, 0);
  EXPECT_EQ(run({"cache", "verify", path("hair.cache")}).status, 0);
  const std::string table = read_text(path("hair.cache"));
  EXPECT_THAT(merge().err, HasSubstr("merged before"));
  EXPECT_TRUE(read_text(path("hair.cache")) == table);
  EXPECT_EQ(run({"farm", "status", path("shot.farm")}).status, 0);
  // A picture that is lost is rendered again, and only that.
  fs::remove(path("out/0002.exr"));
  EXPECT_EQ(status()["tasks"][0]["state"], "lost");
  const Outcome repaired = task(0);
  EXPECT_THAT(repaired.err, HasSubstr("1 rendered, 1 finished before"));
  EXPECT_TRUE(fs::exists(path("out/0002.exr")));
}

TEST_F(Farms, TheFirstFrameCalibratesForAll) {
  ASSERT_EQ(run(farm({"--frames", "1-3", "--calibrate-first", "--submit", "slurm"})).status, 0);
  EXPECT_THAT(arguments("submitted"), HasSubstr("--array=0 "));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--dependency=afterok:101 --kill-on-invalid-dep=yes --array=1-2 "));
  EXPECT_THAT(arguments("submitted"), HasSubstr("--dependency=afterok:102 "));
  ASSERT_EQ(task(0).status, 0);
  ASSERT_TRUE(fs::exists(path("hair.cache")));
  ASSERT_EQ(task(1).status, 0);
  const auto summary = telemetry_lines(path("shot.farm/telemetry/task-0001.jsonl"), "summary");
  ASSERT_EQ(summary.size(), 1u);
  EXPECT_GT(summary[0]["warm_cache"]["rows_known"].get<int>(), 0);
}

TEST_F(Farms, SplitSamplesOfAFrozenTableAreThePictureOfOneRender) {
  const std::vector<std::string> still{"render",       path("scene.json"), "-o",     path("learn.exr"),
                                       "--warm-cache", path("hair.cache"), "--quiet"};
  ASSERT_EQ(run(still).status, 0);
  const std::string table = read_text(path("hair.cache"));
  ASSERT_EQ(run({"render", path("scene.json"), "-o", path("whole.exr"), "--warm-cache", path("hair.cache"),
                 "--cache-mode", "frozen", "--frame", "5"})
                .status,
            0);
  ASSERT_EQ(run(farm({"--frames", "5", "--split-samples", "3", "--cache-mode", "frozen"})).status, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const Outcome outcome = task(i);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  const Outcome merged = merge();
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_THAT(merged.err, HasSubstr("the picture of one render"));
  const auto one = image::read_exr(path("whole.exr")), other = image::read_exr(path("out/0005.exr"));
  ASSERT_TRUE(one && other);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name = std::string("RGB").substr(c, 1);
    const auto of = [&](const image::Picture& picture) {
      return std::ranges::find(picture.channels, name, &image::Channel::name)->pixels;
    };
    EXPECT_TRUE(of(*one) == of(*other)) << name;
  }
  EXPECT_TRUE(read_text(path("hair.cache")) == table) << "a frozen table is not written";
}

TEST_F(Farms, SplitSamplesThatLearnApartAreMergedToo) {
  ASSERT_EQ(run(farm({"--frames", "5", "--split-samples", "2"})).status, 0);
  for (std::size_t i = 0; i < 2; ++i) ASSERT_EQ(task(i).status, 0);
  const Outcome merged = merge();
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_THAT(merged.err, HasSubstr("tables that learned apart"));
  EXPECT_TRUE(fs::exists(path("out/0005.exr")) && fs::exists(path("hair.cache")));
}

TEST_F(Farms, AKilledTaskGoesOnAndATaskStartedTwiceIsDoneOnce) {
  ASSERT_EQ(run(farm({"--frames", "1-2", "--chunk", "2", "--", "--spp", "150", "--checkpoint-interval", "0"})).status,
            0);
  const fs::path telemetry = path("shot.farm/telemetry/task-0000.jsonl");
  {
    const Process process(folder_, {"farm", "run", path("shot.farm"), "--task", "0"});
    for (int tries = 0; tries < 3000; ++tries) {
      if (fs::exists(path("shot.farm/work/task-0000.0001.checkpoint"))) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(status()["tasks"][0]["state"], "running");
    process.send(SIGKILL);
    EXPECT_EQ(process.wait().status, 128 + SIGKILL);
  }
  EXPECT_EQ(status()["tasks"][0]["state"], "killed");
  fs::create_directories(path("second"));
  const Process one(folder_, {"farm", "run", path("shot.farm"), "--task", "0"});
  const Process two(path("second"), {"farm", "run", path("shot.farm"), "--task", "0"});
  const Outcome first = one.wait(), second = two.wait();
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(first.err + second.err, HasSubstr("goes on after"));
  EXPECT_THAT(first.err + second.err, HasSubstr("done before"));
  // Every pass of every frame once.
  std::map<std::pair<int, int>, int> passes;
  for (const nlohmann::json& line : telemetry_lines(telemetry, "pass")) ++passes[{line["frame"], line["pass"]}];
  for (const auto& [pass, times] : passes) EXPECT_EQ(times, 1) << "frame " << pass.first << " pass " << pass.second;
  EXPECT_EQ(telemetry_lines(telemetry, "summary").size(), 2u);
  EXPECT_EQ(merge().status, 0);
}

TEST_F(Farms, ATaskThatFailsMayBeTriedAgainSoOften) {
  write_text(path("hair.cache"), "no cache");  // a task refuses to start from it, and says so
  ASSERT_EQ(run(farm({"--frames", "1", "--calibrate-first", "--retries", "1"})).status, 0);
  EXPECT_EQ(task(0).status, 75);
  EXPECT_EQ(task(0).status, 1);
  EXPECT_EQ(status()["tasks"][0]["state"], "failed");
  EXPECT_EQ(run({"farm", "status", path("shot.farm")}).status, 1);
  EXPECT_THAT(task(0).err, HasSubstr("after 2 attempts"));
  fs::remove(path("hair.cache"));
  ASSERT_EQ(run(farm({"--frames", "1", "--calibrate-first", "--retries", "1"})).status, 0);
  EXPECT_EQ(task(0).status, 0);
}

// The script that sbatch is given, where the program and Slurm are others.
TEST_F(Farms, TheScriptPutsATaskBackIntoTheQueue) {
  const auto ended = [&](const std::string& program, const std::string& restarts) {
    script("program", program);
    script("sleep", "exit 0");
    fs::remove(path("controlled"));
    fs::remove_all(path("shot.farm"));
    EXPECT_EQ(run(farm({"--frames", "1", "--program", path("bin/program")})).status, 0);
    ::setenv("SLURM_ARRAY_TASK_ID", "3", 1);
    ::setenv("SLURM_ARRAY_JOB_ID", "77", 1);
    ::setenv("SLURM_RESTART_COUNT", restarts.c_str(), 1);
    const Outcome outcome = Process(folder_, {path("shot.farm/slurm/task.sh")}, "/bin/bash").wait();
    for (const char* name : {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_JOB_ID", "SLURM_RESTART_COUNT"}) ::unsetenv(name);
    return outcome;
  };
  const Outcome done = ended("echo \"$*\"", "0");
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(done.out, "farm run " + path("shot.farm") + " --task 3\n");
  EXPECT_THAT(arguments("controlled"), IsEmpty());
  EXPECT_EQ(ended("exit 75", "9").status, 75);
  EXPECT_THAT(arguments("controlled"), HasSubstr("requeue 77_3")) << "the program has counted";
  EXPECT_EQ(ended("kill -9 $$", "1").status, 137);
  EXPECT_THAT(arguments("controlled"), HasSubstr("requeue 77_3"));
  EXPECT_EQ(ended("kill -9 $$", "2").status, 137);
  EXPECT_THAT(arguments("controlled"), IsEmpty()) << "as often as it may";
  EXPECT_EQ(ended("exit 1", "0").status, 1);
  EXPECT_THAT(arguments("controlled"), IsEmpty());
  // Slurm's warning before the limit of time: the program saves and ends, and the task goes on later.
  EXPECT_EQ(ended("trap 'exit 143' TERM; kill -USR1 $PPID; while :; do :; done", "9").status, 143);
  EXPECT_THAT(arguments("controlled"), HasSubstr("requeue 77_3"));
  EXPECT_EQ(ended("trap 'exit 143' TERM; kill -TERM $PPID; while :; do :; done", "0").status, 143);
  EXPECT_THAT(arguments("controlled"), IsEmpty()) << "somebody has cancelled it";
}

TEST_F(Farms, LocalAndOpenJdFilesAreWhatTheySay) {
  const Outcome planned = run(farm({"--frames", "1-2", "--", "--spp", "2"}));
  ASSERT_EQ(planned.status, 0);
  for (const char* name : {"local.sh", "slurm/submit.sh", "openjd.json", "flamenco/tress.js", "flamenco/job.json"}) {
    EXPECT_THAT(planned.out, HasSubstr(path("shot.farm/" + std::string(name))));
    EXPECT_TRUE(fs::exists(path("shot.farm/" + std::string(name)))) << name;
  }
  EXPECT_EQ(Process(folder_, {path("shot.farm/local.sh")}, "/bin/sh").wait().status, 0);
  EXPECT_EQ(run({"farm", "status", path("shot.farm")}).status, 0);
  EXPECT_EQ(Process(folder_, {path("shot.farm/slurm/submit.sh")}, "/bin/bash").wait().status, 0);
  EXPECT_THAT(arguments("submitted"), HasSubstr("--dependency=afterok:101"));
}

TEST_F(Farms, ProgressIsPrintedAsOpenJdReadsIt) {
  const Outcome outcome = run({"render", path("scene.json"), "-o", path("out/####.exr"), "--frames", "1-2",
                               "--progress", "openjd", "--spp", "4"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::istringstream lines(outcome.out);
  double last = 0;
  int progress = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(line.starts_with("openjd_progress: ") || line.starts_with("openjd_status: ")) << line;
    if (!line.starts_with("openjd_progress: ")) continue;
    const double percent = std::stod(line.substr(17));
    EXPECT_GE(percent, last);
    EXPECT_LE(percent, 100);
    last = percent;
    ++progress;
  }
  EXPECT_GE(progress, 8);
  EXPECT_GT(last, 99);
  const Outcome failed = run({"render", path("nowhere.json"), "-o", path("out/a.exr"), "--progress", "openjd"});
  EXPECT_EQ(failed.status, 1);
  EXPECT_THAT(failed.out, HasSubstr("openjd_fail: "));
  EXPECT_THAT(run({"render", path("scene.json"), "-o", path("out/b.exr"), "--spp", "1"}).out, IsEmpty());
}

}  // namespace
}  // namespace tress::test
