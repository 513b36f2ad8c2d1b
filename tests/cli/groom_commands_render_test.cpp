// tress info, tress convert, and the same picture of the same strands in every format.
#include <gmock/gmock.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "cli/run_tress.h"
#include "image/picture.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class GroomCommands : public CommandTest {
 protected:
  static std::string fixture(const std::string& name) {
    return (fs::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "grooms" / name).string();
  }

  static std::string fault(const std::string& name) {
    return (fs::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "faults" / name).string();
  }

  /// groom, material: more keys of the only one.
  image::Picture picture_of(const std::string& file, const std::string& groom = "",
                            const std::string& material = "") const {
    return picture_of_scene(file, R"("camera": {"eye": [0, -30, -4], "look_at": [0, 0, -4]}, )",
                            R"(, "cm_per_unit": 1, "up": "z")" + groom, material);
  }

  /// By the automatic camera.
  image::Picture framed_picture_of(const std::string& file, const std::string& groom) const {
    return picture_of_scene(file, "", groom, "");
  }

 private:
  image::Picture picture_of_scene(const std::string& file, const std::string& camera, const std::string& groom,
                                  const std::string& material) const {
    write_text(path("scene.json"), "{" + camera + R"("image": {"width": 24, "height": 32, "samples": 2},
        "materials": [{"name": "hair")" +
                                       material + R"(}], "grooms": [{"name": "same", "file": ")" + file + "\"" + groom +
                                       "}]}");
    const Outcome outcome = run({"render", path("scene.json"), "-o", path("a.exr"), "--model", "exact"});
    EXPECT_EQ(outcome.status, 0) << file << outcome.err;
    auto picture = image::read_exr(path("a.exr"));
    return picture ? std::move(*picture) : image::Picture{};
  }
};

TEST_F(GroomCommands, TheSameStrandsGiveTheSamePictureInFiveFormats) {
  const image::Picture hair = picture_of(fixture("same.hair"));
  double covered = 0;
  for (const image::Channel& channel : hair.channels)
    if (channel.name == "coverage")
      for (const float x : channel.pixels) covered += double{x};
  EXPECT_GT(covered, 4);
  const Outcome converted =
      run({"convert", fixture("same.abc"), path("converted.usda"), "--cm-per-unit", "1", "--up", "z"});
  EXPECT_EQ(converted.status, 0) << converted.err;
  for (const std::string& file : {fixture("same.usda"), fixture("same.pbrt"), fixture("same.ply"),
                                  fixture("same_little.ply"), fixture("same_big.ply")}) {
    const image::Picture other = picture_of(file);
    const auto difference = image::compare(hair, other, "same.hair", file);
    ASSERT_TRUE(difference) << difference.error().message();
    EXPECT_EQ(difference->largest, 0) << file;
    if (!file.ends_with(".pbrt")) {
      EXPECT_TRUE(difference->identical) << file;  // in every layer
    }
  }
  // The archive turns them by 90 degrees and back, which rounds; what is converted is what was read.
  const image::Picture archive = picture_of(fixture("same.abc")), text = picture_of(path("converted.usda"));
  const auto rounding = image::compare(hair, archive, "same.hair", "same.abc"),
             same = image::compare(archive, text, "same.abc", "converted.usda");
  ASSERT_TRUE(rounding && same);
  EXPECT_LT(rounding->rel_mse, 1e-3);
  EXPECT_TRUE(same->identical);
}

