// tress cache merge: any number of files, in any order, to the same bytes; errors by file; nothing half done.
#include <gmock/gmock.h>

#include <algorithm>

#include "adaptive/cache_images.h"
#include "cli/run_tress.h"

namespace tress::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class CacheMergeCommand : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    using namespace adaptive;
    TableSnapshot a = small_image(), b = small_image(), c = small_image();
    b.slices.pop_back();
    b.slices[0].rows = {converged_row(0, 0.002f), open_row(4, {sketch_bin(3, 50, 0.5f)})};
    c.slices.erase(c.slices.begin());
    c.slices[0].rows = {converged_row(0, 0.001f), converged_row(1, 0.001f)};
    for (const auto& [name, image] : {std::pair{"a", a}, {"b", b}, {"c", c}})
      write_text(path(name), encode_cache(image));
    all_ = encode_cache(merge_caches(merge_caches(a, b), c));
  }

  Outcome merge(const std::vector<std::string>& names, const std::string& output) const {
    std::vector<std::string> arguments{"cache", "merge"};
    for (const std::string& name : names) arguments.push_back(path(name));
    arguments.insert(arguments.end(), {"-o", path(output)});
    return run(arguments);
  }

  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  std::string all_;
};

TEST_F(CacheMergeCommand, GivesTheSameBytesForAnyOrderAndAnyGrouping) {
  std::vector<std::string> names{"a", "b", "c"};
  do {
    const Outcome outcome = merge(names, "out");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(read_text(path("out")), all_);
    EXPECT_THAT(outcome.out, HasSubstr("3 files merged, 2 pages, 5 rows, 4 of them converged, hash "));
    EXPECT_THAT(outcome.err, IsEmpty());
  } while (std::next_permutation(names.begin(), names.end()));
  // By way of files with common ancestors, some of them twice.
  ASSERT_EQ(merge({"a", "b"}, "ab").status, 0);
  ASSERT_EQ(merge({"b", "c"}, "bc").status, 0);
  ASSERT_EQ(merge({"bc", "ab", "b", "bc"}, "out").status, 0);
  EXPECT_EQ(read_text(path("out")), all_);
  ASSERT_EQ(merge({"out", "a"}, "again").status, 0);
  EXPECT_EQ(read_text(path("again")), all_);
  ASSERT_EQ(merge({"a"}, "alone").status, 0);
  EXPECT_EQ(read_text(path("alone")), read_text(path("a")));
  EXPECT_EQ(run({"cache", "verify", path("out")}).status, 0);
  const auto info = nlohmann::json::parse(run({"cache", "info", path("out"), "--json"}).out);
  EXPECT_THAT(merge({"out"}, "out").out, HasSubstr(info.at("hash").get<std::string>()));
}

TEST_F(CacheMergeCommand, JoinsSlicesOfBothKindsInAnyOrder) {
  adaptive::TableSnapshot samples{"elliptical-test", {adaptive::slice_of_samples()}};
  samples.slices[0].rows = {adaptive::ribbon_row(1, 0.02f), adaptive::ribbon_row(3, 0.01f, 3)};
  write_text(path("d"), encode_cache(adaptive::samples_image()));
  write_text(path("e"), encode_cache(samples));
  ASSERT_EQ(merge({"d", "e", "b", "a"}, "out").status, 0);
  ASSERT_EQ(merge({"a", "e"}, "ae").status, 0);
  ASSERT_EQ(merge({"ae", "b", "d"}, "other").status, 0);
  EXPECT_EQ(read_text(path("out")), read_text(path("other")));
  const auto info = nlohmann::json::parse(run({"cache", "info", path("out"), "--json"}).out);
  EXPECT_EQ(info.at("ribbons"), 3);
  EXPECT_EQ(info.at("pages")[2].at("rows"), (nlohmann::json{{"open", 0}, {"converged", 3}}));
}

TEST_F(CacheMergeCommand, MayWriteIntoOneOfItsFilesAndThroughALink) {
  fs::create_symlink("c", path("link"));
  const Outcome outcome = merge({"a", "b", "c"}, "link");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_text(path("c")), all_);
}

TEST_F(CacheMergeCommand, NamesEachFileThatItCannotTakeAndWritesNothing) {
  adaptive::TableSnapshot other = adaptive::small_image();
  other.model = "elliptical-0";
  write_text(path("other"), encode_cache(other));
  write_text(path("cut"), read_text(path("a")).substr(0, 100));
  const std::size_t before = files();
  const Outcome outcome = merge({"a", "other", "cut", "none", "b"}, "out");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_THAT(outcome.err, HasSubstr(path("other") + ": byte 16: expected model elliptical-test"));
  EXPECT_THAT(outcome.err, HasSubstr(" as in " + path("a") + ", found model elliptical-0"));
  EXPECT_THAT(outcome.err, HasSubstr(path("cut") + ": section "));
  EXPECT_THAT(outcome.err, HasSubstr(path("none") + ": "));
  EXPECT_FALSE(fs::exists(path("out")));
  EXPECT_LE(files(), before + 2) << "what the command said, and nothing else";
}

TEST_F(CacheMergeCommand, ReplacesACacheButNothingElse) {
  write_text(path("out"), encode_cache(adaptive::small_image()));
  EXPECT_EQ(merge({"b", "c"}, "out").status, 0);
  ASSERT_EQ(merge({"c", "b"}, "bc").status, 0);
  EXPECT_EQ(read_text(path("out")), read_text(path("bc")));

  write_text(path("scene.json"), "{ a scene that took a day }");
  const Outcome outcome = merge({"a", "b"}, "scene.json");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("scene.json: byte 0: expected a new name, or a warm cache to replace"));
  EXPECT_EQ(read_text(path("scene.json")), "{ a scene that took a day }");
  EXPECT_EQ(merge({"a"}, "none/out").status, 1);
  fs::create_directory(path("folder"));
  EXPECT_EQ(merge({"a"}, "folder").status, 1);
}

}  // namespace
}  // namespace tress::test
