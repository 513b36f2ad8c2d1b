// tress cache info and verify: what is printed of a whole file, and of one that is not.
#include <gmock/gmock.h>

#include <string>

#include "adaptive/cache_bytes.h"
#include "adaptive/cache_images.h"
#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class CacheInfo : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    bytes_ = encode_cache(adaptive::small_image());
    write_text(path("t.cache"), bytes_);
  }
  nlohmann::json json(const std::string& command, const std::string& file, int status) const {
    const Outcome outcome = run({"cache", command, path(file), "--json"});
    EXPECT_EQ(outcome.status, status) << outcome.err;
    const nlohmann::json parsed = nlohmann::json::parse(outcome.out, nullptr, false);
    EXPECT_FALSE(parsed.is_discarded()) << outcome.out;
    return parsed;
  }
  std::string bytes_;
};

TEST_F(CacheInfo, PrintsTheTableThatIsInTheFile) {
  const nlohmann::json info = json("info", "t.cache", 0);
  EXPECT_EQ(info.at("model"), "elliptical-test");
  EXPECT_EQ(info.at("format"), 1);
  EXPECT_EQ(info.at("hash"), cache_hash(adaptive::small_image()));
  EXPECT_EQ(info.at("bytes"), bytes_.size());
  EXPECT_EQ(info.at("rows"), (nlohmann::json{{"open", 2}, {"converged", 1}}));
  ASSERT_EQ(info.at("pages").size(), 2u);
  const nlohmann::json& slice = info.at("pages")[0];
  EXPECT_EQ(slice.at("key").at("lobe"), "TT");
  EXPECT_EQ(slice.at("key").at("e"), 0.85);
  EXPECT_EQ(slice.at("nodes"), 6);
  EXPECT_EQ(slice.at("rows"), (nlohmann::json{{"open", 1}, {"converged", 1}}));
  EXPECT_EQ(slice.at("components"), 2);
  const Outcome text = run({"cache", "info", path("t.cache")});
  EXPECT_THAT(text.out, HasSubstr("rows    2 open, 1 converged\n"));
  EXPECT_THAT(text.out, HasSubstr(info.at("hash").get<std::string>()));
}

/// By slice: how many paths taught the converged rows, and below what their errors are known to be.
TEST_F(CacheInfo, PrintsTheAccuracyOfEachSlice) {
  adaptive::TableSnapshot table = adaptive::small_image();
  adaptive::CachedSlice& slice = table.slices[0];
  slice.rows.clear();
  for (std::uint32_t node = 0; node < 6; ++node)
    slice.rows.push_back(adaptive::converged_row(node, 0.001f * static_cast<float>(6 - node)));
  write_text(path("a.cache"), encode_cache(table));
  const nlohmann::json info = json("info", "a.cache", 0);
  const nlohmann::json& page = info.at("pages")[0];
  EXPECT_EQ(page.at("samples"), 6 * 64);
  EXPECT_FLOAT_EQ(page.at("error").at("median").get<float>(), 0.003f);
  EXPECT_FLOAT_EQ(page.at("error").at("q90").get<float>(), 0.005f);
  EXPECT_FLOAT_EQ(page.at("error").at("q99").get<float>(), 0.005f);
  EXPECT_FLOAT_EQ(page.at("error").at("max").get<float>(), 0.006f);
  EXPECT_EQ(info.at("pages")[1].at("samples"), 0);
  EXPECT_FALSE(info.at("pages")[1].contains("error")) << "none has converged";
  const std::string text = run({"cache", "info", path("a.cache")}).out;
  EXPECT_THAT(text, HasSubstr("accuracy of the converged rows"));
  EXPECT_THAT(text, testing::ContainsRegex("TT +6 +384 +0.003 +0.005 +0.005 +0.006  eta"));
}

