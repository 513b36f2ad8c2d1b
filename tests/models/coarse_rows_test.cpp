// Rough fibers that hardly differ share the rows that answer before their own are learned.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "models/registry.h"
#include "tress/adaptive/service.h"

namespace tress::test {
namespace {

using fiber::FiberParameters;

/// Rows that are learned before the first pass.
std::uint64_t rows_before_the_first_pass(const std::vector<FiberParameters>& fibers) {
  const fiber::ModelService learned = fiber::make_service(fiber::rough_info, {});
  const std::unique_ptr<fiber::FiberModel> model = fiber::rough_info.make({.service = learned.service.get()});
  for (const FiberParameters& fiber : fibers) EXPECT_NE(model->add_fiber(fiber), fiber::no_fiber);
  learned.service->prepare();
  return learned.service->publish().rows_open;
}

FiberParameters with(float eccentricity, float roughness) {
  FiberParameters fiber;
  fiber.eccentricity = eccentricity;
  fiber.roughness = roughness;
  return fiber;
}

TEST(CoarseRows, AreSharedBySimilarFibers) {
  const FiberParameters fiber = with(0.85f, 0.2f);
  const std::uint64_t one = rows_before_the_first_pass({fiber});
  EXPECT_GT(one, 0u);
  for (const FiberParameters& similar : {with(0.86f, 0.2f), with(0.84f, 0.2f), with(0.85f, 0.22f), with(0.86f, 0.182f)})
    EXPECT_EQ(rows_before_the_first_pass({fiber, similar, fiber}), one) << similar.roughness;
  for (const FiberParameters& other : {with(0.87f, 0.2f), with(0.85f, 0.223f), with(0.85f, 0.18f)})
    EXPECT_EQ(rows_before_the_first_pass({fiber, other}), 2 * one) << other.roughness;
  FiberParameters fur = fiber;
  fur.medulla_radius = 0.5f;
  EXPECT_EQ(rows_before_the_first_pass({fiber, fur}), 2 * one);
  // A fiber that is similar to the second only, which has no coarse rows of its own, gets some.
  EXPECT_EQ(rows_before_the_first_pass({fiber, with(0.86f, 0.2f), with(0.87f, 0.2f)}), 2 * one);
  EXPECT_LT(rows_before_the_first_pass({with(1, 0.2f), with(0.995f, 0.2f)}), 2 * one) << "a round fiber has fewer";
  const std::uint64_t finer = rows_before_the_first_pass({with(0.795f, 0.2f)});
  EXPECT_GT(finer, one) << "flatter fibers have more azimuths";
  EXPECT_EQ(rows_before_the_first_pass({with(0.795f, 0.2f), with(0.803f, 0.2f)}), finer + one);
}

}  // namespace
}  // namespace tress::test
