// How a shot is cut into tasks, and that a plan is read as it was written.
#include "farm/plan.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <numeric>

#include "farm/slurm.h"
#include "farm/task_files.h"

namespace tress::farm {
namespace {

namespace fs = std::filesystem;

Plan plan_of(int frames) {
  Plan plan;
  plan.program = "/usr/bin/tress";
  plan.directory = "/shot";
  plan.scene = "/shot/a scene.json";
  plan.output = "/shot/out/####.exr";
  plan.frames.resize(std::size_t(frames));
  std::iota(plan.frames.begin(), plan.frames.end(), 1);
  return plan;
}

class FarmFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ("tress_farm_plan_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    ASSERT_FALSE(make_folders(folder_));
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST(FarmPlan, EveryFrameIsInOneTask) {
  for (const int frames : {1, 2, 23, 24, 25}) {
    for (const int chunk : {1, 3, 24, 100}) {
      for (const bool calibrates : {false, true}) {
        Plan plan = plan_of(frames);
        plan.chunk = chunk;
        plan.calibrates = calibrates;
        std::vector<int> all;
        for (const Task& task : tasks_of(plan)) {
          EXPECT_FALSE(task.is_split());
          EXPECT_LE(task.frames.size(), std::size_t(chunk));
          EXPECT_FALSE(task.frames.empty());
          all.insert(all.end(), task.frames.begin(), task.frames.end());
        }
        EXPECT_EQ(all, plan.frames);
        if (calibrates) {
          EXPECT_EQ(tasks_of(plan).front().frames.size(), 1u);
        }
      }
    }
  }
}

TEST(FarmPlan, EverySampleOfEveryFrameIsInOneTask) {
  for (const int split : {1, 3, 7, 64}) {
    Plan plan = plan_of(2);
    plan.split = split;
    plan.samples = 64;
    std::map<int, int> reached;  // of each frame, the sample that comes next
    for (const Task& task : tasks_of(plan)) {
      ASSERT_EQ(task.frames.size(), 1u);
      EXPECT_EQ(task.samples_from, reached[task.frames[0]]);
      EXPECT_LT(task.samples_from, task.samples_to);
      reached[task.frames[0]] = task.samples_to;
    }
    EXPECT_EQ(reached, (std::map<int, int>{{1, 64}, {2, 64}}));
  }
}

TEST(FarmPlan, AStillIsOneTaskOrTheSharesOfItsSamples) {
  Plan plan = plan_of(0);
  ASSERT_EQ(tasks_of(plan).size(), 1u);
  plan.split = 4;
  plan.samples = 10;
  const std::vector<Task> tasks = tasks_of(plan);
  ASSERT_EQ(tasks.size(), 4u);
  EXPECT_EQ(tasks.back().samples_to, 10);
  EXPECT_TRUE(tasks.front().frames.empty());
}

TEST(FarmPlan, FramesAreTextAsTheCommandLineHasIt) {
  EXPECT_EQ(frames_text({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
  EXPECT_EQ(frames_text({5, 4, 3}), "5,4,3");
  EXPECT_EQ(frames_text({}), "");
  EXPECT_EQ(ranges_text({0, 1, 2, 40}), "0-2,40");
}

TEST_F(FarmFolder, APlanIsReadAsItWasWritten) {
  Plan plan = plan_of(24);
  plan.warm_cache = "/shot/hair.cache";
  plan.chunk = 5;
  plan.retries = 0;
  plan.options = {"--spp", "16", "with \"quotes\" and a space"};
  ASSERT_FALSE(write_plan(folder_, plan));
  const Result<Plan> read = read_plan(folder_);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(differences(plan, *read), "");
  EXPECT_EQ(read->retries, 0);
  Plan other = plan;
  other.chunk = 6;
  other.frames = {1};
  EXPECT_EQ(differences(plan, other), "frames: expected 1-24, found 1; chunk: expected 5, found 6");
}

TEST_F(FarmFolder, WhatIsNoPlanIsRefused) {
  EXPECT_FALSE(read_plan(folder_ / "nowhere"));
  ASSERT_FALSE(write_plan(folder_, plan_of(3)));
  std::ifstream in(folder_ / "farm.json");
  const std::string good((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / "farm.json") << text;
    EXPECT_FALSE(read_plan(folder_)) << to;
  };
  refused("\"chunk\": 1", "\"chunk\": 0");
  refused("\"chunk\": 1", "\"chunk\": 1.5");
  refused("\"split\": 0", "\"split\": 8");  // of no samples
  refused("\"split\": 0", "\"split\": -1");
  refused("\"tress_farm\": 1", "\"tress_farm\": 2");
  refused("\"frozen\": false", "\"frozen\": 0");
  refused("\"frames\": [", "\"frames\": [-1,");
  refused("\"options\": []", "\"options\": [1]");
  for (std::size_t length = 0; length + 2 < good.size(); length += 7) {
    std::ofstream(folder_ / "farm.json") << good.substr(0, length);
    EXPECT_FALSE(read_plan(folder_)) << length;
  }
}

TEST_F(FarmFolder, ATaskIsWhatItsFileSays) {
  const fs::path file = task_files(folder_, 3, false).state;
  EXPECT_EQ(read_state(file).phase, Phase::waiting);
  TaskState state;
  state.phase = Phase::interrupted;
  state.attempts = 2;
  state.status = 143;
  state.host = "node1";
  state.job = "12_3";
  ASSERT_FALSE(write_state(file, state));
  const TaskState read = read_state(file);
  EXPECT_EQ(read.phase, Phase::interrupted);
  EXPECT_EQ(read.attempts, 2);
  EXPECT_EQ(read.status, 143);
  EXPECT_EQ(read.host + read.job, "node112_3");
  EXPECT_FALSE(is_held(file));
  std::ofstream(file) << "{\"state\": \"done";
  EXPECT_EQ(read_state(file).phase, Phase::waiting) << "what cannot be read is not done";
}

TEST(FarmSlurm, WordsStayTogetherInTheShell) {
  EXPECT_EQ(shell_word("plain-1.exr"), "plain-1.exr");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("it's $HOME"), "'it'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(FarmSlurm, ArraysNameTheirTasksAndWhatTheyWaitFor) {
  SlurmOptions options;
  options.name = "shot";
  options.at_most = 16;
  options.extra = {"--partition=render"};
  const std::string array = shell_words(slurm_array_command("/farm", options, {0, 1, 2, 5}, {"7"}));
  for (const char* word :
       {"sbatch --parsable", "--array=0-2,5%16", "--dependency=afterok:7", "--kill-on-invalid-dep=yes", "--requeue",
        "--signal=B:USR1@120", "--partition=render", "/farm/slurm/task.sh"})
    EXPECT_NE(array.find(word), std::string::npos) << word << " in " << array;
  // slurm_max_array: numbers count from the offset, which the script adds again; Slurm does not read a % of the folder.
  const std::string rest = shell_words(slurm_array_command("/100%/a", options, {1000, 1002}, {}, 1000));
  for (const char* word : {"--array=0,2%16", "--output=/100%%/a/logs/%A_%a.log", "/100%/a/slurm/task.sh 1000"})
    EXPECT_NE(rest.find(word), std::string::npos) << word << " in " << rest;
  EXPECT_NE(slurm_task_script({}, "/farm").find("$((SLURM_ARRAY_TASK_ID + ${1:-0}))"), std::string::npos);
  const std::string merge = shell_words(slurm_merge_command("/farm", options, {"8", "9"}));
  EXPECT_NE(merge.find("--dependency=afterok:8:9"), std::string::npos) << merge;
}

}  // namespace
}  // namespace tress::farm
