// The learning service in a program of its own: open, observe, publish, converge, save, load.
#include "tress/adaptive/service.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/base/random.h"

using namespace tress;
using namespace tress::adaptive;

// What is to be learned: one bundle of rays whose direction depends on a and whose mass depends on b.
class Beam final : public Target {
 public:
  void trace(const SliceDescription&, float a, float b, std::vector<TracedRay>& out) const override {
    for (int i = 0; i < 32; ++i) out.push_back({a + 0.02f * static_cast<float>(i), b / 32, 0});
  }
  std::string model_name() const override { return "beam-1"; }
};

// One query: draws an azimuth from the row and returns its weight, whose mean is the mass.
static float sample_row(const Service& service, SliceId slice, std::uint32_t a, std::uint32_t b, RandomStream& random) {
  const RowView row = service.look_up(slice, a, b);
  const bool converged = row.state == RowState::converged;
  const float u = converged ? service.options().uniform_share_converged : service.options().uniform_share_open;
  const float x = row.sample(random.next(), u);  // uniformly before the first fit
  const float q = row.proposal_density(x, u);
  if (converged) return row.density(x) / q;
  const float g = row.nodes->density(x);
  service.score(row, x, g, q);  // x was drawn from this very row
  return g / q;
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const Beam beam;
  SliceDescription description;
  description.axis_a = {0.0f, 1.0f, 2.0f};
  description.axis_b = {0.25f, 0.75f};
  Service service(Options{}, beam);
  const SliceId slice = *service.add_slice(description);
  bool right = true;
  for (std::uint64_t pass = 0; pass < 8; ++pass) {
    for (std::uint32_t node = 0; node < 6; ++node) {
      RandomStream random(1, node, pass);
      double mass = 0;
      for (int i = 0; i < 64; ++i) mass += sample_row(service, slice, node / 2, node % 2, random) / 64;
      // Before the first fit draws are uniform and weights up to 2 pi g; afterwards weights are near the mass.
      right = right && std::abs(mass - description.axis_b[node % 2]) < (pass == 0 ? 0.5 : 0.1);
    }
    const PassReport report = service.publish();
    std::printf("pass %d: %d of %d queries on converged rows\n", static_cast<int>(pass),
                static_cast<int>(report.converged_queries), static_cast<int>(report.queries));
  }
  // Joined with what other sessions have saved there; any number of them may run.
  const Result<CacheUpdate> saved = merge_into_cache(argv[1], service.snapshot());
  if (!saved || saved->refusal) {
    std::fprintf(stderr, "%s\n", (saved ? *saved->refusal : saved.error()).message().c_str());
    return 1;
  }
  Result<TableSnapshot> image = load_cache(argv[1], beam.model_name());
  Service next(Options{}, beam);
  right = right && image && !next.load(std::move(*image));
  const RowView warm = next.look_up(*next.add_slice(description), 2, 1);
  std::printf("the next session begins %s\n", warm.state == RowState::converged ? "converged" : "cold");
  return right && warm.state == RowState::converged ? 0 : 1;
}
