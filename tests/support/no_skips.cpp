// Linked into every test program: a test that skips fails, since a run of skipped tests ends with "100 % passed".
#include <gtest/gtest.h>

namespace {

class SkipsFail : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& info) override {
    if (info.result()->Skipped()) ADD_FAILURE() << "skipped: a test brings what it needs";
  }
};

class NoSkips : public testing::Environment {
  void SetUp() override { testing::UnitTest::GetInstance()->listeners().Append(new SkipsFail); }
};

[[maybe_unused]] const testing::Environment* const no_skips = testing::AddGlobalTestEnvironment(new NoSkips);

}  // namespace
