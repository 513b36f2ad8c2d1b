// Renders that are killed and go on end as those that were not: picture, cache and telemetry. What cannot be equal is
// named: `time` of the picture, and `seconds`, `cpu_seconds`, `deeper_cpu_seconds`, `learning_cpu_seconds` of
// telemetry.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "support/seed.h"
#include "tress/base/random.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

void expect_same_pictures(const fs::path& a, const fs::path& b) {
  auto one = image::read_exr(a), other = image::read_exr(b);
  ASSERT_TRUE(one && other);
  for (image::Picture* picture : {&*one, &*other}) {
    for (const char* name : {"time", "command"}) picture->metadata.erase(name);
    nlohmann::json settings = nlohmann::json::parse(picture->metadata["settings"]);
    settings.erase("--warm-cache");  // each has a file of its own
    picture->metadata["settings"] = settings.dump();
  }
  EXPECT_EQ(one->metadata, other->metadata);
  ASSERT_EQ(one->channels.size(), other->channels.size());
  for (std::size_t c = 0; c < one->channels.size(); ++c) {
    EXPECT_EQ(one->channels[c].name, other->channels[c].name);
    EXPECT_TRUE(one->channels[c].pixels == other->channels[c].pixels) << one->channels[c].name;
  }
}

/// Without what no two runs have alike, and without the names of files.
std::string comparable_telemetry(const fs::path& file) {
  std::istringstream lines(read_text(file));
  std::string line, text;
  while (std::getline(lines, line)) {
    nlohmann::json fields = nlohmann::json::parse(line);
    for (const char* name :
         {"seconds", "cpu_seconds", "deeper_cpu_seconds", "learning_cpu_seconds", "image", "warm_cache"})
      fields.erase(name);
    text += fields.dump() + "\n";
  }
  return text;
}

/// All layers, those that are there only if asked for among them.
const std::string data_layers = "all,P,strand_uv,strand_place,strand_id,CryptoStrand";

