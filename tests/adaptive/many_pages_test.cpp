// More slices than there is memory for.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

constexpr std::uint32_t size = 450;  // nodes of an axis: 5.7 MB a slice, of the 16 MB that slices always have

Options small() {
  Options options;
  options.memory_bytes = 1 << 20;
  options.queries_before_creation = 1;
  return options;
}

std::vector<SliceId> add(Service& service, std::uint32_t slices) {
  std::vector<SliceId> ids;
  for (std::uint32_t lobe = 0; lobe < slices; ++lobe) ids.push_back(*service.add_slice(testing::toy_slice(lobe, size)));
  return ids;
}

TEST(ManySlices, AreAnsweredByGWhereTheirIndexHasNoRoomAndThatIsLogged) {
  const testing::MovingPeaks target;
  Service service(small(), target);
  const std::vector<SliceId> ids = add(service, 3);
  EXPECT_FALSE((service.look_up(ids[0], 1, 2), service.look_up(ids[1], 1, 2), service.publish()).at_ceiling);
  std::vector<TracedRay> rays;
  const SliceDescription& slice = service.slice(ids[2]);
  target.trace(slice, slice.axis_a[1], slice.axis_b[2], rays);
  const TracedNodes nodes(rays, slice.blur_rad);
  for (int pass = 0; pass < 3; ++pass) {
    const RowView view = service.look_up(ids[2], 1, 2);
    EXPECT_EQ(view.state, RowState::absent);
    ASSERT_NE(view.nodes, nullptr);
    EXPECT_EQ(view.nodes->density(0.3f), nodes.density(0.3f));
    service.score(view, 0.3f, 1, 1);  // of no effect
    service.credit(view, 1);
    const PassReport report = service.publish(1);
    EXPECT_TRUE(report.at_ceiling);
    EXPECT_EQ(report.queries, 1u);
    EXPECT_EQ(report.rows_queried, 2u);
    EXPECT_EQ(service.peek(ids[2], 1, 2).state, RowState::absent);
  }
}

TEST(ManySlices, KeepTheRowsThatACacheBroughtThem) {
  const testing::MovingPeaks target;
  Options options = small();
  options.memory_bytes = std::size_t{64} << 20;  // room for three
  Service rich(options, target);
  const std::vector<SliceId> ids = add(rich, 3);
  for (const SliceId id : ids) rich.look_up(id, 1, 2);
  rich.publish();
  const TableSnapshot image = rich.snapshot();
  ASSERT_EQ(image.slices.size(), 3u);
  for (const bool before : {false, true}) {
    Service poor(small(), target);
    if (before) {
      ASSERT_FALSE(poor.load(image));
    }
    add(poor, 3);
    if (!before) {
      ASSERT_FALSE(poor.load(image));
    }
    const TableSnapshot kept = poor.snapshot();
    ASSERT_EQ(kept.slices.size(), 3u);
    for (const CachedSlice& slice : kept.slices) EXPECT_EQ(slice.rows.size(), 1u);
    poor.look_up(2, 1, 2);
    EXPECT_TRUE(poor.publish().at_ceiling);
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
