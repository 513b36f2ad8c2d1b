// What the table makes of its rows for a host: once, on first touch, counted, and dropped when the row changes.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint32_t size = 4;

/// The density at four azimuths. Node 3 has an answer of its own.
class FourValues final : public RowForm {
 public:
  std::size_t bytes(const RowView&) const override { return sizeof(values); }
  void write(const RowView& row, void* memory) const override {
    ++made;
    float values[4];
    for (int i = 0; i < 4; ++i) values[i] = row.density(static_cast<float>(i));
    std::memcpy(memory, values, sizeof(values));
  }
  const void* instead_of_row(std::uint32_t node) const override { return node == 3 ? &values : nullptr; }
  mutable std::atomic<int> made{0};
  alignas(16) float values[4]{1, 2, 3, 4};
};

float first_of(const RowAnswer& answer) { return *static_cast<const float*>(answer.block()); }

void learn(Service& service, std::uint64_t passes) {
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    testing::run_pass(service, 1, pass, 3000, 1);
    service.publish();
  }
}

TEST(RowForm, IsMadeOnceOfAConvergedRowAndNeverOfAnother) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
  const auto form = std::make_shared<FourValues>();
  const FormedRows& rows = **service.add_form(slice, form);
  EXPECT_FALSE(service.fetch(rows, 0).answer);
  const FormedLookup absent = service.look_up(rows, 0);
  EXPECT_FALSE(absent.answer);
  ASSERT_NE(absent.row.nodes, nullptr);
  EXPECT_EQ(service.publish().queries, 1u) << "a fetch without an answer is no query";
  learn(service, 12);
  ASSERT_EQ(service.peek(slice, 0, 0).state, RowState::converged);
  const std::uint64_t before = service.publish().bytes;

  const FormedLookup found = service.fetch(rows, 0);
  ASSERT_TRUE(found.answer);
  EXPECT_EQ(found.row.state, RowState::converged);
  EXPECT_EQ(first_of(found.answer), service.peek(slice, 0, 0).density(0));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(service.look_up(rows, 0).answer.block(), found.answer.block());
  {
    AnswerReader reader(&service);
    for (int i = 0; i < 7; ++i) EXPECT_EQ(reader.read(rows.run(0), 0).block(), found.answer.block());
    EXPECT_FALSE(reader.read(rows.run(0), 1)) << "nobody has asked for it";
  }
  EXPECT_EQ(form->made, 1);
  const PassReport report = service.publish();
  EXPECT_EQ(report.queries, 13u);
  EXPECT_EQ(report.converged_queries, 13u);
  EXPECT_EQ(report.bytes, before + 64);
}

TEST(RowForm, ANodeMayHaveAnAnswerInPlaceOfARow) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
  const auto form = std::make_shared<FourValues>();
  const FormedRows& rows = **service.add_form(slice, form);
  const RowAnswer answer = service.look_up(rows, 3).answer;
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer.has_row());
  EXPECT_EQ(answer.block(), &form->values);
  AnswerReader reader(&service);
  EXPECT_EQ(reader.read(rows.run(0), 3).block(), &form->values);
  EXPECT_EQ(service.publish().queries, 0u);
  EXPECT_EQ(service.peek(slice, 0, 3).state, RowState::absent);
}

TEST(RowForm, IsTheSameWhicheverThreadIsFirst) {
  const testing::MovingPeaks target;
  for (const unsigned threads : {1u, 8u}) {
    Service service(Options{}, target);
    const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
    const FormedRows& rows = **service.add_form(slice, std::make_shared<FourValues>());
    learn(service, 12);
    const std::uint64_t before = service.publish().bytes;
    std::vector<std::thread> workers;
    for (unsigned w = 0; w < threads; ++w) {
      workers.emplace_back([&] {
        for (std::uint32_t n = 0; n < size * size; ++n) {
          const FormedLookup found = service.look_up(rows, n);
          if (found.answer && found.answer.has_row()) {
            EXPECT_EQ(first_of(found.answer), service.peek(slice, n / size, n % size).density(0));
          }
        }
      });
    }
    for (std::thread& worker : workers) worker.join();
    std::uint64_t converged = 0;
    for (std::uint32_t n = 0; n < size * size; ++n) {
      if (n != 3 && service.peek(slice, n / size, n % size).state == RowState::converged) ++converged;
    }
    const PassReport report = service.publish();
    EXPECT_EQ(report.queries, threads * (size * size - 1));
    EXPECT_EQ(report.bytes, before + 64 * converged) << threads << " threads";
  }
}

TEST(RowForm, IsAnsweredButNotKeptPastTheCeiling) {
  const testing::MovingPeaks target;
  Options options;
  Service rich(options, target);
  rich.add_slice(testing::toy_slice(0, size));
  learn(rich, 12);
  const TableSnapshot image = rich.snapshot();
  options.memory_bytes = rich.publish().bytes + 8 * size * size + 2 * 64;  // entries and two blocks
  Service service(options, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
  ASSERT_FALSE(service.load(image));
  const auto form = std::make_shared<FourValues>();
  const FormedRows& rows = **service.add_form(slice, form);
  for (int round = 0; round < 2; ++round) {
    for (std::uint32_t n = 4; n < 8; ++n) {
      const FormedLookup found = service.look_up(rows, n);
      ASSERT_TRUE(found.answer) << n;
      EXPECT_EQ(first_of(found.answer), service.peek(slice, 1, n - 4).density(0));
      EXPECT_EQ(found.kept != nullptr, n >= 6) << n;
    }
  }
  EXPECT_EQ(form->made, 2 + 2 * 2);
  const PassReport report = service.publish();
  EXPECT_LE(report.bytes, options.memory_bytes);
  EXPECT_EQ(report.queries, 8u);
  EXPECT_EQ(report.converged_queries, 8u);
}

/// MovingPeaks under the same name, turned.
class Turned final : public Target {
 public:
  void trace(const SliceDescription& slice, float a, float b, std::vector<TracedRay>& out) const override {
    peaks_.trace(slice, a, b, out);
    for (TracedRay& ray : out) ray.azimuth += 1;
  }
  std::string model_name() const override { return peaks_.model_name(); }

 private:
  testing::MovingPeaks peaks_;
};

TEST(RowForm, IsDroppedOfAllRowsOfASliceWhenOneCeasesToBeConverged) {
  const testing::MovingPeaks old;
  Service first(Options{}, old);
  first.add_slice(testing::toy_slice(0, size));
  learn(first, 12);
  const Turned target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, size));
  const auto form = std::make_shared<FourValues>();
  const FormedRows& rows = **service.add_form(slice, form);
  ASSERT_FALSE(service.load(first.snapshot()));
  for (std::uint32_t n = 4; n < 8; ++n) ASSERT_TRUE(service.fetch(rows, n).answer);
  EXPECT_EQ(form->made, 4);
  EXPECT_GT(service.publish().rows_reopened, 0u);  // the first that was asked was checked, and the cache is wrong
  AnswerReader reader(&service);
  for (std::uint32_t b = 0; b < 4; ++b)
    EXPECT_FALSE(reader.read(rows.run(1), b)) << "asked anew, so that it is checked";
  for (std::uint32_t n = 4; n < 8; ++n) service.look_up(rows, n);
  EXPECT_EQ(service.publish().rows_reopened, 4u);
  for (std::uint32_t n = 4; n < 8; ++n) EXPECT_FALSE(service.fetch(rows, n).answer);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
