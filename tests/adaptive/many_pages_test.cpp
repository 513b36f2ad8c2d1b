// More pages than there is memory for.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::adaptive {
namespace {

constexpr std::uint32_t size = 450;  // nodes of an axis: 5.7 MB a page, of the 16 MB that pages always have

Options small() {
  Options options;
  options.memory_bytes = 1 << 20;
  options.birth_touches = 1;
  return options;
}

std::vector<PageId> add(Service& service, std::uint32_t pages) {
  std::vector<PageId> ids;
  for (std::uint32_t lobe = 0; lobe < pages; ++lobe) ids.push_back(service.add_page(testing::toy_page(lobe, size)));
  return ids;
}

TEST(ManyPages, AreAnsweredByGWhereTheirIndexHasNoRoomAndThatIsTold) {
  const testing::MovingPeaks target;
  Service service(small(), target);
  const std::vector<PageId> ids = add(service, 3);
  EXPECT_FALSE((service.look_up(ids[0], 1, 2), service.look_up(ids[1], 1, 2), service.publish()).at_ceiling);
  std::vector<TracedRay> rays;
  const PageDescription& page = service.page(ids[2]);
  target.trace(page, page.axis_a[1], page.axis_b[2], rays);
  const TracedNodes nodes(rays, page.blur_rad);
  for (int pass = 0; pass < 3; ++pass) {
    const RowView view = service.look_up(ids[2], 1, 2);
    EXPECT_EQ(view.state, RowState::unborn);
    ASSERT_NE(view.nodes, nullptr);
    EXPECT_EQ(view.nodes->density(0.3f), nodes.density(0.3f));
    service.score(view, 0.3f, 1, 1);  // of no effect
    service.carry(ids[2], size + 2, 1);
    const PassReport report = service.publish(1);
    EXPECT_TRUE(report.at_ceiling);
    EXPECT_EQ(report.queries, 1u);
    EXPECT_EQ(report.rows_touched, 2u);
    EXPECT_EQ(service.peek(ids[2], 1, 2).state, RowState::unborn);
  }
}

TEST(ManyPages, KeepTheRowsThatACacheBroughtThem) {
  const testing::MovingPeaks target;
  Options options = small();
  options.memory_bytes = std::size_t{64} << 20;  // room for three
  Service rich(options, target);
  const std::vector<PageId> ids = add(rich, 3);
  for (const PageId id : ids) rich.look_up(id, 1, 2);
  rich.publish();
  const TableImage image = rich.snapshot();
  ASSERT_EQ(image.pages.size(), 3u);
  for (const bool before : {false, true}) {
    Service poor(small(), target);
    if (before) {
      ASSERT_FALSE(poor.load(image));
    }
    add(poor, 3);
    if (!before) {
      ASSERT_FALSE(poor.load(image));
    }
    const TableImage kept = poor.snapshot();
    ASSERT_EQ(kept.pages.size(), 3u);
    for (const CachedPage& page : kept.pages) EXPECT_EQ(page.rows.size(), 1u);
    poor.look_up(2, 1, 2);
    EXPECT_TRUE(poor.publish().at_ceiling);
  }
}

}  // namespace
}  // namespace tress::adaptive
