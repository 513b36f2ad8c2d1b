// A service, asked by any number of threads in any order, keeps at every pass end to the rules that the naive model
// restates, through restarts on other targets and at other epsilons; and it is to the bit what a twin is that one
// thread asks in order, and that is spared all that should have no effect. Rows are created in the order of light,
// queries, key.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "adaptive/toy_target.h"
#include "properties/commands.h"
#include "properties/generators.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// Keys of either sign, known in an order of their own; the last slice is added after the first pass.
SliceDescription slice_of(std::uint32_t index) {
  SliceDescription slice = testing::toy_slice(index, 2, index == 1 ? 0.1f : 0.3f);
  slice.key.parameters[0] = index == 0 ? 0.5f : index == 1 ? -0.25f : -1.0f;
  return slice;
}

/// A service, its twin and their model, given the same.
class Session {
 public:
  Session(const Options& options, float turn)
      : options_(options),
        target_(turn),
        service_(options, target_),
        twin_(options, target_),
        model_(options, target_) {}

  void add_slice(std::uint32_t index) {
    if (ids_.size() > index) return;
    ids_.push_back(*service_.add_slice(slice_of(index)));
    twin_.add_slice(slice_of(index));
    model_.add_slice(slice_of(index));
    model_.check_loaded(service_);
  }

  void load(const TableSnapshot& image) {
    RC_ASSERT(!service_.load(image));
    RC_ASSERT(!twin_.load(image));
    model_.load(image);
    model_.check_loaded(service_);
    model_.check_saved(service_);
  }

  void set_learning(bool on) {
    learns_ = on;
    service_.set_learning(on);
    twin_.set_learning(on);
    model_.set_learning(on);
  }

  void run(const Pass& pass, std::uint64_t number) {
    struct One {
      Queries of;
      float u;
    };
    std::vector<One> all;
    for (const Queries& queries : pass.queries) {
      if (queries.slice >= ids_.size()) continue;
      for (std::uint32_t i = 0; i < queries.times; ++i) {
        RandomStream random(number, queries.slice * host_nodes + queries.node, all.size());
        all.push_back({queries, random.next()});
        model_.ask(queries.slice, queries.node, queries.how);
        ask(twin_, queries, all.back().u, true);
      }
    }
    RandomStream random(number, pass.threads);
    for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[random.next_bits() % i]);
    const auto work = [&](std::size_t first) {
      for (std::size_t i = first; i < all.size(); i += pass.threads) ask(service_, all[i].of, all[i].u, false);
    };
    std::vector<std::thread> threads;
    for (std::size_t t = 1; t < pass.threads; ++t) threads.emplace_back(work, t);
    work(0);
    for (std::thread& thread : threads) thread.join();
    const PassReport report = service_.publish(), of_twin = twin_.publish();
    RC_ASSERT(report.g_evaluations == of_twin.g_evaluations);
    RC_ASSERT(report.traces == of_twin.traces);
    RC_ASSERT(report.objective_max == of_twin.objective_max);
    model_.check_pass(service_, report);
    model_.check_saved(service_);
    RC_ASSERT(encode_cache(service_.snapshot()) == encode_cache(twin_.snapshot()));
  }

  /// What the session saves, as the next one reads it.
  TableSnapshot saved() const {
    Result<TableSnapshot> read = decode_cache(encode_cache(service_.snapshot()), target_.model_name(), "saved");
    RC_ASSERT(read.has_value());
    return std::move(*read);
  }

 private:
  /// spare: nothing is passed that has no effect: to rows that are not open, to a table that does not learn.
  void ask(const Service& service, const Queries& one, float u, bool spare) const {
    using Ask = ServiceModel::Ask;
    const RowView row = service.look_up(ids_[one.slice], one.node / 2, one.node % 2);
    if (one.light > 0) service.credit(row, one.light);
    if (one.how == Ask::look || (spare && (row.state != RowState::open || !learns_))) return;
    const RowView flat;
    const RowView& proposal = one.how == Ask::score ? row : flat;
    const float x = proposal.sample(u, options_.uniform_share_open);
    const float g = row.nodes != nullptr ? row.nodes->density(x) : 0.3f;
    if (one.how == Ask::observe) return service.observe(row, x, g);
    service.score(row, x, g, proposal.proposal_density(x, options_.uniform_share_open));
  }

  Options options_;
  testing::MovingPeaks target_;
  Service service_, twin_;
  ServiceModel model_;
  std::vector<SliceId> ids_;
  bool learns_ = true;
};

