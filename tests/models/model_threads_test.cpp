// A model asked by many threads over several passes, as a renderer does: for ThreadSanitizer, and the same to the bit
// as by one thread. Threads are std::thread and publish() has one, since stock oneTBB makes ThreadSanitizer report
// races of its own.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "references/registry.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress {
namespace {

constexpr int passes = 8, events = 600;

struct Asked {
  std::string table;
  std::vector<float> values;  ///< of every event, in order
  std::uint64_t queries = 0, converged = 0, bytes = 0;
  double bias_bound = 0;
};

/// Two colors of one shape and one of another, lit from a few directions: threads race for the same rows, their forms
/// and their light.
Asked ask(const char* name, unsigned threads, std::size_t memory) {
  const fiber::ModelInfo& info = *references::find_model(name);
  adaptive::Options options;
  options.memory_bytes = memory;
  options.sampled_epsilon = 0.3;
  const fiber::ModelService learned = fiber::make_service(info, options);
  adaptive::Service& service = *learned.service;
  const std::unique_ptr<fiber::FiberModel> model = info.make({.service = &service});
  std::vector<fiber::FiberId> ids;
  for (int i = 0; i < 3; ++i) {
    fiber::FiberParameters parameters;
    parameters.eccentricity = i == 2 ? 1.0f : 0.85f;
    parameters.sigma_a *= i == 1 ? 0.3f : 1.0f;
    ids.push_back(model->add_fiber(parameters));
  }
  Asked asked;
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    std::vector<float> values(events);
    std::vector<std::thread> workers;
    for (unsigned w = 0; w < threads; ++w) {
      workers.emplace_back([&, w] {
        for (std::uint64_t i = w; i < events; i += threads) {
          RandomStream random(9, pass, i);
          const fiber::FiberDirection known{0.2f * static_cast<float>(i % 2), 0.7f};
          const float xi1 = random.next(), xi2 = random.next();
          const fiber::FiberEvent event = model->begin(ids[i % 3], known, xi1, xi2, 0);
          const fiber::FiberSample drawn =
              model->sample(event, {random.next(), random.next(), random.next(), random.next()});
          const fiber::FiberValue light = model->evaluate(event, {random.next() - 0.5f, 6 * random.next() - 3});
          values[i] = drawn.value.total().g / drawn.value.pdf + light.total().g;
        }
      });
    }
    for (std::thread& worker : workers) worker.join();
    const adaptive::PassReport report = service.publish(events);
    EXPECT_LE(report.bytes, memory);
    asked.values.insert(asked.values.end(), values.begin(), values.end());
    asked.queries += report.queries;
    asked.converged += report.converged_queries;
    asked.bytes = report.bytes;
    asked.bias_bound = report.bias_bound;
  }
  asked.table = encode_cache(service.snapshot());
  return asked;
}

TEST(ModelThreads, RaceForRowsAndChangeNoBit) {
  const tbb::global_control width(tbb::global_control::max_allowed_parallelism, 1);
  for (const auto& [name, little] : {std::pair{"elliptical", 400000}, {"pekelis2015", 400000}, {"rough", 100000}}) {
    // Room for all; for the rows but not for all that is made of them.
    for (const std::size_t memory : {std::size_t{64} << 20, static_cast<std::size_t>(little)}) {
      const Asked one = ask(name, 1, memory), four = ask(name, 4, memory);
      EXPECT_GT(one.converged, 0u) << name;
      EXPECT_GT(one.bias_bound, 0) << name;
      EXPECT_EQ(one.table, four.table) << name << ' ' << memory;
      EXPECT_EQ(one.values, four.values) << name << ' ' << memory;
      EXPECT_EQ(one.queries, four.queries) << name << ' ' << memory;
      EXPECT_EQ(one.converged, four.converged) << name << ' ' << memory;
      EXPECT_EQ(one.bias_bound, four.bias_bound) << name << ' ' << memory;
      if (memory > 1000000) {
        EXPECT_EQ(one.bytes, four.bytes) << name;
      }
    }
  }
}

}  // namespace
}  // namespace tress
