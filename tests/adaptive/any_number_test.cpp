// Every public function of tress::adaptive that takes numbers answers any of them with finite ones, and what does not
// exist with nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/restricted.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float infinity = std::numeric_limits<float>::infinity(), largest = std::numeric_limits<float>::max();
constexpr float strange[] = {
    std::numeric_limits<float>::quiet_NaN(), infinity, -infinity, largest, -largest, 1e-42f, -0.0f, -1, 1, 2, 1e9f};

Mixture mixture() {
  Mixture two;
  two.component_count = 2;
  two.components[0] = {{0.4f, 0.1f, 0.3f}, 0.3f, 1, 0.5f};
  two.components[1] = {{3.1f, 0.05f, 0.02f}, 0.2f, 2, 0};
  two.uniform_weight = 0.1f;
  return two;
}

Ribbon ribbon() {
  static const Ribbon one = random_ribbon(3);
  return one;
}

/// A service with a converged node, an absent one, and one of samples that answers.
struct Learned {
  explicit Learned(int passes) : service(Options{}, peaks, lobes) {
    densities = *service.add_slice(testing::toy_slice(0, 3));
    samples = *service.add_slice(testing::sampled_slice(1, 3));
    for (int pass = 0; pass < passes; ++pass) {
      for (int i = 0; i < 100; ++i) {
        const float u = (static_cast<float>(i) + 0.5f) / 100;
        sample(service, {densities, 0, 0}, {u, 0, 0});
        for (std::uint32_t node = 0; node < 9; ++node) sample(service, {samples, node / 3, node % 3}, {u, u, u});
      }
      service.publish();
    }
  }
  static const testing::MovingPeaks peaks;
  static const testing::MovingLobes lobes;
  Service service;
  SliceId densities = 0, samples = 0;
};
const testing::MovingPeaks Learned::peaks;
const testing::MovingLobes Learned::lobes;

Service& service() {
  static Learned learned(8);
  return learned.service;
}

std::vector<float> numbers(const NodeValue& value) {
  return {value.azimuth, value.height, value.density, value.parts[0], value.parts[1], value.parts[3], value.pdf};
}

struct Call {
  const char* name;
  std::function<std::vector<float>(float)> of;  ///< its results where one of its numbers is x
};
std::ostream& operator<<(std::ostream& out, const Call& call) { return out << call.name; }

