// The table as an image: a cache that is loaded, used, reopened and saved loses nothing.
#include <gtest/gtest.h>

#include <string>

#include "adaptive/drive_service.h"
#include "adaptive/toy_target.h"
#include "observations/fixed_moments.h"
#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

using testing::MovingPeaks;
using testing::toy_slice;

constexpr std::uint32_t slices = 2;

// A table with converged and open rows.
TableSnapshot learned_image(double epsilon = 0.01) {
  const MovingPeaks target;
  Options options;
  options.epsilon = epsilon;
  Service service(options, target);
  for (std::uint32_t p = 0; p < slices; ++p) service.add_slice(toy_slice(p, 6));
  for (std::uint64_t pass = 0; pass < 4; ++pass) {
    testing::run_pass(service, slices, pass, 2500, 1);
    service.publish();
  }
  return service.snapshot();
}

std::size_t count(const TableSnapshot& image, RowState state) {
  std::size_t n = 0;
  for (const CachedSlice& slice : image.slices) {
    for (const CachedRow& row : slice.rows) n += row.state == state ? 1 : 0;
  }
  return n;
}

/// Nodes that have a row.
std::size_t rows_of(const Service& service) {
  std::size_t rows = 0;
  for (SliceId p = 0; p < service.slice_count(); ++p) {
    for (std::uint32_t n = 0; n < 36; ++n) rows += service.peek(p, n / 6, n % 6).state != RowState::absent ? 1 : 0;
  }
  return rows;
}

TEST(Table, LoadedAndSavedIsTheSameImageWhetherSlicesComeBeforeOrAfter) {
  const TableSnapshot image = learned_image();
  ASSERT_GT(count(image, RowState::open), 0u);
  ASSERT_GT(count(image, RowState::converged), 0u);
  const std::string bytes = encode_cache(image);
  const MovingPeaks target;
  for (const bool before : {true, false}) {
    Service service(Options{}, target);
    if (!before) {
      EXPECT_FALSE(service.load(image));
    }
    for (std::uint32_t p = slices; p > 0; --p) service.add_slice(toy_slice(p - 1, 6));
    if (before) {
      EXPECT_FALSE(service.load(image));
    }
    EXPECT_EQ(rows_of(service), count(image, RowState::open) + count(image, RowState::converged));
    EXPECT_EQ(encode_cache(service.snapshot()), bytes);
    const PassReport report = service.publish();
    EXPECT_EQ(report.rows_converged, count(image, RowState::converged));
    EXPECT_EQ(report.rows_open, count(image, RowState::open));
    EXPECT_EQ(report.creations, 0u);
    EXPECT_EQ(encode_cache(service.snapshot()), bytes);
  }
}

TEST(Table, SlicesThatNobodyUsesAreSavedBack) {
  const TableSnapshot image = learned_image();
  const MovingPeaks target;
  Service service(Options{}, target);
  service.add_slice(toy_slice(1, 6));
  EXPECT_FALSE(service.load(image));
  EXPECT_EQ(service.slice_count(), 1u);
  EXPECT_EQ(encode_cache(service.snapshot()), encode_cache(image));
}

TEST(Table, ASmallerEpsilonReopensRowsWithTheirFitAndKeepsWhatTheCacheHad) {
  const TableSnapshot image = learned_image();
  const MovingPeaks target;
  Options options;
  options.epsilon = 1e-5;
  Service service(options, target);
  EXPECT_FALSE(service.load(image));
  for (std::uint32_t p = 0; p < slices; ++p) service.add_slice(toy_slice(p, 6));
  std::size_t reopened = 0;
  for (std::uint32_t p = 0; p < slices; ++p) {
    for (const CachedRow& cached : image.slices[p].rows) {
      if (cached.state != RowState::converged) continue;
      const RowView row = service.look_up(p, cached.node / 6, cached.node % 6);
      EXPECT_EQ(row.state, cached.objective <= 1e-5 ? RowState::converged : RowState::open);
      ASSERT_NE(row.fit, nullptr);
      EXPECT_EQ(row.fit->density(0.5f), cached.density()->fit.density(0.5f));
      reopened += row.state == RowState::open ? 1 : 0;
      if (row.state == RowState::open) {
        EXPECT_NE(row.nodes, nullptr);
      }
    }
  }
  EXPECT_GT(reopened, 0u);
  EXPECT_EQ(encode_cache(service.snapshot()), encode_cache(image));
}

