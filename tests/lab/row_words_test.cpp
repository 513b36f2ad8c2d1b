// A row's line of telemetry: its command is run as it stands, and shows the row that the line is of.
#include "cli/row_words.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "cli/run_tress.h"
#include "fiber/rough_rows.h"
#include "tress/adaptive/traced_nodes.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::test {
namespace {

class RowWords : public CommandTest {
 protected:
  /// The words of a command line but for the program.
  static std::vector<std::string> words(const std::string& json_text) {
    std::istringstream line(nlohmann::json::parse(json_text).get<std::string>());
    std::vector<std::string> words;
    for (std::string word; line >> word;) words.push_back(word);
    EXPECT_EQ(words.at(0), "tress-lab");
    words.erase(words.begin());
    return words;
  }
  nlohmann::json found_by(std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    return run_json(arguments);
  }
};

TEST_F(RowWords, TheCommandOfADensityFindsTheSameTarget) {
  const auto target = fiber::make_elliptical_target();
  for (const int lobe : {1, 2, 3, fiber::glint_slice, fiber::trt_rest_slice}) {
    const adaptive::SliceDescription slice = fiber::elliptical_slice(lobe, 1.53f, 0.7f, 0.2f);
    for (const std::uint32_t node : {0u, 5u, slice.node_count() / 2}) {
      const std::uint32_t width = static_cast<std::uint32_t>(slice.axis_b.size());
      const float phi_r = slice.axis_a[node / width], theta_d = slice.axis_b[node % width];
      std::vector<adaptive::TracedRay> rays;
      target->trace(slice, phi_r, theta_d, rays);
      const adaptive::TracedNodes g(rays, slice.blur_rad);
      const auto fields = cli::words_of_row(slice, node, 0.02);
      const nlohmann::json found = found_by(words(fields.at("command")));
      EXPECT_LE(found.at("relative_l2"), 0.02) << fields.at("command");
      double largest = 0, off = 0;
      for (std::size_t i = 0; i < found.at("target").size(); ++i) {
        const double phi = found["phi_deg"][i].get<double>() * std::numbers::pi / 180;
        const double there = g.density(adaptive::wrap_angle(static_cast<float>(phi) - phi_r));
        largest = std::max(largest, there);
        off = std::max(off, std::abs(there - found["target"][i].get<double>()));
      }
      // The rays of a node are a midpoint rule of 128 or more, blurred by 11 degrees. A neighbouring node is off by 5
      // %.
      EXPECT_LT(off, 0.01 * largest) << fields.at("command");
    }
  }
}

TEST_F(RowWords, TheCommandOfSamplesIsOfThatFiberAndDirection) {
  fiber::FiberParameters parameters;
  parameters.eccentricity = 0.7f;
  parameters.roughness = 0.3f;
  const adaptive::SliceDescription slice = fiber::rough_slice(parameters);
  const std::uint32_t node = slice.node_count() / 3;
  const std::uint32_t width = static_cast<std::uint32_t>(slice.axis_b.size());
  const auto fields = cli::words_of_row(slice, node, 0.01);
  std::vector<std::string> arguments = words(fields.at("command"));
  EXPECT_EQ(arguments.at(0), "far-field");
  arguments.insert(arguments.end(), {"--paths", "100", "--model", "fiber3d"});
  arguments.erase(std::ranges::find(arguments, "--model"), std::ranges::find(arguments, "--model") + 2);
  const nlohmann::json found = found_by(arguments).at("parameters");
  const auto degrees = [](float x) { return static_cast<double>(x) * 180 / std::numbers::pi; };
  EXPECT_NEAR(found.at("theta_r_deg"), degrees(slice.axis_a[node / width]), 1e-4);
  EXPECT_NEAR(found.at("phi_r_deg"), degrees(slice.axis_b[node % width]), 1e-4);
  EXPECT_NEAR(found.at("tilt_deg"), degrees(parameters.tilt), 1e-4);
}

TEST_F(RowWords, NothingIsSaidOfWhatIsNotKnown) {
  adaptive::SliceDescription slice = fiber::elliptical_slice(1, 1.55f, 0.85f, 0.2f);
  EXPECT_TRUE(cli::words_of_row(slice, slice.node_count(), 0.01).empty());
  slice.key.lobe = 99;
  EXPECT_TRUE(cli::words_of_row(slice, 0, 0.01).empty());
}

}  // namespace
}  // namespace tress::test
