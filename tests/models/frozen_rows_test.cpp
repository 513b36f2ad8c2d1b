// The header without the library gives what the library gives.
#include "tress/frozen_rows.h"

#include <gtest/gtest.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "adaptive/random_ribbons.h"
#include "fiber/rough_rows.h"
#include "tress/adaptive/cache.h"
#include "tress/base/random.h"
#include "tress/fiber/rough_model.h"

namespace tress {
namespace {

using adaptive::CachedRow;
using adaptive::Ribbon;
using adaptive::RibbonRow;
using frozen::Outcome;
using frozen::Status;

constexpr float pi = std::numbers::pi_v<float>;

/// A slice of the rough fiber with rows at every third node, of any shape, and a mixture's slice before it.
adaptive::TableSnapshot table_of(const fiber::FiberParameters& parameters) {
  adaptive::CachedSlice slice{fiber::rough_slice(parameters), {}};
  const auto nodes = static_cast<std::uint32_t>(slice.description.node_count());
  for (std::uint32_t node = 0; node < nodes; node += 3) {
    std::vector<RibbonRow::Part> parts;
    for (std::uint64_t p = 0; p < 4; ++p)
      parts.push_back(
          {adaptive::random_ribbon(4 * node + p, node % 2 == 0), p == 2 && node % 9 == 0 ? 0 : 0.1f + 0.1f * float(p)});
    CachedRow row;
    row.node = node;
    row.state = adaptive::RowState::converged;
    row.count = 512;
    row.objective = 0.05f;
    row.learned = adaptive::CachedSamples{std::make_shared<const RibbonRow>(parts)};
    row.energy = row.ribbons()->total_mass();
    slice.rows.push_back(row);
  }
  CachedRow mixture;
  mixture.state = adaptive::RowState::converged;
  mixture.density()->fit.component_count = 1;
  mixture.density()->fit.components[0] = {{0.5f, 0.1f, 0.2f}, 0.5f, 2, 0.25f};
  mixture.energy = 0.5f;
  adaptive::CachedSlice other{{{1, {1.55f, 0.85f, 0.2f}}, {0, 0.5f}, {0, 0.3f}, 0.2f}, {mixture}};
  return {"a model", {other, slice}};
}

struct Frozen {
  explicit Frozen(const adaptive::TableSnapshot& table, const adaptive::SliceKey& key)
      : bytes(adaptive::encode_cache(table)) {
    outcome = find(bytes.data(), bytes.size(), XXH3_64bits, key.lobe, key.parameters.data(), &slice);
    if (outcome.status != Status::ok) return;
    rows.resize(slice.row_count);
    row_of.resize(slice.count_a * slice.count_b);
    axis_a.resize(slice.count_a);
    axis_b.resize(slice.count_b);
    read(slice, rows.data(), row_of.data(), axis_a.data(), axis_b.data());
  }
  frozen::Table table() const { return {rows.data(), row_of.data(), axis_a.data(), slice.count_a, slice.count_b}; }

