// A path after its first hit: at every later hit it ends, goes on or splits.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/color.h"
#include "integrate/excess_at.h"
#include "integrate/path_tracer.h"
#include "tress/base/random.h"

namespace tress::integrate {
namespace {

constexpr float least_survival = 0.05f;
constexpr float nowhere = std::numeric_limits<float>::infinity();
/// Number of hits of a sample after which no path splits, so that every sample ends, whatever was learned.
constexpr std::uint32_t most_parting_hits = 256;

/// An answer is checked by following a path for one in copies_per_check copies that it replaces, and for at least this
/// share of hits. Answers are also learned from these paths alone, and fewer checks would be too few for pictures with
/// few paths (bench/README.md, what lies deeper).
constexpr float copies_per_check = 4, least_checks = 1 / 16.0f;

/// The excess of rows is evaluated for one in this many directions that go on, in proportion to their weight.
constexpr float directions_per_excess = 32;

float luminance_of(const glm::vec3& color) { return std::max(0.0f, luminance(color)); }

/// The largest absolute value of a channel.
float largest_channel(const glm::vec3& color) {
  return std::max({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
}

/// The square root of the throughput, from early hits on. Variance times time is 0.78 to 0.91 of that with the
/// throughput itself from the sixth hit on (bench/README.md, chart 7). A path without losses always goes on: with a
/// survival of 0.95 a path of 60 hits in white hair would weigh 20 (bench/atlas/README.md, study 5).
float survival(float throughput) { return std::clamp(std::sqrt(throughput), least_survival, 1.0f); }

}  // namespace

/// The contribution to the picture of a unit of light from a vertex, and an estimate of its excess by the rows of the
/// vertices before it. The mean of a product of independent values is the product of their means, so successive errors
/// multiply as they do in the picture.
struct PathTracer::Worth {
  glm::vec3 whole{0.0f}, too_much{0.0f};
};

struct PathTracer::Departure {
  glm::vec3 weight{0.0f}, met{0.0f};  ///< weight: factor of light from there. met: light met on the way
  Worth worth;                        ///< worth of light from the hit
  std::optional<geometry::Hit> hit;
};

/// A hit after the first. Its light is the radiance that leaves it back along the path, without the path's weight.
struct PathTracer::Arrival {
  geometry::Hit hit;
  glm::vec3 direction;              ///< direction of the ray that met it
  int depth;                        ///< number of the hit, from 2
  Worth worth;                      ///< worth of light from each copy
  std::size_t place;                ///< place in DeeperLight
  std::optional<glm::vec3> answer;  ///< light that the picture takes from here; the copies then only measure its bias
  bool is_check;                    ///< whether this hit or one before it has an answer
  float per_copy = 1;               ///< 1 over the mean number of copies
  int copies = 1, copies_left = 1;
  glm::vec3 light{0.0f};  ///< light of the copies that have ended
  std::uint64_t hits = 0;
  glm::vec3 weight{0.0f}, copy_light{0.0f};  ///< of the current copy: factor of light from its next hit, and its light
  std::uint64_t copy_hits = 0;
};

PathTracer::Arrival PathTracer::arrive(const geometry::Hit& hit, const glm::vec3& direction, int depth,
                                       const Worth& worth, bool is_check) const {
  Arrival at{hit, direction, depth, worth, deeper_ ? deeper_->place(hit.position, -direction) : 0, {}, is_check};
  if (answers() && depth >= options_.deep_light_depth && !is_check) {
    at.answer = deeper_->answer(at.place);
    at.is_check = true;
  }
  return at;
}

bool PathTracer::go_on(Arrival at, RandomStream& random, PathSums& sums, Tree& tree) const {
  float mean_copies = 1;
  if (deeper_ && deeper_->is_ready()) {
    mean_copies = deeper_->copies(at.place, at.worth.whole);
    if (at.answer) mean_copies = std::clamp(mean_copies / copies_per_check, least_checks, 1.0f);
    if (sums.vertices >= most_parting_hits) mean_copies = std::min(mean_copies, 1.0f);
  } else if (at.depth >= options_.roulette_depth) {
    mean_copies = survival(largest_channel(at.worth.whole) * static_cast<float>(options_.bcsdf_samples));
  } else {
    tree.push_back(at);
    return true;
  }
  at.copies = static_cast<int>(mean_copies);
  if (random.next() < mean_copies - static_cast<float>(at.copies)) ++at.copies;
  if (at.copies == 0) return false;
  if (at.answer) {  // keeps the worth before roulette: with a larger one the path would split again and again
    ++sums.deep_light_checks;
  } else {
    at.worth = {at.worth.whole / mean_copies, at.worth.too_much / mean_copies};
  }
  at.per_copy = 1 / mean_copies;
  at.copies_left = at.copies;
  tree.push_back(at);
  return true;
}

/// Does not learn from light that may contain answers. Their errors would be passed on, and learning only from paths
/// without answers would favor short ones.
void PathTracer::end_copy(Arrival& hit) const {
  if (deeper_ && (hit.is_check || !answers())) {
    deeper_->note(hit.place, hit.copy_light, hit.copy_hits);
    if (options_.deep_light == DeepLight::learned && hit.depth == options_.deep_light_depth)
      deeper_->note_for_answers(hit.place, hit.copy_light, hit.worth.whole * (hit.answer ? hit.per_copy : 1.0f));
  }
  hit.light += hit.copy_light;
  hit.hits += hit.copy_hits;
}

PathTracer::Departure PathTracer::depart(const Vertex& vertex, const Scattering::Sample& sample, const Worth& worth,
                                         PathSums& sums) const {
  Departure way;
  way.weight = sample.value.total() / sample.value.pdf;
  way.worth.whole = worth.whole * way.weight;
  const float largest = largest_channel(way.worth.whole);
  if (!std::isfinite(largest)) {  // gains above 1 have overflowed: the film will drop the path
    way.met = glm::vec3(nowhere);
    return way;
  }
  if (!(largest > 0)) return way;
  way.hit = fibers_.intersect(ray_from(vertex.hit, sample.direction, sample.value.exit));
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
  const bool is_near = near_.is_traced(near_.of_later(at.hit), options_.seed, bits_of(xi1, xi2), 0);
  Vertex vertex = scattering_.begin(at.hit, at.direction, {xi1, xi2}, luminance_of(at.worth.whole), is_near);
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
  const Arrival next = arrive(*way.hit, sample.direction, at.depth + 1, way.worth, at.is_check);
  if (next.answer) {
    at.copy_light += way.weight * *next.answer;
    sums.excess += luminance(way.worth.too_much * *next.answer);
  }
  return go_on(next, random, sums, tree);
}

void PathTracer::follow(const Vertex& vertex, const Scattering::Sample& sample, RandomStream& random,
                        PathSums& sums) const {
  if (!(sample.value.pdf > 0)) return;
  const float share = 1 / static_cast<float>(vertex.bcsdf_samples);
  const Departure way = depart(vertex, sample, {glm::vec3(share)}, sums);
  glm::vec3 radiance = way.met;
  Tree tree;
  if (way.hit && options_.max_depth >= 2) {
    const Arrival next = arrive(*way.hit, sample.direction, 2, way.worth, false);
    if (next.answer) {
      radiance += *next.answer;
      sums.excess += luminance(way.worth.too_much * *next.answer);
    }
    go_on(next, random, sums, tree);
  }
  while (!tree.empty()) {
    if (tree.back().copies_left > 0) {
      const float excess = sums.excess;
      const bool is_check = tree.back().is_check;
      if (!step(tree, random, sums)) end_copy(tree.back());
      if (is_check) sums.excess = excess;
      if (std::isfinite(largest_channel(tree.back().light))) continue;
      radiance = glm::vec3(nowhere);
      break;
    }
    const Arrival ended = tree.back();
    tree.pop_back();
    glm::vec3 brought = ended.light * ended.per_copy;
    if (ended.answer) {
      const glm::vec3 answered = *ended.answer * static_cast<float>(ended.copies);
      sums.deep_light_excess += luminance(ended.worth.whole * ended.per_copy * (answered - ended.light));
      brought = glm::vec3(0.0f);  // the path has already taken the answer
    }
    if (tree.empty()) {
      radiance += brought;
      break;
    }
    Arrival& before = tree.back();
    before.copy_light += before.weight * brought;
    before.copy_hits += ended.hits;
    end_copy(before);
  }
  // All light after the first vertex scales its layers by the same factor.
  for (std::size_t layer = 0; layer < sample.value.layers.size(); ++layer) {
    sums.layers[layer] += sample.value.layers[layer] * (share / sample.value.pdf) * radiance;
  }
}

}  // namespace tress::integrate