class Checkpoints : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), R"({
      "camera": {"frame": true},
      "image": {"width": 64, "height": 64, "samples": 24},
      "environment": {"constant": [1, 0.9, 0.8]},
      "materials": [{"name": "brown"}],
      "grooms": [{"generate": "straight", "strands": 300, "radius_cm": 0.04, "material": "brown"}]
    })");
  }
  std::vector<std::string> command(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render",       path("scene.json"),
                                   "-o",           path(name + ".exr"),
                                   "--warm-cache", path(name + ".cache"),
                                   "--telemetry",  path(name + ".jsonl"),
                                   "--threads",    "2",
                                   "--precision",  "float"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void expect_same(const std::string& a, const std::string& b) const {
    expect_same_pictures(path(a + ".exr"), path(b + ".exr"));
    EXPECT_TRUE(read_text(path(a + ".cache")) == read_text(path(b + ".cache"))) << "the caches differ";
    EXPECT_EQ(comparable_telemetry(path(a + ".jsonl")), comparable_telemetry(path(b + ".jsonl")));
    EXPECT_FALSE(fs::exists(path(b + ".checkpoint"))) << "it is done";
  }
  /// Waits for the render's second pass, at most a minute.
  static void wait_for_pass(const fs::path& telemetry) {
    for (int tries = 0; tries < 12000; ++tries) {
      if (fs::exists(telemetry) && telemetry_lines(telemetry, "pass").size() >= 2) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  /// Kills the command so many times, then lets it end. Returns how often it went on. The first kill comes with the
  /// second pass, before any render of many passes can end; each later one after a share of the time that the whole
  /// render took. A render that is killed without a checkpoint was done.
  int survive(const std::string& name, const std::vector<std::string>& words, int kills, int signal,
              std::chrono::duration<double> whole, std::uint64_t stream) const {
    const fs::path telemetry = path(name + ".jsonl");
    RandomStream random(seed(2026), stream);
    int resumed = 0;
    for (int kill = 0; kill <= kills; ++kill) {
      const Process process(folder_, words);
      if (kill < kills) {
        if (kill == 0) {
          wait_for_pass(telemetry);
        } else {
          std::this_thread::sleep_for(random.next() * whole);
        }
        process.send(signal);
      }
      const Outcome outcome = process.wait();
      resumed += outcome.err.find("goes on after") != std::string::npos ? 1 : 0;
      if (outcome.status == 0) break;
      EXPECT_EQ(outcome.status, 128 + signal) << outcome.err;
      if (!fs::exists(path(name + ".checkpoint"))) break;
    }
    return resumed;
  }
};

TEST_F(Checkpoints, KilledRendersEndAsIfTheyHadNotBeen) {
  int resumed = 0;
  const std::vector<std::pair<std::string, std::vector<std::string>>> ways{
      {"elliptical", {"--model", "elliptical"}}, {"rough", {}}, {"near", {"--near", "touching", "--spectral"}}};
  for (const auto& [way, options] : ways) {
    SCOPED_TRACE(way);
    std::vector<std::string> more{"--telemetry-level", "rows", "--spp", "48"};
    more.insert(more.end(), options.begin(), options.end());
    const auto start = std::chrono::steady_clock::now();
    const Outcome whole = run(command("whole-" + way, more));
    const auto time = std::chrono::steady_clock::now() - start;
    ASSERT_EQ(whole.status, 0) << whole.err;
    auto words = command("killed-" + way, more);
    words.insert(words.end(), {"--checkpoint", "--checkpoint-interval", "0"});
    resumed += survive("killed-" + way, words, 5, SIGKILL, time, way.size());
    expect_same("whole-" + way, "killed-" + way);
  }
  EXPECT_GT(resumed, 0) << "no run was killed after a checkpoint";
}

TEST_F(Checkpoints, ASignalWritesOneInTime) {
  const std::vector<std::string> more{"--spp", "96", "--layers", data_layers};
  const auto start = std::chrono::steady_clock::now();
  const Outcome whole = run(command("whole", more));
  const auto time = std::chrono::steady_clock::now() - start;
  ASSERT_EQ(whole.status, 0) << whole.err;
  auto words = command("asked", more);
  words.insert(words.end(), {"--checkpoint", "--checkpoint-interval", "100000"});
  EXPECT_GT(survive("asked", words, 2, SIGTERM, time, 1), 0);
  expect_same("whole", "asked");
}

std::size_t times(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

/// While it lives, no file of this process and of those that it starts may grow past so many bytes.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : ignored_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit less{bytes, before_.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &less), 0);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, ignored_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*ignored_)(int);
  rlimit before_{};
};

// The sums of 256 x 256 pixels are 30 MB, packed 0.5 MB after the first pass and more later; each file at the end is
// less than 0.2 MB. So the first save fails already. It takes milliseconds, and the next is tried after a hundred times
// that.
TEST_F(Checkpoints, ThatFindNoRoomAreReportedOnceAndTheRenderEndsAsWithoutThem) {
  const std::vector<std::string> more{"--resolution", "256x256", "--spp",   "4",
                                      "--layers",     "beauty",  "--model", "elliptical"};
  const Outcome whole = run(command("whole", more));
  ASSERT_EQ(whole.status, 0) << whole.err;
  auto words = command("full", more);
  words.insert(words.end(), {"--checkpoint", "--checkpoint-interval", "0"});
  Outcome full;
  {
    const FullDisk disk(250000);
    full = run(words);
  }
  EXPECT_EQ(full.status, 0) << full.err;
  EXPECT_EQ(times(full.err, "checkpoint: not written"), 1u) << full.err;
  EXPECT_THAT(full.err, HasSubstr("File too large"));
  expect_same("whole", "full");
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".tmp-"))) << "nothing is left";
}

TEST_F(Checkpoints, WhoseFolderGoesAreReportedOnceAndTheRenderEndsAsWithoutThem) {
  const std::vector<std::string> more{"--resolution", "32x32", "--spp", "2400"};
  const Outcome whole = run(command("whole", more));
  ASSERT_EQ(whole.status, 0) << whole.err;
  fs::create_directory(path("there"));
  auto words = command("lost", more);
  words.insert(words.end(), {"--checkpoint", path("there/c.checkpoint"), "--checkpoint-interval", "0"});
  const Process process(folder_, words);
  for (int tries = 0; tries < 3000 && !(fs::exists(path("there/c.checkpoint")) && fs::exists(path("lost.exr")));
       ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto partial = image::read_exr(path("lost.exr"));
  ASSERT_TRUE(partial) << partial.error().message();
  EXPECT_EQ(partial->metadata.at("stopped_by"), "checkpoint");
  EXPECT_EQ(partial->channels.size(), 4u) << "of beauty alone";
  fs::rename(path("there"), path("gone"));
  const Outcome lost = process.wait();
  EXPECT_EQ(lost.status, 0) << lost.err;
  EXPECT_EQ(times(lost.err, "checkpoint: not written"), 1u) << lost.err;
  expect_same("whole", "lost");
}

/// However large the sums are: a render that is killed early has lost no more than the interval.
TEST_F(Checkpoints, TheFirstComesWithTheInterval) {
  const Outcome outcome = run({"render", path("scene.json"), "-o", path("a.exr"), "--resolution", "512x512", "--spp",
                               "1", "--checkpoint", "--checkpoint-interval", "0", "--layers", "beauty"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("passes, saved in "));
}

TEST_F(Checkpoints, OfAnotherRenderOrDamagedAreRefusedByName) {
  auto words = command("a", {"--spp", "4096", "--checkpoint"});
  {
    const Process process(folder_, words);
    wait_for_pass(path("a.jsonl"));
    process.send(SIGTERM);
    EXPECT_EQ(process.wait().status, 143);
  }
  ASSERT_TRUE(fs::exists(path("a.checkpoint")));
  const std::string good = read_text(path("a.checkpoint"));
  auto other = words;
  other.insert(other.end(), {"--epsilon", "0.02"});
  Outcome refused = run(other);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("--epsilon: expected 0.02, found nothing"));
  std::string scene = read_text(path("scene.json"));
  const std::string changed = scene.substr(0, scene.find("0.9")) + "0.7" + scene.substr(scene.find("0.9") + 3);
  write_text(path("scene.json"), changed);
  refused = run(words);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("/environment/constant/1: expected 0.7, found 0.9"));
  write_text(path("scene.json"), scene);
  for (const std::string& bad : {good.substr(0, good.size() / 2), good + "x", std::string("not one"), std::string()}) {
    write_text(path("a.checkpoint"), bad);
    refused = run(words);
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.err, HasSubstr("a.checkpoint"));
    EXPECT_EQ(read_text(path("a.checkpoint")), bad) << "it is left as it is";
  }
}

