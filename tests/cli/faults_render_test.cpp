// Full disks, folders and readers that go, closed streams, signals, want of memory: nothing that was saved is lost,
// nothing is half written, the reason is reported.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TRESS_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define TRESS_ADDRESS_SANITIZER
#endif

namespace tress::test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

class Faults : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 16, "height": 16, "samples": 2},
      "environment": {"constant": [1, 1, 1]},
      "materials": [{"name": "brown"}],
      "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}]
    })");
    fs::create_directory(path("out"));
  }

  std::vector<std::string> render(const std::string& picture, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"render", path("scene.json"), "-o", picture, "--threads", "2", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  /// `prepared`: what a shell does before it becomes the program, "$@"; "exec \"$@\" 2>&-".
  Outcome run_in_shell(const std::string& script, const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"-c", script, "sh", TRESS_BINARY};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return Process(folder_, words, "/bin/sh").wait();
  }
  std::vector<std::string> files(const fs::path& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  /// A render that would not end, once it has reported a pass.
  Process started(const std::string& picture, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = render(picture, more);
    arguments.insert(arguments.end(), {"--spp", "1000000", "--telemetry", path("run.jsonl")});
    Process process(folder_, arguments);
    for (int i = 0; i < 1200 && telemetry_lines(path("run.jsonl"), "pass").empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    return process;
  }
};

TEST_F(Faults, PathsThatOverflowAreLeftOutAndReportedAndThePictureIsSaved) {
  write_text(path("scene.json"), R"({
    "camera": {"frame": true},
    "image": {"width": 24, "height": 32, "samples": 4},
    "environment": {"constant": [1, 1, 1]},
    "materials": [{"name": "bright", "sigma_a": [0, 0, 0],
                   "gain": {"R": 100, "TT": 100, "TRT": 100, "TRRT": 100, "residual": 100}}],
    "grooms": [{"generate": "curly_lock", "strands": 1500, "radius_cm": 0.02, "material": "bright"}]
  })");
  const Outcome outcome = run(render(path("out/a.exr"), {"--telemetry", path("run.jsonl")}));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Result<image::Picture> picture = image::read_exr(path("out/a.exr"));  // refuses what is not finite
  ASSERT_TRUE(picture);
  std::uint64_t dropped = 0;
  for (const auto& pass : telemetry_lines(path("run.jsonl"), "pass")) {
    dropped += pass.at("dropped_samples").get<std::uint64_t>();
  }
  EXPECT_GT(dropped, 20u);
  EXPECT_LT(dropped, 24u * 32 * 4 / 2);
  const auto summary = telemetry_lines(path("run.jsonl"), "summary").at(0);
  EXPECT_EQ(summary.at("dropped_samples"), dropped);
  EXPECT_EQ(summary.at("status"), "done");
  EXPECT_EQ(picture->metadata.at("dropped_samples"), std::to_string(dropped));
  EXPECT_THAT(outcome.err, HasSubstr(std::to_string(dropped) + " samples were infinite"));
}

TEST_F(Faults, AReaderOfTelemetryThatGoesStopsTelemetryAlone) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const Outcome outcome = run_in_shell(
      "head -n 1 " + path("pipe") + " > /dev/null & exec \"$@\"",
      render(path("out/a.exr"), {"--telemetry", path("pipe"), "--warm-cache", path("out/t.cache"), "--spp", "64"}));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("telemetry stops: " + path("pipe")));
  EXPECT_TRUE(image::read_exr(path("out/a.exr")));
  EXPECT_EQ(run({"cache", "verify", path("out/t.cache")}).status, 0);
}

TEST_F(Faults, ClosedStreamsDoNotWriteIntoFiles) {
  const Outcome outcome = run_in_shell(
      "exec \"$@\" 0>&- 1>&- 2>&-",
      render(path("out/a.exr"), {"--telemetry", path("out/a.jsonl"), "--warm-cache", path("out/t.cache")}));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(telemetry_lines(path("out/a.jsonl"), "summary").size(), 1u);
  EXPECT_TRUE(image::read_exr(path("out/a.exr")));
  EXPECT_EQ(run({"cache", "verify", path("out/t.cache")}).status, 0);
}

