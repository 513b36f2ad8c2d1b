// The server of the live page, asked as a browser asks, and as nobody should.
#include "live/render_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace tress::live {
namespace {

using Json = RenderServer::Json;
using namespace std::chrono_literals;

std::shared_ptr<const image::Picture> picture_of(float value) {
  image::Picture picture;
  picture.width = 3;
  picture.height = 2;
  for (const char* name : {"R", "G", "B", "A", "Z"}) picture.channels.push_back({name, std::vector<float>(6, value)});
  return std::make_shared<const image::Picture>(std::move(picture));
}

class LiveServer : public ::testing::Test {
 protected:
  void SetUp() override {
    auto started = RenderServer::start("");
    ASSERT_TRUE(started) << started.error().message();
    server_ = std::move(*started);
    const std::string url = server_->url();
    port_ = std::stoi(url.substr(url.rfind(':') + 1));
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port_);
  }
  Json status(int since = 0) { return Json::parse(client_->Get("/status?since=" + std::to_string(since))->body); }
  int control(const std::string& body, const httplib::Headers& headers = {}, const char* type = "application/json") {
    return client_->Post("/control", headers, body, type)->status;
  }
  /// A connection that says this and then nothing.
  int connected(const std::string& words) const {
    const int file = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    EXPECT_EQ(connect(file, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(send(file, words.data(), words.size(), MSG_NOSIGNAL), static_cast<ssize_t>(words.size()));
    return file;
  }

  std::unique_ptr<RenderServer> server_;
  std::unique_ptr<httplib::Client> client_;
  int port_ = 0;
};

TEST_F(LiveServer, ThePageNeedsNoOtherFile) {
  const auto page = client_->Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_NE(page->body.find("Chart.js"), std::string::npos);
  EXPECT_EQ(page->body.find(" src="), std::string::npos);
}

TEST_F(LiveServer, ALookIsTakenOnceAndBeginsThePassesAnew) {
  EXPECT_EQ(control(R"({"do":"look","values":{}})"), 400) << "none is offered";
  server_->offer({{"melanin", "Melanin", 0, 8, 0.1, 1.3}, {"tilt", "Tilt", 0, 10, 0.5, 3}}, {0.1, 0.2, 0.3}, {});
  const Json offered = status();
  ASSERT_EQ(offered["sliders"].size(), 2u);
  EXPECT_EQ(offered["sliders"][0]["value"], 1.3);
  EXPECT_EQ(offered["color"], (Json{0.1, 0.2, 0.3}));
  server_->show(picture_of(1));
  for (int i = 0; i < 3; ++i) server_->add_pass({{"pass", i}});
  EXPECT_FALSE(server_->is_look_asked());
  EXPECT_EQ(control(R"({"do":"pause"})"), 200);
  EXPECT_EQ(control(R"({"do":"look","values":{"melanin":4}})"), 200);
  EXPECT_EQ(control(R"({"do":"look","values":{"melanin":5.5,"tilt":0}})"), 200);
  EXPECT_TRUE(server_->is_look_asked());
  EXPECT_FALSE(server_->is_paused()) << "one wants to see it";
  const RenderServer::Look taken = server_->take_look();
  EXPECT_EQ(taken.values, (std::map<std::string, double>{{"melanin", 5.5}, {"tilt", 0}})) << "the last one";
  EXPECT_EQ(taken.color, "");
  EXPECT_FALSE(server_->is_look_asked());
  server_->add_pass({{"pass", 0}});
  server_->show(picture_of(2));
  const Json answer = status(3);
  EXPECT_EQ(answer["look"], 2);
  EXPECT_EQ(answer["first"], 3);
  ASSERT_EQ(answer["passes"].size(), 1u);
  EXPECT_EQ(answer["first_of_look"], answer["picture"]);
  EXPECT_EQ(answer["look_before"], 1);
  const auto before = client_->Get("/picture?which=look&layer=beauty");
  ASSERT_EQ(before->status, 200);
  float value = 0;
  std::memcpy(&value, before->body.data(), sizeof value);
  EXPECT_EQ(value, 1) << "the picture of the look before";
}

TEST_F(LiveServer, AColorIsTakenAsItsTextUnlessItIsRefused) {
  server_->offer({{"tilt", "Tilt", 0, 10, 0.5, 3}}, {0.1, 0.2, 0.3}, [](const std::string& json) {
    return std::string(json.find("ramp") == json.npos ? "--color: no" : "");
  });
  EXPECT_EQ(control(R"({"do":"look","values":{},"color":[1, 2]})"), 400);
  EXPECT_FALSE(server_->is_look_asked());
  EXPECT_EQ(control(R"({"do":"look","values":{"tilt":1},"color":{"ramp": [[0.5, [0.25, 1, 0]]]}})"), 200);
  const RenderServer::Look look = server_->take_look();
  EXPECT_EQ(look.color, R"({"ramp":[[0.5,[0.25,1,0]]]})");
  EXPECT_EQ(look.values.at("tilt"), 1);
}

TEST_F(LiveServer, AHostileLookIsRefusedByName) {
  server_->offer({{"melanin", "Melanin", 0, 8, 0.1, 1.3}}, nullptr, {});
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"({"do":"look"})", "values: expected"},
      {R"({"do":"look","values":[1]})", "values: expected"},
      {R"({"do":"look","values":{"melanin":1,"tilt":2}})", "values: expected"},
      {R"({"do":"look","values":{"depth":2}})", "depth: expected one of melanin"},
      {R"({"do":"look","values":{"melanin":-0.1}})", "melanin: expected 0..8, found -0.1"},
      {R"({"do":"look","values":{"melanin":1e300}})", "melanin: expected 0..8, found 1e+300"},
      {R"({"do":"look","values":{"melanin":"4"}})", "melanin: expected 0..8, found \"4\""},
      {R"({"do":"look","values":{"melanin":null}})", "melanin: expected 0..8, found null"}};
  for (const auto& [body, named] : cases) {
    const auto answer = client_->Post("/control", body, "application/json");
    EXPECT_EQ(answer->status, 400) << body;
    EXPECT_NE(Json::parse(answer->body).value("error", "").find(named), std::string::npos) << answer->body;
  }
  EXPECT_EQ(control(R"({"do":"look","values":{"melanin":1e999}})"), 400);
  EXPECT_FALSE(server_->is_look_asked());
}

