// The phases of a pass alone, and the first mistake that is kept.
#include <gtest/gtest.h>

#include "table/discipline.h"

namespace tress::inline v0_2::adaptive {
namespace {

TEST(Phases, TheFirstMistakeIsKeptUntilItIsTaken) {
  Discipline discipline(false);
  EXPECT_FALSE(discipline.take());
  discipline.note({"", "first", "", ""});
  discipline.note({"", "second", "", ""});
  EXPECT_EQ(discipline.take()->place, "first");
  EXPECT_FALSE(discipline.take());
}

TEST(Phases, AReaderBeginsAPassAndPublishEndsIt) {
  Discipline discipline(true);
  EXPECT_FALSE(discipline.within_pass("add_slice"));
  EXPECT_TRUE(discipline.begin_reading("look_up"));
  EXPECT_EQ(discipline.within_pass("add_slice")->found, "one during a pass");
  EXPECT_TRUE(discipline.begin_publish());
  EXPECT_EQ(discipline.within_pass("add_slice")->found, "one inside publish()");
  EXPECT_FALSE(discipline.begin_reading("look_up"));
  EXPECT_EQ(discipline.take()->place, "look_up");
  EXPECT_FALSE(discipline.begin_publish());
  EXPECT_EQ(discipline.take()->found, "publish() itself");
  discipline.end_publish();
  EXPECT_FALSE(discipline.within_pass("add_slice"));
}

TEST(Phases, PublishDoesNotBeginWhileAReaderIsInside) {
  Discipline discipline(true);
  {
    const Discipline::Reader reader(discipline);
    EXPECT_FALSE(discipline.begin_publish());
    EXPECT_EQ(discipline.take()->found, "one in look_up");
  }
  EXPECT_TRUE(discipline.begin_publish());
}

TEST(Phases, AreNotKeptWherePassesAreNotChecked) {
  Discipline discipline(false);
  const Discipline::Reader reader(discipline);
  EXPECT_TRUE(discipline.begin_reading("look_up"));
  EXPECT_FALSE(discipline.within_pass("add_slice"));
  EXPECT_TRUE(discipline.begin_publish());
  EXPECT_TRUE(discipline.begin_publish());
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
