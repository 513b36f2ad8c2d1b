// A scene of very many distinct materials: what slices cost in memory and time before and while they are asked, under
// the ceiling of the table. JSON on stdout.
//
//   bench_atlas_slices [--slices N] [--memory MB] [--queries N]
//
// Slice i is a TT slice of sigma 10 degrees and its own eta. Queries go to random slices, one vertex each, in two
// passes.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"

namespace {

using namespace tress;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Of this process now, bytes.
double resident() {
  std::ifstream file("/proc/self/statm");
  double all = 0, held = 0;
  file >> all >> held;
  return held * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

int main(int argc, char** argv) {
  std::uint32_t slices = 1000000, queries = 20000;
  std::size_t memory = 256;
  CLI::App app("many pages, as JSON");
  app.add_option("--pages", slices)->check(CLI::PositiveNumber);
  app.add_option("--memory", memory, "MB")->check(CLI::PositiveNumber);
  app.add_option("--queries", queries, "a pass");
  CLI11_PARSE(app, argc, argv);
  const auto target = fiber::make_elliptical_target();
  adaptive::Options options;
  options.memory_bytes = memory << 20;
  options.queries_before_creation = 1;
  adaptive::Service service(options, *target);
  const double before = resident(), start = cpu_seconds();
  const auto sigma = static_cast<float>(10 * std::numbers::pi / 180);
  adaptive::SliceDescription slice = fiber::elliptical_slice(1, 1.55f, 0.85f, sigma);
  for (std::uint32_t i = 0; i < slices; ++i) {
    slice.key.parameters[0] = 1.2f + 0.7e-6f * static_cast<float>(i);
    service.add_slice(slice);
  }
  const double added = cpu_seconds(), held = resident();
  adaptive::PassReport report;
  double asking = 0, publishing = 0, most = held;
  for (std::uint64_t pass = 0; pass < 2; ++pass) {
    const double first = cpu_seconds();
    RandomStream random(1, pass);
    for (std::uint32_t i = 0; i < queries; ++i) {
      const auto at = static_cast<adaptive::SliceId>(random.next_bits() % service.slice_count());
      service.look_up(at, 2, 5);
    }
    const double then = cpu_seconds();
    report = service.publish();
    asking += then - first;
    publishing += cpu_seconds() - then;
    most = std::max(most, resident());
  }
  const nlohmann::json found = {{"pages", service.slice_count()},
                                {"nodes_a_page", slice.node_count()},
                                {"ceiling_bytes", options.memory_bytes},
                                {"add_us_a_page", 1e6 * (added - start) / slices},
                                {"bytes_a_page", (held - before) / slices},
                                {"resident_bytes", most},
                                {"query_us", 1e6 * asking / (2.0 * queries)},
                                {"publish_ms", 1e3 * publishing / 2},
                                {"rows", report.rows_open + report.rows_converged},
                                {"at_ceiling", report.at_ceiling}};
  fmt::print("{}\n", found.dump());
  return 0;
}
