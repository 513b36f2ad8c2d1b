// What a file says is what is drawn: one input of each kind that was once dropped, overruled or refused. The files are
// in tests/scene/faults; each test has the name of the fault that it holds off.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/ext/matrix_double3x3.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "image/color_image.h"
#include "image/picture.h"
#include "scene/read/assembly.h"
#include "scene/read/environment_file.h"
#include "scene/read/groom_files.h"
#include "scene/read/grooms/alembic_file.h"
#include "scene/read/grooms/groom_formats.h"
#include "scene/read/grooms/hair_file.h"
#include "scene/read/grooms/pbrt_file.h"
#include "scene/read/grooms/ply_file.h"
#include "scene/read/grooms/usc_data.h"
#include "scene/read/grooms/usd_file.h"
#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"
#include "scene/read/mapped_file.h"
#include "scene/read/obj_file.h"
#include "scene/read/shared_strands.h"

namespace tress::scene {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

namespace fs = std::filesystem;

fs::path fault(const std::string& name) { return fs::path(TRESS_SOURCE_DIR) / "tests" / "scene" / "faults" / name; }

GroomFile read(const std::string& name, std::optional<double> frame = {}) {
  auto groom = read_groom_file(fault(name), {}, frame);
  EXPECT_TRUE(groom) << groom.error().message();
  if (groom) return std::move(*groom);
  GroomFile none;
  none.first_point = {0};
  return none;
}

std::string error_of(const std::string& name) {
  const auto groom = read_groom_file(fault(name));
  return groom ? "" : groom.error().message();
}

/// What is named as not used.
std::vector<std::string> ignored(const GroomFile& groom) {
  std::vector<std::string> names;
  for (const IgnoredAttribute& one : groom.ignored) names.push_back(one.name + ": " + one.why);
  return names;
}

struct Assembled {
  Groom groom;
  std::vector<std::string> notes, warnings;
};

Assembled assembled(const std::string& name, const GroomPlacement& placement = {}) {
  Assembled out;
  auto groom = assemble_groom(read(name), placement, name, &out.notes, &out.warnings);
  EXPECT_TRUE(groom) << groom.error().message();
  if (groom) out.groom = std::move(*groom);
  return out;
}

std::vector<float> widths_of(const GroomFile& groom) {
  std::vector<float> widths;
  for (std::size_t i = 0; i < groom.points.size(); ++i) widths.push_back(groom.width_at(i));
  return widths;
}

/// Radii are said to a relative 1e-6: a float has 6e-8, and they are scaled twice at most.
testing::Matcher<float> about(float x) { return testing::FloatNear(x, 1e-6f * std::abs(x) + 1e-12f); }

// ---- widths -------------------------------------------------------------------------------------------------------

TEST(FileFaults, UsdUnitSaidWidthThrown) {
  const Assembled bound = assembled("bound.usda"), whisker = assembled("whisker.usda");
  EXPECT_THAT(bound.groom.radius_cm, ElementsAre(about(0.05f), about(0.035f), about(0.005f)));
  ASSERT_EQ(whisker.groom.radius_cm.size(), 9u);
  EXPECT_THAT(whisker.groom.radius_cm[0], about(0.003f));
  EXPECT_THAT(whisker.groom.radius_cm[6], about(0.06f));
  EXPECT_TRUE(bound.warnings.empty() && whisker.warnings.empty());
}

TEST(FileFaults, WidthsOneThick) {
  EXPECT_THAT(assembled("one_thick.usda").groom.radius_cm[0], about(0.025f));
  EXPECT_THAT(assembled("quill.usda").groom.radius_cm[0], about(0.1f));
  EXPECT_THAT(assembled("bee.usda").groom.radius_cm[0], about(0.0004f));
}

TEST(FileFaults, WidthsAreUsedAsTheSceneAsks) {
  const auto first = [](GroomPlacement placement) { return assembled("quill.usda", placement).groom.radius_cm[0]; };
  EXPECT_THAT(first({.widths = *width_use_of("clamp")}), about(0.05f));
  EXPECT_THAT(first({.widths = *width_use_of("scale=0.5")}), about(0.05f));
  EXPECT_THAT(first({.radius_cm = 0.02}), about(0.02f));
  for (const char* wrong :
       {"", "files", "scale", "scale=", "scale=0", "scale=-1", "scale=2x", "scale=nan", "scale=1e7"})
    EXPECT_FALSE(width_use_of(wrong)) << wrong;
  // A guess of the unit is a guess of widths; who says that they are right is believed.
  GroomFile guessed = read("quill.usda");
  guessed.cm_per_unit.reset();
  std::vector<std::string> notes, warnings;
  const auto usual = assemble_groom(guessed, {}, "x", &notes, &warnings);
  EXPECT_THAT(usual->radius_cm[0], about(usual_radius_cm));
  EXPECT_THAT(notes, Contains(HasSubstr("--widths file")));
  const auto file = assemble_groom(guessed, {.widths = *width_use_of("file")}, "x", &notes, &warnings);
  EXPECT_THAT(file->radius_cm[0], about(1.5f));  // 2 units are 30 cm, so 0.2 are 3
}

TEST(FileFaults, ScaleRadiusFloor) {
  Groom groom = assembled("scaled.usda").groom;
  const float before = groom.radius_cm[0];
  ObjectTransform small;
  small.scale = 1e-3;
  ASSERT_FALSE(move_groom(std::span(&small, 1), &groom));
  EXPECT_THAT(groom.radius_cm[0], about(1e-3f * before));
}

TEST(FileFaults, WidthsZeroVisible) {
  const Assembled some = assembled("zero_widths.usda"), none = assembled("all0.usda");
  EXPECT_EQ(some.groom.strand_count(), 1u);
  EXPECT_THAT(some.notes, Contains(HasSubstr("500 of 501 strands are hidden, their width is 0")));
  EXPECT_EQ(none.groom.strand_count(), 0u);
}

TEST(FileFaults, StrayStrandUnit) {
  const Assembled good = assembled("good.hair"), stray = assembled("stray.hair");
  // 60 of 61 strands are those of the other file: the same unit, so the same points.
  ASSERT_GT(stray.groom.points.size(), good.groom.points.size());
  EXPECT_EQ(stray.groom.points[0], good.groom.points[0]);
  EXPECT_EQ(stray.groom.radius_cm[0], good.groom.radius_cm[0]);
  EXPECT_THAT(stray.warnings, Contains(HasSubstr("1 of 61 strands lie far from all others")));
  const auto scene = load_scene(fault("stray.hair")), without = load_scene(fault("good.hair"));
  ASSERT_TRUE(scene && without);
  EXPECT_LT(glm::distance(scene->camera.eye, without->camera.eye), 1e-3f);
}

// ---- Alembic ------------------------------------------------------------------------------------------------------

TEST(FileFaults, AbcHidden) {
  const GroomFile groom = read("hidden.abc");
  EXPECT_EQ(groom.strand_count(), 1u);
  EXPECT_THAT(ignored(groom), Contains(HasSubstr("it is hidden (visible)")));
}

TEST(FileFaults, AbcClampedKnots) {
  const GroomFile groom = read("knots.abc");
  ASSERT_EQ(groom.strand_count(), 1u);
  EXPECT_EQ(groom.basis, StrandBasis::bezier);
  ASSERT_EQ(groom.points.size(), 7u);
  EXPECT_TRUE(groom.ignored.empty());
  // Knots 0 0 0 0 1 2 2 2 2: by Boehm's insertion at 1 the segments meet halfway between the middle thirds.
  const auto& p = groom.points;
  EXPECT_LT(glm::distance(p[3], 0.5f * (p[2] + p[4])), 1e-5f);
}

TEST(FileFaults, AbcWidthInArbDropped) {
  EXPECT_THAT(widths_of(read("widtharb.abc")), ElementsAre(about(0.08f), about(0.06f), about(0.04f), about(0.01f)));
  EXPECT_THAT(read("ididx.abc").id, ElementsAre(9, 7));
}

TEST(FileFaults, AbcColors) {  // abc_bytes_color_white, abc_color_rgba_dropped, abc_text_named_color
  const GroomFile bytes = read("cdc3c.abc"), rgba = read("cd4.abc"), text = read("strs.abc");
  const glm::vec3 color = bytes.color_at(0, 0);
  EXPECT_LT(glm::distance(color, glm::vec3(200, 100, 50) / 255.0f), 1e-6f);
  EXPECT_TRUE(rgba.has_color);
  EXPECT_FALSE(text.has_color);
  EXPECT_THAT(ignored(text), Contains(HasSubstr("color: it is a text")));
  EXPECT_EQ(text.strand_count(), 1u);
}

TEST(FileFaults, AbcEmptyFirstSample) {
  EXPECT_THAT(error_of("emptyfirst.abc"), HasSubstr("no curves in the first of 3 samples; --frame"));
  EXPECT_GT(read("emptyfirst.abc", 2.0).strand_count(), 0u);
}

TEST(FileFaults, AbcFpsIgnored) {
  const GroomFile own = read("fps25.abc", 50.0);
  EXPECT_NEAR(own.points[0].x, 50, 1e-3);
  const auto said = read_groom_file(fault("fps25.abc"), {}, 50.0, 24.0);
  EXPECT_NEAR(said->points[0].x, 50.0 * 25 / 24, 1e-3);
}

TEST(FileFaults, AbcInstancesAndOrders) {
  const GroomFile orders = read("varorder.abc");
  GroomFile instances = read("instance.abc");
  ASSERT_FALSE(write_out("instance.abc", &instances));
  ASSERT_EQ(instances.strand_count(), 2u);
  EXPECT_NEAR(instances.points[instances.first_point[1]].x - instances.points[0].x, 5, 1e-5);
  EXPECT_EQ(orders.strand_count(), 2u);
  EXPECT_EQ(orders.basis, StrandBasis::bezier);
}

// ---- USD ----------------------------------------------------------------------------------------------------------

TEST(FileFaults, UsdIndexedPrimvars) {
  EXPECT_THAT(widths_of(read("idxw.usda")),
              ElementsAre(about(.08f), about(.08f), about(.02f), about(.08f), about(.08f), about(.02f)));
  const GroomFile groom = read("idxid.usda");
  EXPECT_THAT(groom.id, ElementsAre(30, 20, 10));
  ASSERT_EQ(groom.root_uv.size(), 3u);
  EXPECT_EQ(groom.root_uv[0], glm::vec2(1, 1));
  ASSERT_EQ(groom.normal.size(), 6u);
  EXPECT_EQ(groom.normal[0], glm::vec3(1, 0, 0));
  EXPECT_EQ(groom.normal[2], glm::vec3(0, 1, 0));
  EXPECT_TRUE(groom.ignored.empty());
}

TEST(FileFaults, UsdInheritedPrimvars) {
  const GroomFile groom = read("inh.usda");
  EXPECT_THAT(groom.width_at(0), about(0.06f));
  EXPECT_EQ(groom.color_at(0, 0), glm::vec3(1, 0, 0));
}

TEST(FileFaults, UsdDefaultVsFirstSample) {
  EXPECT_EQ(read("defts.usda").points[0].x, 9);
  EXPECT_EQ(read("defts.usda", 0.0).points[0].x, 9);
  EXPECT_EQ(read("defts.usda", 1.5).points[0].x, 14);
}

/// They are not interpolated within the shutter, which is said.
TEST(FileFaults, AnimatedNormals) {
  EXPECT_THAT(read("animated_normals.usda", 0.0).remarks, Contains(HasSubstr("normals change in time")));
}

TEST(FileFaults, UsdVaryingTopology) {
  EXPECT_EQ(read("vary.usda", 1.0).strand_count(), 2u);
  EXPECT_EQ(read("vary.usda", 1.9).strand_count(), 2u);
  EXPECT_EQ(read("vary.usda", 2.0).strand_count(), 1u);
  Overrides overrides;
  overrides.frame = 1;
  overrides.settings = {R"(camera/shutter={"open": 0, "close": 1})"};
  const auto scene = load_scene(fault("vary.usda"), overrides);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_THAT(scene->notes, Contains(HasSubstr("strands stand still while the shutter is open")));
}

TEST(FileFaults, UsdFlattenedInstances) {
  GroomFile groom = read("flatinst.usda");
  EXPECT_EQ(groom.strand_count(), 1u) << "they share it";
  ASSERT_FALSE(write_out("flatinst.usda", &groom));
  ASSERT_EQ(groom.strand_count(), 2u);
  EXPECT_EQ(groom.points[0].x, 0);
  EXPECT_EQ(groom.points[2].x, 5);
}

TEST(FileFaults, ReferencesInCirclesEnd) {
  const fs::path file = fs::path(testing::TempDir()) / "circle.usda";
  const std::string curves =
      "def BasisCurves \"h\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] point3f[] points = "
      "[(0,0,0),(0,0,5)] }\n";
  std::ofstream(file) << "#usda 1.0\ndef Xform \"a\" { def Xform \"b\" ( references = </a> ) { }\n" << curves << "}\n";
  const auto ancestor = read_groom_file(file);
  ASSERT_FALSE(ancestor);
  EXPECT_THAT(ancestor.error().message(), HasSubstr("prims in one another"));
  std::ofstream(file)
      << "#usda 1.0\ndef Xform \"a\" ( references = </b> ) { }\ndef Xform \"b\" ( references = [</a>, </none>] ) {\n"
      << curves << "}\n";
  const auto each_other = read_groom_file(file);
  ASSERT_TRUE(each_other) << each_other.error().message();
  EXPECT_EQ(each_other->strand_count(), 2u);
  EXPECT_THAT(ignored(*each_other), Contains(HasSubstr("what it refers to is not there: /none")));
  fs::remove(file);
}

TEST(FileFaults, UsdVisibilityAfterChild) {
  const GroomFile groom = read("visafter.usda");
  std::vector<std::string> parts;
  for (const GroomPart& part : groom.parts) parts.push_back(part.name);
  EXPECT_THAT(parts, ElementsAre("/p/render_child", "/plain"));
  EXPECT_THAT(ignored(groom), Contains("/g: it is invisible"));
}

TEST(FileFaults, UsdOnlyNurbs) {
  EXPECT_THAT(error_of("nurbs.usda"), HasSubstr("NurbsCurves /h (prims of this type are not read)"));
}

TEST(FileFaults, UsdUtf8Identifier) { EXPECT_EQ(read("utf8id.usda").strand_count(), 1u); }

// ---- texts, pbrt, PLY ---------------------------------------------------------------------------------------------

TEST(FileFaults, BomAndUtf16) {
  EXPECT_GT(read("bom.usda").strand_count(), 0u);
  EXPECT_GT(read("bom.pbrt").strand_count(), 0u);
  EXPECT_THAT(error_of("u16.usda"), HasSubstr("UTF-16"));
}

TEST(FileFaults, ObjBom) {
  const auto bytes = read_input_file(fault("b.obj"), "an .obj file", 1 << 20);
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(parse_obj_file(*bytes, "b.obj"));
}

TEST(FileFaults, OneNanPoint) {
  const GroomFile groom = read("nan.usda");
  EXPECT_THAT(groom.broken, ElementsAre(1u));
  EXPECT_THAT(ignored(groom),
              Contains(HasSubstr("/h: 1 of 2 strands, the first 1: they have points that are not finite")));
  const Assembled drawn = assembled("nan.usda");
  EXPECT_EQ(drawn.groom.strand_count(), 1u);
  std::vector<std::string> notes, warnings;
  EXPECT_FALSE(assemble_groom(groom, {.strict = true}, "x", &notes, &warnings));
}

/// Two prims, the first of which is `first`; the second is whole.
fs::path two_prims(const std::string& first) {
  const fs::path file =
      fs::path(testing::TempDir()) / fmt::format("two_prims_{}.usda", std::hash<std::string>{}(first));
  std::ofstream(file)
      << "#usda 1.0\n( metersPerUnit = 0.01\n upAxis = \"Z\" )\ndef BasisCurves \"a\" { uniform token type = "
         "\"linear\" "
      << first
      << " }\ndef BasisCurves \"b\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] point3f[] "
         "points = [(0,0,0),(0,0,5)] float[] widths = [0.02, 0.01] (interpolation = \"vertex\") }\n";
  return file;
}

TEST(FileFaults, ABrokenPrimDoesNotCostTheOthers) {
  const auto groom = read_groom_file(two_prims("int[] curveVertexCounts = [3] point3f[] points = [(1,0,0),(1,0,5)]"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->strand_count(), 1u);
  EXPECT_THAT(ignored(*groom), ElementsAre("/a: expected 3 vertices, as 1 curves have them, found 2"));
}

TEST(FileFaults, OperationsAlongOneAxisAndThoseWithoutAValue) {
  const auto groom = read_groom_file(two_prims(
      "int[] curveVertexCounts = [2] point3f[] points = [(1,2,3),(1,2,5)] double xformOp:translateX = 5 float "
      "xformOp:scaleY = 3 double3 xformOp:translate:a = None uniform token[] xformOpOrder = [\"xformOp:translateX\", "
      "\"xformOp:scaleY\", \"xformOp:translate:a\"]"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->points[1], glm::vec3(6, 6, 5));
  EXPECT_THAT(ignored(*groom), ElementsAre("/a: xformOp:translate:a: it has no value"));
}

/// Its name ends as that of texture coordinates does, which have two numbers.
TEST(FileFaults, AnAttributeOfOneNumberHasIndicesToo) {
  const auto groom =
      read_groom_file(two_prims("int[] curveVertexCounts = [2] point3f[] points = [(1,0,0),(1,0,5)] float[] "
                                "primvars:dust = [0.25, 0.5] (interpolation = \"vertex\") int[] "
                                "primvars:dust:indices = [1, 0]"),
                      {}, {}, {}, "dust");
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->color_at(0, 0), glm::vec3(0.5f));
  EXPECT_EQ(groom->color_at(0, 1), glm::vec3(0.25f));
}

TEST(FileFaults, CurvesOfTooFewPointsAreNamed) {
  const auto groom = read_groom_file(two_prims("int[] curveVertexCounts = [1] point3f[] points = [(1,0,0)]"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_THAT(ignored(*groom), ElementsAre("1 of 2 strands: they have too few points for a segment"));
}

TEST(FileFaults, StrandsWithoutWidthsBesideOthersAreSeen) {
  auto groom = read_groom_file(two_prims("int[] curveVertexCounts = [2] point3f[] points = [(1,0,0),(1,0,5)]"));
  ASSERT_TRUE(groom) << groom.error().message();
  std::vector<std::string> notes, warnings;
  const auto made = assemble_groom(*groom, {}, "x", &notes, &warnings);
  EXPECT_THAT(made->radius_cm,
              ElementsAre(about(usual_radius_cm), about(usual_radius_cm), about(0.01f), about(0.005f)));
  say_widths(&*groom);
  EXPECT_THAT(groom->width[0], about(2 * usual_radius_cm));
}

TEST(FileFaults, PackedGroomsAndStandardInputAreRead) {
  EXPECT_EQ(read("geo.pbrt.gz").strand_count(), 1u);
  std::ifstream file(fault("widtharb.abc"), std::ios::binary);
  std::streambuf* const before = std::cin.rdbuf(file.rdbuf());
  const auto groom = read_groom_file("-");
  std::cin.rdbuf(before);
  std::cin.clear();
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_EQ(groom->strand_count(), 1u);
  // Cut anywhere, packed bytes are an error.
  std::ifstream packed(fault("geo.pbrt.gz"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(packed)), {});
  for (std::size_t size = 3; size < whole.size(); ++size)
    EXPECT_FALSE(unpacked({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}, "x", 1 << 20)) << size;
  EXPECT_FALSE(unpacked({whole.begin(), whole.end()}, "x", 8)) << "more than is allowed";
}

/// groom_truncated_sigbus: the program's handler of the signal finds the file by the address.
TEST(FileFaults, AMappingIsKnownByItsAddress) {
  const void* address = nullptr;
  {
    const auto mapped = MappedFile::open(fault("good.hair"), "a groom", 1 << 20);
    ASSERT_TRUE(mapped);
    address = mapped->bytes().data() + 100;
    ASSERT_NE(name_of_mapping(address), nullptr);
    EXPECT_EQ(name_of_mapping(address), fault("good.hair").string());
  }
  EXPECT_EQ(name_of_mapping(address), nullptr);
}

TEST(FileFaults, PbrtTransforms) {  // pbrt_active_transform, pbrt_coordsys
  EXPECT_EQ(read("act.pbrt").points[0].x, 0);
  EXPECT_THAT(ignored(read("act.pbrt")), Contains(HasSubstr("ActiveTransform")));
  EXPECT_EQ(read("coordsys.pbrt").points[0].x, 1);
}

TEST(FileFaults, PbrtIncludeGz) { EXPECT_GT(read("incgz.pbrt").strand_count(), 0u); }

TEST(FileFaults, PbrtIncludeNotInIdentity) {
  EXPECT_THAT(included_files(fault("a.pbrt")), ElementsAre(fault("inc.pbrt")));
  EXPECT_THAT(included_files(fault("incgz.pbrt")), ElementsAre(fault("geo.pbrt.gz")));
}

TEST(FileFaults, PbrtInstancesNone) { EXPECT_EQ(read("inst.pbrt").strand_count(), 1u); }

TEST(FileFaults, PlyInterleavedAndLineSets) {  // ply_interleaved, ply_line_set
  const GroomFile interleaved = read("inter.ply"), lines = read("lineset.ply");
  EXPECT_THAT(interleaved.first_point, ElementsAre(0u, 2u, 4u));
  EXPECT_THAT(lines.first_point, ElementsAre(0u, 50u, 100u, 150u, 200u));
}

// ---- pictures that light a scene ----------------------------------------------------------------------------------

struct Lit {
  std::optional<Environment> environment;
  std::vector<std::string> warnings;
};

Lit lit(const std::string& name) {
  Lit out;
  auto environment = load_environment(fault(name), 0, 1, &out.warnings);
  EXPECT_TRUE(environment) << environment.error().message();
  if (environment) out.environment = std::move(*environment);
  return out;
}

/// The largest difference over directions, relative to the largest radiance there.
double difference(const Environment& a, const Environment& b) {
  double most = 0, largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (2 * i + 1) / 2000.0, r = std::sqrt(1 - z * z), phi = 2.39996323 * i;
    const glm::vec3 direction(r * std::cos(phi), r * std::sin(phi), z);
    const glm::vec3 x = a.radiance(direction), y = b.radiance(direction);
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(double{x[c]} - y[c]));
      largest = std::max(largest, double{y[c]});
    }
  }
  return most / largest;
}

TEST(FileFaults, EnvDataWindow) {  // env_data_window, exr_data_window
  EXPECT_EQ(difference(*lit("e_crop2.exr").environment, *lit("e_full2.exr").environment), 0);
  EXPECT_EQ(difference(*lit("card.exr").environment, *lit("card_full.exr").environment), 0);
}

TEST(FileFaults, EnvChromaticities) {
  EXPECT_THAT(lit("e_aces.exr").warnings, Contains(HasSubstr("converted from the chromaticities")));
  EXPECT_THAT(lit("e_ref.exr").warnings, testing::Each(testing::Not(HasSubstr("chromaticities"))));
  // The matrix that is printed for ACES 2065-1 to Rec. 709 (Bradford), with five digits.
  const glm::dmat3 printed =
      glm::transpose(glm::dmat3(2.52169, -1.13413, -0.38756, -0.27648, 1.37272, -0.09624, -0.01538, -0.15298, 1.16835));
  const auto raw = image::read_exr(fault("e_aces.exr"));
  const auto color = image::read_exr_color(fault("e_aces.exr"));
  ASSERT_TRUE(raw && color);
  for (std::size_t i = 0; i < color->pixels.size(); i += 97) {
    const glm::dvec3 aces(raw->find("R")->pixels[i], raw->find("G")->pixels[i], raw->find("B")->pixels[i]);
    EXPECT_LT(glm::distance(glm::dvec3(color->pixels[i]), printed * aces), 1e-4 * glm::length(aces) + 1e-9) << i;
  }
}

TEST(FileFaults, EnvOneInfPixel) {
  for (const char* name : {"e_inf.exr", "e_nan.exr", "sun_inf.exr"})
    EXPECT_THAT(lit(name).warnings, Contains(HasSubstr("values are not finite"))) << name;
}

TEST(FileFaults, EnvironmentChannels) {
  EXPECT_TRUE(lit("depth_inf.exr").environment);
  const Lit exposed = lit("exposure4.hdr");
  ASSERT_TRUE(exposed.environment);
  EXPECT_NEAR(exposed.environment->radiance({0, 0, 1}).y, 0.25, 0.25 / 128);  // RGBE has 8 bits
}

TEST(FileFaults, ExrEnvRefused) {
  EXPECT_THAT(lit("e_y.exr").warnings, Contains(HasSubstr("its color is taken from Y")));
  EXPECT_THAT(lit("e_blender.exr").warnings, Contains(HasSubstr("ViewLayer.Combined.R")));
}

// ---- the tables ---------------------------------------------------------------------------------------------------

/// A .hair file that says one item otherwise than the file without one.
std::string hair_with(std::string_view item) {
  std::string bytes;
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const auto put_array = [&](std::uint32_t count, float value) {
    for (std::uint32_t i = 0; i < count; ++i) put(value);
  };
  const auto bit = [&](std::string_view array, std::uint32_t value) { return item == array ? value : 0; };
  const std::uint32_t strands = item == "strands" ? 3 : 2, segments = item == "segments of all strands" ? 1 : 2,
                      points = strands * (segments + 1),
                      bits = 2 + bit("segments", 1) + bit("thickness", 4) + bit("transparency", 8) + bit("colors", 16);
  bytes = "HAIR";
  for (const std::uint32_t number : {strands, points, bits, segments}) put(number);
  put(item == "thickness of all strands" ? 0.1f : 0.0f);
  put(item == "transparency of all strands" ? 0.5f : 0.0f);
  put_array(3, item == "color of all strands" ? 0.5f : 0.0f);
  bytes.append(88, item == "remark" ? 'r' : '\0');
  if (bits & 1)
    for (const std::uint16_t one : {1, 3}) put(one);
  for (std::uint32_t i = 0; i < 3 * points; ++i) put(static_cast<float>(i) + (item == "points" ? 1.0f : 0.0f));
  if (bits & 4) put_array(points, 0.1f);
  if (bits & 8) put_array(points, 0.5f);
  if (bits & 16) put_array(3 * points, 0.5f);
  return bytes;
}

/// The same as a .data file.
std::string usc_data_with(std::string_view item) {
  std::string bytes;
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const std::int32_t strands = item == "strands" ? 3 : 2, points = item == "points of a strand" ? 4 : 3;
  put(strands);
  for (std::int32_t s = 0; s < strands; ++s) {
    put(points);
    for (std::int32_t i = 0; i < 3 * points; ++i) put(static_cast<float>(i) + (item == "points" ? 1.0f : 0.0f));
  }
  return bytes;
}

/// Each item has a file of its own: what is used makes another groom than the file without it, and what is not used is
/// named with the reason of the table.
void expect_used_or_named(std::span<const FormatItem> items, std::string (*with)(std::string_view item)) {
  const fs::path file = fs::path(testing::TempDir()) / "item.bytes";
  const auto groom_with = [&](std::string_view item) {
    std::ofstream(file, std::ios::binary) << with(item);
    auto groom = read_groom_file(file);
    EXPECT_TRUE(groom) << groom.error().message();
    return std::move(*groom);
  };
  const auto drawn = [](const GroomFile& g) {
    return std::tuple(g.first_point, g.points, g.width, g.default_width, g.has_color, g.color, g.default_color);
  };
  const GroomFile without = groom_with("");
  EXPECT_TRUE(without.ignored.empty());
  for (const FormatItem& item : items) {
    const GroomFile groom = groom_with(item.name);
    const bool is_used = *item.why == 0 && item.name != "remark";
    EXPECT_EQ(drawn(groom) != drawn(without), is_used) << item.name;
    if (*item.why == 0)
      EXPECT_TRUE(groom.ignored.empty()) << item.name;
    else
      EXPECT_THAT(ignored(groom), ElementsAre(std::string(item.name) + ": " + item.why));
  }
  fs::remove(file);
}

TEST(FileFaults, EveryItemOfHairFilesIsUsedOrNamed) { expect_used_or_named(hair_items(), hair_with); }

TEST(FileFaults, EveryItemOfUscDataIsUsedOrNamed) { expect_used_or_named(usc_data_items(), usc_data_with); }

/// What a USD file says of its curves elsewhere than in their attributes, as a text and as a crate.
TEST(FileFaults, WhatUsdSaysAroundCurvesIsUsedOrNamed) {
  for (const char* name : {"said.usda", "../grooms/crates/said.usdc"}) {
    const GroomFile groom = read(name);
    EXPECT_THAT(ignored(groom),
                testing::UnorderedElementsAre(
                    "h: clipAssetPaths: time samples of other files are not read",
                    "r: offset: times of what it refers to are taken as they are there",
                    "h.primvars:displayColor: colorSpace srgb_rec709_scene: colors are taken for linear Rec. 709",
                    "/a: colorSpace:name lin_ap1_scene: colors are taken for linear Rec. 709",
                    "/a: model:drawMode: curves are drawn, not cards in their place",
                    "primvars:displayOpacity: hair is not transparent by an attribute",
                    "ids: primvars:id is in its place", "/a/h: 1 of 2 colors: they are clamped to [0, 1]"));
    EXPECT_THAT(groom.materials, ElementsAre("/a/h: bound to a USD material, which is not read",
                                             "/a/h/s: bound to a USD material, which is not read"));
    ASSERT_EQ(groom.color.size(), 6u) << name;
    EXPECT_EQ(groom.color[3], glm::vec3(0, 1, 0)) << "indices of None are no indices";
    ASSERT_EQ(groom.root_uv.size(), 3u) << name;
    EXPECT_EQ(groom.root_uv[0], glm::vec2(0.75f, 1)) << "of texture coordinates of three numbers the first two";
    EXPECT_EQ(groom.root_uv[1], glm::vec2(0.25f, 0.5f));
    EXPECT_EQ(groom.id[1], 8);
  }
}

TEST(FileFaults, SplinesOfAUsdTextAreNamed) {
  const auto groom = read_groom_file(two_prims(
      "int[] curveVertexCounts = [2] point3f[] points = [(1,0,0),(1,0,5)] double xformOp:rotateX = 5 double "
      "xformOp:rotateX.spline = { bezier, 1: 10, 2: 20 } uniform token[] xformOpOrder = [\"xformOp:rotateX\"]"));
  ASSERT_TRUE(groom) << groom.error().message();
  EXPECT_THAT(ignored(*groom), ElementsAre("a.xformOp:rotateX: animation by splines is not read"));
}

/// A USD text with every attribute of the table: what is not used is named with the reason of the table, and all else
/// is not named.
TEST(FileFaults, EveryItemOfUsdIsUsedOrNamed) {
  for (const FormatItem& item : usd_items()) {
    const fs::path file = fs::path(testing::TempDir()) / "item.usda";
    std::ofstream(file)
        << "#usda 1.0\ndef BasisCurves \"h\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] "
           "point3f[] points = [(0,0,0),(0,0,5)] custom int "
        << (item.name == "type" || item.name == "curveVertexCounts" || item.name == "points" ? "userProperties:x"
                                                                                             : item.name)
        << " = None }\n";
    const auto groom = read_groom_file(file);
    ASSERT_TRUE(groom) << groom.error().message();
    if (*item.why == 0)
      EXPECT_TRUE(groom->ignored.empty()) << item.name;
    else
      EXPECT_THAT(ignored(*groom), ElementsAre(std::string(item.name) + ": " + item.why));
    fs::remove(file);
  }
}

/// An archive in which a property of no meaning has the name of the item: what is not used is named with the reason of
/// the table, and no other is named as without use.
TEST(FileFaults, EveryItemOfAlembicIsUsedOrNamed) {
  std::ifstream in(fault("../grooms/placeholders.abc"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (const FormatItem& item : alembic_items()) {
    const std::string size(1, static_cast<char>(item.name.size()));
    const std::size_t at = whole.find(size + std::string(item.name.size(), '_'));
    ASSERT_NE(at, whole.npos) << item.name;
    const fs::path file = fs::path(testing::TempDir()) / "item.abc";
    std::ofstream(file, std::ios::binary) << std::string(whole).replace(at + 1, item.name.size(), item.name);
    const auto groom = read_groom_file(file);
    ASSERT_TRUE(groom) << groom.error().message();
    if (*item.why == 0)
      EXPECT_THAT(ignored(*groom), testing::Not(Contains(std::string(item.name) + ": nothing here has a use for it")));
    else
      EXPECT_THAT(ignored(*groom), Contains(std::string(item.name) + ": " + item.why));
    fs::remove(file);
  }
}

TEST(FileFaults, WhatAlembicSaysAroundCurvesIsNamed) {
  EXPECT_THAT(ignored(read("said.abc")),
              testing::UnorderedElementsAre(
                  "densityMask: nothing here has a use for it", ".material.assign: a scene's material says it",
                  "Material: objects of this kind are not read", "color: Cd is in its place",
                  ".arbGeomParams/width: width is in its place", "groom_width: width is in its place",
                  "N: it has 2 numbers, where normals have 3"));
}

TEST(FileFaults, EveryPropertyOfPlyIsUsedOrNamed) {
  for (const FormatItem& item : ply_items()) {
    if (item.name.size() == 1 && item.name[0] >= 'x') continue;
    const fs::path file = fs::path(testing::TempDir()) / "item.ply";
    const auto with_others = [&](std::string_view others) {  // a color has three
      return others.find(item.name) == others.npos ? std::string(item.name) : std::string(others);
    };
    const std::string names = with_others(item.name.size() == 1 ? "r g b" : "red green blue");
    std::ofstream out(file);
    out << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
    std::istringstream words(names);
    std::string values;
    for (std::string word; words >> word; values += " 1") out << "property float " << word << "\n";
    out << "end_header\n0 0 0" << values << "\n0 0 5" << values << "\n";
    out.close();
    const auto groom = read_groom_file(file, 2);
    ASSERT_TRUE(groom) << groom.error().message();
    if (*item.why == 0)
      EXPECT_TRUE(groom->ignored.empty()) << item.name;
    else
      EXPECT_THAT(ignored(*groom), ElementsAre("property " + std::string(item.name) + ": " + item.why));
    fs::remove(file);
  }
}

TEST(FileFaults, PropertiesOfPlyThatAreNotTakenAreNamed) {
  const fs::path file = fs::path(testing::TempDir()) / "two.ply";
  const auto named = [&](const std::string& properties, const std::string& values, const std::string& rest = "",
                         const std::string& body = "") {
    std::ofstream(file)
        << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        << properties << rest << "end_header\n0 0 0 " << values << "\n0 0 5 " << values << "\n"
        << body;
    const auto groom = read_groom_file(file, 2);
    EXPECT_TRUE(groom) << groom.error().message();
    return ignored(*groom);
  };
  const std::string why = ": another is in its place, or what belongs to it is not there";
  EXPECT_THAT(named("property float width\nproperty float radius\n", "1 1"), ElementsAre("property radius" + why));
  EXPECT_THAT(named("property float red\nproperty float green\n", "1 1"),
              ElementsAre("property red" + why, "property green" + why));
  EXPECT_THAT(
      named("property int strand_id\n", "1",
            "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty uchar red\n", "0 1 9\n"),
      ElementsAre("property red of edges: those of vertices are read", "element edge: strand ids join the vertices"));
  fs::remove(file);
}

TEST(FileFaults, EveryDirectiveOfPbrtIsNamed) {
  for (const FormatItem& item : pbrt_items()) {
    const fs::path file = fs::path(testing::TempDir()) / "item.pbrt";
    std::ofstream(file) << "WorldBegin\nShape \"curve\" \"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]\n"
                        << item.name << " \"other\"\n";
    const auto groom = read_groom_file(file);
    ASSERT_TRUE(groom) << groom.error().message();
    EXPECT_THAT(ignored(*groom), ElementsAre(std::string(item.name) + " \"other\": " + item.why));
    fs::remove(file);
  }
}

TEST(FileFaults, EveryParameterOfPbrtCurvesIsUsedOrNamed) {
  for (const FormatItem& item : pbrt_curve_items()) {
    const fs::path file = fs::path(testing::TempDir()) / "item.pbrt";
    const bool is_there = item.name == "P";
    std::ofstream(file) << "WorldBegin\nShape \"curve\" \"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]"
                        << (is_there ? "" : fmt::format(" \"float {}\" 3", item.name)) << "\n";
    const auto groom = read_groom_file(file);
    ASSERT_TRUE(groom) << groom.error().message();
    if (*item.why == 0)
      EXPECT_TRUE(groom->ignored.empty()) << item.name;
    else
      EXPECT_THAT(ignored(*groom), ElementsAre("curve " + std::string(item.name) + ": " + item.why));
    fs::remove(file);
  }
}

TEST(FileFaults, MaterialsOfPbrtAreListedWithWhatIsNotRead) {
  const fs::path file = fs::path(testing::TempDir()) / "materials.pbrt";
  const std::string curve = "Shape \"curve\" \"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]\n";
  std::ofstream(file) << "WorldBegin\nMaterial \"coateddiffuse\" \"rgb reflectance\" [.9 .6 .1]\n"
                      << curve << "Material \"hair\" \"float eumelanin\" 1 \"texture beta_m\" \"t\"\n"
                      << curve << "NamedMaterial \"none\"\nColorSpace \"srgb\"\n"
                      << curve;
  const auto groom = read_groom_file(file);
  ASSERT_TRUE(groom) << groom.error().message();
  ASSERT_EQ(groom->materials.size(), 2u);
  EXPECT_EQ(groom->materials[0], "coateddiffuse: a material that is not hair, which is not read");
  EXPECT_THAT(groom->materials[1], testing::EndsWith("; not read: beta_m"));
  EXPECT_THAT(ignored(*groom), ElementsAre("NamedMaterial \"none\": no MakeNamedMaterial before it has the name"));
  fs::remove(file);
}

}  // namespace
}  // namespace tress::scene