TEST(Table, AReopenedRowConvergesToTheSmallerEpsilonAndIsThenSavedWithIt) {
  const TableSnapshot image = learned_image();
  const MovingPeaks target;
  Options options;
  options.epsilon = 0.001;
  Service service(options, target);
  EXPECT_FALSE(service.load(image));
  for (std::uint32_t p = 0; p < slices; ++p) service.add_slice(toy_slice(p, 6));
  PassReport report;
  for (std::uint64_t pass = 10; pass < 30; ++pass) {
    testing::run_pass(service, slices, pass, 2500, 1);
    report = service.publish();
  }
  EXPECT_GT(report.rows_converged, 60u);  // of 72
  std::size_t fine = 0;
  for (const CachedSlice& slice : service.snapshot().slices) {
    for (const CachedRow& row : slice.rows) {
      fine += row.state == RowState::converged && row.objective <= 0.001f ? 1 : 0;
    }
  }
  EXPECT_EQ(fine, report.rows_converged);
}

TEST(Table, ACacheLargerThanMemoryIsKeptWhole) {
  const TableSnapshot image = learned_image();
  const MovingPeaks target;
  Options options;
  options.memory_bytes = 4000;
  Service service(options, target);
  for (std::uint32_t p = 0; p < slices; ++p) service.add_slice(toy_slice(p, 6));
  EXPECT_FALSE(service.load(image));
  EXPECT_LT(rows_of(service), count(image, RowState::converged));
  EXPECT_GT(rows_of(service), 0u);
  const PassReport report = service.publish();
  EXPECT_LE(report.bytes, options.memory_bytes);
  EXPECT_EQ(report.rows_open, 0u) << "converged rows come first";
  EXPECT_EQ(encode_cache(service.snapshot()), encode_cache(image));
}

TEST(Table, AnotherModelOrOtherAxesAreRefusedAndNothingIsTaken) {
  TableSnapshot image = learned_image();
  const MovingPeaks target;
  Service service(Options{}, target);
  service.add_slice(toy_slice(0, 5));
  const auto axes = service.load(image);
  ASSERT_TRUE(axes);
  EXPECT_NE(axes->message().find("6 x 6"), std::string::npos) << axes->message();
  image.model = "another";
  const auto model = service.load(image);
  ASSERT_TRUE(model);
  EXPECT_NE(model->message().find("another"), std::string::npos);
  EXPECT_TRUE(service.snapshot().slices.empty());
}

TEST(Table, ASliceAddedAfterTheCacheOnOtherAxesIsRefusedByNameAndStartsCold) {
  const MovingPeaks target;
  Service service(Options{}, target);
  EXPECT_FALSE(service.load(learned_image()));
  service.add_slice(toy_slice(1, 6));
  EXPECT_TRUE(service.refusals().empty());
  const SliceId slice = *service.add_slice(toy_slice(0, 5));
  ASSERT_EQ(service.refusals().size(), 1u);
  EXPECT_NE(service.refusals()[0].message().find("6 x 6"), std::string::npos) << service.refusals()[0].message();
  EXPECT_EQ(service.slice(slice).axis_a.size(), 5u);
  EXPECT_EQ(service.peek(slice, 0, 0).state, RowState::absent);
  const TableSnapshot saved = service.snapshot();
  ASSERT_EQ(saved.slices.size(), 1u) << "no page on axes that the session does not have";
  EXPECT_EQ(saved.slices[0].description.key.lobe, 1u);
}

TEST(FixedMoments, AgreeWithDoublesAndNotWithTheOrder) {
  FixedMoments<2> up, down;
  double sum = 0, squares = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = 1e-6 * i * i, y = 1e-6 * (999 - i) * (999 - i);
    up.add(x);
    down.add(y);
    sum += x;
    squares += x * x;
  }
  const Moments a = up.moments(), b = down.moments();
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.mean_square, b.mean_square);
  EXPECT_NEAR(a.mean, sum / 1000, 4e-12);  // the unit: 2^-38
  EXPECT_NEAR(a.mean_square, squares / 1000, 1e-11);
  FixedMoments<2> extreme;
  extreme.add(100);
  extreme.add(-1);
  EXPECT_EQ(extreme.moments().mean, 2);
  EXPECT_EQ(extreme.moments().mean_square, 8);
  EXPECT_EQ(extreme.moments().variance(), 8);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