TEST_F(LiveServer, StatusHasThePassesSinceThoseThatAreKnown) {
  EXPECT_FALSE(server_->is_watched());
  for (int i = 0; i < 5; ++i) server_->add_pass({{"pass", i}});
  server_->set_facts({{"said", "x"}});
  const Json answer = status(3);
  EXPECT_TRUE(server_->is_watched());
  EXPECT_EQ(answer["said"], "x");
  EXPECT_EQ(answer["first"], 3);
  ASSERT_EQ(answer["passes"].size(), 2u);
  EXPECT_EQ(answer["passes"][1]["pass"], 4);
  for (std::size_t i = 0; i < RenderServer::most_passes; ++i) server_->add_pass({{"pass", i}});
  EXPECT_EQ(status(0)["first"], 5) << "older ones are forgotten";
}

TEST_F(LiveServer, PicturesAreFloatsByLayer) {
  EXPECT_EQ(client_->Get("/picture?which=&layer=beauty")->status, 404);
  server_->show(picture_of(0.25f));
  server_->show(picture_of(0.5f));
  EXPECT_EQ(status()["picture"], 2);
  for (const auto& [which, value] : {std::pair{"", 0.5f}, {"before", 0.25f}}) {
    for (const char* layer : {"beauty", "Z"}) {
      const auto got = client_->Get(std::string("/picture?which=") + which + "&layer=" + layer);
      ASSERT_EQ(got->status, 200);
      EXPECT_EQ(got->get_header_value("X-Size"), "3x2");
      ASSERT_EQ(got->body.size(), 3 * 6 * sizeof(float));
      float last = 0;
      std::memcpy(&last, got->body.data() + got->body.size() - sizeof last, sizeof last);
      EXPECT_EQ(last, value);
    }
  }
  EXPECT_EQ(client_->Get("/picture?which=&layer=nothing")->status, 404);
}

TEST_F(LiveServer, TakesWhatThePageAsks) {
  EXPECT_EQ(control(R"({"do":"pause"})"), 200);
  EXPECT_TRUE(server_->is_paused());
  EXPECT_EQ(control(R"({"do":"resume"})"), 200);
  EXPECT_FALSE(server_->is_paused());
  EXPECT_EQ(control(R"({"do":"save"})"), 200);
  EXPECT_EQ(control(R"({"do":"row","slice":1,"node":99999999999})"), 200);
  const RenderServer::Asked asked = server_->take_asked();
  EXPECT_TRUE(asked.save);
  ASSERT_EQ(asked.rows.size(), 1u);
  EXPECT_EQ(asked.rows[0].slice, 1u);
  EXPECT_FALSE(server_->take_asked().save);
  EXPECT_EQ(client_->Get("/row?request=1")->status, 204);
  server_->answer_row(1, {{"words", "y"}});
  EXPECT_EQ(Json::parse(client_->Get("/row?request=1")->body)["words"], "y");
  EXPECT_EQ(control(R"({"do":"stop"})"), 200);
  EXPECT_TRUE(server_->is_stopped());
}

TEST_F(LiveServer, OtherOriginsHostsAndWordsAreRefused) {
  const std::string stop = R"({"do":"stop"})", own = "http://127.0.0.1:" + std::to_string(port_);
  EXPECT_EQ(control(stop, {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(control(stop, {{"Origin", "null"}}), 403);
  EXPECT_EQ(control(stop, {{"Host", "evil.example:" + std::to_string(port_)}}), 403);
  EXPECT_EQ(control(stop, {}, "text/plain"), 403) << "as a form of another page would send it";
  EXPECT_EQ(client_->Get("/status", {{"Origin", "http://evil.example"}})->status, 403);
  for (const char* words : {"", "[]", "{}", R"({"do":1})", R"({"do":"row","slice":-1,"node":0})", "{\"do\":\"stop\""})
    EXPECT_EQ(control(words), 400) << words;
  EXPECT_EQ(control(std::string(100000, ' ')), 413);
  EXPECT_FALSE(server_->is_stopped());
  EXPECT_EQ(control(stop, {{"Origin", own}}), 200);
}

TEST_F(LiveServer, EndsSoonWhateverItsClientsDo) {
  std::vector<int> files;
  for (int i = 0; i < 20; ++i) files.push_back(connected(i % 2 == 0 ? "" : "GET /status HTTP/1.1\r\nHost: "));
  const auto start = std::chrono::steady_clock::now();
  server_->add_pass({{"pass", 0}});
  server_->show(picture_of(1));
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s) << "the render waited";
  server_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s) << "a silent client holds a thread for some seconds only";
  for (const int file : files) close(file);
}

TEST(LiveServerAddress, IsReportedWhereItIsWrong) {
  for (const char* address : {"127.0.0.1:x", "127.0.0.1:65536", "127.0.0.1:-1", "256.1.1.1:0"}) {
    const auto server = RenderServer::start(address);
    ASSERT_FALSE(server) << address;
    EXPECT_NE(server.error().message().find("--serve"), std::string::npos);
  }
}

}  // namespace
}  // namespace tress::live