TEST_F(Checkpoints, FramesAreSkippedWhereTheyAreFinished) {
  const auto frames = [&](const std::string& list, const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "render",      path("scene.json"),   "-o",           path("f.####.exr"),  "--frames", list, "--spp", "2",
        "--telemetry", path("frames.jsonl"), "--warm-cache", path("frames.cache")};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  const Outcome first = frames("1-3x2", {});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("2 frames: 2 rendered, 0 finished before, 0 failed"));
  EXPECT_THAT(first.err, HasSubstr("from the frame before"));
  write_text(path("f.0003.exr"), read_text(path("f.0003.exr")).substr(0, 2000));
  const Outcome second = frames("1-3", {});
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.err, HasSubstr("3 frames: 2 rendered, 1 finished before, 0 failed"));
  const Outcome other = frames("1-3", {"--max-depth", "3"});
  EXPECT_THAT(other.err, HasSubstr("3 frames: 3 rendered, 0 finished before"));
  const std::string lines = read_text(path("frames.jsonl"));
  for (const char* frame : {"\"frame\":1", "\"frame\":2", "\"frame\":3"}) EXPECT_THAT(lines, HasSubstr(frame));
  EXPECT_THAT(frames("1-3", {"--set", "integrator/max_depth=3"}).err, HasSubstr("3 finished before")) << "the same key";
  EXPECT_EQ(run({"render", path("scene.json"), "-o", path("f.exr"), "--frames", "1-3"}).status, 2);
}