RC_GTEST_PROP(Service, KeepsToTheRulesThatANaiveModelRestates, ()) {
  const Host host = *any_host();
  Options options;
  options.queries_before_creation = host.queries_before_creation;
  options.tests_before_refusal = host.tests_before_refusal;
  options.max_components = host.max_components;
  options.seed = host.seed;
  options.epsilon = host.epsilon;
  float turn = 0;
  auto session = std::make_unique<Session>(options, turn);
  session->add_slice(0);
  session->add_slice(1);
  for (std::size_t i = 0; i < host.passes.size(); ++i) {
    const Pass& pass = host.passes[i];
    session->run(pass, i);
    session->add_slice(2);
    switch (pass.then) {
      case Pass::Then::nothing:
        continue;
      case Pass::Then::learn:
      case Pass::Then::stop:
        session->set_learning(pass.then == Pass::Then::learn);
        continue;
      case Pass::Then::restart_on_another_target:
        turn += 0.2f;
        break;
      case Pass::Then::restart_at_another_epsilon:
        options.epsilon = options.epsilon < 0.01 ? 0.3 : options.epsilon * 0.1;
        break;
      case Pass::Then::restart:
        break;
    }
    const TableSnapshot saved = session->saved();
    session = std::make_unique<Session>(options, turn);
    // Before its slices are known or after: the third one comes from what was kept for it.
    if (i % 2 == 0) session->add_slice(0);
    if (i % 2 == 0) session->add_slice(1);
    session->load(saved);
    session->add_slice(0);
    session->add_slice(1);
    session->add_slice(2);
    // The same program on the same scene: nothing is lost or changed by the way through a file.
    if (pass.then == Pass::Then::restart) RC_ASSERT(encode_cache(session->saved()) == encode_cache(saved));
  }
}

// Of nodes that are all asked often enough, a ceiling lets in the first ones: by light, then queries, then key and
// node.
RC_GTEST_PROP(Service, CreatesRowsInTheOrderOfLightThenQueriesThenKey, ()) {
  const std::vector<std::uint32_t> drawn = *any_numbers(2 * host_slices * host_nodes + 1, 1000);
  const testing::MovingPeaks target;
  Options options;
  options.memory_bytes = 4000 + 60 * std::size_t{drawn.back()};  // from room for none to room for all
  Service service(options, target);
  struct Asked {
    float light;
    std::uint32_t queries;
    SliceKey key;
    std::uint32_t node;
    SliceId slice;
  };
  std::vector<Asked> all;
  for (std::uint32_t p = 0; p < host_slices; ++p) {
    SliceDescription slice = slice_of(p);
    slice.blur_rad = 0.3f;  // rows of one size
    const SliceId id = *service.add_slice(slice);
    for (std::uint32_t n = 0; n < host_nodes; ++n) {
      // Few values, so that there are ties.
      const float light = 0.25f * static_cast<float>(drawn[2 * all.size()] % 3);
      const std::uint32_t queries = options.queries_before_creation + drawn[2 * all.size() + 1] % 2;
      for (std::uint32_t i = 0; i < queries; ++i) service.look_up(id, n / 2, n % 2);
      if (light > 0) service.credit(service.peek(id, n / 2, n % 2), light);
      all.push_back({light, queries, slice.key, n, id});
    }
  }
  const PassReport report = service.publish();
  std::ranges::sort(all, [](const Asked& x, const Asked& y) {
    return std::tuple(-x.light, -static_cast<int>(x.queries), x.key, x.node) <
           std::tuple(-y.light, -static_cast<int>(y.queries), y.key, y.node);
  });
  RC_ASSERT(report.bytes <= options.memory_bytes);
  RC_ASSERT(report.at_ceiling == (report.creations < all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const RowView row = service.peek(all[i].slice, all[i].node / 2, all[i].node % 2);
    RC_ASSERT(row.state == (i < report.creations ? RowState::open : RowState::absent));
  }
  RC_TAG(report.at_ceiling ? "some" : "all");
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
