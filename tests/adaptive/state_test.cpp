// A table that is saved as it is and taken over by a new service goes on to the bit; bytes that are no state of it are
// refused and change nothing.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/learner.h"
#include "tress/adaptive/row_form.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// The density of a row at one place.
class AtHalf final : public RowForm {
 public:
  std::size_t bytes(const RowView&) const override { return sizeof(float); }
  void write(const RowView& row, void* memory) const override { *static_cast<float*>(memory) = row.density(0.5f); }
};

constexpr std::uint32_t density_slices = 3;

/// A service of three slices of densities, one of samples, and a form of the first two.
struct Host {
  explicit Host(const Options& options, float turn = 0, bool adds_slices = true)
      : samples(turn), service(options, peaks, samples) {
    for (std::uint32_t p = 0; adds_slices && p < density_slices; ++p)
      slices.push_back(*service.add_slice(testing::toy_slice(p, 6, p == 2 ? 0.1f : 0.2f)));
    if (!adds_slices) return;
    SliceDescription graded = testing::sampled_slice(9, 3);
    graded.coarse = {{{0, 2}, {0, 2}}};
    slices.push_back(*service.add_slice(graded));
    for (const SliceId slice : {slices[0], slices[3]})
      forms.push_back(*service.add_form(slice, std::make_shared<AtHalf>(), {0.3f}));
  }

  PassReport pass(std::uint64_t number, std::size_t queries = 2500) {
    testing::run_pass(service, density_slices, number, queries, 1);
    for (std::uint32_t node = 0; node < 9; ++node) {
      for (std::uint32_t i = 0; i < 2 + node % 3; ++i) {
        const RowView row = service.look_up(slices[3], node / 3, node % 3);
        service.credit(row, 0.1f * static_cast<float>(node));
      }
      if (node % 2 == number % 2) (void)service.look_up(*forms[0], 3 * node);
      if (node % 4 == number % 4) (void)service.look_up(*forms[1], node);
    }
    return service.publish(100);
  }

  testing::MovingPeaks peaks;
  testing::MovingLobes samples;
  Service service;
  std::vector<SliceId> slices;
  std::vector<const FormedRows*> forms;
};

void expect_same(const PassReport& a, const PassReport& b) {
  EXPECT_EQ(a.queries, b.queries);
  EXPECT_EQ(a.converged_queries, b.converged_queries);
  EXPECT_EQ(a.g_evaluations, b.g_evaluations);
  EXPECT_EQ(a.traces, b.traces);
  EXPECT_EQ(a.refits, b.refits);
  EXPECT_EQ(a.creations, b.creations);
  EXPECT_EQ(a.newly_converged, b.newly_converged);
  EXPECT_EQ(a.validation_draws, b.validation_draws);
  EXPECT_EQ(a.rows_queried, b.rows_queried);
  EXPECT_EQ(a.rows_open, b.rows_open);
  EXPECT_EQ(a.rows_converged, b.rows_converged);
  EXPECT_EQ(a.rows_reopened, b.rows_reopened);
  EXPECT_EQ(a.rows_refused, b.rows_refused);
  EXPECT_EQ(a.bytes, b.bytes);
  EXPECT_EQ(a.at_ceiling, b.at_ceiling);
  EXPECT_EQ(a.objective_p50, b.objective_p50);
  EXPECT_EQ(a.objective_max, b.objective_max);
  EXPECT_EQ(a.absorbed_objective, b.absorbed_objective);
  EXPECT_EQ(a.effective_sample_size, b.effective_sample_size);
  EXPECT_EQ(a.bias_bound, b.bias_bound);
  EXPECT_EQ(a.ribbons, b.ribbons);
}

/// Runs `passes` passes; after each a new service takes over and does one more beside the old one. `cache`: loaded
/// first. Returns the last report.
PassReport follow(const Options& options, std::uint64_t passes, const TableSnapshot* cache = nullptr, float turn = 0) {
  Host first(options, turn);
  if (cache != nullptr) {
    EXPECT_FALSE(first.service.load(*cache));
  }
  std::unique_ptr<Host> resumed;
  PassReport report;
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    report = first.pass(pass);
    if (resumed) expect_same(report, resumed->pass(pass));
    const Result<std::string> state = first.service.state();
    EXPECT_TRUE(state) << state.error().message();
    if (resumed) {
      EXPECT_TRUE(*state == *resumed->service.state()) << "pass " << pass;
    }
    resumed = std::make_unique<Host>(options, turn);
    const std::optional<Error> refused = resumed->service.restore(*state);
    EXPECT_FALSE(refused) << refused->message();
    EXPECT_EQ(cache_hash(*first.service.rows()), cache_hash(*resumed->service.rows()));
  }
  return report;
}

