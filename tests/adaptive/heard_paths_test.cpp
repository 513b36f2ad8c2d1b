// What a service of samples hears of its host's own paths: kept alike by any threads, saved, tested with, taught by.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "adaptive/toy_samples.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

using testing::MovingLobes;
using testing::sampled_slice;

constexpr std::uint32_t size = 2, nodes = size * size;

/// The exit of one path that ends where chance has it, as a host draws it: an exit with the probability of its weight,
/// or, of weight 0, none.
SampledExit one_path(const MovingLobes& target, const SliceDescription& slice, std::uint32_t node,
                     std::uint32_t index) {
  std::vector<SampledExit> exits;
  target.draw(slice, slice.axis_a[node / size], slice.axis_b[node % size], 7777, index, 1, exits);
  float u = RandomStream(99, index, node).next();
  for (const SampledExit& exit : exits) {
    if (u < exit.weight) return {exit.azimuth, exit.height, exit.part, 1, exit.attribute};
    u -= exit.weight;
  }
  return {0, 0, 0, 0, 0};
}

struct Session {
  explicit Session(const Options& options, float turn = 0) : service(options, taught), heard(turn) {
    slice = *service.add_slice(sampled_slice(3, size));
  }
  /// Asks each node once and passes it so many paths of `heard`, from so many threads.
  PassReport pass(std::uint32_t paths, unsigned threads = 1) {
    std::vector<std::thread> readers;
    for (unsigned t = 0; t < threads; ++t) {
      readers.emplace_back([&, t] {
        for (std::uint32_t i = t; i < paths; i += threads) {
          for (std::uint32_t n = 0; n < nodes; ++n) {
            const RowView view = service.look_up(slice, n / size, n % size);
            service.hear(view, one_path(heard, service.slice(slice), n, passed + i));
          }
        }
      });
    }
    for (std::thread& reader : readers) reader.join();
    passed += paths;
    return service.publish();
  }
  MovingLobes taught;
  Service service;
  MovingLobes heard;
  SliceId slice = 0;
  std::uint32_t passed = 0;
};

TEST(HeardPaths, AreKeptAlikeByAnyThreads) {
  Session one({}), three({});
  for (const std::uint32_t paths : {100u, 700u, 700u}) {
    const PassReport a = one.pass(paths, 1), b = three.pass(paths, 3);
    EXPECT_EQ(a.newly_heard, nodes * paths);
    EXPECT_EQ(b.heard_paths, a.heard_paths);
    EXPECT_EQ(a.bytes, b.bytes);
  }
  EXPECT_EQ(*one.service.state(), *three.service.state());
  EXPECT_EQ(one.service.test_by_heard().paths, nodes * 1024u) << "the first ones of 1,500 a node";
}

TEST(HeardPaths, LeaveOutWhatIsNoExitOrHasNoRoom) {
  Session session({});
  const RowView view = session.service.look_up(session.slice, 0, 0);
  for (const SampledExit& bad :
       {SampledExit{NAN, 0, 0, 1, 0}, SampledExit{0, INFINITY, 0, 1, 0}, SampledExit{0, 0, 4, 1, 0},
        SampledExit{0, 0, 0, -1, 0}, SampledExit{0, 0, 0, 1, NAN}, SampledExit{0, 0, 0, 1, -1}})
    session.service.hear(view, bad);
  RowView nowhere = view;
  nowhere.node = nodes;
  session.service.hear(nowhere, {0, 0, 0, 1, 0});
  nowhere.slice = 9;
  session.service.hear(nowhere, {0, 0, 0, 1, 0});
  EXPECT_EQ(session.service.publish().heard_paths, 0u);

  Options small;
  small.memory_bytes = 4000;
  Session full(small);
  EXPECT_LE(full.pass(500).bytes, small.memory_bytes);
}

TEST(HeardPaths, AreInTheState) {
  Session before({}), after({});
  before.pass(300);
  ASSERT_FALSE(after.service.restore(*before.service.state()));
  after.passed = before.passed;
  EXPECT_EQ(*after.service.state(), *before.service.state());
  before.pass(300);
  after.pass(300);
  EXPECT_EQ(*after.service.state(), *before.service.state());
}

// Rows of the target itself pass: chi^2 within 4 standard deviations of what their last test allows (false alarms 3e-5
// for each of two). Rows of a target that is turned by 0.1 radians do not, and what they have in common shows.
TEST(HeardPaths, TestTheRows) {
  Options options;
  options.learns_to_epsilon = true;
  options.queries_before_creation = 1;
  Session right(options), turned(options, 0.1f);
  for (Session* one : {&right, &turned}) {
    one->pass(1);
    one->pass(1023);
  }
  const HeardTest of_right = right.service.test_by_heard(), of_turned = turned.service.test_by_heard();
  EXPECT_EQ(of_right.paths, nodes * 1024u);
  EXPECT_LT(of_right.chi2 - 4 * of_right.deviation, options.sampled_epsilon);
  EXPECT_LT(of_right.common_chi2 - 4 * of_right.common_deviation, options.sampled_epsilon);
  EXPECT_GT(of_turned.common_chi2,
            of_right.common_chi2 + 4 * std::hypot(of_right.common_deviation, of_turned.common_deviation));
  EXPECT_LT(of_right.common_deviation, of_right.deviation);
}

// Without paths of its own the service learns by those of its host alone, pass by pass.
TEST(HeardPaths, TeachWhereTheServiceDrawsNone) {
  Options options;
  options.own_paths = false;
  Session session(options);
  EXPECT_EQ(session.pass(63).ribbons, 0u);
  std::vector<double> errors;
  for (const std::uint32_t paths : {1u, 192u, 768u}) {
    EXPECT_EQ(session.pass(paths).ribbons, nodes);
    const RowView row = session.service.peek(session.slice, 0, 1);
    ASSERT_NE(row.ribbons, nullptr);
    EXPECT_EQ(row.paths, session.passed);
    // Against a row by 16,384 paths of the target, on a grid.
    Options many;
    many.learns_to_epsilon = true;
    many.sampled_epsilon = 0.001;
    many.queries_before_creation = 1;
    Session truth(many);
    truth.pass(1);
    const RowView known = truth.service.peek(truth.slice, 0, 1);
    double error = 0;
    for (int i = 0; i < 64; ++i) {
      for (int j = 0; j < 64; ++j) {
        const float x = 3.1f * (static_cast<float>(i) / 32 - 1), t = 2 * (static_cast<float>(j) / 32 - 1);
        for (std::uint32_t p = 0; p < 2; ++p) {
          const double off = double{row.ribbons->mass(p)} * double{row.ribbons->ribbon(p).density(x, t)} -
                             double{known.ribbons->mass(p)} * double{known.ribbons->ribbon(p).density(x, t)};
          error += off * off;
        }
      }
    }
    errors.push_back(std::sqrt(error));
  }
  // 4 and 16 times the paths: errors fall by 2 and 4 in the mean, by 1.3 and 2 in a run that chance is not kind to.
  EXPECT_LT(errors[1], errors[0] / 1.3);
  EXPECT_LT(errors[2], errors[0] / 2);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
