#include "properties/commands.h"

#include <cstddef>
#include <ostream>
#include <utility>

#include "properties/combinators.h"

namespace tress::inline v0_2::adaptive {
namespace {

using testing::below;
using testing::pick;

rc::Gen<Queries> any_queries() {
  using Ask = ServiceModel::Ask;
  return rc::gen::apply([](std::uint32_t slice, std::uint32_t node, std::uint32_t times, Ask how,
                           float light) { return Queries{slice, node, times, how, light}; },
                        below(host_slices), below(host_nodes), pick<std::uint32_t>({1, 8, 3, 7, 20, 60}),
                        pick<Ask>({Ask::score, Ask::score, Ask::observe, Ask::look}), pick<float>({0, 1, 0.25f}));
}

rc::Gen<Pass> any_pass() {
  using Then = Pass::Then;
  return rc::gen::apply(
      [](std::vector<Queries> queries, std::uint32_t threads, Then then) {
        return Pass{std::move(queries), 1 + threads, then};
      },
      testing::up_to(6, any_queries()), below(8u),
      pick<Then>({Then::nothing, Then::nothing, Then::nothing, Then::nothing, Then::restart,
                  Then::restart_on_another_target, Then::restart_at_another_epsilon, Then::learn, Then::stop}));
}

}  // namespace

rc::Gen<Host> any_host() {
  return rc::gen::apply(
      [](std::uint32_t creation, std::uint32_t tests, std::uint32_t components, std::uint64_t seed, double epsilon,
         std::vector<Pass> passes) { return Host{creation, tests, components, seed, epsilon, std::move(passes)}; },
      pick<std::uint32_t>({8, 1, 30}), pick<std::uint32_t>({32, 1, 2}), pick<std::uint32_t>({8, 1, 2}),
      below(std::uint64_t{100}), pick<double>({0.01, 0.3, 0.001}), testing::up_to(12, any_pass()));
}

void showValue(const Host& host, std::ostream& out) {
  out << "birth after " << host.queries_before_creation << " touches, refusal after " << host.tests_before_refusal
      << " tests, D " << host.max_components << ", seed " << host.seed << ", epsilon " << host.epsilon;
  const char* how[] = {"score", "observe", "look"};
  const char* then[] = {"nothing", "restart", "restart on another target", "restart at another epsilon",
                        "learn",   "stop"};
  for (const Pass& pass : host.passes) {
    out << "\n  pass of " << pass.threads << " threads:";
    for (const Queries& one : pass.queries) {
      out << " " << one.times << " x " << how[static_cast<std::size_t>(one.how)] << " (" << one.slice << ", "
          << one.node << ")";
      if (one.light > 0) out << " light " << one.light;
      out << ";";
    }
    out << " then " << then[static_cast<std::size_t>(pass.then)];
  }
  out << "\n";
}

}  // namespace tress::inline v0_2::adaptive
