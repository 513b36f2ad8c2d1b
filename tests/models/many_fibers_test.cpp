// A model with many fibers: what they share, what stays their own, and rows that cease to be converged.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/color.h"
#include "models/learned_model.h"

namespace tress {
namespace {

using fiber::Estimator;
using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberId;
using fiber::FiberParameters;
using fiber::FiberSample;
using fiber::FiberValue;
using test::LearnedModel;
using test::Rows;

std::vector<FiberParameters> thousand_fibers() {
  std::vector<FiberParameters> fibers;
  for (const float e : {0.85f, 0.7f}) {
    for (int color = 0; color < 5; ++color) {
      for (int width = 0; width < 100; ++width) {
        FiberParameters fiber;
        fiber.eccentricity = e;
        fiber.sigma_a = static_cast<float>(color) * glm::vec3(0.1f, 0.2f, 0.4f);
        fiber.longitudinal_lambda[0] = 0.1f + 0.001f * static_cast<float>(width);
        fibers.push_back(fiber);
      }
    }
  }
  return fibers;
}

TEST(many_fibers, share_slices_energies_and_colors) {
  const auto target = fiber::make_elliptical_target();
  adaptive::Service service(adaptive::Options{}, *target);
  const auto model = *fiber::make_elliptical_model(Estimator::fitted, &service);
  const std::vector<FiberParameters> fibers = thousand_fibers();
  std::vector<FiberId> ids;
  std::size_t of_ten_values = 0;
  for (const FiberParameters& fiber : fibers) {
    ids.push_back(model->add_fiber(fiber));
    if (ids.size() % 100 == 1) of_ten_values = model->bytes();
  }
  EXPECT_EQ(service.slice_count(), 6u);
  for (std::size_t i = 0; i < fibers.size(); ++i) {
    ASSERT_EQ(ids[i], i);
    ASSERT_EQ(model->add_fiber(fibers[i]), ids[i]);
  }
  // 99 fibers that differ in nothing that is shared cost no more than their parameters and references.
  EXPECT_LT(model->bytes() - of_ten_values, 99u * 1024u);
}

TEST(many_fibers, of_one_color_read_the_same_rows_and_of_another_their_own) {
  const FiberDirection known{0.3f, 0.7f};
  FiberParameters brown;
  const auto model = test::model_in(Rows::converged, brown, known);
  FiberParameters tilted = brown, red = brown;
  tilted.tilt = 0;
  red.sigma_a = {0.1f, 1.0f, 2.0f};
  const FiberId same = model->model().add_fiber(tilted), other = model->model().add_fiber(red);
  const FiberDirection wi{0.2f, 2.9f};
  const FiberEvent first = model->begin(known), second = model->model().begin(same, known, first.xi1, first.xi2, 0),
                   third = model->model().begin(other, known, first.xi1, first.xi2, 0);
  const auto shape = [&](const FiberEvent& event) {
    const FiberValue value = model->model().evaluate(event, wi);
    EXPECT_EQ(value.exact_queries, 0);  // the rows converged for the first fiber, and serve all
    return value.s[2] / event.energy[2];
  };
  const glm::vec3 a = shape(first), b = shape(second), c = shape(third);
  EXPECT_NEAR(a.g / b.g, a.r / b.r, 1e-5);  // M differs, the azimuthal shape does not
  EXPECT_GT(std::abs(c.g / c.r - a.g / a.r), 1e-3);
}

TEST(many_fibers, queries_answered_by_forms_are_counted) {
  const FiberDirection known{0.3f, 0.7f};
  const auto model = test::model_in(Rows::converged, FiberParameters{}, known);
  std::uint64_t queries = 0, exact = 0;
  RandomStream random(3);
  for (int i = 0; i < 500; ++i) {
    const FiberEvent event = model->begin(known);
    const FiberSample sample =
        model->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    const FiberValue light = model->model().evaluate(event, {2 * random.next() - 1, 6 * random.next() - 3});
    queries += sample.value.queries + light.queries;
    exact += sample.value.exact_queries + light.exact_queries;
  }
  const adaptive::PassReport report = model->service().publish();
  EXPECT_EQ(report.queries, queries);
  EXPECT_EQ(report.queries - report.converged_queries, exact);
}

// A cache whose rows are wrong: the first that is asked is checked and reopened, and then the whole slice is asked
// again, so that the service can check the others.
TEST(many_fibers, rows_that_cease_to_be_converged_are_asked_again) {
  const FiberDirection known{0.3f, 0.7f};
  const auto taught = test::model_in(Rows::converged, FiberParameters{}, known);
  adaptive::TableSnapshot image = taught->service().snapshot();
  for (adaptive::CachedSlice& slice : image.slices) {
    for (adaptive::CachedRow& row : slice.rows) {
      for (adaptive::Component& part : row.density()->fit.components) part.shape.mu = 0.5f * part.shape.mu + 0.4f;
    }
  }
  const auto target = fiber::make_elliptical_target();
  adaptive::Service service(adaptive::Options{}, *target);
  const auto model = *fiber::make_elliptical_model(Estimator::fitted, &service);
  const FiberId id = model->add_fiber(FiberParameters{});
  ASSERT_FALSE(service.load(std::move(image)).has_value());
  int reopened = 0, exact = 0;
  for (int pass = 0; pass < 4; ++pass) {
    exact = 0;
    for (float theta = -1.2f; theta < 1.2f; theta += 0.05f) {
      exact += model->evaluate(model->begin(id, known, 0.37f, 0.61f, 0), {theta, 2.9f}).exact_queries;
    }
    if (pass == 0) {
      EXPECT_EQ(exact, 0) << "a cache answers until it is found wrong";
    }
    const adaptive::PassReport report = service.publish();
    reopened = static_cast<int>(report.rows_reopened);
  }
  EXPECT_GT(reopened, 3);  // more than the one a slice that was checked first
  EXPECT_GT(exact, 3);
}

TEST(many_fibers, gain_scales_each_lobe_and_the_choice_between_them) {
  const FiberDirection known{0.3f, 0.7f}, wi{-0.1f, 2.5f};
  FiberParameters plain, gained;
  gained.gain[0] = {0.5f, 1.0f, 2.0f};
  gained.gain[1] = {0.0f, 0.0f, 0.0f};
  gained.gain[2] = {3.0f, 0.25f, 1.0f};
  const LearnedModel one(plain, Estimator::exact), two(gained, Estimator::exact);
  const FiberEvent event = one.begin(known), gained_event = two.begin(known);
  const FiberValue value = one.model().evaluate(event, wi), scaled = two.model().evaluate(gained_event, wi);
  for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(scaled.s[p][c], value.s[p][c] * gained.gain[p][c], 1e-4f * value.s[p][c] + 1e-9f) << p << " " << c;
    }
  }
  EXPECT_EQ(gained_event.selection[1], 0);
  float sum = 0;
  for (const float share : gained_event.selection) sum += share;
  EXPECT_NEAR(sum, 1, 1e-6);
  const auto luminance = [](const glm::vec3& c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; };
  EXPECT_NEAR(gained_event.selection[2] / gained_event.selection[0],
              luminance(event.energy[2] * gained.gain[2]) / luminance(event.energy[0] * gained.gain[0]), 1e-4);
}