TEST_F(Checkpoints, PartsOfOneFrozenTableAreThePictureOfOneRender) {
  ASSERT_EQ(run({"render", path("scene.json"), "-o", path("warm.exr"), "--spp", "8", "--warm-cache", path("c")}).status,
            0);
  const auto part = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words{"render",       path("scene.json"), "-o",           path(name + ".exr"),
                                   "--warm-cache", path("c"),          "--cache-mode", "frozen",
                                   "--layers",     "Z,TT,half",        "--spp",        "6",
                                   "--part",       path(name),         "--threads",    "2"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  };
  part("whole", {});
  part("a", {"--samples-to", "2"});
  part("b", {"--samples-from", "2"});
  part("left", {"--crop", "0,0,30,64"});
  part("right", {"--crop", "30,0,64,64"});
  const std::vector<std::vector<std::string>> ways{{path("b"), path("a")}, {path("left"), path("right")}};
  for (const std::vector<std::string>& way : ways) {
    const Outcome merged = run({"merge", way[0], way[1], "-o", path("merged.exr")});
    ASSERT_EQ(merged.status, 0) << merged.err;
    EXPECT_THAT(merged.err, HasSubstr("the picture of one render"));
    const auto whole = image::read_exr(path("whole.exr")), all = image::read_exr(path("merged.exr"));
    ASSERT_TRUE(whole && all);
    for (const char* name : {"R", "G", "B", "A", "TT.R", "TT.G", "TT.B", "half_a.R", "half_b.G"}) {
      ASSERT_NE(whole->find(name), nullptr) << name;
      ASSERT_NE(all->find(name), nullptr) << name;
      EXPECT_TRUE(whole->find(name)->pixels == all->find(name)->pixels) << name;
    }
    EXPECT_NE(all->find("half_b_variance.B"), nullptr);
  }
  for (const std::string one : {"whole", "a"}) {
    const auto picture = image::read_exr(path(one == "a" ? "merged.exr" : "whole.exr"));
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->find("CryptoObject00.R"), nullptr) << "not among --layers, which a merge keeps to";
  }
  Outcome refused = run({"merge", path("a"), path("whole"), "-o", path("no.exr")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("samples 0 to 6 of pixels of both"));
  part("other", {"--samples-from", "2", "--max-depth", "9"});
  refused = run({"merge", path("a"), path("other"), "-o", path("no.exr")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("/integrator/max_depth: expected nothing, found 9"));
  EXPECT_FALSE(fs::exists(path("no.exr")));
}

// Three grooms that cross, so that pixels have several objects, of two materials.
TEST_F(Checkpoints, MergedPicturesHaveMattesAndHeaderOfOneRender) {
  write_text(path("scene.json"), R"({
    "camera": {"frame": true},
    "image": {"width": 24, "height": 24, "samples": 6, "exposure": 1},
    "environment": {"constant": [1, 0.9, 0.8]},
    "materials": [{"name": "brown"}, {"name": "blond", "sigma_a": [0.1, 0.2, 0.4]}],
    "grooms": [{"name": "left", "generate": "straight", "strands": 60, "radius_cm": 0.04, "material": "brown"},
               {"name": "na\u00efve", "generate": "curly", "strands": 60, "radius_cm": 0.04, "material": "blond"},
               {"name": "right", "generate": "curly", "strands": 30, "radius_cm": 0.04, "material": "brown"}]
  })");
  ASSERT_EQ(
      run({"render", path("scene.json"), "-o", path("warm.exr"), "--warm-cache", path("c"), "--model", "elliptical"})
          .status,
      0);
  const auto part = [&](const std::string& name, const std::vector<std::string>& more,
                        const std::string& layers = data_layers) {
    std::vector<std::string> words{"render",       path("scene.json"),
                                   "-o",           path(name + ".exr"),
                                   "--warm-cache", path("c"),
                                   "--cache-mode", "frozen",
                                   "--part",       path(name + ".part"),
                                   "--model",      "elliptical",
                                   "--layers",     layers};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  };
  part("whole", {});
  part("a", {"--samples-to", "2"});
  part("b", {"--samples-from", "2", "--samples-to", "3"});
  part("c3", {"--samples-from", "3"});
  part("left", {"--crop", "0,0,11,24"});
  part("right", {"--crop", "11,0,24,24"});
  const auto whole = image::read_exr(path("whole.exr"));
  ASSERT_TRUE(whole);
  const std::vector<std::vector<std::string>> ways{{"c3", "a", "b"}, {"right", "left"}};
  for (const std::vector<std::string>& way : ways) {
    std::vector<std::string> words{"merge", "-o", path("merged.exr")};
    for (const std::string& name : way) words.push_back(path(name + ".part"));
    const Outcome merged = run(words);
    ASSERT_EQ(merged.status, 0) << merged.err;
    const auto all = image::read_exr(path("merged.exr"));
    ASSERT_TRUE(all);
    ASSERT_EQ(all->channels.size(), whole->channels.size());
    std::size_t shared = 0;
    for (const image::Channel& channel : whole->channels) {
      ASSERT_NE(all->find(channel.name), nullptr) << channel.name;
      // Sums of doubles in another order may differ in their last bits, which a float shows once in some 10^8 values.
      EXPECT_TRUE(all->find(channel.name)->pixels == channel.pixels) << channel.name;
      if (channel.name == "CryptoObject00.A")
        shared = static_cast<std::size_t>(std::ranges::count_if(channel.pixels, [](float x) { return x > 0; }));
    }
    EXPECT_GT(shared, 20u) << "pixels with two objects";
    std::map<std::string, std::string> one = whole->metadata, other = all->metadata;
    // The estimate is of the paths that each part had chosen by its own brightness: another one of the same bias.
    EXPECT_TRUE(one.contains("bias_estimate") && other.contains("bias_estimate"));
    // The noise of parts is that of their samples; a render's has what light they may not have met besides.
    EXPECT_LE(std::stod(other["noise"]), std::stod(one["noise"]));
    for (const char* name : {"command", "time", "parts", "settings", "bias_estimate", "noise"}) {
      one.erase(name);
      other.erase(name);
    }
    for (const auto& [name, value] : one) EXPECT_EQ(value, other[name]) << name;
    EXPECT_EQ(one.size(), other.size());
    EXPECT_EQ(whole->matrices, all->matrices);
    EXPECT_EQ(whole->screen_width, all->screen_width);
    EXPECT_EQ(read_text(path("whole.png")), read_text(path("merged.png")));
  }
  for (const char* name : {"P.X", "strand_uv.v", "strand_place", "strand_id", "CryptoStrand05.A"})
    EXPECT_NE(whole->find(name), nullptr) << name;
  part("none", {"--samples-from", "2"}, "beauty");
  const Outcome refused = run({"merge", path("a.part"), path("none.part"), "-o", path("no.exr")});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("--layers: expected " + data_layers + ", found beauty"));
}

}  // namespace
}  // namespace tress::test
