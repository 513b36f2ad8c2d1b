// Properties that run the same cases every time: include this instead of <rapidcheck/gtest.h>.
//
// RC_PARAMS of the environment is RapidCheck's own: "seed=7 max_success=10000" runs other and more cases, and a failure
// prints what reproduces it. Without a seed there, a fixed one is used; RapidCheck prints which at the start.
#pragma once

#include <gtest/gtest.h>
// RapidCheck's header needs GoogleTest's before it.
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <utility>

namespace tress::testing {

/// Done before main(), where RapidCheck has not read its parameters yet.
inline const bool seed_is_fixed = [] {
  const char* given = std::getenv("RC_PARAMS");
  const std::string parameters = given != nullptr ? given : "";
  if (parameters.find("seed=") != std::string::npos || parameters.find("reproduce=") != std::string::npos) return false;
  setenv("RC_PARAMS", (parameters + " seed=20150101").c_str(), 1);
  return true;
}();

/// Checks a property with `percent` of the cases of RC_PARAMS (100 where it says nothing): for dear ones.
template <class Property>
void check_share(int percent, Property&& property) {
  rc::detail::TestParams parameters = rc::detail::configuration().testParams;
  parameters.maxSuccess = std::max(1, parameters.maxSuccess * percent / 100);
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  rc::detail::TestMetadata metadata;
  metadata.id = std::string(test->test_suite_name()) + "/" + test->name();
  metadata.description = test->name();
  const auto result =
      rc::detail::checkProperty(rc::detail::toProperty(std::forward<Property>(property)), metadata, parameters);
  std::ostringstream message;
  rc::detail::printResultMessage(result, message);
  if (!result.template is<rc::detail::SuccessResult>()) FAIL() << message.str();
}

}  // namespace tress::testing

/// As RC_GTEST_PROP without arguments, with `percent` of the cases.
#define TRESS_DEAR_PROPERTY(Suite, Name, percent)                                                \
  void dear_property_##Suite##_##Name();                                                         \
  TEST(Suite, Name) { ::tress::testing::check_share(percent, &dear_property_##Suite##_##Name); } \
  void dear_property_##Suite##_##Name()