/// Of files without a unit, too, which is found by how large the strands are.
TEST_F(GroomCommands, TheSameStrandsAreFramedTheSameInEveryFormat) {
  const std::string radius = R"(, "up": "z", "radius_cm": 0.03125)", unit = R"(, "cm_per_unit": 1)" + radius;
  for (const std::string& groom : {unit, radius}) {
    const image::Picture hair = framed_picture_of(fixture("same.hair"), groom);
    for (const char* name : {"same.usda", "same.pbrt", "same.ply", "same_big.ply", "same.data", "same.abc"}) {
      if (groom == radius && std::string(name) == "same.usda") continue;  // has a unit
      const auto difference = image::compare(hair, framed_picture_of(fixture(name), groom), "same.hair", name);
      ASSERT_TRUE(difference) << difference.error().message();
      if (std::string(name) == "same.abc") {  // turned by 90 degrees and back, which rounds
        EXPECT_LT(difference->rel_mse, 1e-3);
      } else {
        EXPECT_EQ(difference->largest, 0) << name << groom;
      }
    }
  }
  const auto untransformed =
      image::compare(framed_picture_of(fixture("colored.hair"), radius),
                     framed_picture_of(fixture("colored.abc"), radius), "colored.hair", "colored.abc");
  ASSERT_TRUE(untransformed) << untransformed.error().message();
  EXPECT_EQ(untransformed->largest, 0);
}

/// .data has no widths: one radius for all. The same material draws all the others so, too.
TEST_F(GroomCommands, StrandsWithoutWidthsGiveTheSamePictureOnceTheSceneSaysOne) {
  const std::string radius = R"(, "radius_cm": 0.03125)";
  const image::Picture hair = picture_of(fixture("same.hair"), radius);
  for (const char* name : {"same.data", "same.usda", "same_big.ply"}) {
    const auto difference = image::compare(hair, picture_of(fixture(name), radius), "same.hair", name);
    ASSERT_TRUE(difference) << difference.error().message();
    EXPECT_TRUE(difference->identical) << name;
  }
}

TEST_F(GroomCommands, TheSameColorsOfStrandsGiveTheSamePictureInEveryFormatThatHasThem) {
  const std::string from_file = R"(, "color": "file")";
  const image::Picture hair = picture_of(fixture("colored.hair"), "", from_file),
                       one = picture_of(fixture("colored.hair"), "", R"(, "color": [0.5, 0.5, 0.5])");
  const auto colors_matter = image::compare(hair, one, "colored.hair", "of one color");
  ASSERT_TRUE(colors_matter);
  EXPECT_GT(colors_matter->largest, 0.01);
  for (const char* name : {"colored.usda", "colored.abc", "colored.ply"}) {
    const auto difference = image::compare(hair, picture_of(fixture(name), "", from_file), "colored.hair", name);
    ASSERT_TRUE(difference) << difference.error().message();
    EXPECT_EQ(difference->largest, 0) << name;
  }
}

/// Strands from near black at the root to light at the tip, which all thirds of the picture had the mean of.
TEST_F(GroomCommands, ColorsOfPointsShowAlongTheStrand) {
  const auto scene = [&](const std::string& color) {
    return R"({"image": {"width": 12, "height": 48, "samples": 64}, "environment": {"constant": [1, 1, 1]},
        "camera": {"eye": [0, -10, 0], "look_at": [0, 0, 0], "orthographic_height_cm": 9},
        "materials": [{"name": "m", "color": )" +
           color + R"(}], "grooms": [{"file": ")" + fault("ombre.hair") + R"(", "up": "z", "cm_per_unit": 1}]})";
  };
  /// Red over blue in each third, from above.
  const auto thirds_of = [&](const std::string& color, const char* model) {
    write_text(path("ombre.json"), scene(color));
    const Outcome outcome = run({"render", path("ombre.json"), "-o", path("a.exr"), "--model", model});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("places along the strands") != std::string::npos, color[0] != '[') << outcome.err;
    const auto picture = image::read_exr(path("a.exr"));
    std::vector<double> red(3), blue(3);
    for (std::size_t i = 0; picture && i < 12 * 48; ++i) {
      red[i / (12 * 16)] += picture->find("albedo.R")->pixels[i];
      blue[i / (12 * 16)] += picture->find("albedo.B")->pixels[i];
    }
    for (std::size_t third = 0; third < 3; ++third) red[third] /= blue[third];
    return red;
  };
  for (const char* model : {"chiang2016", "elliptical"}) {
    const std::vector<double> file = thirds_of("\"file\"", model),
                              ramp = thirds_of(R"({"ramp": [[0, [0.02, 0.01, 0.1]], [1, [0.95, 0.48, 0.1]]]})", model);
    EXPECT_GT(file[2], 1.1 * file[0]) << model;  // one color: 1 within 0.02, below
    EXPECT_TRUE(file[0] < file[1] && file[1] < file[2]) << model;
    for (std::size_t third = 0; third < 3; ++third) EXPECT_NEAR(ramp[third], file[third], 0.02 * file[third]) << model;
    const std::vector<double> root = thirds_of("[0.02, 0.01, 0.1]", model);
    EXPECT_NEAR(root[2], root[0], 0.02 * root[0]) << model;
  }
}

