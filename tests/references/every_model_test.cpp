// What every model of the registry owes the integrator, whatever it models.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "models/learned_model.h"
#include "models/model_measures.h"
#include "references/registry.h"

namespace tress {
namespace {

using fiber::FiberDirection;
using fiber::FiberEvent;
using fiber::FiberParameters;
using fiber::FiberSample;
using fiber::FiberValue;
using fiber::ModelInfo;
using test::OneFiber;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float degree = pi / 180;

class every_model : public testing::TestWithParam<std::size_t> {
 protected:
  const ModelInfo& info() const { return references::models()[GetParam()]; }
  /// Rays or points at every vertex: such models are asked less often.
  bool is_slow() const { return info().has_rows() || info().has_quadrature; }
};

std::string name_of(const testing::TestParamInfo<std::size_t>& index) {
  std::string name = references::models()[index.param].name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(models, every_model, testing::Range(std::size_t{0}, references::models().size()), name_of);

FiberParameters clear_hair(float e) {
  FiberParameters parameters;
  parameters.sigma_a = glm::vec3(0);
  parameters.eccentricity = e;
  return parameters;
}

bool is_sound(const glm::vec3& color) {
  for (int c = 0; c < 3; ++c)
    if (!(std::isfinite(color[c]) && color[c] >= 0)) return false;
  return true;
}

bool is_sound(const FiberValue& value) {
  return std::isfinite(value.pdf) && value.pdf >= 0 &&
         std::all_of(value.s.begin(), value.s.end(), [](const auto& s) { return is_sound(s); });
}

float largest_of(const FiberValue& value) {
  const glm::vec3 total = value.total();
  return std::max({total.r, total.g, total.b});
}

/// Corners of the parameters, few enough that what is shared by (eta, e) is made four times only.
std::vector<FiberParameters> corners() {
  std::vector<FiberParameters> fibers;
  for (const auto& [eta, e] : {std::pair{1.05f, 0.5f}, {1.55f, 1.0f}, {3.0f, 0.5f}, {3.0f, 1.0f}}) {
    for (const float roughness : {0.01f, 0.2f, 1.0f}) {
      for (const glm::vec3& sigma_a : {glm::vec3(0), glm::vec3(0, 3, 100)}) {
        FiberParameters fiber;
        fiber.eta = eta;
        fiber.eccentricity = e;
        fiber.roughness = roughness;
        fiber.sigma_a = sigma_a;
        fiber.tilt = roughness > 0.5f ? 0.3f : 0.05f;
        fibers.push_back(fiber);
      }
    }
  }
  return fibers;
}

// Drawn at random from the corners of everything (seed 1): directions at the poles and seams, offsets at the edges,
// uniforms at their ends.
TEST_P(every_model, is_finite_and_not_negative_at_the_corners) {
  const float below_one = 0x1.fffffep-1f;
  const std::vector<float> thetas{-pi / 2, -89.95f * degree, -1, 0, 1e-4f, 0.8f, 89.9f * degree, pi / 2};
  const std::vector<float> phis{-pi, -pi / 2, -1, 0, 0.7f, pi / 2, 3.1415925f, 7};
  const std::vector<float> offsets{-1, -0.999999f, -0.7f, 0, 0.3f, 1}, uniforms{0, 1e-7f, 0.31f, 0.5f, 0.9f, below_one};
  RandomStream random(1);
  const auto one_of = [&random](const std::vector<float>& values) {
    return values[static_cast<std::size_t>(random.next() * static_cast<float>(values.size()))];
  };
  const auto model = info().make({.estimator = fiber::Estimator::exact, .service = nullptr});
  std::vector<fiber::FiberId> fibers;
  for (const FiberParameters& fiber : corners()) fibers.push_back(model->add_fiber(fiber));
  const int events = is_slow() ? 150 : 4000;
  for (int i = 0; i < events; ++i) {
    const std::size_t fiber = static_cast<std::size_t>(i) % fibers.size();
    const FiberDirection wr{one_of(thetas), one_of(phis)};
    const float xi1 = one_of(uniforms), xi2 = one_of(uniforms), h = one_of(offsets);
    const std::array<float, 4> u{one_of(uniforms), one_of(uniforms), one_of(uniforms), one_of(uniforms)};
    const FiberDirection other{one_of(thetas), one_of(phis)};
    SCOPED_TRACE(testing::Message() << "corner " << fiber << " theta_r " << wr.theta << " phi_r " << wr.phi << " h "
                                    << h << " u " << u[0] << " " << u[1] << " " << u[2] << " " << u[3] << " wi "
                                    << other.theta << " " << other.phi);
    const FiberEvent event = model->begin(fibers[fiber], wr, xi1, xi2, h);
    for (const glm::vec3& energy : event.energy) ASSERT_TRUE(is_sound(energy));
    const FiberSample sample = model->sample(event, u);
    ASSERT_TRUE(std::isfinite(sample.wi.theta) && std::abs(sample.wi.theta) <= pi / 2) << sample.wi.theta;
    ASSERT_TRUE(sample.wi.phi >= -pi && sample.wi.phi < pi) << sample.wi.phi;
    ASSERT_TRUE(is_sound(sample.value) && sample.value.pdf > 0)
        << sample.value.pdf << " at " << sample.wi.theta << " " << sample.wi.phi;
    const FiberValue value = model->evaluate(event, other);
    ASSERT_TRUE(is_sound(value)) << value.pdf;
    ASSERT_TRUE(value.pdf > 0 || largest_of(value) == 0);
    ASSERT_TRUE(model->evaluates(event) || model->estimates(event) || largest_of(value) == 0);
  }
}

// What a direction is worth does not depend on who asks: to the rounding of a direction that is passed on, 1e-4 of a
// density that may be a few degrees wide. And lobes are layers of the picture: GLINT is one only where the fiber splits
// it off, or its light would be in no layer.
TEST_P(every_model, sample_and_evaluate_agree_and_glint_is_a_lobe_only_where_it_is_split_off) {
  constexpr auto glint = static_cast<std::size_t>(fiber::Lobe::glint);
  FiberParameters parameters;
  parameters.eccentricity = 0.8f;
  const OneFiber fiber(info(), parameters);
  RandomStream random(2);
  for (int i = 0; i < (is_slow() ? 150 : 2000); ++i) {
    const FiberDirection wr{pi * (random.next() - 0.5f), 2 * pi * (random.next() - 0.5f)};
    const FiberEvent event = fiber.begin(wr, random);
    const FiberSample sample = test::draw(fiber.model(), event, random);
    ASSERT_EQ(event.energy[glint], glm::vec3(0));
    ASSERT_EQ(sample.value.s[glint], glm::vec3(0));
    if (!fiber.model().evaluates(event)) continue;
    const FiberValue again = fiber.model().evaluate(event, sample.wi);
    ASSERT_NEAR(sample.value.pdf / again.pdf, 1, 1e-4f) << "theta_r " << wr.theta;
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) {
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(sample.value.s[p][c], again.s[p][c], 1e-4f * again.pdf) << fiber::lobe_names[p];
    }
  }
}

// The error of a rule is estimated by a coarser one (4/9 of the points): its difference bounds the finer rule's own
// error, whose order is higher. Kinks (a terminator, a trimmed tail) and energies that are interpolated (1.5e-3) are
// allowed 2e-3 beside it; a density that the rules cannot resolve to 2 % fails.
TEST_P(every_model, density_has_mass_one_and_clear_hair_a_furnace) {
  double largest = 0;
  for (const auto& [e, theta] : {std::pair{1.0f, 0.0f}, {0.85f, 50.0f}, {0.7f, -80.0f}}) {
    const OneFiber fiber(info(), clear_hair(e));
    if (!fiber.model().evaluates()) return;
    const FiberEvent event = fiber.begin({theta * degree, 1.1f}, theta == 0 ? -0.6f : 0.8f);
    const int panels = is_slow() ? 12 : 18;
    const test::Masses coarse = test::masses(fiber.model(), event, panels, 2 * panels / 3),
                       fine = test::masses(fiber.model(), event, 3 * panels / 2, panels);
    SCOPED_TRACE(testing::Message() << "e " << e << " theta_r " << theta << " coarse " << coarse.pdf << " "
                                    << coarse.s);
    const double pdf_error = std::abs(fine.pdf - coarse.pdf), s_error = std::abs(fine.s - coarse.s);
    EXPECT_LT(pdf_error, 0.02);
    EXPECT_LT(s_error, 0.02 * fine.s);
    EXPECT_NEAR(fine.pdf, 1, 2e-3 + pdf_error);
    EXPECT_GT(fine.s, 0);
    if (info().conserves_energy) {
      EXPECT_NEAR(fine.s, 1, 2e-3 + s_error);
    }
    std::printf("%s e %.2f theta_r %.0f: furnace %.4f +- %.0e, mass of the density %.4f\n", info().name,
                static_cast<double>(e), static_cast<double>(theta), fine.s, s_error, fine.pdf);
    largest = std::max(largest, std::abs(fine.s - 1));
  }
  RecordProperty("largest_furnace_error", std::to_string(largest));
}

// A gain is a factor of its lobe, at every direction and in the energies. Factors near 1, so that no lobe's share falls
// below what a model gives to its residual.
TEST_P(every_model, gains_multiply_their_lobes) {
  FiberParameters parameters = clear_hair(0.9f);
  parameters.sigma_a = glm::vec3(0.1f, 0.2f, 0.3f);
  const OneFiber plain(info(), parameters);
  for (std::size_t p = 0; p < fiber::lobe_count; ++p)
    parameters.gain[p] = glm::vec3(1.0f + 0.1f * static_cast<float>(p), 1.5f, 0.8f);
  parameters.gain[5] = parameters.gain[2];  // GLINT is part of TRT where it is not split off
  const OneFiber gained(info(), parameters);
  const FiberDirection wr{0.3f, 0.4f};
  const FiberEvent before = plain.begin(wr), after = gained.begin(wr);
  const auto expect_factor = [&](const glm::vec3& with, const glm::vec3& without, std::size_t p) {
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(with[c], without[c] * parameters.gain[p][c], 1e-4f * with[c] + 1e-9f)
          << fiber::lobe_names[p] << " " << c;
  };
  for (std::size_t p = 0; p < fiber::lobe_count; ++p) expect_factor(after.energy[p], before.energy[p], p);
  if (!plain.model().evaluates()) return;
  for (const FiberDirection wi : {FiberDirection{-0.3f, 0.5f}, {-0.2f, 3.0f}, {-0.5f, -1.2f}}) {
    const FiberValue with = gained.model().evaluate(after, wi), without = plain.model().evaluate(before, wi);
    for (std::size_t p = 0; p < fiber::lobe_count; ++p) expect_factor(with.s[p], without.s[p], p);
  }
}

TEST_P(every_model, gives_equal_fibers_one_id) {
  const auto model = info().make({.estimator = fiber::Estimator::exact, .service = nullptr});
  const fiber::FiberId first = model->add_fiber(clear_hair(1)),
                       second = model->add_fiber(FiberParameters{.eccentricity = 1});
  EXPECT_NE(first, second);
  EXPECT_EQ(model->add_fiber(clear_hair(1)), first);
  EXPECT_EQ(model->name(), info().name);
}

TEST_P(every_model, refuses_a_fiber_that_is_out_of_its_ranges) {
  const auto model = info().make({.estimator = fiber::Estimator::exact, .service = nullptr});
  EXPECT_EQ(model->add_fiber(FiberParameters{.eccentricity = 0.4f}), fiber::no_fiber);
}

// A model that learns, before it has: its rows are open, and it still owes what it owes.
TEST_P(every_model, learns_from_a_service) {
  if (!info().has_rows()) return;
  test::LearnedModel model(clear_hair(0.9f), fiber::Estimator::fitted, {}, info());
  RandomStream random(4);
  for (int i = 0; i < 200; ++i) {
    const FiberDirection wr{1.5f * (random.next() - 0.5f), 6 * (random.next() - 0.5f)};
    const float xi1 = random.next(), xi2 = random.next();
    const FiberEvent event = model.begin(wr, xi1, xi2);
    const FiberSample sample = test::draw(model.model(), event, random);
    ASSERT_TRUE(is_sound(sample.value) && sample.value.pdf > 0);
    const FiberValue again = model.model().evaluate(event, sample.wi);
    if (model.model().estimates(event)) {  // a value of its own path, beside the same pdf
      ASSERT_TRUE(is_sound(again));
      ASSERT_NEAR(sample.value.pdf / again.pdf, 1, 1e-4f);
      continue;
    }
    if (!model.model().evaluates(event)) {
      ASSERT_EQ(again.pdf, 0);
      ASSERT_EQ(largest_of(again), 0);
      continue;
    }
    ASSERT_NEAR(sample.value.pdf / again.pdf, 1, 1e-4f);
    ASSERT_NEAR(sample.value.total().g, again.total().g, 1e-4f * again.pdf);
  }
}

}  // namespace
}  // namespace tress