TEST_F(Faults, ResultsThatFindNoRoomAreAnError) {
  ASSERT_EQ(run(render(path("out/a.exr"), {"--warm-cache", path("out/t.cache")})).status, 0);
  const std::vector<std::vector<std::string>> commands{{"cache", "info", path("out/t.cache")},
                                                       {"cache", "verify", path("out/t.cache"), "--json"},
                                                       {"diff", path("out/a.exr"), path("out/a.exr")},
                                                       {"help", "render"},
                                                       {"--version"}};
  for (const auto& command : commands) {
    for (const char* script : {"exec \"$@\" > /dev/full", "exec \"$@\" >&-"}) {
      const Outcome outcome = run_in_shell(script, command);
      EXPECT_EQ(outcome.status, 1) << command[0] << " " << script;
      EXPECT_THAT(outcome.err, HasSubstr("standard output: expected room for the results, found ")) << command[0];
    }
  }
}

TEST_F(Faults, AFullDiskLeavesTheOldFilesAndIsReported) {
  const std::vector<std::string> command = render(path("out/a.exr"), {"--warm-cache", path("out/t.cache"), "--heatmap",
                                                                      path("out/h.exr"), "--model", "elliptical"});
  ASSERT_EQ(run(command).status, 0);
  const std::vector<std::string> names = files(path("out"));
  std::vector<std::string> before;
  for (const std::string& name : names) before.push_back(read_text(path("out/" + name)));
  // 2 KB a file, messages too: less than any of them but the preview has.
  const Outcome outcome = run_in_shell("ulimit -f 4; exec \"$@\"", command);
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  for (const char* name : {"out/a.exr", "out/h.exr", "out/t.cache"}) {
    EXPECT_THAT(outcome.err, HasSubstr("error: " + path(name) + ": expected room for the file")) << name;
  }
  EXPECT_EQ(files(path("out")), names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "a.png") continue;  // has room, and is that of the second render
    EXPECT_EQ(read_text(path("out/" + names[i])), before[i]) << names[i];
  }
}

TEST_F(Faults, AnInterruptedRenderThatCannotSaveSaysSoAndIsNoSuccess) {
  const Process process = started(path("out/a.exr"), {"--warm-cache", path("out/t.cache")});
  fs::remove_all(path("out"));
  write_text(path("out"), "no folder any more");
  process.send(SIGINT);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("error: " + path("out/a.exr")));
  EXPECT_THAT(outcome.err, HasSubstr("error: " + path("out/t.cache")));
  EXPECT_EQ(telemetry_lines(path("run.jsonl"), "summary").at(0).at("status"), "failed");
  EXPECT_EQ(read_text(path("out")), "no folder any more");
  // Nothing that took hours is lost: the nearest folder that is there has it, and the message says so.
  EXPECT_THAT(outcome.err, HasSubstr(path("out/a.exr") + ": saved as " + path("a.exr") + " instead"));
  EXPECT_TRUE(image::read_exr(path("a.exr")));
  EXPECT_TRUE(fs::exists(path("a.png")));
  EXPECT_EQ(telemetry_lines(path("run.jsonl"), "summary").at(0).at("image"), path("a.exr"));
}

TEST_F(Faults, APictureThatIsSavedElsewhereReplacesNothingThere) {
  write_text(path("a.exr"), "another picture");
  write_text(path("a-1.exr"), "and another");
  const Process process = started(path("out/a.exr"), {});
  fs::remove_all(path("out"));
  process.send(SIGTERM);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_EQ(read_text(path("a.exr")), "another picture");
  EXPECT_EQ(read_text(path("a-1.exr")), "and another");
  EXPECT_TRUE(image::read_exr(path("a-2.exr"))) << outcome.err;
}