// GLINT and the rest are a partition of TRT: in every state that knows g they add up to the unsplit lobe, and with a
// gain of their own they do not.
TEST(many_fibers, glint_and_the_rest_of_trt_add_up_to_the_whole) {
  const FiberDirection known{0.3f, 0.7f}, wi{-0.1f, 2.5f};
  FiberParameters whole, split;
  split.split_glint = true;
  const LearnedModel one(whole, Estimator::exact), two(split, Estimator::exact);
  for (const float phi : {-2.5f, -0.6f, 0.2f, 1.4f, 2.5f}) {
    const FiberValue value = one.model().evaluate(one.begin(known), {wi.theta, phi});
    const FiberValue parts = two.model().evaluate(two.begin(known), {wi.theta, phi});
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(parts.s[5][c], 0);
      // Both shapes are divided by their own traced mass and given the table's energy: off by its interpolation.
      EXPECT_NEAR(parts.s[2][c] + parts.s[5][c], value.s[2][c], 0.02f * value.s[2][c] + 1e-6f) << phi << " " << c;
    }
  }
  const auto learned = test::model_in(Rows::converged, split, known);
  EXPECT_EQ(learned->service().slice_count(), 4u);
  const FiberEvent event = learned->begin(known);
  EXPECT_GT(event.selection[5], 0);
  RandomStream random(19);
  bool drawn = false;
  for (int i = 0; i < 400; ++i) {
    const FiberSample sample =
        learned->model().sample(event, {random.next(), random.next(), random.next(), random.next()});
    const FiberValue again = learned->model().evaluate(event, sample.wi);
    ASSERT_EQ(sample.value.pdf, again.pdf);
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) ASSERT_EQ(sample.value.s[p], again.s[p]);
    drawn = drawn || sample.lobe == fiber::Lobe::glint;
  }
  EXPECT_TRUE(drawn);
}

}  // namespace
}  // namespace tress
