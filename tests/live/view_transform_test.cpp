// The live page shows colors as the preview has them: one is JavaScript, the other C++.
#include "image/view_transform.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/vec3.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "live/web_page.h"
#include "tress/base/random.h"

namespace tress::live {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::json;

/// Dark and bright, of any hue, and what no light should be. Seed 1.
std::vector<glm::vec3> colors() {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  std::vector<glm::vec3> all{{0, 0, 0},    {1, 1, 1},     {0.18f, 0.18f, 0.18f},
                             {1e7f, 0, 0}, {-1, 0.5f, 2}, {none, 0.2f, 0.1f}};
  for (std::uint64_t i = 0; i < 3000; ++i) {
    RandomStream random(1, i);
    glm::vec3 color;
    for (int c = 0; c < 3; ++c) color[c] = std::exp2(-14 + 20 * random.next());
    all.push_back(color);
  }
  return all;
}

/// What node makes of them, by name of the view; null where it has failed.
json shown_by_the_page(const std::vector<glm::vec3>& colors) {
  const fs::path folder = fs::path(::testing::TempDir()) / ("tress_views_" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "transforms.js") << web_assets().at("view_transform.js");
  json list = json::array();
  for (const glm::vec3& color : colors) list.push_back({color.x, color.y, color.z});
  std::ofstream(folder / "colors.json") << list;
  const std::string script = (fs::path(TRESS_SOURCE_DIR) / "tests/live/view_transform_page.js").string();
  const std::string command = "node '" + script + "' '" + (folder / "transforms.js").string() + "' '" +
                              (folder / "colors.json").string() + "' > '" + (folder / "out").string() + "'";
  const int status = std::system(command.c_str());
  std::ifstream out(folder / "out");
  const json result = status == 0 ? json::parse(out, nullptr, false) : json();
  fs::remove_all(folder);
  return result;
}

// A table of sRGB in 65536 steps is off by half a step of 0.0002 at most, that is a 40th of a step of 8 bits; floats
// here and doubles there differ by 1e-5.
TEST(LivePage, ShowsColorsAsThePreviewDoes) {
  const auto all = colors();
  const json page = shown_by_the_page(all);
  ASSERT_TRUE(page.is_object()) << "node must be there (bootstrap installs nodejs)";
  ASSERT_EQ(page.size(), image::view_names().size());
  for (const std::string& name : image::view_names()) {
    ASSERT_EQ(page.at(name).size(), all.size()) << name;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const glm::vec3 preview = image::displayed(*image::view_of(name), all[i]);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(page.at(name)[i][static_cast<std::size_t>(c)].get<float>(), preview[c], 1.2e-4)
            << name << ' ' << all[i].x << ' ' << all[i].y << ' ' << all[i].z;
    }
  }
}

}  // namespace
}  // namespace tress::live
