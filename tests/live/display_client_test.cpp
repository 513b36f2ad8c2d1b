// The picture in a viewer, by packets that a small one takes.
#include "live/display_client.h"

#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <optional>
#include <string>

#include "live/small_viewer.h"
#include "live/viewer_packets.h"

namespace tress::live {
namespace {

using test::SmallViewer;
using namespace std::chrono_literals;

DisplayClient::Options quick() {
  DisplayClient::Options options;
  options.cpu_share = 1;
  options.patience = 300ms;
  options.retry = 5ms;
  return options;
}

/// Three layers of 300 x 140 pixels: 3 x 2 tiles.
image::Picture some_picture(float seed = 1) {
  image::Picture picture;
  picture.width = 300;
  picture.height = 140;
  for (const char* name : {"R", "G", "B", "A", "TT.R", "TT.G", "TT.B", "Z"}) {
    image::Channel channel{name, {}};
    for (int i = 0; i < picture.width * picture.height; ++i)
      channel.pixels.push_back(seed / (1.0f + static_cast<float>(i)) + static_cast<float>(name[0]));
    picture.channels.push_back(std::move(channel));
  }
  return picture;
}

std::shared_ptr<const image::Picture> shared(image::Picture picture) {
  return std::make_shared<const image::Picture>(std::move(picture));
}

void expect_shown(const SmallViewer& viewer, const std::string& name, const image::Picture& picture) {
  const SmallViewer::Image image = viewer.image(name);
  ASSERT_EQ(image.width, picture.width);
  ASSERT_EQ(image.height, picture.height);
  ASSERT_EQ(image.channels.size(), picture.channels.size());
  for (const image::Channel& channel : picture.channels) {
    const auto found = image.channels.find(channel.name);
    ASSERT_NE(found, image.channels.end()) << channel.name;
    std::size_t different = 0;
    for (std::size_t i = 0; i < channel.pixels.size(); ++i)
      different += std::bit_cast<std::uint32_t>(found->second[i]) != std::bit_cast<std::uint32_t>(channel.pixels[i]);
    EXPECT_EQ(different, 0u) << channel.name;
  }
  EXPECT_EQ(viewer.bad(), 0);
}

/// Waits until the client has sent what it was given.
bool is_idle(const DisplayClient& client) {
  return SmallViewer::wait_until([&] { return client.wants_picture(); });
}

TEST(ViewerPackets, AreTheBytesOfTheProtocol) {
  const std::string packet = create_image_packet("a.exr", 2, 1, {"R", "G", "B"});
  const std::string expected("\x1e\0\0\0\x04\0a.exr\0\x02\0\0\0\x01\0\0\0\x03\0\0\0R\0G\0B\0", 30);
  EXPECT_EQ(packet, expected);
  const image::Channel channel{"Z", {0, 1, 0, 2}};
  const std::string update = update_image_packet("i", {&channel}, 2, {1, 0, 1, 2});
  const std::string bytes(
      "\x26\0\0\0\x05\0i\0\x01\0\0\0Z\0\x01\0\0\0\0\0\0\0\x01\0\0\0\x02\0\0\0\0\0\x80\x3f\0\0\0\x40", 38);
  EXPECT_EQ(update, bytes);
}

TEST(ViewerPackets, TilesCoverThePictureOnce) {
  for (const auto& [width, height] : {std::pair{1, 1}, {128, 128}, {129, 128}, {300, 140}}) {
    std::vector<int> count(static_cast<std::size_t>(width * height), 0);
    for (const image::Window& tile : tiles_of(width, height)) {
      for (int y = tile.top; y < tile.top + tile.height; ++y)
        for (int x = tile.left; x < tile.left + tile.width; ++x) ++count.at(static_cast<std::size_t>(y * width + x));
    }
    EXPECT_EQ(count, std::vector<int>(count.size(), 1)) << width << " x " << height;
  }
}

TEST(FindEndpoint, RefusesWhatIsNone) {
  for (const char* text : {"", "localhost", "localhost:", ":14158", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:x",
                           "::1:14158", "127.0.0.1:14158 "})
    EXPECT_FALSE(find_endpoint(text)) << text;
  EXPECT_TRUE(find_endpoint("127.0.0.1:14158"));
  EXPECT_TRUE(find_endpoint("[::1]:14158"));
}

TEST(DisplayClient, TheViewerHasEveryLayerToTheBit) {
  SmallViewer viewer;
  DisplayClient client(*find_endpoint(viewer.address()), "a.exr", quick());
  client.show(shared(some_picture(1)));
  ASSERT_TRUE(is_idle(client));
  const image::Picture last = some_picture(2);
  EXPECT_TRUE(client.finish(shared(last)));
  ASSERT_TRUE(SmallViewer::wait_until([&] { return viewer.updates() == 2 * 3 * 6; })) << viewer.updates();
  EXPECT_EQ(viewer.created(), 1);
  expect_shown(viewer, "a.exr", last);
}

TEST(DisplayClient, OnlyTilesThatChangedAreSent) {
  SmallViewer viewer;
  DisplayClient client(*find_endpoint(viewer.address()), "a.exr", quick());
  image::Picture picture = some_picture();
  client.show(shared(picture));
  ASSERT_TRUE(is_idle(client));
  ASSERT_TRUE(SmallViewer::wait_until([&] { return viewer.updates() == 18; })) << viewer.updates();
  client.show(shared(picture));
  ASSERT_TRUE(is_idle(client));
  picture.channels[4].pixels.back() += 1;  // TT, the last tile
  EXPECT_TRUE(client.finish(shared(picture)));
  ASSERT_TRUE(SmallViewer::wait_until([&] { return viewer.updates() >= 19; }));
  expect_shown(viewer, "a.exr", picture);
  EXPECT_EQ(viewer.updates(), 19);
}

TEST(DisplayClient, AViewerThatComesLateSeesThePictureAndOneThatLeftSeesItAnew) {
  std::optional<SmallViewer> viewer(std::in_place);
  const std::uint16_t port = viewer->port();
  const std::string address = viewer->address();
  viewer.reset();
  DisplayClient client(*find_endpoint(address), "a.exr", quick());
  const image::Picture picture = some_picture();
  client.show(shared(picture));
  ASSERT_TRUE(is_idle(client));
  for (int round = 0; round < 2; ++round) {
    viewer.emplace(port);
    ASSERT_TRUE(viewer->is_listening());
    EXPECT_TRUE(SmallViewer::wait_until([&] { return viewer->updates() == 18; })) << viewer->updates();
    expect_shown(*viewer, "a.exr", picture);
    viewer.reset();
  }
  EXPECT_FALSE(client.finish(shared(picture)));
}

TEST(DisplayClient, AStalledViewerHoldsNobodyUp) {
  SmallViewer viewer(0, SmallViewer::Manner::stalls);
  DisplayClient client(*find_endpoint(viewer.address()), "a.exr", quick());
  image::Picture large = some_picture();  // 43 MB: more than sockets hold
  large.width = large.height = 1160;
  for (image::Channel& channel : large.channels) channel.pixels.assign(1160 * 1160, 1.0f);
  const auto picture = shared(std::move(large));
  const auto start = std::chrono::steady_clock::now();
  client.show(picture);
  EXPECT_FALSE(client.wants_picture());
  EXPECT_LT(std::chrono::steady_clock::now() - start, 100ms);
  ASSERT_TRUE(is_idle(client));  // given up
  const auto end = std::chrono::steady_clock::now();
  EXPECT_FALSE(client.finish(picture));
  EXPECT_LT(std::chrono::steady_clock::now() - end, quick().patience) << "waited for it once more";
}

TEST(DisplayClient, EndsAtOnceWhileItSends) {
  SmallViewer viewer(0, SmallViewer::Manner::stalls);
  DisplayClient::Options patient = quick();
  patient.patience = 60s;
  const auto start = std::chrono::steady_clock::now();
  {
    DisplayClient client(*find_endpoint(viewer.address()), "a.exr", patient);
    image::Picture large = some_picture();
    large.width = large.height = 1160;
    for (image::Channel& channel : large.channels) channel.pixels.assign(1160 * 1160, 1.0f);
    client.show(shared(std::move(large)));
    std::this_thread::sleep_for(50ms);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);
}

TEST(TimeShare, AllTogetherStaysWithinTheShare) {
  const TimeShare::Clock::time_point start{};
  TimeShare time(0.01, start);
  double spent = 0;
  for (int ms = 0; ms < 100000; ms += 7) {
    if (!time.is_due(start + std::chrono::milliseconds(ms))) continue;
    const double cost = 0.005 + 0.00001 * ms / 100;
    time.spent(TimeShare::Seconds(cost));
    spent += cost;
    EXPECT_LE(spent, 0.01 * 1.2 * ms / 1000 + 0.02) << ms;
  }
  EXPECT_GT(spent, 0.9);  // of the second that it may take
}

}  // namespace
}  // namespace tress::live