std::vector<Call> calls() {
  using All = std::vector<float>;
  std::vector<Call> all{
      {"wrap_angle", [](float x) { return All{wrap_angle(x)}; }},
      {"SkewLogistic_density", [](float x) { return All{mixture().components[0].shape.density(x)}; }},
      {"SkewLogistic_sample", [](float x) { return All{mixture().components[0].shape.sample(x)}; }},
      {"Mixture_density", [](float x) { return All{mixture().density(x)}; }},
      {"Mixture_proposal_density",
       [](float x) { return All{mixture().proposal_density(x, 0.1f), mixture().proposal_density(1, x)}; }},
      {"Mixture_sample", [](float x) { return All{mixture().sample(x, 0.1f), mixture().sample(0.3f, x)}; }},
      {"decayed_share",
       [](float x) {
         return All{static_cast<float>(decayed_share(static_cast<double>(x), 1, 0.5)),
                    static_cast<float>(decayed_share(static_cast<double>(x), 1, 0))};
       }},
      {"GammaDecay",
       [](float x) {
         const GammaDecay from = GammaDecay::from({x, 0.5f}), to = GammaDecay::from({0.5f, x});
         return All{from.at(1), to.at(1), GammaDecay{}.at(x), GammaDecay{0.5f, 2}.at(x)};
       }},
      {"height_density",
       [](float x) {
         return All{height_density(HeightLaw::normal, x, 0, 0.1f, 0.2f),
                    height_density(HeightLaw::logistic, x, 0, 0.1f, 0.2f)};
       }},
      {"height_share_below",
       [](float x) {
         return All{height_share_below(HeightLaw::normal, x, 0, 0.1f, 0.2f),
                    height_share_below(HeightLaw::logistic, x, 0, 0.1f, 0.2f)};
       }},
      {"sample_height",
       [](float x) {
         return All{sample_height(HeightLaw::normal, x, 0, 0.1f, 0.2f),
                    sample_height(HeightLaw::logistic, x, 0, 0.1f, 0.2f)};
       }},
      {"Ribbon_density", [](float x) { return All{ribbon().density(x, 0), ribbon().density(1, x)}; }},
      {"Ribbon_cdf",
       [](float x) {
         const auto a = ribbon().cdf(x, 0), b = ribbon().cdf(1, x);
         return All{a[0], a[1], b[0], b[1]};
       }},
      {"Ribbon_sample",
       [](float x) {
         const Ribbon::Place a = ribbon().sample(x, 0.5f), b = ribbon().sample(0.5f, x);
         return All{a.azimuth, a.height, b.azimuth, b.height};
       }},
      {"TracedNodes",
       [](float x) {
         const std::array<TracedRay, 3> rays{{{x, 1, 0}, {1, x, 0}, {2, 0.5f, 1}}};
         const TracedNodes nodes(rays, 0.2f), blurred(std::span<const TracedRay>(rays).last(1), std::fmax(x, 0.01f));
         return All{nodes.density(1), nodes.density(x), nodes.variation(), blurred.density(2), blurred.variation()};
       }},
      {"sample_of_query",
       [](float x) {
         All found;
         for (const SliceId slice : {0u, 1u}) {
           for (const std::uint32_t a : {0u, 2u}) {
             for (const NodeValue& value :
                  {sample(service(), {slice, a, 0}, {x, 0.5f, 0.5f}), sample(service(), {slice, a, 0}, {0.5f, x, x})})
               std::ranges::copy(numbers(value), std::back_inserter(found));
           }
         }
         return found;
       }},
      {"evaluate_of_query",
       [](float x) {
         All found;
         for (const SliceId slice : {0u, 1u}) {
           for (const std::uint32_t a : {0u, 2u}) {
             for (const NodeValue& value :
                  {evaluate(service(), {slice, a, 0}, x, 0.5f), evaluate(service(), {slice, a, 0}, 0.5f, x)})
               std::ranges::copy(numbers(value), std::back_inserter(found));
             found.push_back(pdf(service(), {slice, a, 0}, x, 0.5f));
             found.push_back(pdf(service(), {slice, a, 0}, 0.5f, x));
           }
         }
         return found;
       }},
      {"mean_of_query",
       [](float x) {
         All found;
         for (const SliceId slice : {0u, 1u}) {
           for (const NodeValue& value :
                {mean(service(), slice, x, 0.5f, 1, 0), mean(service(), slice, 0.5f, x, 1, 0),
                 mean(service(), slice, 0.5f, 0.5f, x, x), sample_mean(service(), slice, x, x, {x, x, x, x, x})})
             std::ranges::copy(numbers(value), std::back_inserter(found));
         }
         return found;
       }},
      {"calls_of_an_open_row",
       [](float x) {
         static Learned learned(1);
         const RowView row = learned.service.look_up(0, 0, 0);
         learned.service.observe(row, x, 1);
         learned.service.observe(row, 1, x);
         for (const auto& [at, g, q] : {std::array{x, 1.0f, 1.0f}, {1.0f, x, 1.0f}, {1.0f, 1.0f, x}})
           learned.service.score(row, at, g, q);
         learned.service.credit(row, x);
         learned.service.hear(learned.service.look_up(1, 0, 0), {x, x, 0, x, x});
         const PassReport report = learned.service.publish();
         const PackedMixture* fit = learned.service.peek(0, 0, 0).fit;
         return All{static_cast<float>(report.effective_sample_size), static_cast<float>(report.objective_max),
                    static_cast<float>(learned.service.light(0, 0, 0)), fit != nullptr ? fit->density(1) : 0};
       }},
  };
  const auto in_arc = [](const Arc& arc) {
    const RestrictedMixture cut(mixture(), arc);
    const RestrictedRibbon band(ribbon(), arc);
    const float x = cut.sample(0.3f, 0.1f), y = band.sample(0.3f, 0.5f).azimuth;
    EXPECT_TRUE(arc.contains(x) && arc.contains(y));
    EXPECT_GT(cut.proposal_density(x, 0.1f), 0);
    return All{cut.share_inside(),
               cut.density(x),
               cut.proposal_density(x, 0.1f),
               x,
               band.share_inside(),
               band.density(y, 0),
               y};
  };
  all.push_back({"Arc_from", [=](float x) { return in_arc({x, 1}); }});
  all.push_back({"Arc_width", [=](float x) { return in_arc({2, x}); }});
  all.push_back({"Restricted", [](float x) {
                   const RestrictedMixture cut(mixture(), {1, 3});
                   const RestrictedRibbon band(ribbon(), {1, 3});
                   const Ribbon::Place a = band.sample(x, 0.5f), b = band.sample(0.5f, x);
                   return All{cut.density(x),
                              cut.proposal_density(x, 0.1f),
                              cut.proposal_density(2, x),
                              cut.sample(x, 0.1f),
                              cut.sample(0.5f, x),
                              band.density(x, 0),
                              band.density(2, x),
                              a.azimuth,
                              a.height,
                              b.azimuth,
                              b.height};
                 }});
  return all;
}

