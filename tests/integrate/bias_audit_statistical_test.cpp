// What the audit says of pictures whose bias is known on paper.
#include <gtest/gtest.h>

#include <cmath>

#include "integrate/picture_mean.h"
#include "integrate/white_fiber.h"

namespace tress::integrate {
namespace {

/// Fibers of 0.8 of the light, audited by ones of all of it: with one scattering the picture is 0.8 of the truth.
MeasuredBias audited(float share_of_light, float share, int threads) {
  const scene::Scene scene = tangle(40, 24, 24);
  WhiteFiber model;
  fiber::LobeColors darker = lossless_shares();
  for (glm::vec3& lobe : darker) lobe *= share_of_light;
  const fiber::FiberId truth = model.add_fiber(lossless_shares()), dark = model.add_fiber(darker);
  const BiasAudit audit{&model, {truth}, share};
  RenderOptions options = long_paths(400, 11);
  options.max_depth = 1;
  options.audit = &audit;
  return *render_with(scene, model, {dark}, options, threads).bias;
}

TEST(BiasAudit, FindsTheBiasThatIsThere) {
  const MeasuredBias bias = audited(0.8f, 0.25f, 2);
  EXPECT_GT(bias.paths, 0u);
  EXPECT_LT(bias.error, 0.02 * test::widened(400));
  EXPECT_LT(std::abs(bias.value + 0.2), z_limit * bias.error) << bias.value << " +- " << bias.error;
}

TEST(BiasAudit, FindsNoneWhereThereIsNone) {
  const MeasuredBias bias = audited(1, 0.25f, 2);
  EXPECT_LT(std::abs(bias.value), z_limit * bias.error) << bias.value << " +- " << bias.error;
}

TEST(BiasAudit, IsTheSameForAnyNumberOfThreads) {
  const MeasuredBias one = audited(0.8f, 0.02f, 1), many = audited(0.8f, 0.02f, 4);
  EXPECT_EQ(one.value, many.value);
  EXPECT_EQ(one.error, many.error);
  EXPECT_EQ(one.paths, many.paths);
}

}  // namespace
}  // namespace tress::integrate
