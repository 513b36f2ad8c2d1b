// tress render: cold and warm, one thread and eight, and what happens to the files when something goes wrong.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* small_scene = R"({
  "camera": {"frame": true},
  "image": {"width": 40, "height": 40, "samples": 8},
  "environment": {"constant": [1, 1, 1]},
  "materials": [{"name": "brown"}],
  "grooms": [{"generate": "straight", "strands": 1500, "radius_cm": 0.02, "material": "brown"}]
})";

class Render : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write_text(path("scene.json"), small_scene);
  }

  Outcome render(const std::string& picture, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"render", path("scene.json"), "-o", path(picture)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  void render_well(const std::string& picture, const std::vector<std::string>& more = {}) const {
    const Outcome outcome = render(picture, more);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, IsEmpty());
  }

  void expect_same_picture(const std::string& a, const std::string& b) const {
    const Outcome outcome = run({"diff", path(a), path(b), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(outcome.out).at("identical"), true) << a << " " << b << " " << outcome.out;
  }

  nlohmann::json summary(const std::string& telemetry) const {
    const auto lines = telemetry_lines(path(telemetry), "summary");
    EXPECT_EQ(lines.size(), 1u);
    return lines.empty() ? nlohmann::json::object() : lines[0];
  }

  /// Slices of `cache info --json`, by state of their rows.
  std::uint64_t rows(const std::string& cache, const char* state) const {
    const Outcome outcome = run({"cache", "info", path(cache), "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::uint64_t sum = 0;
    const nlohmann::json info = nlohmann::json::parse(outcome.out, nullptr, false);
    if (info.is_discarded()) return 0;
    for (const auto& slice : info.at("pages")) sum += slice.at("rows").at(state).get<std::uint64_t>();
    return sum;
  }
};

TEST_F(Render, AWarmStartConvergesEarlierThanAColdOne) {
  render_well("cold.exr", {"--warm-cache", path("t.cache"), "--telemetry", path("cold.jsonl")});
  const Outcome warm = render("warm.exr", {"--warm-cache", path("t.cache"), "--telemetry", path("warm.jsonl")});
  ASSERT_EQ(warm.status, 0) << warm.err;
  EXPECT_THAT(warm.err, HasSubstr("t.cache: loaded "));
  EXPECT_THAT(warm.err, HasSubstr("1 page for 1 fiber"));

  const auto cold_passes = telemetry_lines(path("cold.jsonl"), "pass");
  const auto warm_passes = telemetry_lines(path("warm.jsonl"), "pass");
  ASSERT_EQ(cold_passes.size(), 11u);  // four parts of sample 0, then seven whole samples
  ASSERT_EQ(warm_passes.size(), 11u);
  EXPECT_EQ(cold_passes[0].at("converged_query_share"), 0.0);
  EXPECT_GT(warm_passes[0].at("answered_query_share"), 0.5);
  for (std::size_t i = 0; i < cold_passes.size(); ++i) {
    EXPECT_EQ(cold_passes[i].at("pass"), i);
    for (const char* name : {"pixels", "samples", "seconds"}) EXPECT_TRUE(cold_passes[i].contains(name)) << name;
  }
  EXPECT_EQ(cold_passes.back().at("samples"), 40 * 40 * 8);
  EXPECT_EQ(telemetry_lines(path("warm.jsonl"), "header").at(0).at("warm_cache").at("loaded"), "loaded");
  EXPECT_EQ(summary("cold.jsonl").at("warm_cache").at("loaded"), "absent");
  EXPECT_EQ(summary("warm.jsonl").at("status"), "done");

  const auto picture = image::read_exr(path("warm.exr"));
  ASSERT_TRUE(picture) << picture.error().message();
  for (const char* name : {"scene", "seed", "samples", "time", "model", "estimator", "epsilon", "cache_hash", "command",
                           "version", "camera", "noise", "alpha"}) {
    EXPECT_TRUE(picture->metadata.contains(name)) << name;
  }
  for (const char* name : {"worldToCamera", "worldToNDC"}) EXPECT_TRUE(picture->matrices.contains(name)) << name;
  EXPECT_TRUE(fs::exists(path("warm.png")));
  EXPECT_EQ(run({"cache", "verify", path("t.cache")}).status, 0);
  // The coarsest grid has 36 nodes, and some finer ones have light enough: 45 to 53 rows over nine seeds.
  EXPECT_GT(rows("t.cache", "converged"), 36u);
}

TEST_F(Render, TheSameBitsForAnyNumberOfThreads) {
  for (const std::string threads : {"1", "8"}) {
    render_well("rough" + threads + ".exr", {"--threads", threads, "--warm-cache", path("rough" + threads + ".cache")});
    expect_same_picture("rough" + threads + ".exr", "rough1.exr");
    EXPECT_EQ(read_text(path("rough" + threads + ".cache")), read_text(path("rough1.cache")));
  }
  // First with room for all rows, then with about half of what they need, so that the ceiling binds.
  std::string memory = "256";
  for (const std::string table : {"whole", "half"}) {
    for (const std::string threads : {"1", "2", "8", "16"}) {
      const std::string name = table + threads;
      render_well(name + ".exr", {"--threads", threads, "--warm-cache", path(name + ".cache"), "--telemetry",
                                  path(name + ".jsonl"), "--table-memory", memory, "--model", "elliptical"});
      expect_same_picture(name + ".exr", table + "1.exr");
      EXPECT_EQ(read_text(path(name + ".cache")), read_text(path(table + "1.cache"))) << name;
    }
    const auto last = telemetry_lines(path(table + "1.jsonl"), "pass").back();
    EXPECT_EQ(last.at("at_ceiling"), table == "half") << last;
    std::uint64_t demand = 0;
    for (const auto& pass : telemetry_lines(path(table + "1.jsonl"), "pass")) {
      demand = std::max(demand, pass.at("bytes").get<std::uint64_t>());
    }
    memory = std::to_string(0.5 * double(demand) / double(1 << 20));
  }
}

TEST_F(Render, EachCacheModeDoesWhatItSays) {
  const std::string cache = path("t.cache");
  const Outcome required = render("a.exr", {"--warm-cache", cache, "--cache-mode", "require"});
  EXPECT_EQ(required.status, 1);
  EXPECT_THAT(required.err, HasSubstr("t.cache"));
  EXPECT_FALSE(fs::exists(path("a.exr")));

  render_well("a.exr", {"--warm-cache", cache, "--cache-mode", "frozen", "--spp", "2"});
  EXPECT_FALSE(fs::exists(cache)) << "frozen must not save";

  render_well("a.exr", {"--warm-cache", cache});
  const std::string first = read_text(cache);
  const std::uint64_t converged = rows("t.cache", "converged");
  render_well("b.exr", {"--warm-cache", cache, "--cache-mode", "frozen", "--seed", "1", "--quiet"});
  EXPECT_EQ(read_text(cache), first) << "frozen must not save";

  const Outcome again = render("c.exr", {"--warm-cache", cache, "--cache-mode", "require", "--seed", "2", "--quiet"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(again.err, "") << "a load and a save that went well change nothing: silence under --quiet";
  EXPECT_GE(rows("t.cache", "converged"), converged);

  // Scratch forgets what was there: as if the file had never been.
  render_well("d.exr", {"--warm-cache", cache, "--cache-mode", "scratch", "--telemetry", path("d.jsonl")});
  EXPECT_EQ(read_text(cache), first);
  expect_same_picture("a.exr", "d.exr");
  EXPECT_EQ(summary("d.jsonl").at("warm_cache").at("saved"), "saved");
}

TEST_F(Render, ATruncatedCacheIsReportedLeftAloneAndRenderedWithout) {
  const std::string cache = path("t.cache");
  render_well("cold.exr", {"--warm-cache", cache});
  const std::string broken = read_text(cache).substr(0, fs::file_size(cache) - 5);
  write_text(cache, broken);
  const Outcome outcome = render("again.exr", {"--warm-cache", cache, "--telemetry", path("again.jsonl"), "--quiet"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("t.cache: refused, starting cold"));
  EXPECT_THAT(outcome.err, HasSubstr("expected"));
  EXPECT_EQ(read_text(cache), broken);
  expect_same_picture("cold.exr", "again.exr");
  EXPECT_EQ(summary("again.jsonl").at("warm_cache").at("loaded"), "refused");
  EXPECT_EQ(run({"cache", "verify", cache}).status, 1);
  EXPECT_EQ(render("c.exr", {"--warm-cache", cache, "--cache-mode", "require"}).status, 1);
  EXPECT_FALSE(fs::exists(path("c.exr")));
}

TEST_F(Render, ASignalEndsItWithPictureCacheAndTelemetrySaved) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const std::string telemetry = path("run.jsonl");
    fs::remove(telemetry);
    const Process process(folder_, {"render", path("scene.json"), "-o", path("run.exr"), "--spp", "1000000",
                                    "--warm-cache", path("run.cache"), "--telemetry", telemetry});
    // Until it is well into rendering; a minute is far more than it needs.
    for (int i = 0; i < 1200 && telemetry_lines(telemetry, "pass").size() < 8; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    process.send(signal);
    const Outcome outcome = process.wait();
    EXPECT_EQ(outcome.status, 128 + signal) << outcome.err;
    EXPECT_TRUE(image::read_exr(path("run.exr")));
    EXPECT_EQ(run({"cache", "verify", path("run.cache")}).status, 0);
    EXPECT_GT(rows("run.cache", "converged") + rows("run.cache", "open"), 0u);
    EXPECT_EQ(summary("run.jsonl").at("status"), "interrupted");
    fs::remove(path("run.exr"));
  }
}

TEST_F(Render, GoesOnWithoutItsTerminalUnderNohup) {
  const std::string telemetry = path("run.jsonl");
  const Process process(folder_,
                        {"-c", "trap '' HUP; exec \"$@\"", "sh", TRESS_BINARY, "render", path("scene.json"), "-o",
                         path("run.exr"), "--spp", "32", "--telemetry", telemetry},
                        "/bin/sh");
  for (int i = 0; i < 1200 && telemetry_lines(telemetry, "pass").empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  process.send(SIGHUP);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(summary("run.jsonl").at("status"), "done");
}

TEST_F(Render, ExactNeedsNoTableAndAgreesWithFitted) {
  render_well("exact.exr", {"--model", "elliptical", "--estimator", "exact", "--telemetry", path("exact.jsonl")});
  render_well("short.exr", {"--model", "exact"});
  expect_same_picture("exact.exr", "short.exr");
  EXPECT_EQ(telemetry_lines(path("exact.jsonl"), "header").at(0).at("estimator"), "exact");
  render_well("fitted.exr", {"--model", "elliptical"});
  const Outcome outcome = run({"diff", path("exact.exr"), path("fitted.exr"), "--json"});
  const nlohmann::json difference = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(difference.at("identical"), false);
  // 40 x 40 x 8 paths under a constant light of 1: a path's standard deviation is below 1, so the mean of each picture
  // has one below 1/sqrt(12800) = 0.009, the difference of two 0.0125; six of those never fail for chance.
  for (const double bias : difference.at("bias")) EXPECT_LT(std::abs(bias), 0.075);
}

TEST_F(Render, ACropOfExactOrOfAFrozenTableHasTheWholePicturesPixels) {
  const std::vector<std::string> crop{"--crop", "9,3,30,24"};
  const auto with_crop = [&](std::vector<std::string> more) {
    more.insert(more.end(), crop.begin(), crop.end());
    return more;
  };
  const std::vector<std::string> exact{"--model", "elliptical", "--estimator", "exact", "--spp", "3"};
  render_well("exact.exr", exact);
  render_well("exact_crop.exr", with_crop(exact));
  expect_same_picture("exact.exr", "exact_crop.exr");
  const auto part = image::read_exr(path("exact_crop.exr"));
  ASSERT_TRUE(part);
  EXPECT_EQ(part->window(), (image::Window{9, 3, 21, 21}));
  EXPECT_EQ(part->whole(), (image::Window{0, 0, 40, 40}));

  // A table that is loaded and frozen learns nothing, so that open rows answer the same whatever else is rendered.
  render_well("learn.exr", {"--warm-cache", path("t.cache"), "--spp", "3", "--model", "elliptical"});
  EXPECT_GT(rows("t.cache", "open"), 0u);
  EXPECT_GT(rows("t.cache", "converged"), 0u);
  const std::vector<std::string> frozen{"--warm-cache", path("t.cache"), "--cache-mode", "frozen", "--seed", "5",
                                        "--model",      "elliptical"};
  render_well("frozen.exr", frozen);
  render_well("frozen_crop.exr", with_crop(frozen));
  expect_same_picture("frozen.exr", "frozen_crop.exr");

  // A table that learns has learned less: the same in the mean, not in the bits.
  render_well("cold.exr", {"--spp", "12"});
  render_well("cold_crop.exr", with_crop({"--spp", "12"}));
  const auto json = nlohmann::json::parse(run({"diff", path("cold.exr"), path("cold_crop.exr"), "--json"}).out);
  EXPECT_EQ(json.at("identical"), false);
  // 441 pixels of 12 paths each, a path's standard deviation below 1: 0.014 each way at most, 0.02 between; six of
  // those.
  for (const double bias : json.at("bias")) EXPECT_LT(std::abs(bias), 0.12);

  const Outcome outside = render("a.exr", {"--crop", "0,0,41,40"});
  EXPECT_EQ(outside.status, 2);
  EXPECT_THAT(outside.err, HasSubstr("within 40 x 40"));
}

/// The seed is the frame unless it is given; what it was is in the header, with the command that a shell takes.
TEST_F(Render, FramesHaveGrainOfTheirOwnUnlessTheSeedIsGiven) {
  const std::vector<std::string> few{"--spp", "1", "--resolution", "12x12", "--quiet"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), few.begin(), few.end());
    return more;
  };
  render_well("still.exr", with({}));
  render_well("f0.exr", with({"--frame", "0"}));
  render_well("f7.exr", with({"--frame", "7"}));
  render_well("seed7.exr", with({"--seed", "7"}));
  render_well("f7 fixed.exr", with({"--frame", "7", "--seed", "0"}));
  expect_same_picture("still.exr", "f0.exr");
  expect_same_picture("f7.exr", "seed7.exr");
  expect_same_picture("still.exr", "f7 fixed.exr");
  EXPECT_EQ(nlohmann::json::parse(run({"diff", path("f0.exr"), path("f7.exr"), "--json"}).out).at("identical"), false);
  const auto header = image::read_exr(path("f7 fixed.exr"))->metadata;
  EXPECT_EQ(header.at("frame"), "7");
  EXPECT_EQ(header.at("seed"), "0");
  EXPECT_EQ(nlohmann::json::parse(header.at("camera")).at("eye").size(), 3u);
  EXPECT_THAT(header.at("command"), HasSubstr(path("f7 fixed.exr") + "' --frame 7 --seed 0 --spp 1"));
}

/// Each half has half of the paths: R, G, B are their mean.
void expect_mean_of_halves(const image::Picture& picture) {
  double apart = 0;
  for (const std::string c : {"R", "G", "B"}) {
    for (std::size_t i = 0; i < picture.find(c)->pixels.size(); ++i) {
      const float beauty = picture.find(c)->pixels[i], a = picture.find("half_a." + c)->pixels[i],
                  b = picture.find("half_b." + c)->pixels[i];
      EXPECT_NEAR(0.5f * (a + b), beauty, 1e-5f * std::abs(beauty)) << c << " of pixel " << i;
      apart += std::abs(a - b);
    }
  }
  EXPECT_GT(apart, 0);
}

/// Of 40 channels at 32 bits 4 are left, in capitals, and exposure and view change the PNG alone.
TEST_F(Render, LayersAndBitsAreChosenAndExposureIsOfThePreview) {
  render_well("all.exr", {"--precision", "float"});
  render_well("half.exr");
  render_well("few.EXR", {"--layers", "albedo,Z", "--exposure", "2"});
  render_well("film.exr", {"--view", "agx"});
  render_well("least.exr", {"--layers", "beauty"});
  render_well("halves.exr", {"--layers", "beauty,half"});
  render_well("with halves.exr", {"--layers", "all,half", "--precision", "float"});
  const auto all = image::read_exr(path("all.exr")), half = image::read_exr(path("half.exr"));
  const auto few = image::read_exr(path("few.EXR")), least = image::read_exr(path("least.exr"));
  const auto halves = image::read_exr(path("halves.exr")), more = image::read_exr(path("with halves.exr"));
  ASSERT_TRUE(all && half && few && least && halves && more);
  EXPECT_EQ(halves->channels.size(), 4u + 4 * 3);
  EXPECT_EQ(more->channels.size(), all->channels.size() + 4 * 3);
  expect_mean_of_halves(*more);
  EXPECT_EQ(few->channels.size(), 4u + 3 + 1);
  EXPECT_EQ(least->channels.size(), 4u);
  EXPECT_EQ(all->channels.size(), half->channels.size());
  for (const image::Channel& channel : all->channels) {
    const image::Channel* other = half->find(channel.name);
    ASSERT_NE(other, nullptr);
    const bool same = channel.name == "Z" || channel.name.starts_with("variance.");
    for (std::size_t i = 0; i < channel.pixels.size(); ++i) {  // half a step of 2^-10, and steps of 2^-24 near 0
      const float value = channel.pixels[i];
      EXPECT_NEAR(other->pixels[i], value, same ? 0 : std::abs(value) * 0x1p-11f + 0x1p-25f) << channel.name;
    }
  }
  EXPECT_EQ(half->find("R")->pixels, few->find("R")->pixels) << "the exposure is not of the EXR";
  EXPECT_LT(fs::file_size(path("half.exr")), 0.75 * static_cast<double>(fs::file_size(path("all.exr"))));
  EXPECT_EQ(read_text(path("half.png")), read_text(path("all.png")));
  EXPECT_NE(read_text(path("few.png")), read_text(path("all.png")));
  EXPECT_NE(read_text(path("film.png")), read_text(path("all.png")));
  EXPECT_EQ(half->find("R")->pixels, image::read_exr(path("film.exr"))->find("R")->pixels) << "nor is the view";
}

TEST_F(Render, AHeatMapShowsWhatPixelsCostAndLeavesThePictureAsItIs) {
  // Without rows, so that vertices are traced.
  render_well("plain.exr", {"--precision", "float", "--table-memory", "0"});
  render_well("a.exr", {"--heatmap", path("heat.exr"), "--precision", "float", "--table-memory", "0"});
  expect_same_picture("plain.exr", "a.exr");
  const auto picture = image::read_exr(path("a.exr")), heat = image::read_exr(path("heat.exr"));
  ASSERT_TRUE(picture);
  ASSERT_TRUE(heat);
  const auto value = [](const image::Picture& from, const char* name, std::size_t pixel) {
    return from.find(name)->pixels.at(pixel);
  };
  double traced = 0, hair = 0, empty = 0;
  int hairs = 0, empties = 0;
  for (std::size_t i = 0; i < 40 * 40; ++i) {
    EXPECT_EQ(value(*heat, "paths", i), 8);
    EXPECT_GE(value(*heat, "vertices", i), value(*picture, "coverage", i) - 1e-6f);
    const float queries = value(*heat, "queries", i);
    if (queries > 0) {
      EXPECT_NEAR(value(*heat, "exact", i) / queries, value(*picture, "ais.exact", i), 1e-5);
    }
    traced += value(*heat, "exact", i);
    const bool covered = value(*picture, "coverage", i) > 0.9f;
    (covered ? hair : empty) += value(*heat, "cpu_ns", i);
    ++(covered ? hairs : empties);
  }
  EXPECT_GT(traced, 0);
  ASSERT_GT(hairs, 30);
  ASSERT_GT(empties, 30);
  EXPECT_GT(hair / hairs, empty / empties) << "hair costs more than what is behind it";
}

TEST_F(Render, TimeAndNoiseChooseOnlyHowManyPasses) {
  render_well("noise.exr", {"--noise", "0.12", "--telemetry", path("noise.jsonl")});
  const nlohmann::json end = summary("noise.jsonl");
  EXPECT_EQ(end.at("stopped_by"), "noise");
  EXPECT_LE(end.at("noise"), 0.12);
  const auto passes = telemetry_lines(path("noise.jsonl"), "pass");
  ASSERT_GE(passes.size(), 7u) << "4 samples before a variance is believed";
  for (std::size_t i = 6; i + 1 < passes.size(); ++i) EXPECT_GT(passes[i].at("noise"), 0.12);
  const std::size_t samples = passes.size() - 3;  // four passes make the first
  EXPECT_NEAR(end.at("samples_per_pixel"), samples, 0.1);
  // The same picture as with that many samples in the mean asked for.
  render_well("samples.exr",
              {"--spp", std::to_string(samples), "--adaptive", "on", "--telemetry", path("samples.jsonl")});
  expect_same_picture("noise.exr", "samples.exr");
  EXPECT_EQ(summary("samples.jsonl").at("stopped_by"), "samples");

  render_well("time.exr", {"--time", "2", "--telemetry", path("time.jsonl")});
  EXPECT_EQ(summary("time.jsonl").at("stopped_by"), "time");
  const double count = summary("time.jsonl").at("samples_per_pixel");
  EXPECT_NEAR(count, std::round(count), 0.1) << "passes of one sample in the mean";
  EXPECT_GE(count, 1);
  render_well("short.exr", {"--time", "0.000001", "--telemetry", path("short.jsonl")});
  EXPECT_EQ(summary("short.jsonl").at("samples_per_pixel"), 1.0);
}

TEST_F(Render, WhatCannotBeWrittenIsFoundBeforeRendering) {
  const Outcome picture = render("none/a.exr", {"--spp", "1000000"});
  EXPECT_EQ(picture.status, 1);
  EXPECT_THAT(picture.err, HasSubstr("none"));
  EXPECT_EQ(render("a.exr", {"--spp", "1000000", "--warm-cache", path("none/t.cache")}).status, 1);
  EXPECT_EQ(render("a.exr", {"--spp", "1000000", "--telemetry", path("none/t.jsonl")}).status, 1);
  fs::create_directory(path("folder.exr"));
  EXPECT_EQ(render("folder.exr", {"--spp", "1000000"}).status, 1);
}

TEST_F(Render, TelemetryOfRowsListsEachChangedRow) {
  render_well("a.exr", {"--telemetry", path("a.jsonl"), "--telemetry-level", "rows", "--spp", "4"});
  const auto lines = telemetry_lines(path("a.jsonl"), "row");
  ASSERT_GT(lines.size(), 40u) << "coarse rows before the first pass, and what came of them";
  EXPECT_TRUE(lines[0].contains("state"));
}

}  // namespace
}  // namespace tress::test