TEST_F(Faults, WhatAKilledRenderLeftIsRemovedAndLogged) {
  const fs::file_time_type hour_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
  const std::vector<std::string> left{"a.exr.tmp-12-0", "a.png.tmp-12-1", "h.exr.tmp-12-2", "t.cache.tmp-12-3"};
  for (const std::string& name : left) {
    write_text(path("out/" + name), "half");
    fs::last_write_time(path("out/" + name), hour_ago);
  }
  for (const char* mode : {"append", "scratch"}) {
    write_text(path("out/t.cache.tmp-12-3"), "half");
    fs::last_write_time(path("out/t.cache.tmp-12-3"), hour_ago);
    std::vector<std::string> arguments = render(
        path("out/a.exr"), {"--warm-cache", path("out/t.cache"), "--cache-mode", mode, "--heatmap", path("out/h.exr")});
    std::erase(arguments, "--quiet");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("removed " + path("out/t.cache.tmp-12-3"))) << mode;
    if (mode == std::string("append")) {
      for (const std::string& name : left) EXPECT_THAT(outcome.err, HasSubstr("removed " + path("out/" + name)));
    }
    EXPECT_EQ(files(path("out")), (std::vector<std::string>{"a.exr", "a.png", "h.exr", "t.cache"}));
  }
}

TEST_F(Faults, NamesThatAreTooLongAreFoundBeforeRendering) {
  const std::string stem(240, 'x');
  for (const std::vector<std::string>& command :
       {render(path("out/" + stem + "abcdefg.exr")),
        render(path("out/a.exr"), {"--warm-cache", path("out/" + stem + "abcdefg")})}) {
    std::vector<std::string> endless = command;
    endless.insert(endless.end(), {"--spp", "1000000"});
    const Outcome outcome = run(endless);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.err, HasSubstr("name that leaves room"));
  }
  EXPECT_TRUE(files(path("out")).empty());
}

TEST_F(Faults, NamesWithLinesAndOtherAlphabetsAreNames) {
  const std::string name = "out/\xc3\xa4 \xe9\xab\xaa\n'\xff";
  const Outcome outcome =
      run(render(path(name + ".exr"), {"--warm-cache", path(name + ".cache"), "--telemetry", path(name + ".jsonl")}));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(image::read_exr(path(name + ".exr")));
  EXPECT_EQ(run({"cache", "verify", path(name + ".cache")}).status, 0);
  EXPECT_EQ(telemetry_lines(path(name + ".jsonl"), "summary").size(), 1u);
}

#ifndef TRESS_ADDRESS_SANITIZER  // which needs more address space than that
// From too little for Embree to begin with to enough: a reason and status 1, or a picture; never a signal.
TEST_F(Faults, WantOfMemoryIsReportedAndLosesNothing) {
  const std::vector<std::string> command =
      render(path("out/a.exr"), {"--warm-cache", path("out/t.cache"), "--telemetry", path("a.jsonl")});
  ASSERT_EQ(run(command).status, 0);
  const std::string cache = read_text(path("out/t.cache")), picture = read_text(path("out/a.exr"));
  int reported = 0;
  for (const int megabytes : {80, 120, 180, 240, 280}) {
    const Outcome outcome = run_in_shell("ulimit -v " + std::to_string(megabytes * 1000) + "; exec \"$@\"", command);
    if (outcome.status == 127) continue;  // the loader found no room for the libraries
    ASSERT_TRUE(outcome.status == 0 || outcome.status == 1) << megabytes << " MB: " << outcome.status << outcome.err;
    if (outcome.status == 0) continue;
    ++reported;
    // oneTBB has its own words for a thread without room for its stack.
    EXPECT_THAT(outcome.err, AnyOf(HasSubstr("memory"), HasSubstr("pthread_create"))) << megabytes;
    EXPECT_EQ(read_text(path("out/t.cache")), cache);
    EXPECT_EQ(read_text(path("out/a.exr")), picture);
  }
  EXPECT_GT(reported, 0);
}
#endif

}  // namespace
}  // namespace tress::test
