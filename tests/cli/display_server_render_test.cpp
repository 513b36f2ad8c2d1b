// A render that a viewer watches.
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "cli/run_tress.h"
#include "image/picture.h"
#include "live/small_viewer.h"

namespace tress::test {
namespace {

class DisplayServer : public CommandTest {
 protected:
  std::vector<std::string> command(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render",       std::string(TRESS_SOURCE_DIR) + "/scenes/brown_lock.json",
                                   "-o",           path("a.exr"),
                                   "--spp",        "3",
                                   "--resolution", "64x48"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(DisplayServer, TheViewerEndsWithTheBitsOfTheFile) {
  for (const char* precision : {"half", "float"}) {
    SmallViewer viewer;
    const Outcome outcome = run(command({"--display-server", viewer.address(), "--precision", precision}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Result<image::Picture> picture = image::read_exr(path("a.exr"));
    ASSERT_TRUE(picture) << picture.error().message();
    const auto as_the_file = [&] {
      const SmallViewer::Image image = viewer.image(path("a.exr"));
      if (image.channels.size() != picture->channels.size()) return false;
      for (const image::Channel& channel : picture->channels) {
        const auto found = image.channels.find(channel.name);
        if (found == image.channels.end() || found->second.size() != channel.pixels.size()) return false;
        for (std::size_t i = 0; i < channel.pixels.size(); ++i) {
          if (std::bit_cast<std::uint32_t>(found->second[i]) != std::bit_cast<std::uint32_t>(channel.pixels[i]))
            return false;
        }
      }
      return true;
    };
    EXPECT_TRUE(SmallViewer::wait_until(as_the_file)) << precision;
    EXPECT_EQ(viewer.bad(), 0);
    EXPECT_LE(viewer.created(), 2);  // mattes are made of the whole picture alone
  }
}

TEST_F(DisplayServer, OnlyTheLayersThatAreAskedForAreShown) {
  SmallViewer viewer;
  ASSERT_EQ(run(command({"--display-server", viewer.address(), "--layers", "TT"})).status, 0);
  EXPECT_TRUE(SmallViewer::wait_until([&] { return viewer.image(path("a.exr")).channels.size() == 7; }));
  EXPECT_TRUE(viewer.image(path("a.exr")).channels.contains("TT.R"));
  EXPECT_EQ(viewer.created(), 1);
  EXPECT_GT(viewer.updates(), 2) << "the picture was shown while it came";
}

TEST_F(DisplayServer, ThePictureIsTheSameWhoeverWatches) {
  ASSERT_EQ(run(command({})).status, 0);
  fs::rename(path("a.exr"), path("alone.exr"));
  const Result<image::Picture> alone = image::read_exr(path("alone.exr"));
  for (const SmallViewer::Manner manner : {SmallViewer::Manner::reads, SmallViewer::Manner::stalls}) {
    SmallViewer viewer(0, manner);
    ASSERT_EQ(run(command({"--display-server", viewer.address()})).status, 0);
    const Result<image::Picture> watched = image::read_exr(path("a.exr"));
    ASSERT_TRUE(alone && watched);
    EXPECT_TRUE(image::compare(*alone, *watched, "alone", "watched")->identical);
    EXPECT_EQ(watched->metadata.at("settings"), alone->metadata.at("settings"));
  }
}

TEST_F(DisplayServer, AViewerThatIsNotThereIsReportedAndAnUnknownHostRefused) {
  SmallViewer viewer;
  Outcome outcome = run(command({"--display-server", "127.0.0.1:1"}));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.err.find("no viewer there"), std::string::npos) << outcome.err;
  outcome = run(command({"--display-server", "14158"}));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("--display-server: expected HOST:PORT"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace tress::test
