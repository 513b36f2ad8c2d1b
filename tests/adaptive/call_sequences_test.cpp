// Random sequences of a host's calls, in passes by several threads and between them: the table is the same to the bit
// for any number of threads, within its memory, and a session that goes on from its state goes on as it would. Under
// TSan (test_races) it is a search for races.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/query.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// The mass of a row, in blocks of one size.
struct MassForm final : RowForm {
  std::size_t bytes(const RowView&) const override { return 128; }
  void write(const RowView& row, void* memory) const override {
    const float value = row.ribbons != nullptr ? row.ribbons->total_mass() : row.density(0.5f);
    std::memcpy(memory, &value, sizeof value);
  }
};

constexpr std::uint32_t density_side = 5, sampled_side = 9;

/// Threads of the test's own: TSan takes those of oneTBB for races.
void on_four_threads(std::size_t count, const std::function<void(std::size_t)>& task) {
  std::vector<std::thread> workers;
  for (std::size_t w = 0; w < 4; ++w) {
    workers.emplace_back([=, &task] {
      for (std::size_t i = w; i < count; i += 4) task(i);
    });
  }
  for (std::thread& worker : workers) worker.join();
}

struct Host {
  explicit Host(std::size_t memory)
      : service(Options{.memory_bytes = memory, .parallel_for = on_four_threads}, peaks, lobes) {
    for (std::uint32_t p = 0; p < 2; ++p) slices.push_back(*service.add_slice(testing::toy_slice(p, density_side)));
    SliceDescription graded = testing::sampled_slice(9, sampled_side);
    graded.coarse = {{{0, 8}, {0, 4, 8}}};
    slices.push_back(*service.add_slice(graded));
    add_forms();
  }
  void add_forms() {
    for (const SliceId slice : slices) forms.push_back(*service.add_form(slice, std::make_shared<MassForm>(), {1.0f}));
  }

  /// Call `index` of a pass, by its own numbers alone.
  void call(std::uint64_t seed, std::uint64_t pass, std::uint64_t index) {
    RandomStream random(seed, pass, index);
    const auto below = [&random](std::size_t count) {
      return static_cast<std::uint32_t>(random.next() * static_cast<float>(count));
    };
    const SliceId slice = slices[below(slices.size())];
    const std::uint32_t side = slice == slices.back() ? sampled_side : density_side;
    const std::uint32_t a = below(side), b = below(side);
    const float u = random.next(), v = random.next();
    switch (below(6)) {
      case 0:
        sample(service, {slice, a, b}, {u, v, random.next()});
        break;
      case 1:
        evaluate(service, {slice, a, b}, 6 * u - 3, v);
        break;
      case 2:
        service.credit(service.look_up(slice, a, b), u, 1 + below(200));
        break;
      case 3: {
        const RowView row = service.look_up(slice, a, b);
        if (row.nodes != nullptr) service.observe(row, 6 * u - 3, row.nodes->density(6 * u - 3));
        if (slice == slices.back()) service.hear(row, {6 * u - 3, v, below(2), 0.5f, 0.1f});
        break;
      }
      default: {
        const FormedRows& rows = *forms[below(forms.size())];
        const std::uint32_t width = rows.width(), node = below(width * width);
        RowAnswer answer = AnswerReader(&service).read(rows.run(node / width), node % width);
        FormedLookup found;  // it owns an answer that memory has no room for
        if (!answer) {
          found = service.look_up(rows, node);
          answer = found.answer;
        }
        RowView row;
        row.slice = rows.slice();
        row.node = node;
        service.credit(row, u);
        if (answer) touched.fetch_add(static_cast<const std::uint32_t*>(answer.block())[0], std::memory_order_relaxed);
      }
    }
  }

  /// A pass of `calls` calls, then some of those between passes.
  PassReport pass(std::uint64_t seed, std::uint64_t number, std::uint64_t calls, unsigned threads) {
    std::vector<std::thread> workers;
    for (unsigned w = 0; w < threads; ++w) {
      workers.emplace_back([=, this] {
        for (std::uint64_t i = w; i < calls; i += threads) call(seed, number, i);
      });
    }
    for (std::thread& worker : workers) worker.join();
    pays = pays * 2 + (service.publish_pays() ? 1 : 0);
    const PassReport report = service.publish(calls);
    RandomStream random(seed, number, calls);
    if (random.next() < 0.3f) service.prepare();
    if (random.next() < 0.1f) service.set_learning(random.next() < 0.7f);
    return report;
  }

  testing::MovingPeaks peaks;
  testing::MovingLobes lobes;
  Service service;
  std::vector<SliceId> slices;
  std::vector<const FormedRows*> forms;
  std::atomic<std::uint64_t> touched{0};  ///< the sum of what forms answered
  std::uint64_t pays = 1;
};

struct Ended {
  std::string table;  ///< not the state: which answers memory keeps at its limit depends on who came first
  std::uint64_t touched, pays;
  bool operator==(const Ended&) const = default;
};

Ended run(std::uint64_t seed, std::size_t memory, unsigned threads) {
  Host host(memory);
  for (std::uint64_t pass = 0; pass < 6; ++pass) {
    const PassReport report = host.pass(seed, pass, 100 + 150 * pass, threads);
    EXPECT_LE(report.bytes, memory);
    EXPECT_FALSE(report.misuse) << report.misuse->message();
  }
  return {encode_cache(host.service.snapshot()), host.touched, host.pays};
}

TEST(CallSequences, GiveTheSameTableForAnyNumberOfThreads) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const std::size_t memory = std::size_t{4000} << (seed % 6);
    const Ended one = run(seed, memory, 1), four = run(seed, memory, 4);
    EXPECT_TRUE(one.table == four.table) << "seed " << seed << ", " << memory << " bytes";
    EXPECT_EQ(one.touched, four.touched) << "seed " << seed;
    EXPECT_EQ(one.pays, four.pays) << "seed " << seed;
  }
}

TEST(CallSequences, GoOnFromAState) {
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    const std::size_t memory = std::size_t{4000} << (seed % 6);
    Host first(memory), second(memory), threaded(memory);
    for (std::uint64_t pass = 0; pass < 3; ++pass) first.pass(seed, pass, 400, 1);
    first.service.set_learning(true);
    for (Host* host : {&second, &threaded}) ASSERT_FALSE(host->service.restore(*first.service.state())) << seed;
    for (std::uint64_t pass = 3; pass < 5; ++pass) {
      first.pass(seed, pass, 400, 1);
      second.pass(seed, pass, 400, 1);
      EXPECT_TRUE(*first.service.state() == *second.service.state()) << "seed " << seed << ", pass " << pass;
      // The state also has which answers are kept at the limit of memory, which depends on who came first.
      threaded.pass(seed, pass, 400, 2);
      EXPECT_TRUE(encode_cache(first.service.snapshot()) == encode_cache(threaded.service.snapshot()))
          << "seed " << seed << ", pass " << pass;
    }
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