class AnyNumber : public ::testing::TestWithParam<Call> {};
TEST_P(AnyNumber, HasFiniteAnswers) {
  for (const float x : strange) {
    for (const float y : GetParam().of(x)) EXPECT_TRUE(std::isfinite(y)) << x;
  }
}
INSTANTIATE_TEST_SUITE_P(Calls, AnyNumber, ::testing::ValuesIn(calls()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(Arc, ClampsItsWidth) {
  for (const float width : {std::numeric_limits<float>::quiet_NaN(), -1.0f, 0.0f, -infinity})
    EXPECT_EQ((Arc{1, width}.clamped().width), Arc::least_width);
  for (const float width : {7.0f, infinity}) EXPECT_EQ((Arc{1, width}.clamped().width), 2 * pi);
  EXPECT_EQ((Arc{infinity, 1}.clamped().from), 0);
  EXPECT_FALSE((Arc{1, -2}.contains(2)));
  EXPECT_TRUE((Arc{1, infinity}.contains(0)));
}

// Of a slice that was never added, and of nodes beyond a slice's ends.
TEST(Query, WhatDoesNotExistIsNotAnswered) {
  Learned learned(1);
  const Node missing[] = {{7, 0, 0}, {0, 3, 0}, {0, 0, 3}, {1, 3, 0}, {~0u, ~0u, ~0u}};
  for (const Node& node : missing) {
    for (const NodeValue& value :
         {sample(learned.service, node, {0.5f, 0.5f, 0.5f}), evaluate(learned.service, node, 1, 0.5f)}) {
      EXPECT_FALSE(value.answered);
      EXPECT_EQ(value.density, 0);
      EXPECT_EQ(value.pdf, 0);
    }
    EXPECT_EQ(pdf(learned.service, node, 1), 0);
    const RowView row = learned.service.peek(node.slice, node.a, node.b);
    EXPECT_EQ(row.node, RowView::no_node);
    learned.service.credit(row, 1);
    learned.service.hear(row, {1, 0, 0, 1, 0});
    EXPECT_TRUE(learned.service.publish().misuse) << "of sample() and evaluate()";
  }
  EXPECT_EQ(learned.service.light(0, 0, 0), 0) << "where a missing node's light must not go";
  EXPECT_FALSE(mean(learned.service, 7, 0.5f, 0.5f, 1).answered);
  EXPECT_FALSE(sample_mean(learned.service, 7, 0.5f, 0.5f, {}).answered);
}

TEST(Query, BatchesEndWithTheirShortestSpan) {
  Learned learned(1);
  const std::array<Node, 2> nodes{{{0, 0, 0}, {0, 1, 1}}};
  const std::array<std::array<float, 3>, 3> u{};
  const std::array<std::array<float, 2>, 1> places{};
  std::array<NodeValue, 4> values;
  values.fill({.pdf = 5, .answered = true});
  sample(learned.service, nodes, u, values);
  EXPECT_TRUE(values[1].answered);
  EXPECT_FALSE(values[2].answered || values[3].answered);
  evaluate(learned.service, nodes, places, values);
  EXPECT_TRUE(values[0].answered);
  EXPECT_FALSE(values[1].answered);
  sample(learned.service, {}, {}, values);
  EXPECT_FALSE(values[0].answered);
}

/// A service with each option strange in turn learns, answers with numbers, and says what it replaced.
TEST(AnyNumber, OptionsAreReplacedByUsableOnesAndNamed) {
  using Set = std::function<void(Options&, float)>;
  struct Case {
    const char* name;
    Set set;
  } const cases[] = {
      {"epsilon", [](Options& o, float x) { o.epsilon = static_cast<double>(x); }},
      {"sampled_epsilon", [](Options& o, float x) { o.sampled_epsilon = static_cast<double>(x); }},
      {"picture_error", [](Options& o, float x) { o.picture_error = static_cast<double>(x); }},
      {"heard_share", [](Options& o, float x) { o.heard_share = x; }},
      {"uniform_share_converged", [](Options& o, float x) { o.uniform_share_converged = x; }},
      {"uniform_share_open", [](Options& o, float x) { o.uniform_share_open = x; }},
      {"tests_before_refusal", [](Options& o, float x) { o.tests_before_refusal = x > 0 ? 1'000'000'000 : 0; }},
      {"queries_before_creation", [](Options& o, float x) { o.queries_before_creation = x > 0 ? 1'000'000'000 : 0; }},
      {"max_components", [](Options& o, float x) { o.max_components = x > 0 ? 1'000'000'000 : 0; }},
      {"memory_bytes", [](Options& o, float x) { o.memory_bytes = x > 0 ? ~std::size_t{0} : 0; }},
      {"learner", [](Options& o, float) { o.learner = nullptr; }},
  };
  for (const auto& [name, set] : cases) {
    for (const float x : strange) {
      Options options;
      set(options, x);
      Options usable = options;
      const std::vector<Error> unusable = make_usable(usable);
      EXPECT_TRUE(make_usable(usable).empty()) << name << " " << x;
      std::vector<std::string> logged;
      options.log = [&](const std::string& sentence) { logged.push_back(sentence); };
      Service service(options, Learned::peaks, Learned::lobes);
      ASSERT_EQ(logged.size(), unusable.size()) << name << " " << x;
      for (const std::string& sentence : logged)
        EXPECT_EQ(sentence.find(std::string("Options::") + name), 0u) << sentence;
      const SliceId densities = *service.add_slice(testing::toy_slice(0, 3)),
                    samples = *service.add_slice(testing::sampled_slice(1, 3));
      for (int pass = 0; pass < 3; ++pass) {
        for (int i = 0; i < 20; ++i) {
          const float u = (static_cast<float>(i) + 0.5f) / 20;
          for (const SliceId slice : {densities, samples})
            for (const float number : numbers(sample(service, {slice, 1, 1}, {u, u, u})))
              ASSERT_TRUE(std::isfinite(number)) << name << " " << x;
        }
        service.publish(20);
      }
    }
  }
}

TEST(AnyNumber, RaysThatWereMovedFromHaveNoDensity) {
  const TracedRay ray{1, 0.5f, 0};
  TracedNodes nodes(std::span(&ray, 1), 0.1f);
  const TracedNodes taken = std::move(nodes);
  EXPECT_GT(taken.density(1), 0);
  EXPECT_EQ(nodes.density(1), 0);
  EXPECT_EQ(nodes.size(), 0u);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
