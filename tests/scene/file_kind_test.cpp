// What is said of a file that is neither a scene nor a groom.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "scene/read/grooms/groom_formats.h"
#include "scene/read/input_files.h"
#include "scene/read/load_scene.h"

namespace tress::scene {
namespace {

using namespace std::string_literals;

std::string refusal(const std::string& name, const std::string& bytes) {
  const auto file = std::filesystem::path(testing::TempDir()) / (std::to_string(getpid()) + "_" + name);
  std::ofstream(file, std::ios::binary) << bytes;
  const auto scene = load_scene(file);
  std::filesystem::remove(file);
  return scene ? "" : scene.error().message();
}

TEST(FileKind, IsNamedForWhatIsNeitherASceneNorAGroom) {
  const std::vector<std::pair<std::string, std::string>> files{
      {"glTF\2\0"s, "a binary glTF file"},
      {"\x89PNG\r\n\x1a\n\0"s, "a PNG picture"},
      {"solid cube\nfacet"s, "a text that begins \"solid cube\""},
      {"\0\1\2\3\4"s, "binary data that begins 00 01 02 03"},
      {"[1, 2]"s, "a text that begins \"[1, 2]\""}};
  for (const auto& [bytes, kind] : files) {
    for (const char* name : {"tress_kind.xyz", "tress_kind"}) {
      const std::string said = refusal(name, bytes);
      EXPECT_NE(said.find("expected a scene (JSON) or a groom (" + groom_endings() + "), found " + kind),
                std::string::npos)
          << said;
    }
    const std::string groom = refusal("tress_kind.hair", bytes);
    EXPECT_NE(groom.find("the mark of a .hair file, found " + kind), std::string::npos) << groom;
  }
  EXPECT_NE(refusal("tress_kind.json", "\x89PNG\r\n\x1a\n").find("found a PNG picture"), std::string::npos);
}

TEST(FileKind, SaysWhatMakesAGroomThatCanBeRead) {
  const std::vector<std::pair<std::string, std::string>> files{{"\x89HDF\r\n\x1a\n\0"s, "abcconvert -toOgawa"},
                                                               {"PXR-USDC\0"s, "a header of 88 bytes"},
                                                               {"\x1f\x8b\x08\0"s, "packed by gzip"}};
  for (const auto& [bytes, remedy] : files) {
    for (const char* name : {"tress_kind.abc", "tress_kind"}) {
      const std::string said = refusal(name, bytes);
      EXPECT_NE(said.find(remedy), std::string::npos) << said;
    }
  }
}

TEST(FileKind, LeavesScenesToTheirParser) {
  EXPECT_NE(refusal("tress_parsed.json", "{").find("byte 2: expected JSON"), std::string::npos);
  EXPECT_NE(refusal("tress_parsed.json", "grooms").find("expected JSON"), std::string::npos);
  EXPECT_NE(refusal("tress_parsed", " \n{]").find("expected JSON"), std::string::npos);
  EXPECT_EQ(refusal("tress_parsed", R"( {"grooms": [{"generate": "single_fiber"}]})"), "");
}

}  // namespace
}  // namespace tress::scene