TEST_F(CacheInfo, CountsRowsOfKnotsThatAreLearnedAnew) {
  write_text(path("k.cache"), adaptive::knot_cache());
  const nlohmann::json info = json("info", "k.cache", 0);
  EXPECT_EQ(info.at("format"), 2);
  EXPECT_EQ(info.at("rows"), (nlohmann::json{{"open", 2}, {"converged", 1}}));
  EXPECT_EQ(info.at("knot_tables"), 1);
  EXPECT_EQ(info.at("pages")[0].at("components"), 2);
  EXPECT_THAT(run({"cache", "info", path("k.cache")}).out, HasSubstr("knots   1 more rows, of an earlier version"));
  const Outcome merged = run({"cache", "merge", path("k.cache"), path("t.cache"), "-o", path("m.cache")});
  EXPECT_THAT(merged.err, HasSubstr("k.cache: 1 rows of knots are left out"));
  EXPECT_EQ(json("info", "m.cache", 0).at("hash"), cache_hash(adaptive::small_image()));
}

TEST_F(CacheInfo, NamesSlicesOfSamplesByTheirParameters) {
  write_text(path("s.cache"), adaptive::encode_cache(adaptive::samples_image()));
  const nlohmann::json info = json("info", "s.cache", 0);
  EXPECT_EQ(info.at("format"), 3);
  EXPECT_EQ(info.at("rows"), (nlohmann::json{{"open", 3}, {"converged", 3}}));
  EXPECT_EQ(info.at("ribbons"), 2);
  EXPECT_EQ(info.at("knot_tables"), 0);
  ASSERT_EQ(info.at("pages").size(), 3u);
  EXPECT_EQ(info.at("pages")[0].at("kind"), "densities");
  EXPECT_EQ(info.at("pages")[0].at("ribbons"), 0);
  const nlohmann::json& slice = info.at("pages")[2];
  EXPECT_EQ(slice.at("kind"), "samples");
  EXPECT_EQ(slice.at("key"),
            (nlohmann::json{{"lobe", "rough"}, {"parameters", {1.55, 0.85, 0.3, 0.05, 0.0, 0.0, 0.0, 2.0}}}));
  EXPECT_EQ(slice.at("rows"), (nlohmann::json{{"open", 1}, {"converged", 2}}));
  EXPECT_EQ(slice.at("ribbons"), 2);
  EXPECT_EQ(slice.at("components"), 0);
  std::uint64_t bytes = 0;
  for (const nlohmann::json& page : info.at("pages")) bytes += page.at("bytes").get<std::uint64_t>();
  EXPECT_EQ(bytes + 24 + 4 * 24 + 4 + 15 + 4, info.at("bytes")) << "headers, the model's name, the number of pages";
  const std::string text = run({"cache", "info", path("s.cache")}).out;
  EXPECT_THAT(text, HasSubstr("ribbons 2 of the converged\n"));
  EXPECT_THAT(text, HasSubstr("1.55 0.85 0.3 0.05 0 0 0 2\n"));
}

TEST_F(CacheInfo, VerifySaysWhichByteIsWrong) {
  EXPECT_EQ(json("verify", "t.cache", 0), (nlohmann::json{{"file", path("t.cache")}, {"ok", true}}));
  EXPECT_EQ(run({"cache", "verify", path("t.cache")}).out, path("t.cache") + ": ok\n");
  bytes_[bytes_.size() / 2] ^= 1;
  write_text(path("flipped.cache"), bytes_);
  const nlohmann::json flipped = json("verify", "flipped.cache", 1);
  EXPECT_EQ(flipped.at("ok"), false);
  EXPECT_THAT(flipped.at("reason").get<std::string>(), HasSubstr("flipped.cache: section "));
  const Outcome info = run({"cache", "info", path("flipped.cache"), "--json"});
  EXPECT_EQ(info.status, 1);
  EXPECT_THAT(info.out, IsEmpty());
  EXPECT_THAT(info.err, HasSubstr("checksum"));
}

}  // namespace
}  // namespace tress::test
