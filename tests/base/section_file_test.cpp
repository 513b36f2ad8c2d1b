#include "base/section_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tress {
namespace {

namespace fs = std::filesystem;

class SectionFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  std::string bytes() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  void put(const std::string& bytes) const { std::ofstream(file_, std::ios::binary) << bytes; }

  fs::path folder_ = fs::temp_directory_path() / ("section_file_test-" + std::to_string(::getpid()));
  fs::path file_ = folder_ / "a";
};

TEST_F(SectionFile, GivesBackWhatWasWritten) {
  const std::string large(100000, 'x');
  ASSERT_FALSE(write_sections(file_, {{"one", ""}, {"two.three", large}}));
  const auto read = read_sections(file_);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(read->at("one"), "");
  EXPECT_EQ(read->at("two.three"), large);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1) << "nothing is left beside it";
}

TEST_F(SectionFile, PiecesArePackedWhereThatMakesThemSmaller) {
  std::string numbers(1000003, '\0');  // of several pieces, the last of which ends within a word
  for (std::size_t i = 0; i < numbers.size(); i += 24) numbers[i] = static_cast<char>(i % 251);
  ASSERT_FALSE(write_sections(file_, {{"numbers", numbers}, {"text", "as it is"}}));
  EXPECT_LT(bytes().size(), numbers.size() / 8);
  EXPECT_NE(bytes().find("as it is"), std::string::npos);
  const auto read = read_sections(file_);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(read->at("numbers") == numbers);
}

TEST_F(SectionFile, EveryCutAndEveryFlippedBitIsRefused) {
  ASSERT_FALSE(write_sections(file_, {{"a", "12345"}, {"b", std::string(90, '\0') + "678"}}));
  const std::string good = bytes();
  ASSERT_LT(good.size(), 100u) << "the second is packed";
  for (std::size_t size = 0; size < good.size(); ++size) {
    put(good.substr(0, size));
    EXPECT_FALSE(read_sections(file_)) << size;
  }
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ static_cast<char>(1u << bit % 8));
    put(bad);
    const auto read = read_sections(file_);
    if (read) {
      EXPECT_FALSE(read->contains("a") && read->contains("b")) << "bit " << bit << " of no name";
    }
  }
  put(good + "x");
  EXPECT_FALSE(read_sections(file_));
  EXPECT_FALSE(read_sections(folder_)) << "a folder";
  EXPECT_FALSE(read_sections(folder_ / "none"));
}

TEST_F(SectionFile, AFileThatCannotBeWrittenLeavesTheOldOne) {
  ASSERT_FALSE(write_sections(file_, {{"a", "old"}}));
  EXPECT_TRUE(write_sections(folder_ / "lost" / "a", {{"a", "new"}}));
  EXPECT_EQ(read_sections(file_)->at("a"), "old");
}

}  // namespace
}  // namespace tress