  std::string bytes;
  frozen::Slice slice;
  Outcome outcome;
  std::vector<frozen::Row> rows;
  std::vector<std::uint32_t> row_of;
  std::vector<float> axis_a, axis_b;
};

fiber::FiberParameters hair(float tilt = 0.05f) {
  fiber::FiberParameters parameters;
  parameters.tilt = tilt;
  return parameters;
}

/// The ribbon that one channel sees, of mass 1, and the share of the light that is left.
std::pair<Ribbon, double> colored(const Ribbon& ribbon, float rate) {
  std::vector<adaptive::RibbonKnot> knots(ribbon.main().begin(), ribbon.main().end());
  knots.insert(knots.end(), ribbon.broad().begin(), ribbon.broad().end());
  double left = 0;
  for (adaptive::RibbonKnot& knot : knots) knot.density *= adaptive::GammaDecay::from(knot.decays).at(rate);
  const std::span all(knots);
  const auto main = all.first<Ribbon::main_knots>();
  const auto broad = all.last<Ribbon::broad_knots>();
  for (const auto layer : {std::span<const adaptive::RibbonKnot>(main), std::span<const adaptive::RibbonKnot>(broad)}) {
    for (std::size_t k = 0; k < layer.size(); ++k) {
      const bool is_last = k + 1 == layer.size();
      const double width =
          double{layer[is_last ? 0 : k + 1].azimuth} - double{layer[k].azimuth} + (is_last ? 2 * std::numbers::pi : 0);
      left += 0.5 * width * (double{layer[k].density} + double{layer[is_last ? 0 : k + 1].density});
    }
  }
  return {Ribbon(main, ribbon.main_law(), broad), left};
}

// Bounds are 1e-6 of the value, some ten roundings of single precision; below 1e-30 exponentials are denormal.
void expect_same(double found, double expected, double bound = 1e-6) {
  EXPECT_NEAR(found, expected, bound * std::abs(expected) + 1e-30);
}

/// The error of colored densities over that of all places: where knots differ by much, the rounding of the larger one
/// is no small part of a value between them.
struct RootMeanSquare {
  double errors = 0, squares = 0;
  void add(double found, double expected) {
    errors += (found - expected) * (found - expected);
    squares += expected * expected;
  }
  double relative() const { return std::sqrt(errors / squares); }
};

TEST(FrozenRows, AnswerAndDrawAsTheLibraryDoes) {
  const adaptive::TableSnapshot table = table_of(hair());
  const adaptive::CachedSlice& slice = table.slices[1];
  const Frozen frozen(table, slice.description.key);
  ASSERT_EQ(frozen.outcome.status, Status::ok) << frozen.outcome.byte;
  ASSERT_EQ(frozen.rows.size(), slice.rows.size());
  EXPECT_EQ(frozen.axis_a, slice.description.axis_a);
  EXPECT_EQ(frozen.axis_b, slice.description.axis_b);
  RandomStream random(4);
  for (std::size_t i = 0; i < frozen.rows.size(); i += 7) {
    const frozen::Row& row = frozen.rows[i];
    EXPECT_EQ(row.node, slice.rows[i].node);
    EXPECT_EQ(row.paths, 512u);
    frozen::Row dark = {}, darker = {};
    color(row, 0.7f, &dark);
    color(dark, 0.5f, &darker);
    for (std::uint32_t p = 0; p < 4; ++p) {
      const Ribbon ribbon = slice.rows[i].ribbons()->ribbon(p);
      const float mass = slice.rows[i].ribbons()->mass(p);
      EXPECT_EQ(row.part[p].mass, mass);
      if (!(mass > 0)) continue;
      const auto [one, left_of_one] = colored(ribbon, 0.7f);
      const auto [both, left_of_both] = colored(ribbon, 0.7f + 0.5f);
      expect_same(double{dark.part[p].mass}, double{mass} * left_of_one);
      expect_same(double{darker.part[p].mass}, double{mass} * left_of_both);
      RootMeanSquare errors;
      for (int k = 0; k < 100; ++k) {
        const float x = pi * (6 * random.next() - 3), t = 4 * random.next() - 2;
        expect_same(double{density(row.part[p], x, t)}, double{ribbon.density(x, t)});
        const float rates[3] = {0, 0.7f, 0.7f + 0.5f};
        float s[3] = {0, 0, 0};
        add_densities(row.part[p], x, t, 2, rates, 3, s);
        expect_same(double{s[0]}, 2 * double{ribbon.density(x, t)});
        errors.add(double{s[1]}, 2 * left_of_one * double{one.density(x, t)});
        errors.add(double{s[2]}, 2 * left_of_both * double{both.density(x, t)});
        errors.add(double{density(dark.part[p], x, t)}, double{one.density(x, t)});
        const float u = random.next(), v = random.next();
        float azimuth = 0, height = 0;
        sample(row.part[p], u, v, &azimuth, &height);
        const Ribbon::Place place = ribbon.sample(u, v);
        EXPECT_NEAR(azimuth, place.azimuth, 1e-6f * pi);
        EXPECT_NEAR(height, place.height, 1e-6f * (1 + std::abs(place.height)));
      }
      EXPECT_LT(errors.relative(), 1e-6);
    }
  }
}

// Nodes and places are those of RoughGrid, with and without a tilt; values are sums over parts of the library's.
// As the library does; on a GPU a read beyond the knots would go unnoticed.
TEST(FrozenRows, TakeAnyNumberAsUniform) {
  const adaptive::TableSnapshot table = table_of(hair());
  const Frozen frozen(table, table.slices[1].description.key);
  const float strange[] = {
      std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30f, -0.5f, 1, 5};
  for (const float x : strange) {
    for (const float y : {x, 0.5f}) {
      const frozen::Event event = begin(frozen.table(), {0.3f, 0.5f}, y, x);
      const float u[3] = {y, x, x};
      const frozen::Direction wi = sample(frozen.table(), event, u);
      EXPECT_TRUE(std::isfinite(wi.theta) && std::isfinite(wi.phi)) << x << " " << y;
    }
  }
}

TEST(FrozenRows, ChooseNodesAndPlacesAsTheModelDoes) {
  for (const float tilt : {0.0f, 0.05f}) {
    const adaptive::TableSnapshot table = table_of(hair(tilt));
    const adaptive::CachedSlice& slice = table.slices[1];
    const Frozen frozen(table, slice.description.key);
    ASSERT_EQ(frozen.outcome.status, Status::ok);
    const fiber::RoughGrid grid(slice.description);
    RandomStream random(5);
    for (int i = 0; i < 3000; ++i) {
      const fiber::FiberDirection wr{pi * (random.next() - 0.5f), pi * (2 * random.next() - 1)},
          wi{3.1f * (random.next() - 0.5f), pi * (2 * random.next() - 1)};
      const float xi1 = random.next(), xi2 = random.next();
      const fiber::RoughNode node = grid.choose(wr, xi1, xi2);
      const frozen::Event event = begin(frozen.table(), {wr.theta, wr.phi}, xi1, xi2);
      const std::uint32_t index = node.a * frozen.slice.count_b + node.b;
      ASSERT_EQ(event.row, frozen.row_of[index]);
      if (frozen.rows[event.row].node != index) continue;  // another row answers
      const CachedRow& row = slice.rows[event.row];
      const float x = node.azimuth(wi.phi, wr.phi), t = node.height(wi.theta, wr.theta);
      double s = 0, q = 0;
      for (std::uint32_t p = 0; p < 4; ++p) {
        const auto [ribbon, left] = colored(row.ribbons()->ribbon(p), 0.4f);
        s += double{row.ribbons()->mass(p)} * left * double{ribbon.density(x, t)} / std::cos(double{wi.theta});
        q += double{row.ribbons()->mass(p)} * double{row.ribbons()->ribbon(p).density(x, t)} /
             std::cos(double{wi.theta});
      }
      const float sigma_a = 0.4f;
      float found = 0;
      evaluate(frozen.table(), event, {wi.theta, wi.phi}, &sigma_a, 1, &found);
      // A height is known to 1e-7 of itself, and the narrowest law has a scale of 1e-3.
      expect_same(double{found}, s, 2e-3);
      expect_same(double{pdf(frozen.table(), event, {wi.theta, wi.phi})}, q / double{row.ribbons()->total_mass()},
                  2e-3);
      const float u[3] = {random.next(), random.next(), random.next()};
      const frozen::Direction drawn = sample(frozen.table(), event, u);
      EXPECT_GT(pdf(frozen.table(), event, drawn), 0);
    }
  }
}

// The library's energies of a part are from more paths than a row's, and its packed densities are rounded to 2e-3. The
// sum of absolute differences over that of values is 0.011.
TEST(FrozenRows, GiveTheEventsOfTheModel) {
  const auto target = fiber::make_rough_target();
  adaptive::Options options;
  options.heard_share = 0;
  adaptive::Service service(options, *target);
  const auto model = *fiber::make_rough_model(fiber::Estimator::fitted, &service);
  const fiber::FiberParameters parameters = hair();
  const fiber::FiberId id = model->add_fiber(parameters);
  service.prepare();
  const fiber::FiberDirection wr{0.33f, 0.83f};
  RandomStream random(8);
  for (int pass = 0; pass < 6; ++pass) {
    for (int i = 0; i < 4000; ++i) {
      const auto event = model->begin(id, wr, random.next(), random.next(), 0);
      (void)model->sample(event, {random.next(), random.next(), random.next(), random.next()});
    }
    service.publish(4000);
  }
  const Frozen frozen(service.snapshot(), fiber::rough_slice(parameters).key);
  ASSERT_EQ(frozen.outcome.status, Status::ok);
  double off = 0, all = 0;
  for (int i = 0; i < 4000; ++i) {
    const float xi1 = random.next(), xi2 = random.next();
    const fiber::FiberDirection wi{pi * (random.next() - 0.5f), pi * (2 * random.next() - 1)};
    const auto event = model->begin(id, wr, xi1, xi2, 0);
    ASSERT_TRUE(model->evaluates(event));
    const glm::vec3 expected = model->evaluate(event, wi).total();
    float found[3];
    evaluate(frozen.table(), begin(frozen.table(), {wr.theta, wr.phi}, xi1, xi2), {wi.theta, wi.phi},
             &parameters.sigma_a.x, 3, found);
    for (int c = 0; c < 3; ++c) {
      off += std::abs(double{found[c]} - double{expected[c]});
      all += double{expected[c]};
    }
  }
  EXPECT_LT(off / all, 0.02);
  RecordProperty("difference", std::to_string(off / all));
}

TEST(FrozenRows, RefuseWhatIsNoCache) {
  const adaptive::TableSnapshot table = table_of(hair());
  const adaptive::SliceKey key = table.slices[1].description.key;
  const Frozen whole(table, key);
  frozen::Slice slice;
  const auto status = [&](const std::string& bytes, frozen::Hash hash) {
    return find(bytes.data(), bytes.size(), hash, key.lobe, key.parameters.data(), &slice).status;
  };
  EXPECT_EQ(status(whole.bytes, nullptr), Status::ok);
  EXPECT_EQ(status("no cache, but longer than a header", nullptr), Status::not_a_cache);
  for (std::size_t size = 0; size < whole.bytes.size(); size += 1999)
    EXPECT_EQ(status(whole.bytes.substr(0, size), XXH3_64bits), Status::truncated) << size;
  EXPECT_EQ(status(whole.bytes + 'x', XXH3_64bits), Status::invalid);
  // Every changed byte is found by the checksums; without them nothing worse happens than that a value differs.
  RandomStream random(6);
  for (std::size_t i = 0; i < 400; ++i) {
    std::string changed = whole.bytes;
    const std::size_t at = 24 + static_cast<std::size_t>(random.next() * static_cast<float>(changed.size() - 24));
    changed[at] = static_cast<char>(changed[at] ^ (1 << i % 8));
    EXPECT_NE(status(changed, XXH3_64bits), Status::ok) << at;
    if (status(changed, nullptr) != Status::ok) continue;
    std::vector<frozen::Row> rows(slice.row_count);
    std::vector<std::uint32_t> row_of(slice.count_a * slice.count_b);
    std::vector<float> axis_a(slice.count_a), axis_b(slice.count_b);
    if (i % 50 == 0) read(slice, rows.data(), row_of.data(), axis_a.data(), axis_b.data());
  }
  frozen::Slice other;
  EXPECT_EQ(find(whole.bytes.data(), whole.bytes.size(), nullptr, 17, nullptr, &other).status, Status::no_such_slice);
  EXPECT_EQ(find(whole.bytes.data(), whole.bytes.size(), nullptr, 1, nullptr, &other).status, Status::no_rows);
}

}  // namespace
}  // namespace tress
