// The page of the gallery has every scene of it, with its picture. That scenes render is tested in
// scenes_render_test.cpp.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tress::scene {
namespace {

namespace fs = std::filesystem;

TEST(Gallery, ThePageNamesEverySceneWithItsCommandAndPicture) {
  constexpr std::uintmax_t most_bytes = 300'000;
  const fs::path folder = fs::path(TRESS_SOURCE_DIR) / "scenes/gallery";
  std::ifstream file(folder / "README.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  int scenes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    ++scenes;
    const std::string name = entry.path().stem().string();
    EXPECT_NE(page.find("\ntress render scenes/gallery/" + name + ".json "), std::string::npos) << name;
    EXPECT_NE(page.find("(" + name + ".png) | `" + name + ".json`"), std::string::npos) << name;
    ASSERT_TRUE(fs::exists(folder / (name + ".png"))) << name;
    EXPECT_LE(fs::file_size(folder / (name + ".png")), most_bytes) << name;
  }
  EXPECT_GE(scenes, 5);
}

}  // namespace
}  // namespace tress::scene
