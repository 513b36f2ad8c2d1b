// Slices as the hair that they are of: which belong together, what two differ in, and which is nearest.
#include "cli/hair_words.h"

#include <gmock/gmock.h>

#include "fiber/rough_rows.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/parameters.h"

namespace tress::cli {
namespace {

using ::testing::ElementsAre;

adaptive::SliceDescription slice(int lobe, float eccentricity, float roughness) {
  fiber::FiberParameters fiber;
  fiber.roughness = roughness;
  const auto order = static_cast<std::size_t>(fiber::slice_order(lobe));
  return fiber::elliptical_slice(lobe, 1.55f, eccentricity, fiber::azimuthal_sigmas(fiber)[order - 1]);
}

SliceContents contents(const adaptive::SliceDescription& description, std::vector<float> objectives) {
  SliceContents held;
  held.slice = description;
  held.converged = objectives.size();
  held.open = 1;
  held.samples = 10;
  held.objectives = std::move(objectives);
  return held;
}

TEST(HairWords, BlursOfOneRoughnessAreOneHair) {
  // TRRT of 0.3 and of 0.5 are both held to 45 degrees: one slice, of both.
  const auto all = hair_of({contents(slice(1, 0.85f, 0.3f), {0.004f, 0.001f}), contents(slice(1, 0.85f, 0.5f), {}),
                            contents(slice(2, 0.85f, 0.3f), {0.009f}), contents(slice(3, 0.85f, 0.3f), {0.002f}),
                            contents(slice(3, 0.75f, 0.1f), {})});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(words(all[0].parameters), "eta 1.55, eccentricity 0.85, roughness 0.3");
  EXPECT_THAT(all[0].lobes, ElementsAre("TT", "TRT", "TRRT"));
  EXPECT_EQ(all[0].converged, 4u);
  EXPECT_EQ(all[0].open, 3u);
  EXPECT_EQ(all[0].samples, 30u);
  EXPECT_FLOAT_EQ(static_cast<float>(all[0].error_median), 0.002f);
  EXPECT_FLOAT_EQ(static_cast<float>(all[0].error_max), 0.009f);
  EXPECT_EQ(words(all[1].parameters), "eta 1.55, eccentricity 0.85, roughness 0.5");
  EXPECT_THAT(all[1].lobes, ElementsAre("TT", "TRRT"));
  // One lobe alone has a blur, not what it came from.
  EXPECT_EQ(words(all[2].parameters), "eta 1.55, eccentricity 0.75, blur 17.189 degrees");
}

TEST(HairWords, NamesWhatTwoSlicesDifferInAndWhichIsNearest) {
  const auto here = slice(1, 0.75f, 0.2f);
  const std::vector<adaptive::SliceDescription> among{slice(1, 0.85f, 0.3f), slice(2, 0.75f, 0.2f),
                                                      slice(1, 0.9f, 0.2f), slice(1, 0.8f, 0.2f)};
  const adaptive::SliceDescription* nearest = nearest_hair(here, among);
  ASSERT_EQ(nearest, &among[3]);
  const auto differences = hair_differences(here, *nearest);
  ASSERT_EQ(differences.size(), 1u);
  EXPECT_EQ(differences[0].name, "eccentricity");
  EXPECT_EQ(differences[0].here, 0.75);
  EXPECT_EQ(differences[0].there, 0.8);
  EXPECT_EQ(hair_words(here), "eta 1.55, eccentricity 0.75, blur 5.7296 degrees (roughness 0.2)");
  EXPECT_EQ(nearest_hair(slice(3, 0.75f, 0.2f), among), nullptr);

  fiber::FiberParameters fur;
  fur.medulla_radius = 0.5f;
  fur.medulla_scattering = 2;
  const auto with = fiber::rough_slice(fur), without = fiber::rough_slice(fiber::FiberParameters());
  EXPECT_EQ(hair_words(without), "eta 1.55, eccentricity 0.85, roughness 0.2, tilt 3 degrees");
  EXPECT_EQ(hair_differences(with, without).size(), 2u);
  EXPECT_EQ(hair_differences(without, with).back().there, hair_differences(with, without).back().here);
  EXPECT_EQ(lobe_word(with), "rough");
  fiber::FiberParameters wet;
  wet.cortex_scattering = 1.5f;
  wet.wetness = 1;
  EXPECT_EQ(hair_words(fiber::rough_slice(wet)),
            hair_words(without) + ", cortex scattering 1.5, cortex asymmetry 0, wetness 1");
}

TEST(HairWords, ABlurAtALimitHasNoRoughness) {
  EXPECT_FALSE(roughness_of_blur(slice(3, 0.85f, 0.5f)));
  EXPECT_FALSE(roughness_of_blur(fiber::elliptical_slice(1, 1.55f, 0.85f, 0.06981317f)));
  EXPECT_EQ(roughness_of_blur(slice(2, 0.85f, 0.25f)), 0.25);
}

}  // namespace
}  // namespace tress::cli
