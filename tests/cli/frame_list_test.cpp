#include "cli/frame_list.h"

#include <gmock/gmock.h>

namespace tress::cli {
namespace {

using ::testing::ElementsAre;

TEST(FrameList, RangesStepsAndSingleFramesInTheirOrder) {
  EXPECT_THAT(*parse_frames("7"), ElementsAre(7));
  EXPECT_THAT(*parse_frames("3-5,1,10-15x2"), ElementsAre(3, 4, 5, 1, 10, 12, 14));
  EXPECT_THAT(*parse_frames("1-3,2-4"), ElementsAre(1, 2, 3, 4)) << "each once";
  EXPECT_THAT(*parse_frames("5-9x18446744073709551615"), ElementsAre(5));
  EXPECT_THAT(*parse_frames("-3"), ElementsAre(-3));
  EXPECT_THAT(*parse_frames("-10--8,-1-1,-5-5x5"), ElementsAre(-10, -9, -8, -1, 0, 1, -5, 5));
  EXPECT_EQ(of_frame("a.####.exr", -7), "a.-007.exr");
  for (const char* text :
       {"", "-", "--3", "1-", "-3-", "-2000000", "5-3", "1x2", "1-3x0", "1,,2", "a", "1-2000000", "1-3x"})
    EXPECT_FALSE(parse_frames(text)) << text;
}

TEST(FrameList, TheLastRunOfHashesIsTheNumber) {
  EXPECT_EQ(of_frame("a#b/c##.####.exr", 7), "a#b/c##.0007.exr");
  EXPECT_EQ(of_frame("a.##.exr", 1234), "a.1234.exr");
  EXPECT_EQ(of_frame("a.exr", 3), "a.exr");
  EXPECT_FALSE(names_frames("a##/b.exr"));
}

}  // namespace
}  // namespace tress::cli
