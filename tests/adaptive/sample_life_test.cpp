// Which rows of samples are to have more paths, and what learning one brings: without a service.
#include "table/sample_life.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "adaptive/toy_samples.h"
#include "fit/learn_stage.h"

namespace tress::inline v0_2::adaptive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct SampleLifeTest : ::testing::Test {
  Options options;
  Rows rows;
  LightPolicy light{options};
  testing::MovingLobes target;
  SampleLife life{options, rows, light, &target};

  SliceId add(std::uint32_t size, std::vector<std::uint32_t> coarse = {}) {
    SliceDescription slice = testing::sampled_slice(1, size);
    if (!coarse.empty()) slice.coarse = {{coarse, coarse}};
    return rows.add_slice(slice, true, target.parts(slice));
  }
  void ask(SliceId slice, std::uint32_t node, std::uint32_t events) { rows.slice(slice).events[node] = events; }
  /// Lets a row answer that has this many paths.
  Row& answer(SliceId slice, std::uint32_t node, std::uint32_t paths, bool has_converged = false) {
    Row& row = rows.add({slice, node});
    auto made = std::make_unique<RibbonAnswer>();
    made->paths = paths;
    made->has_converged = has_converged;
    rows.show_ribbons(row, std::move(made));
    return row;
  }
  std::vector<std::uint32_t> paths(SliceId slice, bool is_coarse = false) const {
    std::vector<std::uint32_t> paths;
    for (const SampleLife::Growth& one : life.growths(slice, is_coarse, {})) paths.push_back(one.paths);
    return paths;
  }
};

TEST_F(SampleLifeTest, ARowHasOnePathForTwoEventsRoundedUpToAStage) {
  const SliceId slice = add(1);
  std::vector<std::vector<std::uint32_t>> found;
  for (const std::uint32_t events : {7u, 8u, 1023u, 1024u, 4096u, 16384u, 1u << 30}) {
    ask(slice, 0, events);
    found.push_back(paths(slice));
  }
  EXPECT_THAT(found, ElementsAre(IsEmpty(), ElementsAre(512u), ElementsAre(512u), ElementsAre(2048u),
                                 ElementsAre(8192u), ElementsAre(16384u), ElementsAre(16384u)));
}

TEST_F(SampleLifeTest, ARowWithEnoughPathsAndARefusedOneDoNotGrow) {
  const SliceId slice = add(2);
  for (const std::uint32_t node : {0u, 1u, 2u}) ask(slice, node, 1000);
  answer(slice, 0, 512);
  rows.refuse(rows.add({slice, 1}));
  const std::vector<SampleLife::Growth> growths = life.growths(slice, false, {});
  ASSERT_EQ(growths.size(), 1u);
  EXPECT_EQ(growths[0].node, 2u);
}

TEST_F(SampleLifeTest, RowsOfMostLightComeFirst) {
  const SliceId slice = add(2);
  for (const std::uint32_t node : {0u, 1u, 2u}) ask(slice, node, 100 + node);
  rows.slice(slice).light[1] = fixed_light(3);
  std::vector<std::uint32_t> nodes;
  for (const SampleLife::Growth& one : life.growths(slice, false, {})) nodes.push_back(one.node);
  EXPECT_THAT(nodes, ElementsAre(1u, 2u, 0u)) << "by light, then by events";
}

TEST_F(SampleLifeTest, WhereCoarseRowsAnswerANodeWaitsFor512Events) {
  const SliceId slice = add(3, {0, 2});
  ask(slice, 4, 511);
  EXPECT_THAT(paths(slice), IsEmpty());
  ask(slice, 4, 512);
  EXPECT_THAT(paths(slice), ElementsAre(512u));
}

TEST_F(SampleLifeTest, CoarseRowsGrowTogetherOnceOneHasTwiceTheEventsThatItNeeds) {
  const SliceId slice = add(3, {0, 2});
  EXPECT_EQ(paths(slice, true).size(), 4u) << "all, before the first query";
  for (const std::uint32_t node : {0u, 2u, 6u, 8u}) answer(slice, node, 512);
  for (const std::uint32_t node : {0u, 2u}) ask(slice, node, 1024);
  EXPECT_THAT(paths(slice, true), IsEmpty());
  ask(slice, 0, 2048);
  EXPECT_THAT(paths(slice, true), ElementsAre(2048u, 2048u));
  ask(slice, 0, 1u << 30);
  EXPECT_THAT(paths(slice, true), ElementsAre(2048u, 2048u)) << "the most of a coarse row";
}

TEST_F(SampleLifeTest, ARowThatLearnsToEpsilonGoesOnUntilItHasConverged) {
  options.learns_to_epsilon = true;
  const SliceId slice = add(2);
  for (const std::uint32_t node : {0u, 1u}) ask(slice, node, 100);
  answer(slice, 0, 16384);
  answer(slice, 1, 2048, true);
  EXPECT_THAT(paths(slice), ElementsAre(65536u));
  EXPECT_EQ(life.most_paths(), 65536u);
}

TEST_F(SampleLifeTest, GrowthPaysByTheShareOfTheEventsThatWaitForIt) {
  const SliceId slice = add(2);
  ask(slice, 0, 900);
  ask(slice, 1, 100);
  answer(slice, 0, 512);
  EXPECT_TRUE(life.pays(slice, 0.1));
  EXPECT_FALSE(life.pays(slice, 0.11));
}

// Both tests see fixed draws. The lobes that have turned by 0.5 are 1.7 of their deviation away from the row's.
TEST_F(SampleLifeTest, ARowPassesTheTestOfItsOwnTargetAndNotOfAnother) {
  const SliceId slice = add(1);
  Row& row = rows.add({slice, 0});
  RowOutcome young = life.learn(row, 512, false, nullptr);
  ASSERT_TRUE(young.ribbons);
  EXPECT_FALSE(young.converged) << "512 paths are too few for a test";
  rows.show_ribbons(row, std::move(young.ribbons));
  RowOutcome grown = life.learn(row, 8192, false, nullptr);
  ASSERT_TRUE(grown.ribbons);
  EXPECT_TRUE(grown.converged);
  EXPECT_EQ(grown.g_evaluations, 8192u - 512u) << "earlier paths are not drawn again";
  rows.show_ribbons(row, std::move(grown.ribbons));
  EXPECT_FALSE(life.audit(row, 1).audit_failed);
  const testing::MovingLobes turned(0.5f);
  EXPECT_TRUE(SampleLife(options, rows, light, &turned).audit(row, 1).audit_failed);
}

TEST_F(SampleLifeTest, InvalidDrawsRefuseARowAndAreNamed) {
  class Broken final : public testing::MovingLobes {
    void draw(const SliceDescription&, float, float, std::uint64_t, std::uint32_t, std::uint32_t count,
              std::vector<SampledExit>& out) const override {
      out.resize(out.size() + count, {0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0});
    }
  };
  const Broken broken;
  const SampleLife of_broken(options, rows, light, &broken);
  const SliceId slice = add(1);
  const Row& row = rows.add({slice, 0});
  EXPECT_TRUE(of_broken.learn(row, 512, false, nullptr).refused);
  const std::optional<Error> error = of_broken.invalid_exits(row, 512);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->place, "SampledTarget::draw");
  EXPECT_FALSE(life.invalid_exits(row, 512)) << "its exits are valid";
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
