// A path after its first hit: at every later one it ends, goes on, or parts into several.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/color.h"
#include "integrate/excess_at.h"
#include "integrate/path_tracer.h"

namespace tress::integrate {
namespace {

constexpr float least_survival = 0.05f;
constexpr float nowhere = std::numeric_limits<float>::infinity();
/// Of one sample of a pixel: after so many hits no path parts, so that a sample has an end whatever was learned.
constexpr std::uint32_t most_parting_hits = 256;

/// How often it is asked what rows have too much: for one in so many directions that go on, times what they are worth.
constexpr float directions_per_excess = 32;

float luminance_of(const glm::vec3& color) { return std::max(0.0f, luminance(color)); }

/// Without regard to sign.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

/// The root of the throughput, from early on: variance times time is .78 to .91 of that of the throughput itself from
/// the sixth hit on (bench/README.md, chart 7). A path that has lost nothing goes on: at .95 a path of 60 hits in white
/// hair would weigh 20 (bench/atlas/README.md, study 5).
float survival(float throughput) { return std::clamp(std::sqrt(throughput), least_survival, 1.0f); }

}  // namespace

/// What a unit of light from a vertex brings to the picture, and what of that is too much by the rows of the vertices
/// before it, in the mean. The mean of a product of independent values is the product of their means: errors that
/// follow each other are multiplied as they are in the picture.
struct PathTracer::Worth {
  glm::vec3 whole{0.0f}, too_much{0.0f};
};

struct PathTracer::Departure {
  glm::vec3 weight{0.0f}, met{0.0f};  ///< of what comes from there; light met on the way
  Worth worth;                        ///< of what comes from the hit
  std::optional<geometry::Hit> hit;
};

/// A hit after the first. Light is in radiance along the way back from it, and what the path's weight does not know.
struct PathTracer::Arrival {
  geometry::Hit hit;
  glm::vec3 direction;  ///< of the ray that met it
  int depth;            ///< from 2
  Worth worth;          ///< of every copy
  std::size_t place;    ///< of DeeperLight
  float per_copy;       ///< 1 over the mean number of copies
  int copies_left;
  glm::vec3 light{0.0f};  ///< of the copies that have ended
  std::uint64_t hits = 0;
  glm::vec3 weight{0.0f}, copy_light{0.0f};  ///< of the copy under way; weight: of what comes from its next hit
  std::uint64_t copy_hits = 0;
};

bool PathTracer::go_on(const geometry::Hit& hit, const glm::vec3& direction, int depth, const Worth& worth,
                       RandomStream& random, const PathSums& sums, Tree& tree) const {
  const std::size_t place = deeper_ ? deeper_->place(hit.position, -direction) : 0;
  float mean_copies = 1;
  if (deeper_ && deeper_->is_ready()) {
    mean_copies = deeper_->copies(place, worth.whole);
    if (sums.vertices >= most_parting_hits) mean_copies = std::min(mean_copies, 1.0f);
  } else if (depth >= options_.roulette_depth) {
    mean_copies = survival(largest_channel(worth.whole) * static_cast<float>(options_.bcsdf_samples));
  } else {
    tree.push_back({hit, direction, depth, worth, place, 1, 1});
    return true;
  }
  int copies = static_cast<int>(mean_copies);
  if (random.next() < mean_copies - static_cast<float>(copies)) ++copies;
  if (copies == 0) return false;
  const Worth of_copy{worth.whole / mean_copies, worth.too_much / mean_copies};
  tree.push_back({hit, direction, depth, of_copy, place, 1 / mean_copies, copies});
  return true;
}

void PathTracer::end_copy(Arrival& hit) const {
  if (deeper_) deeper_->note(hit.place, hit.copy_light, hit.copy_hits);
  hit.light += hit.copy_light;
  hit.hits += hit.copy_hits;
}

PathTracer::Departure PathTracer::depart(const Vertex& vertex, const Scattering::Sample& sample, const Worth& worth,
                                         PathSums& sums) const {
  Departure way;
  way.weight = sample.value.total() / sample.value.pdf;
  way.worth.whole = worth.whole * way.weight;
  const float largest = largest_channel(way.worth.whole);
  if (!std::isfinite(largest)) {  // gains above 1, again and again: whatever it meets, the film will drop it
    way.met = glm::vec3(nowhere);
    return way;
  }
  if (!(largest > 0)) return way;
  way.hit = fibers_.intersect(ray_from(vertex.hit, sample.direction));
  way.met = met_light(vertex, sample, way.hit ? way.hit->distance_cm : nowhere, way.worth.whole, sums.groups);
  ExcessAt excess(scattering_, vertex, sample.direction);
  const auto too_much_after = [&](float chance) {
    return worth.too_much * way.weight + (worth.whole - worth.too_much) * (excess.by(chance) / sample.value.pdf);
  };
  if (way.met != glm::vec3(0.0f))
    sums.excess += luminance(too_much_after(chance_of_light(luminance_of(way.worth.whole * way.met))) * way.met);
  if (way.hit)
    way.worth.too_much = too_much_after(std::min(luminance_of(way.worth.whole) / directions_per_excess, 1.0f));
  return way;
}

bool PathTracer::step(Tree& tree, RandomStream& random, PathSums& sums) const {
  Arrival& at = tree.back();
  --at.copies_left;
  at.copy_light = glm::vec3(0.0f);
  at.copy_hits = 1;
  const float xi1 = random.next(), xi2 = random.next();
  Vertex vertex = scattering_.begin(at.hit, at.direction, {xi1, xi2}, luminance_of(at.worth.whole));
  vertex.light_samples = vertex.evaluates ? std::min(1, options_.light_samples) : 0;
  ++sums.vertices;
  if (vertex.light_samples > 0) {
    const float u_light = random.next(), u1 = random.next(), u2 = random.next();
    const Lit lit = light(vertex, u_light, {u1, u2}, at.worth.whole, random, sums);
    const glm::vec3 total = total_of(lit.layers);
    at.copy_light += total;
    sums.groups.add(lit.group, at.worth.whole * total);
    sums.excess += luminance(at.worth.too_much * total + (at.worth.whole - at.worth.too_much) * lit.excess);
  }
  std::array<float, 4> u;
  for (float& number : u) number = random.next();
  const Scattering::Sample sample = scattering_.sample(vertex, u, sums);
  if (!(sample.value.pdf > 0)) return false;
  const Departure way = depart(vertex, sample, at.worth, sums);
  at.weight = way.weight;
  at.copy_light += way.weight * way.met;
  if (!way.hit || at.depth >= options_.max_depth) return false;
  return go_on(*way.hit, sample.direction, at.depth + 1, way.worth, random, sums, tree);
}

void PathTracer::follow(const Vertex& vertex, const Scattering::Sample& sample, RandomStream& random,
                        PathSums& sums) const {
  if (!(sample.value.pdf > 0)) return;
  const float share = 1 / static_cast<float>(vertex.bcsdf_samples);
  const Departure way = depart(vertex, sample, {glm::vec3(share)}, sums);
  glm::vec3 radiance = way.met;
  Tree tree;
  if (way.hit && options_.max_depth >= 2) go_on(*way.hit, sample.direction, 2, way.worth, random, sums, tree);
  while (!tree.empty()) {
    if (tree.back().copies_left > 0) {
      if (!step(tree, random, sums)) end_copy(tree.back());
      if (std::isfinite(largest_channel(tree.back().light))) continue;
      radiance = glm::vec3(nowhere);
      break;
    }
    const glm::vec3 brought = tree.back().light * tree.back().per_copy;
    const std::uint64_t hits = tree.back().hits;
    tree.pop_back();
    if (tree.empty()) {
      radiance += brought;
      break;
    }
    Arrival& before = tree.back();
    before.copy_light += before.weight * brought;
    before.copy_hits += hits;
    end_copy(before);
  }
  // Everything after the first vertex scales its layers alike.
  for (std::size_t layer = 0; layer < sample.value.layers.size(); ++layer) {
    sums.layers[layer] += sample.value.layers[layer] * (share / sample.value.pdf) * radiance;
  }
}

}  // namespace tress::integrate
