// A row at a stage of its learning: of the paths that it says, tested by those that had not taught it.
#include "fit/learn_stage.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "adaptive/sampled_targets.h"
#include "adaptive/toy_samples.h"
#include "convergence/held_out_test.h"

namespace tress::inline v0_2::adaptive {
namespace {

const testing::MovingLobes& target() {
  static const testing::MovingLobes lobes;
  return lobes;
}
const SliceDescription& slice() {
  static const SliceDescription one = testing::sampled_slice(3, 4);
  return one;
}
StagedRow stage(std::uint32_t paths, std::uint32_t before_paths = 0, const RibbonRow* before = nullptr,
                const RibbonRow* parent = nullptr, float a = 0.3f) {
  return learn_stage(target(), slice(), a, 0.4f, paths, before_paths, before, parent);
}

/// Leaves this byte all over the memory that the next calls have their variables in.
[[gnu::noinline]] void fill_stack(unsigned char byte) {
  std::array<unsigned char, 256 * 1024> memory;
  std::memset(memory.data(), byte, memory.size());
  asm volatile("" : : "r"(memory.data()) : "memory");  // or the compiler drops it
}

// A row depends on its arguments alone, whatever the memory of the fit held before: 0xff makes every float a NaN, 0x7f
// a huge number. The priors of rows without a parent had no value, and rows differed from run to run.
TEST(LearnStage, DoesNotAskWhatMemoryHeldBefore) {
  const auto learned = [](unsigned char byte) {
    fill_stack(byte);
    return stage(512).row;
  };
  const RibbonRow zeros = learned(0);
  for (const unsigned char byte : {0xff, 0x7f}) {
    const RibbonRow other = learned(byte);
    for (std::uint32_t p = 0; p < zeros.parts(); ++p) {
      const Ribbon a = zeros.ribbon(p), b = other.ribbon(p);
      EXPECT_EQ(zeros.mass(p), other.mass(p));
      for (int i = 0; i < 200; ++i) {
        const float x = 0.03f * static_cast<float>(i) - 3, t = 0.02f * static_cast<float>(i) - 2;
        EXPECT_EQ(a.density(x, t), b.density(x, t)) << "part " << p << " byte " << int{byte};
      }
    }
  }
}

TEST(LearnStage, IsPureAndTestsTheStageBeforeByPathsThatItDoesNotKnow) {
  const StagedRow first = stage(512);
  ASSERT_TRUE(first.usable);
  EXPECT_FALSE(first.tested);
  EXPECT_EQ(stage(512).row, first.row);
  const StagedRow second = stage(2048, 512, &first.row);
  ASSERT_TRUE(second.usable && second.tested);
  HeldOutTest held_out(first.row);
  for (std::uint64_t s = 0; s < 4; ++s) {
    std::vector<SampledExit> exits;
    target().draw(slice(), 0.3f, 0.4f, s, 128, 384, exits);
    held_out.add(s, exits);
  }
  const SampledTest test = held_out.result(384);
  // A stage scales its weights and back: each is off by less than 2^-23 of itself, so chi2 by less than 2^-22
  // sqrt(chi2).
  EXPECT_NEAR(second.test.chi2, test.chi2, 1e-7);
  EXPECT_NEAR(second.test.deviation, test.deviation, 1e-7);
  EXPECT_EQ(stage(2048).row, second.row);  // what is tested teaches nothing
}

// By 16 times the paths a row is nearer to fresh draws, and what is learned of a node of a twentieth is a good parent.
TEST(LearnStage, GrowsBetterByStages) {
  const StagedRow first = stage(512), last = stage(8192);
  const auto off = [](const RibbonRow& row) {
    HeldOutTest held_out(row);
    for (std::uint64_t s = 0; s < 4; ++s) {
      std::vector<SampledExit> exits;
      target().draw(slice(), 0.3f, 0.4f, 100 + s, 0, 8192, exits);
      held_out.add(s, exits);
    }
    return held_out.result(8192).chi2;
  };
  EXPECT_LT(off(last.row), 0.3 * off(first.row));
  const RibbonRow near = stage(8192, 0, nullptr, nullptr, 0.31f).row;
  const StagedRow child = stage(512, 0, nullptr, &near);
  ASSERT_TRUE(child.tested);
  EXPECT_LT(off(child.row), 0.5 * off(first.row));
}

// A fit anew may end elsewhere. What is published is never worse, on paths that it knows, than what they have tested.
TEST(LearnStage, KeepsTheRowBeforeWhereTheFitAnewIsWorse) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const PathTarget paths = target_of(random_ribbon(seed, true));
    const SliceDescription one;
    const auto at = [&](std::uint32_t all, std::uint32_t had, const RibbonRow* before) {
      return learn_stage(paths, one, 0, 0, all, had, before, nullptr);
    };
    const StagedRow first = at(2048, 0, nullptr), second = at(8192, 2048, &first.row);
    HeldOutTest again(second.row);
    for (std::uint64_t s = 0; s < HeldOutTest::sets; ++s) {
      std::vector<SampledExit> exits;
      paths.draw(one, 0, 0, s, 512, 1536, exits);
      again.add(s, exits);
    }
    EXPECT_LE(again.result(1536).chi2, second.test.chi2 + 1e-6) << seed;
  }
}

TEST(LearnStage, LeavesAParentThatFails) {
  const RibbonRow far = stage(8192, 0, nullptr, nullptr, 0.9f).row;
  const StagedRow child = stage(512, 0, nullptr, &far);
  ASSERT_TRUE(child.tested);
  EXPECT_GT(child.test.chi2 + child.test.deviation, 0.3);
  EXPECT_EQ(child.row, stage(512).row);
}

TEST(LearnStage, ReportsWhatIsNoTarget) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const auto always = [](SampledExit exit) {
    return PathTarget(2, [exit](RandomStream&, std::vector<SampledExit>& out) { out.push_back(exit); });
  };
  for (const SampledExit& exit : {SampledExit{0, 0, 2, 1, 0}, SampledExit{0, 0, 0, nan, 0}, SampledExit{0, 0, 0, 0, 0},
                                  SampledExit{0, 0, 0, 3e38f, 0}, SampledExit{0, 0, 0, largest_weight, 0}}) {
    const StagedRow row = learn_stage(always(exit), SliceDescription{}, 0, 0, 512, 0, nullptr, nullptr);
    EXPECT_EQ(row.usable, exit.weight == largest_weight);
  }
  EXPECT_FALSE(learn_stage(PathTarget(5, nullptr), SliceDescription{}, 0, 0, 512, 0, nullptr, nullptr).usable);
  EXPECT_TRUE(learn_stage(always({1, 0.3f, 1, 0.5f, 2}), SliceDescription{}, 0, 0, 512, 0, nullptr, nullptr).usable);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