// Whoever has no groom yet takes the strands of a generated one.
TEST_F(GroomCommands, TheStrandsOfASceneAreWrittenAsAGroom) {
  const std::string rest = R"("camera": {"eye": [0, -60, -8], "look_at": [0, 0, -8]},
      "image": {"width": 24, "height": 32, "samples": 2}, "grooms": [{"name": "lock", )";
  write_text(path("made.json"), "{" + rest + R"("generate": "wavy", "strands": 300, "radius_cm": 0.02}]})");
  write_text(path("read.json"), "{" + rest + R"("file": "lock.usda"}]})");
  const Outcome converted = run({"convert", path("made.json"), path("lock.usda")});
  ASSERT_EQ(converted.status, 0) << converted.err;
  EXPECT_THAT(run({"info", path("made.json")}).out, HasSubstr("strands   300\n"));
  for (const std::string name : {"made", "read"})
    EXPECT_EQ(run({"render", path(name + ".json"), "-o", path(name + ".exr"), "--model", "exact"}).status, 0);
  const auto made = image::read_exr(path("made.exr")), read = image::read_exr(path("read.exr"));
  ASSERT_TRUE(made && read);
  const auto difference = image::compare(*made, *read, "made", "read");
  ASSERT_TRUE(difference) << difference.error().message();
  EXPECT_EQ(difference->largest, 0);
  EXPECT_EQ(run({"convert", path("made.json"), path("lock.hair"), "--up", "y"}).status, 1);
}

TEST_F(GroomCommands, InfoSaysWhatIsInAFileAndWhatIsNotUsed) {
  const Outcome text = run({"info", fixture("same.abc")});
  EXPECT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("strands   9\n"));
  EXPECT_THAT(text.out, HasSubstr("root uv   per strand"));
  EXPECT_THAT(text.out, HasSubstr("points    99, 11 a strand\n"));
  EXPECT_THAT(text.out, HasSubstr("normals   none"));
  EXPECT_THAT(run({"info", fixture("normals.abc")}).out, HasSubstr("normals   per point (minor axes of the fibers"));
  EXPECT_THAT(text.out, HasSubstr("not used  groom_closest_guides"));
  const Outcome outcome = run({"info", fixture("same.usda"), "--json"});
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["strands"], 9);
  EXPECT_EQ(json["points"], 81);
  EXPECT_EQ(json["cm_per_unit"], 1);
  EXPECT_EQ(json["up"], "z");
  EXPECT_EQ(json["parts"][0]["curve"], "cubic bspline, pinned");
}

TEST_F(GroomCommands, WhatIsNotUsedIsAnErrorUnderStrict) {
  const std::string nan = fault("nan.usda");
  const Outcome info = run({"info", nan});
  EXPECT_EQ(info.status, 0);
  EXPECT_THAT(info.out, HasSubstr("not used  /h: 1 of 2 strands"));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"info", nan, "--strict"}, {"render", nan, "-o", path("a.exr"), "--strict"}}) {
    const Outcome refused = run(command);
    EXPECT_EQ(refused.status, 1) << command[0];
    EXPECT_THAT(refused.err, HasSubstr("--strict: expected a file of which everything is used")) << command[0];
  }
  EXPECT_EQ(run({"info", fault("bound.usda"), "--strict"}).status, 0);
}

