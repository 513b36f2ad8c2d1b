// Rows of slices of samples: their life in the table, beside rows of densities, with good targets and bad.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

using testing::MovingLobes;
using testing::MovingPeaks;
using testing::sampled_slice;
using testing::toy_slice;

constexpr std::uint32_t size = 2, nodes = size * size;

/// Asks each node of a slice of `of` x `of` nodes so often, from so many threads.
void ask_all(const Service& service, SliceId slice, std::uint32_t of = size, int queries = 8, unsigned threads = 1) {
  std::vector<std::thread> readers;
  for (unsigned t = 0; t < threads; ++t) {
    readers.emplace_back([&, t] {
      for (int k = static_cast<int>(t); k < queries; k += static_cast<int>(threads)) {
        for (std::uint32_t n = 0; n < of * of; ++n) service.look_up(slice, n / of, n % of);
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
}

/// Rows learn until they pass their test, whatever they are asked.
Options to_epsilon() {
  Options options;
  options.learns_to_epsilon = true;
  return options;
}

/// A service whose every row has been asked in one pass.
struct Session {
  explicit Session(const SampledTarget& target, const Options& options = to_epsilon(),
                   const TableSnapshot* image = nullptr)
      : service(options, target) {
    slice = *service.add_slice(sampled_slice(3, size));
    if (image != nullptr) {
      EXPECT_FALSE(service.load(*image));
    }
  }
  PassReport pass() {
    ask_all(service, slice);
    return service.publish();
  }
  Service service;
  SliceId slice = 0;
};

TEST(SampledRows, ConvergeAtTheEndOfThePassOfTheirLastQuery) {
  const MovingLobes target;
  Session session(target);
  const Service& service = session.service;
  ask_all(service, session.slice, size, 7);
  EXPECT_EQ(session.service.publish().creations, 0u);

  const RowView absent = service.look_up(session.slice, 0, 1);
  EXPECT_EQ(absent.state, RowState::absent);
  EXPECT_EQ(absent.nodes, nullptr);
  EXPECT_EQ(absent.ribbons, nullptr);
  EXPECT_EQ(absent.objective, 1);
  service.credit(absent, 1);
  service.observe(absent, 0, 1);
  const PassReport first = session.service.publish();
  EXPECT_EQ(first.creations, 1u);
  EXPECT_EQ(first.newly_converged, 1u);
  EXPECT_EQ(first.rows_converged, 1u);
  EXPECT_EQ(first.ribbons, 1u);
  EXPECT_EQ(first.traces, 0u);
  EXPECT_GE(first.g_evaluations, 2048u);
  EXPECT_EQ(first.converged_queries, 0u);
  EXPECT_LE(first.objective_max, service.options().sampled_epsilon);

  const RowView row = service.look_up(session.slice, 0, 1);
  EXPECT_EQ(row.state, RowState::converged);
  ASSERT_NE(row.ribbons, nullptr);
  EXPECT_EQ(row.fit, nullptr);
  EXPECT_EQ(row.nodes, nullptr);
  EXPECT_EQ(row.objective, static_cast<float>(first.objective_max));
  EXPECT_EQ(row.ribbons->parts(), 2u);
  EXPECT_NEAR(row.ribbons->total_mass(), 0.8f, 1e-4f);
  const RibbonRow before = *row.ribbons;
  service.credit(row, 1);
  service.observe(row, 0, 1);
  service.score(row, 0, 1, 1);
  const PassReport second = session.service.publish(1);
  EXPECT_EQ(second.converged_queries, 1u);
  EXPECT_EQ(second.g_evaluations, 0u);
  EXPECT_EQ(second.bytes, first.bytes);
  EXPECT_GT(second.bias_bound, 0);
  EXPECT_EQ(*service.peek(session.slice, 0, 1).ribbons, before);
}

struct Learned {
  std::string bytes;
  PassReport report;
};

/// Both kinds in one service: their slices in turn.
Learned learn_both(unsigned threads, std::size_t memory_bytes) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
  const MovingPeaks target;
  const MovingLobes samples;
  Options options = to_epsilon();
  options.memory_bytes = memory_bytes;
  Service service(options, target, samples);
  service.add_slice(toy_slice(0, 4));
  service.add_slice(toy_slice(2, 4));
  const SliceId sampled = *service.add_slice(sampled_slice(1, size));
  Learned learned;
  for (std::uint64_t pass = 0; pass < 5; ++pass) {
    testing::run_pass(service, 2, pass, 800, threads);
    ask_all(service, sampled, size, 8, threads);
    for (std::uint32_t n = 0; n < nodes; ++n)
      service.credit(service.peek(sampled, n / size, n % size), static_cast<float>(n));
    learned.report = service.publish(100);
    EXPECT_LE(learned.report.bytes, memory_bytes);
  }
  learned.bytes = encode_cache(service.snapshot());
  return learned;
}

TEST(SampledRows, AreTheSameToTheBitForAnyNumberOfThreads) {
  const Learned one = learn_both(1, 64 << 20);
  EXPECT_EQ(one.report.ribbons, nodes);
  EXPECT_GT(one.report.rows_open, 0u);
  EXPECT_GT(one.report.rows_converged, one.report.ribbons);
  for (const unsigned threads : {2u, 8u}) EXPECT_EQ(learn_both(threads, 64 << 20).bytes, one.bytes);
}

TEST(SampledRows, WaitAtTheCeilingInOrderOfTheirLight) {
  // Rows of densities are there first; after them a row of samples, perhaps two.
  const std::size_t ceiling = learn_both(1, 64 << 20).report.bytes / 2;
  const Learned one = learn_both(1, ceiling);
  EXPECT_TRUE(one.report.at_ceiling);
  for (const unsigned threads : {2u, 8u}) EXPECT_EQ(learn_both(threads, ceiling).bytes, one.bytes);

  const MovingLobes target;
  Options options = to_epsilon();
  options.memory_bytes = 4000;  // for two rows
  Session session(target, options);
  for (std::uint32_t n = 0; n < nodes; ++n)
    session.service.credit(session.service.look_up(session.slice, n / size, n % size), static_cast<float>(n));
  const PassReport report = session.pass();
  EXPECT_TRUE(report.at_ceiling);
  ASSERT_EQ(report.ribbons, 2u);
  EXPECT_LE(report.bytes, options.memory_bytes);
  EXPECT_EQ(session.service.look_up(session.slice, 0, 0).state, RowState::absent);
  EXPECT_NE(session.service.look_up(session.slice, 1, 1).ribbons, nullptr);
}

TEST(SampledRows, LeaveThoseOfDensitiesAsTheyWouldBeAlone) {
  const MovingPeaks target;
  const MovingLobes samples;
  Service both(Options{}, target, samples), alone(Options{}, target);
  for (Service* service : {&both, &alone}) service->add_slice(toy_slice(0, 4));
  const SliceId sampled = *both.add_slice(sampled_slice(1, size));
  for (std::uint64_t pass = 0; pass < 3; ++pass) {
    for (Service* service : {&both, &alone}) testing::run_pass(*service, 1, pass, 800, 1);
    ask_all(both, sampled);
    both.publish();
    alone.publish();
  }
  TableSnapshot image = both.snapshot();
  ASSERT_EQ(image.slices.size(), 2u);
  EXPECT_EQ(image.slices[1].description.kind, SliceKind::samples);
  image.slices.pop_back();
  EXPECT_EQ(encode_cache(image), encode_cache(alone.snapshot()));

  Service loaded(Options{}, target, samples);
  EXPECT_FALSE(loaded.load(alone.snapshot()));
  loaded.add_slice(sampled_slice(1, size));
  loaded.add_slice(toy_slice(0, 4));
  EXPECT_EQ(encode_cache(loaded.snapshot()), encode_cache(alone.snapshot()));
}

TEST(SampledRows, OfACacheAnswerAtOnceAndSaveToTheSameBytes) {
  const MovingLobes target;
  Session first(target);
  first.pass();
  const TableSnapshot image = first.service.snapshot();
  Session second(target, to_epsilon(), &image);
  const RowView row = second.service.look_up(second.slice, 1, 0);
  ASSERT_NE(row.ribbons, nullptr);
  EXPECT_EQ(*row.ribbons, *first.service.peek(first.slice, 1, 0).ribbons);
  const PassReport report = second.pass();
  EXPECT_EQ(report.rows_reopened, 0u);
  EXPECT_EQ(report.newly_converged, 0u);
  EXPECT_GT(report.g_evaluations, 0u) << "the first row that is asked is audited";
  EXPECT_LT(report.g_evaluations, 5u * 4096);
  EXPECT_EQ(encode_cache(second.service.snapshot()), encode_cache(image));
}

TEST(SampledRows, OfATargetThatHasChangedAreLearnedAnew) {
  const MovingLobes old;
  Session first(old);
  first.pass();
  const TableSnapshot image = first.service.snapshot();
  const MovingLobes moved(0.5f);
  std::vector<std::string> logged;
  Options options = to_epsilon();
  options.log = [&](const std::string& sentence) { logged.push_back(sentence); };
  Session second(moved, options, &image);
  PassReport report = second.pass();
  EXPECT_GT(report.rows_reopened, 0u);
  ASSERT_EQ(logged.size(), 1u);
  EXPECT_NE(logged[0].find("do not fit their target"), std::string::npos);
  report = second.pass();
  EXPECT_EQ(report.rows_reopened, nodes) << "one that does not fit brings its slice to the test";
  EXPECT_EQ(report.ribbons, nodes);
  Session fresh(moved);
  fresh.pass();
  for (std::uint32_t n = 0; n < nodes; ++n) {
    EXPECT_EQ(*second.service.peek(second.slice, n / size, n % size).ribbons,
              *fresh.service.peek(fresh.slice, n / size, n % size).ribbons);
  }
  const TableSnapshot after = second.service.snapshot();
  for (const CachedRow& row : after.slices[0].rows) EXPECT_EQ(row.generation, 1u);
}

/// Draws that SampledTarget does not allow, in one way each.
class BadLobes final : public MovingLobes {
 public:
  enum class Fault { negative, nan_weight, nan_place, infinite_height, part, no_mass, no_exit };
  BadLobes(Fault fault, std::uint32_t bad_node_b) : fault_(fault), bad_b_(bad_node_b) {}
  void draw(const SliceDescription& slice, float a, float b, std::uint64_t stream, std::uint32_t first,
            std::uint32_t count, std::vector<SampledExit>& out) const override {
    MovingLobes::draw(slice, a, b, stream, first, count, out);
    if (b != slice.axis_b[bad_b_] || out.empty()) return;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    SampledExit& last = out.back();
    if (fault_ == Fault::negative) last.weight = -1e-6f;
    if (fault_ == Fault::nan_weight) last.weight = nan;
    if (fault_ == Fault::nan_place) last.azimuth = nan;
    if (fault_ == Fault::infinite_height) last.height = std::numeric_limits<float>::infinity();
    if (fault_ == Fault::part) last.part = 2;
    if (fault_ == Fault::no_exit) out.clear();
    if (fault_ != Fault::no_mass) return;
    for (SampledExit& exit : out) exit.weight = 0;
  }

 private:
  Fault fault_;
  std::uint32_t bad_b_;
};

TEST(SampledRows, OfInvalidDrawsAreRefusedAndReportedOnce) {
  using Fault = BadLobes::Fault;
  for (const Fault fault : {Fault::negative, Fault::nan_weight, Fault::nan_place, Fault::infinite_height, Fault::part,
                            Fault::no_mass, Fault::no_exit}) {
    const BadLobes target(fault, 1);
    const bool is_misuse = fault != Fault::no_mass && fault != Fault::no_exit;  // a valid target may have no light
    std::vector<std::string> logged;
    Options options = to_epsilon();
    options.log = [&](const std::string& sentence) { logged.push_back(sentence); };
    Session session(target, options);
    for (int pass = 0; pass < 2; ++pass) {
      const PassReport report = session.pass();
      EXPECT_EQ(report.rows_refused, 2u) << static_cast<int>(fault);
      EXPECT_EQ(report.unusable, 2u);
      EXPECT_EQ(report.ribbons, 2u);
      EXPECT_EQ(report.misuse.has_value(), is_misuse && pass == 0) << static_cast<int>(fault);
      if (report.misuse) {
        EXPECT_NE(report.misuse->expected.find("a part below 2"), std::string::npos) << report.misuse->message();
      }
    }
    EXPECT_EQ(logged.size(), is_misuse ? 2u : 1u);
    const RowView row = session.service.look_up(session.slice, 0, 1);
    EXPECT_EQ(row.state, RowState::refused);
    EXPECT_EQ(row.ribbons, nullptr);
    EXPECT_EQ(row.nodes, nullptr);
    EXPECT_EQ(row.objective, 1);
  }
}

Options hard() {
  Options options = to_epsilon();
  options.sampled_epsilon = 1e-5;  // past what the most paths show
  return options;
}

TEST(SampledRows, ThatDoNotPassAnswerOnAndAreLogged) {
  const MovingLobes target;
  Session first(target, hard());
  const PassReport report = first.pass();
  EXPECT_EQ(report.rows_refused, 0u);
  EXPECT_EQ(report.rows_converged, 0u);
  EXPECT_EQ(report.rows_open, nodes);
  EXPECT_EQ(report.ribbons, nodes);
  EXPECT_EQ(report.rows_at_most_paths, nodes);
  const RowView row = first.service.look_up(first.slice, 0, 0);
  EXPECT_EQ(row.state, RowState::open);
  EXPECT_NE(row.ribbons, nullptr);
  EXPECT_EQ(row.paths, 65536u);
  EXPECT_EQ(first.pass().g_evaluations, 0u) << "for good";
  const TableSnapshot image = first.service.snapshot();
  Session second(target, to_epsilon(), &image);
  EXPECT_EQ(second.service.look_up(second.slice, 0, 0).state, RowState::converged) << "within the usual epsilon";
  EXPECT_EQ(encode_cache(second.service.snapshot()), encode_cache(image));
}

TEST(SampledRows, OfACacheThatAreTooCoarseAnswerAtOnceAndAreRefined) {
  const MovingLobes target;
  Session first(target);
  first.pass();
  const TableSnapshot image = first.service.snapshot();
  Session second(target, hard(), &image);
  const RowView before = second.service.look_up(second.slice, 0, 0);
  ASSERT_NE(before.ribbons, nullptr);
  EXPECT_EQ(before.state, RowState::open);
  const std::uint32_t paths = before.paths;
  second.pass();
  EXPECT_GT(second.service.look_up(second.slice, 0, 0).paths, paths);
}

/// 9 x 9 nodes with a coarse grid, and a second one, which is not used.
SliceDescription graded_slice() {
  SliceDescription slice = sampled_slice(3, 9);
  slice.coarse = {{{0, 4, 8}, {0, 8}}, {{0, 2, 4, 6, 8}, {0, 4, 8}}};
  return slice;
}

TEST(SampledRows, AreCoarseBeforeTheFirstPassAndAnswerEveryNode) {
  const MovingLobes target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(graded_slice());
  EXPECT_EQ(service.look_up(slice, 3, 3).ribbons, nullptr);
  service.prepare();
  EXPECT_EQ(service.peek(slice, 4, 8).state, RowState::open);
  EXPECT_EQ(service.peek(slice, 4, 8).paths, 512u);
  for (std::uint32_t n = 0; n < 81; ++n) {
    const RowView row = service.look_up(slice, n / 9, n % 9);
    ASSERT_NE(row.ribbons, nullptr) << n;
    EXPECT_EQ(row.state, row.row == RowView::no_row ? RowState::absent : RowState::open);
    EXPECT_NEAR(row.ribbons->total_mass(), 0.8f, 1e-3f) << n;
  }
  // Half way between coarse nodes the lobe lies half way: at a = 1.5/9 part 0 is at 2 a.
  const Ribbon between = service.peek(slice, 2, 0).ribbons->ribbon(0);
  const float there = 2 * graded_slice().axis_a[2], height = graded_slice().axis_b[0];
  EXPECT_GT(between.density(there, height), 2 * between.density(there + 0.5f, height));
  EXPECT_GT(between.density(there, height), 2 * between.density(there - 0.5f, height));
  const PassReport report = service.publish();
  EXPECT_EQ(report.rows_open, 6u);
  EXPECT_EQ(report.rows_coarse, 75u);
  EXPECT_EQ(report.ribbons, 6u);
}

TEST(SampledRows, BecomeFinerAndGetPathsWhereEventsAre) {
  const MovingLobes target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(graded_slice());
  service.prepare();
  const auto ask = [&](std::uint32_t a, std::uint32_t b, std::uint32_t events) {
    service.credit(service.look_up(slice, a, b), 0, events);
  };
  ask(2, 4, 128);
  ask(3, 5, 512);
  service.publish();
  EXPECT_EQ(service.peek(slice, 2, 4).row, RowView::no_row);
  EXPECT_EQ(service.peek(slice, 3, 5).state, RowState::open);
  EXPECT_EQ(service.peek(slice, 3, 5).paths, 512u);
  ask(3, 5, 1024);
  const PassReport report = service.publish();
  EXPECT_EQ(service.peek(slice, 3, 5).paths, 2048u) << "at least one path for two events";
  EXPECT_GE(report.newly_converged, 1u);
  EXPECT_EQ(service.peek(slice, 3, 5).state, RowState::converged);
  ask(3, 5, 1000000);
  for (int pass = 0; pass < 3; ++pass) service.publish();
  EXPECT_EQ(service.peek(slice, 3, 5).paths, 16384u) << "a row that has passed gets paths all the same";
  EXPECT_EQ(service.publish().g_evaluations, 0u);
}

// With an epsilon to reach, coarse rows answer until rows of their own are learned, and are not held to it.
TEST(SampledRows, LearnToEpsilonOnlyWhereTheyAreAsked) {
  const MovingLobes target;
  Options options;
  options.learns_to_epsilon = true;
  Service service(options, target);
  const SliceId slice = *service.add_slice(graded_slice());
  service.prepare();
  EXPECT_EQ(service.publish().newly_converged, 0u);
  service.credit(service.look_up(slice, 4, 8), 0, options.queries_before_creation);  // a coarse node
  service.credit(service.look_up(slice, 3, 5), 0, options.queries_before_creation);
  EXPECT_EQ(service.publish().newly_converged, 2u);
  EXPECT_EQ(service.peek(slice, 4, 8).state, RowState::converged);
  EXPECT_EQ(service.peek(slice, 3, 5).state, RowState::converged);
  EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::open);
  EXPECT_EQ(service.peek(slice, 0, 0).paths, 512u);
}

// What answers a node must be what a session that goes on from its state, or from the cache, would answer by.
TEST(SampledRows, InterpolateTheSameFromACacheAndFromAState) {
  const MovingLobes target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(graded_slice());
  service.prepare();
  for (std::uint32_t n = 0; n < 81; ++n) service.credit(service.look_up(slice, n / 9, n % 9), 1, 11 * n);
  service.publish();
  for (std::uint32_t n = 0; n < 81; ++n) service.look_up(slice, n / 9, n % 9);
  service.publish();
  const TableSnapshot image = service.snapshot();
  const Result<std::string> state = service.state();
  ASSERT_TRUE(state);
  Service warm(Options{}, target), resumed(Options{}, target);
  warm.add_slice(graded_slice());
  resumed.add_slice(graded_slice());
  EXPECT_FALSE(warm.load(image));
  EXPECT_FALSE(resumed.restore(*state));
  EXPECT_EQ(*resumed.state(), *state);
  for (std::uint32_t n = 0; n < 81; ++n) {
    const RowView row = service.peek(slice, n / 9, n % 9);
    EXPECT_EQ(*warm.peek(0, n / 9, n % 9).ribbons, *row.ribbons) << n;
    EXPECT_EQ(*resumed.peek(0, n / 9, n % 9).ribbons, *row.ribbons) << n;
    EXPECT_EQ(resumed.peek(0, n / 9, n % 9).state, row.state) << n;
  }
}

/// A slice whose coarse rows are those of graded_slice().
SliceDescription similar_slice() {
  SliceDescription slice = graded_slice();
  slice.key.parameters[1] = 0.25f;
  slice.coarse_rows_of = graded_slice().key;
  return slice;
}

TEST(SampledRows, AnswerWhileCoarseForASimilarSlice) {
  const MovingLobes target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(graded_slice()), similar = *service.add_slice(similar_slice());
  service.prepare();
  for (std::uint32_t n = 0; n < 81; ++n) {
    const RowView row = service.look_up(similar, n / 9, n % 9);
    ASSERT_NE(row.ribbons, nullptr) << n;
    EXPECT_EQ(*row.ribbons, *service.peek(slice, n / 9, n % 9).ribbons) << n;
    EXPECT_EQ(row.state, RowState::absent);
  }
  service.credit(service.peek(similar, 4, 8), 1, 64);    // a node of the coarse grid
  service.credit(service.peek(similar, 3, 5), 1, 8192);  // a node of the slice alone
  const PassReport report = service.publish();
  EXPECT_EQ(report.queries, 81u);
  EXPECT_EQ(report.answered_queries, 81u);
  // The events of both refine the coarse rows of the one; a finer row is the similar slice's own.
  EXPECT_EQ(service.peek(similar, 4, 8).row, RowView::no_row);
  EXPECT_EQ(service.peek(slice, 4, 8).paths, 2048u);
  EXPECT_EQ(service.peek(similar, 4, 8).paths, 2048u);
  EXPECT_EQ(*service.peek(similar, 4, 8).ribbons, *service.peek(slice, 4, 8).ribbons) << "made again";
  EXPECT_NE(service.peek(similar, 3, 5).row, RowView::no_row);
  EXPECT_EQ(service.peek(slice, 3, 5).row, RowView::no_row);
}

TEST(SampledRows, OfACoarseGridGrowTogether) {
  const MovingLobes target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(graded_slice()), similar = *service.add_slice(similar_slice());
  service.prepare();
  EXPECT_EQ(service.publish().creations, 6u) << "those of prepare()";
  // Events of the similar slice, since those of the slice itself would refine its rows as its own.
  service.credit(service.peek(similar, 4, 8), 0, 2047);
  service.credit(service.peek(similar, 0, 0), 0, 1024);
  service.publish();
  EXPECT_EQ(service.peek(slice, 4, 8).paths, 512u) << "each has the 1,024 events of the next stage, none twice as many";
  EXPECT_EQ(service.peek(slice, 0, 0).paths, 512u);
  service.credit(service.peek(similar, 4, 8), 0, 1);
  service.publish();
  EXPECT_EQ(service.peek(slice, 4, 8).paths, 2048u);
  EXPECT_EQ(service.peek(slice, 0, 0).paths, 2048u);
  EXPECT_EQ(service.peek(slice, 0, 8).paths, 512u) << "it has no events";
}

TEST(SampledRows, OfASimilarSliceAreTheSameFromAState) {
  for (const std::size_t memory : {std::size_t{1} << 26, std::size_t{60000}}) {
    const MovingLobes target;
    Options options;
    options.memory_bytes = memory;
    Service service(options, target), resumed(options, target);
    const auto add = [](Service& to) {
      ASSERT_TRUE(to.add_slice(graded_slice()));
      ASSERT_TRUE(to.add_slice(similar_slice()));
    };
    add(service);
    service.prepare();
    for (int pass = 0; pass < 2; ++pass) {
      for (SliceId slice : {1u, 0u}) {
        for (std::uint32_t n = 0; n < 81; ++n) service.credit(service.look_up(slice, n / 9, n % 9), 1, 11 * n);
      }
      service.publish();
    }
    for (std::uint32_t n = 0; n < 81; n += 2) service.look_up(1, n / 9, n % 9);
    service.publish();
    const Result<std::string> state = service.state();
    ASSERT_TRUE(state);
    add(resumed);
    ASSERT_FALSE(resumed.restore(*state));
    EXPECT_EQ(*resumed.state(), *state) << memory;
    for (std::uint32_t n = 0; n < 81; ++n) {
      for (SliceId slice : {0u, 1u}) {
        const RowView before = service.peek(slice, n / 9, n % 9), after = resumed.peek(slice, n / 9, n % 9);
        ASSERT_NE(before.ribbons, nullptr) << n;
        ASSERT_NE(after.ribbons, nullptr) << n;
        EXPECT_EQ(*after.ribbons, *before.ribbons) << n;
      }
    }
  }
}

TEST(SampledRows, OfASimilarSliceWithoutAnIndexAreNotAsked) {
  const MovingLobes target;
  Options options;
  options.memory_bytes = 0;
  int without_index = 0;
  options.log = [&](const std::string& sentence) {
    without_index += sentence.find("no room for its index") != std::string::npos ? 1 : 0;
  };
  Service service(options, target);
  ASSERT_TRUE(service.add_slice(graded_slice()));
  SliceDescription similar = similar_slice();
  SliceId last = 0;
  for (int i = 1; without_index == 0; ++i) {
    similar.key.parameters[1] = static_cast<float>(i);
    last = *service.add_slice(similar);
    ASSERT_LT(last, 100000u);
  }
  service.look_up(0, 2, 4);
  service.look_up(last, 2, 4);
  service.publish();
  EXPECT_EQ(service.look_up(last, 2, 4).ribbons, nullptr);
}

TEST(SampledRows, OfASimilarSliceNeedOneThatWasAddedOnTheSameGrids) {
  const MovingLobes target;
  Service service(Options{}, target);
  EXPECT_FALSE(service.add_slice(similar_slice())) << "not added yet";
  ASSERT_TRUE(service.add_slice(graded_slice()));
  SliceDescription other = similar_slice();
  other.coarse.erase(other.coarse.begin());
  const Result<SliceId> refused = service.add_slice(other);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("same grids"), std::string::npos) << refused.error().message();
  EXPECT_TRUE(service.add_slice(similar_slice()));
}

TEST(SampledRows, OfEveryLevelAreTheSameForAnyNumberOfThreads) {
  std::string bytes;
  for (const unsigned threads : {1u, 2u, 8u}) {
    const tbb::global_control width(tbb::global_control::max_allowed_parallelism, threads);
    const MovingLobes target;
    Service service(Options{}, target);
    const SliceId slice = *service.add_slice(graded_slice());
    service.prepare();
    for (int pass = 0; pass < 4; ++pass) {
      ask_all(service, slice, 9, 16, threads);
      for (std::uint32_t n = 0; n < 81; ++n) service.credit(service.peek(slice, n / 9, n % 9), 1, 13 * n);
      service.publish(100);
    }
    const std::string now = encode_cache(service.snapshot());
    if (bytes.empty()) bytes = now;
    EXPECT_EQ(now, bytes) << threads;
  }
}

TEST(SampledRows, NeedCoarseAxesThatCoverTheSlice) {
  const MovingLobes target;
  for (const CoarseAxes& bad : {CoarseAxes{{0, 4}, {0, 8}}, CoarseAxes{{0, 8}, {2, 8}}, CoarseAxes{{0, 0, 8}, {0, 8}},
                                CoarseAxes{{}, {0, 8}}}) {
    Service service(Options{}, target);
    SliceDescription slice = sampled_slice(3, 9);
    slice.coarse = {bad};
    EXPECT_FALSE(service.add_slice(slice));
  }
}

TEST(SampledRows, OfAFrozenTableStayAsTheyAre) {
  const MovingLobes target;
  Session cold(target);
  cold.service.set_learning(false);
  const PassReport none = cold.pass();
  EXPECT_EQ(none.creations, 0u);
  EXPECT_EQ(none.g_evaluations, 0u);
  EXPECT_EQ(cold.service.look_up(cold.slice, 0, 0).state, RowState::absent);
  Session first(target);
  first.pass();
  const TableSnapshot image = first.service.snapshot();
  const MovingLobes moved(0.5f);
  Session warm(moved, to_epsilon(), &image);
  warm.service.set_learning(false);
  const PassReport report = warm.pass();
  EXPECT_EQ(report.ribbons, nodes);
  EXPECT_EQ(report.g_evaluations, 0u) << "not audited either";
}

TEST(SampledRows, AreLearnedByTheLightThatTheyCarry) {
  const MovingLobes target;
  Options options;
  options.picture_error = 0.001;
  Session session(target, options);
  const Service& service = session.service;
  service.credit(service.look_up(session.slice, 1, 1), 100);
  ask_all(service, session.slice);
  const PassReport report = session.service.publish(100);
  ASSERT_EQ(report.ribbons, nodes);
  const RowView bright = service.peek(session.slice, 1, 1), dark = service.peek(session.slice, 0, 0);
  // error = 0.001/(0.1 x 4 rows x 1.01 of the light), squared, and no less than 0.005; of the dark one 0.0001/0.0004.
  EXPECT_LE(bright.objective, 0.005f);
  EXPECT_GT(dark.objective, 0.005f);
  EXPECT_LE(dark.objective, 0.5f);
  EXPECT_NEAR(report.bias_bound, std::sqrt(bright.objective), 1e-6);
}

/// Density of part 0 at four azimuths.
class FourDensities final : public RowForm {
 public:
  std::size_t bytes(const RowView&) const override { return 4 * sizeof(float); }
  void write(const RowView& row, void* memory) const override {
    std::array<float, 4> values;
    const Ribbon part = row.ribbons->ribbon(0);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = part.density(static_cast<float>(i), 0.5f);
    std::memcpy(memory, values.data(), sizeof(values));
  }
};

TEST(SampledRows, AreReadInAFormToo) {
  const MovingLobes target;
  Session session(target);
  Service& service = session.service;
  const FormedRows& rows = **service.add_form(session.slice, std::make_shared<FourDensities>(), {1.0f});
  const FormedLookup absent = service.look_up(rows, 3);
  EXPECT_FALSE(absent.answer);
  EXPECT_EQ(absent.row.state, RowState::absent);
  session.pass();
  const FormedLookup found = service.fetch(rows, 3);
  ASSERT_TRUE(found.answer);
  EXPECT_EQ(static_cast<const float*>(found.answer.block())[1],
            service.peek(session.slice, 1, 1).ribbons->ribbon(0).density(1, 0.5f));
  {
    AnswerReader reader(&service);
    EXPECT_EQ(reader.read(rows.run(1), 1).block(), found.answer.block());
  }
  const PassReport report = service.publish();
  EXPECT_EQ(report.converged_queries, 2u);
  EXPECT_EQ(report.answered_queries, 2u);
}

TEST(SampledRows, ArePassedToTheListener) {
  const BadLobes target(BadLobes::Fault::no_mass, 1);
  Session session(target);
  std::vector<RowReport> heard;
  session.service.set_row_listener([&](const RowReport& row) { heard.push_back(row); });
  session.pass();
  ASSERT_EQ(heard.size(), nodes);
  EXPECT_EQ(heard[0].state, RowState::converged);
  EXPECT_EQ(heard[0].ribbons, 2u);
  EXPECT_EQ(heard[0].components, 0u);
  EXPECT_EQ(heard[0].slice, sampled_slice(3, size).key);
  EXPECT_EQ(heard[1].state, RowState::refused);
  EXPECT_LT(heard[1].objective, 0);
  EXPECT_EQ(heard[1].ribbons, 0u);
}

TEST(SampledRows, NeedATargetAndAKeyOfTheirOwn) {
  const MovingPeaks target;
  const MovingLobes samples;
  Service densities(Options{}, target), sampled(Options{}, samples), both(Options{}, target, samples);
  EXPECT_NE(densities.add_slice(sampled_slice(3, size)).error().message().find("a target of samples"),
            std::string::npos);
  EXPECT_NE(sampled.add_slice(toy_slice(1, size)).error().message().find("a target of densities"), std::string::npos);
  SliceDescription same_key = toy_slice(1, size);
  ASSERT_TRUE(both.add_slice(same_key));
  same_key.kind = SliceKind::samples;
  EXPECT_FALSE(both.add_slice(same_key));
  SliceDescription four = toy_slice(2, size);
  four.key.parameters[3] = 1;
  EXPECT_NE(both.add_slice(four).error().message().find("3 parameters"), std::string::npos);
}

TEST(SampledRows, OfAnotherKindOrOtherPartsAreNotTaken) {
  const MovingLobes target;
  Session first(target);
  first.pass();
  TableSnapshot image = first.service.snapshot();
  image.slices[0].rows[0].learned = CachedDensity{};
  const std::array<RibbonRow::Part, 1> one{{{Ribbon(), 0.5f}}};
  image.slices[0].rows[1].learned = CachedSamples{std::make_shared<const RibbonRow>(one)};
  Session second(target, to_epsilon(), &image);
  EXPECT_EQ(second.service.peek(second.slice, 0, 0).state, RowState::absent);
  EXPECT_EQ(second.service.peek(second.slice, 0, 1).state, RowState::absent);
  EXPECT_EQ(second.service.peek(second.slice, 1, 0).state, RowState::converged);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