TEST(TableState, ANewServiceGoesOnToTheBitAfterEveryPass) {
  const PassReport last = follow(Options{}, 4);
  EXPECT_GT(last.rows_converged, 0u);
  EXPECT_GT(last.ribbons, 0u);
  EXPECT_GT(last.rows_open, 0u) << "open rows must be among those saved";
}

TEST(TableState, RowsThatAreRefusedOrDrivenByLightAreAmongIt) {
  Options options;
  options.epsilon = 1e-6;  // most are refused in the end
  options.tests_before_refusal = 2;
  EXPECT_GT(follow(options, 6).rows_refused, 0u);
  Options driven;
  driven.picture_error = 0.01;
  follow(driven, 5);
}

TEST(TableState, SoAreRowsOfACacheThatWaitMoveOrHaveNoUser) {
  TableSnapshot cache;
  {
    Options coarse;
    coarse.epsilon = 0.05;
    Host host(coarse);
    (void)host.service.add_slice(testing::toy_slice(7, 4));
    for (std::uint64_t pass = 0; pass < 4; ++pass) host.pass(pass);
    for (std::uint32_t i = 0; i < 400; ++i) {
      const RowView row = host.service.look_up(4, i % 4, i / 4 % 4);
      const float x = 0.01f * static_cast<float>(i);
      if (row.nodes != nullptr) host.service.observe(row, x, row.nodes->density(x));
    }
    host.pass(4);
    cache = host.service.snapshot();
  }
  ASSERT_EQ(cache.slices.size(), 5u);
  EXPECT_GT(follow(Options{}, 5, &cache).rows_converged, 0u);
  EXPECT_GT(follow(Options{}, 5, &cache, 1.0f).rows_reopened, 0u) << "the samples have moved";
  Options small;
  small.memory_bytes = 60000;
  EXPECT_TRUE(follow(small, 5, &cache).at_ceiling);
}

TEST(TableState, IsRefusedWhereTheServiceIsAnother) {
  Host host(Options{});
  EXPECT_FALSE(host.service.state()) << "before the first pass";
  host.pass(0);
  const std::string state = *host.service.state();
  const Learner other_learner{"other", "", sketch_learner.make};
  Options other;
  other.learner = &other_learner;
  EXPECT_NE(Host(other).service.restore(state)->message().find("learner other"), std::string::npos);
  EXPECT_NE(Host(Options{}, 0, false).service.restore(state)->message().find("0 slices"), std::string::npos);
  EXPECT_TRUE(host.service.restore(state)) << "it has a pass behind it";
  Host loaded(Options{});
  EXPECT_FALSE(loaded.service.load(host.service.snapshot()));
  EXPECT_TRUE(loaded.service.restore(state)) << "it has loaded a cache";
}

TEST(TableState, BytesThatAreNoStateAreRefusedAndChangeNothing) {
  Host host(Options{});
  for (std::uint64_t pass = 0; pass < 3; ++pass) host.pass(pass);
  const std::string state = *host.service.state();
  Host fresh(Options{});
  for (std::size_t size = 0; size < state.size(); size += 1 + size / 10)
    EXPECT_TRUE(fresh.service.restore(state.substr(0, size))) << size;
  EXPECT_TRUE(fresh.service.restore(state + "x"));
  // Nothing was taken over: it still accepts a state, and is then what the other is.
  EXPECT_FALSE(fresh.service.restore(state));
  EXPECT_TRUE(*fresh.service.state() == state);
  std::size_t refused = 0, tried = 0;
  RandomStream random(11, 0);
  for (; tried < 60; ++tried) {
    std::string bad = state;
    const std::size_t at = random.next_bits() % bad.size();
    bad[at] = static_cast<char>(bad[at] ^ static_cast<char>(1u << random.next_bits() % 8));
    Host victim(Options{});
    if (victim.service.restore(bad)) {
      ++refused;
      continue;
    }
    victim.pass(3, 200);  // a wrong table at worst
  }
  EXPECT_GT(refused, 0u);
  EXPECT_LT(refused, tried) << "none of the flips was in a number of no bounds: the test is too weak";
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