TEST_F(GroomCommands, InfoShowsTheFrameThatIsAskedFor) {
  EXPECT_EQ(run({"info", fault("emptyfirst.abc")}).status, 1);
  EXPECT_EQ(run({"info", fault("emptyfirst.abc"), "--frame", "2"}).status, 0);
  EXPECT_THAT(run({"info", fault("vary.usda"), "--frame", "1"}).out, HasSubstr("strands   2"));
  EXPECT_THAT(run({"info", fault("vary.usda"), "--frame", "2"}).out, HasSubstr("strands   1"));
  EXPECT_THAT(run({"info", fault("vary.usda"), "--frame", "-1"}).out, HasSubstr("strands   2"));
}

TEST_F(GroomCommands, WidthsAreThoseOfTheFileOrOfTheOption) {
  const auto covered = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "render", fault("quill.usda"), "-o",         path("w.exr"), "--resolution", "64x64", "--spp",
        "64",     "--model",           "chiang2016", "--quiet",     "--transparent"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run(words).status, 0);
    const auto picture = image::read_exr(path("w.exr"));
    double sum = 0;
    if (picture)
      for (const float alpha : picture->find("A")->pixels) sum += alpha;
    return sum / (64 * 64);
  };
  // 4096 pixels of 64 samples: the share of an edge pixel is off by 0.06 at most, of some 200 such pixels by 4e-4.
  const double file = covered({});
  EXPECT_GT(file, 0.05);
  EXPECT_NEAR(covered({"--widths", "scale=0.5"}), file / 2, 0.02 * file);
  EXPECT_NEAR(covered({"--radius", "0.05"}), file / 2, 0.02 * file);
  EXPECT_NEAR(covered({"--widths", "clamp"}), file / 2, 0.02 * file);
  EXPECT_EQ(run({"render", fault("quill.usda"), "-o", path("w.exr"), "--widths", "huge"}).status, 2);
}

/// A file that is cut while it is read: read already, or an error, never a signal.
TEST_F(GroomCommands, AGroomThatIsCutMeanwhileEndsWithAnError) {
  constexpr int points = 2'000'000;
  std::string text = "#usda 1.0\ndef BasisCurves \"h\" { uniform token type = \"linear\" int[] curveVertexCounts = [" +
                     std::to_string(points + 1) + "] point3f[] points = [";
  for (int i = 0; i < points; ++i) text += "(0.125,0.25," + std::to_string(i) + "),";
  write_text(path("big.usda"), text + "(0,0,0)] }\n");
  for (const int milliseconds : {20, 60, 120}) {
    fs::copy_file(path("big.usda"), path("cut.usda"), fs::copy_options::overwrite_existing);
    const Process reading(folder_, {"info", path("cut.usda")});
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    fs::resize_file(path("cut.usda"), 0);
    const Outcome outcome = reading.wait();
    EXPECT_LE(outcome.status, 1) << outcome.err;
    if (outcome.status == 1) {
      EXPECT_THAT(outcome.err, HasSubstr("cut.usda"));
    }
  }
}

TEST_F(GroomCommands, ErrorsNameTheFileAndEndWithStatusOne) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{"info", fixture("malformed/cut.usda")},
                                                  {"convert", fixture("malformed/cut.usda"), path("out.usda")},
                                                  {"render", fixture("malformed/cut.usda"), "-o", path("a.exr")}}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 1) << command[0];
    EXPECT_THAT(outcome.err, HasSubstr("cut.usda: line ")) << command[0];
    EXPECT_THAT(outcome.out, IsEmpty());
  }
  EXPECT_FALSE(fs::exists(path("out.usda")));
  EXPECT_EQ(run({"convert", fixture("same.usda"), path("out.abc")}).status, 2);
}

}  // namespace
}  // namespace tress::test
