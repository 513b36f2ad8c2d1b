// The word that a user may have meant.
#include "base/nearest_word.h"

#include <gtest/gtest.h>

namespace tress {
namespace {

TEST(NearestWord, CountsSwappedLettersAsOneEdit) {
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("inof", "info"), 1);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(nearest_word("--sp", {"--seed", "--spp"}), "--spp");
  EXPECT_EQ(nearest_word("x", {}), "");
}

}  // namespace
}  // namespace tress
