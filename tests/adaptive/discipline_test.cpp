// What is reported to a host that breaks the rules of the passes: by name where it asks for it, and never a crash.
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

Options checked() {
  Options options;
  options.check_passes = true;
  options.queries_before_creation = 1;
  return options;
}

void expect_reported(const std::optional<Error>& misuse, const std::string& call, const std::string& found) {
  ASSERT_TRUE(misuse.has_value()) << call;
  EXPECT_EQ(misuse->place, call);
  EXPECT_EQ(misuse->found, found);
}

TEST(Discipline, ASliceOnOtherAxesIsRefusedInAnyBuild) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  const SliceDescription small = testing::toy_slice(0, 4);
  ASSERT_EQ(*service.add_slice(small), 0u);
  EXPECT_EQ(*service.add_slice(small), 0u);
  SliceDescription large = testing::toy_slice(0, 5), blurred = small, empty = testing::toy_slice(1, 4);
  large.key = small.key;
  blurred.blur_rad = 0.3f;
  empty.axis_b.clear();
  for (const SliceDescription& refused : {large, blurred, empty}) {
    const Result<SliceId> added = service.add_slice(refused);
    ASSERT_FALSE(added);
    EXPECT_NE(added.error().message().find("slice of lobe"), std::string::npos) << added.error().message();
  }
  EXPECT_EQ(service.slice_count(), 1u);
  EXPECT_EQ(service.slice(0).axis_a.size(), 4u);
}

TEST(Discipline, ANodeThatIsNotThereIsAnsweredByNothingAndReportedInAnyBuild) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  EXPECT_FALSE(service.publish().misuse.has_value());
  for (const auto& [id, a, b] : std::vector<std::array<std::uint32_t, 3>>{{slice, 4, 0}, {slice, 0, 4}, {7, 0, 0}}) {
    const RowView row = service.look_up(id, a, b);
    EXPECT_EQ(row.state, RowState::absent);
    ASSERT_NE(row.nodes, nullptr);
    EXPECT_EQ(row.nodes->density(0.5f), 0.0f);
    service.observe(row, 0.5f, 1);
    service.score(row, 0.5f, 1, 1);
    service.credit(row, 1);
    const PassReport report = service.publish();
    ASSERT_TRUE(report.misuse.has_value());
    EXPECT_EQ(report.misuse->place, "look_up");
    EXPECT_EQ(report.queries, 0u);
  }
  EXPECT_FALSE(service.publish().misuse.has_value()) << "reported once";
  EXPECT_FALSE(service.add_form(7, nullptr)) << "no such slice";
}

TEST(Discipline, AHostThatKeepsToThePassesGetsNoReport) {
  const testing::MovingPeaks target;
  Service service(checked(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  for (int pass = 0; pass < 4; ++pass) {
    const RowView row = service.look_up(slice, 1, 1);
    service.credit(row, 1);
    if (row.state == RowState::open) service.score(row, 0.5f, row.nodes->density(0.5f), 1);
    EXPECT_FALSE(service.publish(1).misuse.has_value());
    EXPECT_TRUE(service.add_slice(testing::toy_slice(1, 4)));
  }
}

TEST(Discipline, AReaderInsidePublishIsReported) {
  const testing::MovingPeaks target;
  Service service(checked(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  service.set_row_listener([&](const RowReport&) { (void)service.look_up(slice, 0, 0); });
  service.look_up(slice, 1, 1);
  expect_reported(service.publish().misuse, "look_up", "one inside publish()");
}

/// A target that calls its host back.
class Calling final : public Target {
 public:
  void trace(const SliceDescription& slice, float a, float b, std::vector<TracedRay>& out) const override {
    if (call) call();
    peaks_.trace(slice, a, b, out);
  }
  std::string model_name() const override { return "calling-1"; }
  std::function<void()> call;

 private:
  testing::MovingPeaks peaks_;
};

TEST(Discipline, APublishWithAReaderLeftIsReportedAndDoesNothing) {
  Calling target;
  Service service(checked(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  target.call = [&] { EXPECT_EQ(service.publish().queries, 0u); };
  service.look_up(slice, 1, 1);
  target.call = nullptr;
  const PassReport report = service.publish();
  expect_reported(report.misuse, "publish", "one in look_up");
  EXPECT_EQ(report.queries, 1u);
}

TEST(Discipline, AViewOfAnEarlierPassIsReported) {
  const testing::MovingPeaks target;
  Service service(checked(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  service.look_up(slice, 1, 1);
  service.publish();
  const RowView row = service.look_up(slice, 1, 1);
  ASSERT_EQ(row.state, RowState::open);
  service.publish();
  const std::vector<std::function<void()>> calls{
      [&] { service.observe(row, 0.5f, 1); }, [&] { service.score(row, 0.5f, 1, 1); }, [&] { service.credit(row, 1); }};
  const std::vector<std::string> names{"observe", "score", "credit"};
  std::uint32_t pass = 2;
  for (std::size_t i = 0; i < calls.size(); ++i) {
    calls[i]();
    const PassReport report = service.publish(1);
    expect_reported(report.misuse, names[i], "one of pass 1");
    EXPECT_EQ(report.misuse->expected, "a view of pass " + std::to_string(pass++));
    EXPECT_EQ(report.g_evaluations, 0u) << "what comes late is not taken";
  }
}

struct Nothing final : RowForm {
  std::size_t bytes(const RowView&) const override { return 64; }
  void write(const RowView&, void*) const override {}
};

TEST(Discipline, ASliceOrAFormAddedDuringAPassIsRefused) {
  const testing::MovingPeaks target;
  Service service(checked(), target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  service.look_up(slice, 1, 1);
  const Result<SliceId> added = service.add_slice(testing::toy_slice(1, 4));
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().place, "add_slice");
  EXPECT_EQ(added.error().found, "one during a pass");
  EXPECT_FALSE(service.add_form(slice, std::make_shared<Nothing>()));
  service.publish();
  EXPECT_TRUE(service.add_slice(testing::toy_slice(1, 4)));
  EXPECT_TRUE(service.add_form(slice, std::make_shared<Nothing>()));
}

TEST(Discipline, TheLogHasMisuseAndTheCeilingOnceEach) {
  const testing::MovingPeaks target;
  std::vector<std::string> logged;
  Options options;
  options.queries_before_creation = 1;
  options.memory_bytes = 1000;  // an index for the slice fits in its own 16 MB, a row does not
  options.log = [&](const std::string& sentence) { logged.push_back(sentence); };
  Service service(options, target);
  const SliceId slice = *service.add_slice(testing::toy_slice(0, 4));
  EXPECT_TRUE(logged.empty());
  for (int pass = 0; pass < 3; ++pass) {
    service.look_up(slice, 1, 1);
    EXPECT_TRUE(service.publish().at_ceiling);
  }
  ASSERT_EQ(logged.size(), 1u);
  EXPECT_NE(logged[0].find("ceiling of 1000 bytes"), std::string::npos) << logged[0];
  service.look_up(slice, 9, 9);
  service.publish();
  ASSERT_EQ(logged.size(), 2u);
  EXPECT_NE(logged[1].find("a node below 16"), std::string::npos) << logged[1];
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
