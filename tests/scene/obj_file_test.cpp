#include "scene/read/obj_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "scene/read/assembly.h"
#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"
#include "tress/base/random.h"

namespace tress::scene {
namespace {

Result<ObjFile> parse_obj(const std::string& text) {
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  return parse_obj_file(bytes, "a.obj");
}

std::string refusal(const std::string& text) {
  const auto file = parse_obj(text);
  return file ? "" : file.error().message();
}

/// At rest.
Result<Mesh> placed(const ObjFile& file, const MeshDescription& description, const std::string& name,
                    std::vector<std::string>* warnings) {
  return place_mesh(std::array{MeshAtMoment{&file, description.path.at(0)}}, description, name, warnings);
}

const std::string square = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n";

TEST(ObjFile, ReadsEveryFormOfFace) {
  const glm::uvec3 low(0, 1, 2), high(0, 2, 3);
  for (const char* face :
       {"f 1 2 3 4", "f 1/1 2/2 3/3 4/4", "f 1//7 2//7 3//7 4//7", "f 1/1/1 2/2/1 3/3/1 4/-4/1", "f -4 -3 -2 -1",
        "  f\t1  2 3 4 \r", "f 1 2 \\\n 3 4", "f 1 2 3 4 # four", "f 1 2 3\nf 1 3 4"}) {
    const auto file =
        parse_obj("# a comment\nmtllib a.mtl\no square\n" + square + "vn 0 0 1\nvt 0 0\nusemtl x\ns off\n" + face);
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->triangles.size(), 2u) << face;
    EXPECT_EQ(file->triangles[0], low) << face;
    EXPECT_EQ(file->triangles[1], high) << face;
  }
  const auto file = parse_obj("v 1e-3 +2.5 -3 1 .5 .5 .5\nv 4 5 6\nv 7 8 9\nf 3 2 1\n");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->positions[0], glm::vec3(1e-3f, 2.5f, -3));
  EXPECT_EQ(file->triangles[0], glm::uvec3(2, 1, 0));
}

/// The same for texture coordinates; those of a bad line count as missing.
TEST(ObjFile, ReadsTextureCoordinatesWhereTheyAreGood) {
  const auto file =
      parse_obj(square + "vt 0.5 -2 9\nvt 1 nonsense\nvt 1e7 0\nvt 0.25 3\nf 1/1 2/-1 3/4\nf 1/2 2/3 3/9\nf 1 2 3\n");
  ASSERT_TRUE(file) << file.error().message();
  ASSERT_EQ(file->corner_uvs.size(), 3u);
  EXPECT_EQ(file->corner_uvs[0], glm::uvec3(0, 3, 3));
  EXPECT_EQ(file->corner_uvs[1], glm::uvec3(no_uv, no_uv, no_uv));
  EXPECT_EQ(file->corner_uvs[2], glm::uvec3(no_uv, no_uv, no_uv));
  EXPECT_EQ(file->uvs[0], glm::vec2(0.5f, -2));
  EXPECT_TRUE(parse_obj(square + "vt 0 0\nf 1 2 3\n")->corner_uvs.empty());
}

/// A corner names a normal that is there so far, from the front or the back; any other is ignored, and files that name
/// normals badly are read as before.
TEST(ObjFile, ReadsNormalsWhereTheyAreGood) {
  const auto file = parse_obj(square + "vn 0 0 2\nvn 1 nonsense\nvn 1 0 0\nf 1//1 2//-1 3//2 4//9\nf 1 2 3\n");
  ASSERT_TRUE(file) << file.error().message();
  ASSERT_EQ(file->corner_normals.size(), 3u);
  EXPECT_EQ(file->corner_normals[0], glm::uvec3(0, 2, 1));
  EXPECT_EQ(file->corner_normals[1], glm::uvec3(0, 1, no_normal));
  EXPECT_EQ(file->corner_normals[2], glm::uvec3(no_normal, no_normal, no_normal));
  EXPECT_EQ(file->normals[1], glm::vec3(0.0f));
  EXPECT_TRUE(parse_obj(square + "vn 0 0 1\nf 1 2 3\n")->corner_normals.empty());
  MeshDescription description;
  description.y_up = true;
  std::vector<std::string> warnings;
  const auto mesh = placed(*file, description, "a.obj", &warnings);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->normals[0], glm::vec3(0, -1, 0)) << "unit, turned with the file";
  EXPECT_EQ(mesh->corner_normals.size(), mesh->triangles.size());
}

TEST(ObjFile, FansPolygonsAroundTheirFirstVertex) {
  std::string text, face = "f";
  for (int i = 0; i < 1000; ++i) {
    text += fmt::format("v {} {} 0\n", std::cos(i * 0.00628), std::sin(i * 0.00628));
    face += fmt::format(" {}", i + 1);
  }
  const auto file = parse_obj(text + face);
  ASSERT_TRUE(file);
  ASSERT_EQ(file->triangles.size(), 998u);
  for (std::uint32_t i = 0; i < 998; ++i) ASSERT_EQ(file->triangles[i], glm::uvec3(0, i + 1, i + 2));
}

