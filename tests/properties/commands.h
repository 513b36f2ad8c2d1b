// What a host may do to a service, at random: passes of queries, and what comes between passes.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "properties/property.h"
#include "properties/service_model.h"

namespace tress::inline v0_2::adaptive {

/// `times` queries of one node.
struct Queries {
  std::uint32_t slice, node, times;
  ServiceModel::Ask how;
  float light;  ///< passed to carry(); 0: not called
};

struct Pass {
  enum class Then : std::uint8_t {
    nothing,
    restart,
    restart_on_another_target,
    restart_at_another_epsilon,
    learn,
    stop
  };

  std::vector<Queries> queries;
  std::uint32_t threads;  ///< 1 to 8 readers
  Then then;              ///< after publish(); a restart saves, ends the session and loads
};

struct Host {
  std::uint32_t queries_before_creation, tests_before_refusal, max_components;
  std::uint64_t seed;
  double epsilon;
  std::vector<Pass> passes;
};

/// Three slices of 2 x 2 nodes.
constexpr std::uint32_t host_slices = 3, host_nodes = 4;

rc::Gen<Host> any_host();

void showValue(const Host& host, std::ostream& out);

}  // namespace tress::inline v0_2::adaptive
