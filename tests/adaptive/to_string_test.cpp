// What the public values of the service say of themselves.
#include "tress/adaptive/to_string.h"

#include <gtest/gtest.h>

#include <string>

#include "tress/version.h"

namespace tress::inline v0_2::adaptive {
namespace {

TEST(ToString, NamesEveryState) {
  EXPECT_STREQ(state_name(RowState::absent), "absent");
  EXPECT_STREQ(state_name(RowState::open), "open");
  EXPECT_STREQ(state_name(RowState::converged), "converged");
  EXPECT_STREQ(state_name(RowState::refused), "refused");
}

TEST(ToString, ASliceSaysItsKeyItsNodesAndItsBlur) {
  SliceDescription slice;
  slice.key = {2, {1.55f, 0.85f, 0.2f}};
  slice.axis_a = {0, 1, 2};
  slice.axis_b = {0, 1};
  slice.blur_rad = 0.25f;
  EXPECT_EQ(to_string(slice), "lobe 2 (1.55, 0.85, 0.2): 3 x 2 nodes, blur 0.25 rad");
}

TEST(ToString, OptionsSayEverySettingThatIsInForce) {
  Options options;
  options.queries_before_creation = 1;
  options.epsilon = 0.003;
  options.memory_bytes = 1 << 20;
  options.seed = 7;
  EXPECT_EQ(to_string(options),
            "learner sketch, epsilon 0.003, table memory 1 MB, 1 query before creation, uniform share 0.02 converged "
            "and 0.05 open, 32 tests before refusal, at most 8 components, seed 7");
  options.picture_error = 0.1;
  EXPECT_NE(to_string(options).find("picture error 0.1"), std::string::npos);
}

TEST(ToString, APassWithoutQueriesHasAShareOfZero) {
  PassReport report;
  report.at_ceiling = true;
  EXPECT_EQ(to_string(report),
            "0 queries, 0 % answered by rows; rows: 0 open, 0 converged, 0 refused; 0 MB, at the ceiling");
}

TEST(Version, IsThatOfTheHeaders) {
  EXPECT_EQ(std::string(version()), std::to_string(TRESS_VERSION_MAJOR) + "." + std::to_string(TRESS_VERSION_MINOR) +
                                        "." + std::to_string(TRESS_VERSION_PATCH));
  EXPECT_GT(TRESS_VERSION, TRESS_VERSION_NUMBER(0, 1, 999));
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