TEST(ObjFile, NamesTheLine) {
  const std::pair<std::string, std::string> wrong[] = {
      {"", "a.obj: expected a face or more, found none in 0 lines"},
      {square, "a.obj: expected a face or more"},
      {square + "f 1 2", "a.obj: line 5: expected a face of three corners or more, found 2"},
      {square + "f", "found 0"},
      {square + "f 1 2 5", "a.obj: line 5: expected an index of one of the 4 vertices so far, found 5"},
      {square + "f 1 2 0", "found 0"},
      {square + "f 1 2 -5", "found -5"},
      {square + "f 1 2 99999999999999999999", "expected a corner as v"},
      {square + "f 1 2 3/", "expected a corner as v"},
      {square + "f 1 2 3/1/", "expected a corner as v"},
      {square + "f 1 2 3/1/1/1", "expected a corner as v"},
      {square + "f 1 2 /3", "expected a corner as v"},
      {square + "f 1 2 3.5", "expected a corner as v"},
      {"f 1 2 3\n" + square, "a.obj: line 1"},
      {"v 0 0\n", "a.obj: line 1: expected a finite coordinate, found the end of the line"},
      {"v 0 nan 0\n", "found nan"},
      {"v 0 inf 0\n", "found inf"},
      {"v 0 1e99 0\n", "found 1e99"},
      {"v 0 0x10 0\n", "found 0x10"},
      {"# x\n\ncurv 0 1 2\n", "a.obj: line 3: expected v, f or another statement of polygons, found curv"},
      {std::string("\x7f"
                   "ELF\0\1\2",
                   7),
       "a.obj: line 1"}};
  for (const auto& [text, why] : wrong) EXPECT_NE(refusal(text).find(why), std::string::npos) << refusal(text);
}

/// Seed 29: texts of a whole file with bytes changed, taken out or doubled are read or refused; indices stay in range.
TEST(ObjFile, SurvivesChangedBytes) {
  const std::string whole =
      "o a\n" + square + "vn 0 0 1\nvt 0.5 0.5\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\nf 1//1 \\\n2//1 3//1\n";
  RandomStream random(29);
  int read = 0;
  for (int i = 0; i < 50000; ++i) {
    std::string text = whole;
    for (auto n = random.next_bits() % 4 + 1; n > 0; --n) {
      const auto at = random.next_bits() % text.size();
      if (const auto how = random.next_bits() % 3; how == 0)
        text[at] = static_cast<char>(random.next_bits());
      else if (how == 1)
        text.erase(at, 1);
      else
        text.insert(at, 1, whole[random.next_bits() % whole.size()]);
    }
    const auto file = parse_obj(text);
    if (!file) continue;
    ++read;
    for (const auto& t : file->triangles)
      ASSERT_TRUE(t.x < file->positions.size() && t.y < file->positions.size() && t.z < file->positions.size());
  }
  EXPECT_GT(read, 1000);
}

TEST(Mesh, IsScaledTurnedAndMoved) {
  MeshDescription description;
  description.y_up = true;
  description.cm_per_unit = 10;
  description.path.still.translate = {1, 2, 3};
  std::vector<std::string> warnings;
  const auto mesh =
      placed(*parse_obj("v 1 2 3\nv 0 0 0\nv 1 0 0\nf 1 2 3\nf 1 2 2\n"), description, "a.obj", &warnings);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->positions[0], glm::vec3(11, -28, 23));
  EXPECT_EQ(mesh->triangles.size(), 1u);  // the other has no area
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "a.obj: 1 of 2 triangles have no area and are left out");
  description.cm_per_unit = 1e6;
  EXPECT_EQ(
      placed(*parse_obj("v 0 1e10 0\nv 0 0 0\nv 1 0 0\nf 1 2 3"), description, "a.obj", &warnings).error().message(),
      "a.obj: vertex 1: expected coordinates within 1e+06 cm, found 1e+16 cm at 1e+06 cm per unit");
}

struct Folder {
  std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "tress_mesh_scene";
  Folder() { std::filesystem::create_directories(path / "parts"); }
  ~Folder() { std::filesystem::remove_all(path); }
};

TEST(LoadScene, FindsMeshesBesideTheSceneFile) {
  const Folder folder;
  std::ofstream(folder.path / "parts" / "head.obj") << square << "f 1 2 3 4\n";
  const auto write = [&](const std::string& file) {
    std::ofstream(folder.path / "s.json")
        << R"({"meshes": [{"file": ")" << file
        << R"(", "albedo": [0.1, 0.2, 0.3]}], "grooms": [{"generate": "single_fiber"}]})";
    return load_scene(folder.path / "s.json");
  };
  const auto scene = write("parts/head.obj");
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->meshes.size(), 1u);
  EXPECT_EQ(scene->meshes[0].positions.size(), 4u);
  EXPECT_EQ(scene->meshes[0].albedo, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_NE(write("parts/none.obj").error().message().find("none.obj: expected an .obj file, found no such file"),
            std::string::npos);
}

}  // namespace
}  // namespace tress::scene
