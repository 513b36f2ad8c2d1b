// A service, asked by any number of threads in any order, is what a naive model says at every pass end: states, counts,
// published fits and the saved table, to the bit, through restarts on other targets and at other epsilons.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "adaptive/toy_target.h"
#include "properties/commands.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"

namespace tress::adaptive {
namespace {

/// The peaks of MovingPeaks, all of them turned: another target under the same name, as a changed tracer would be.
class TurnedPeaks final : public Target {
 public:
  explicit TurnedPeaks(float turn) : turn_(turn) {}
  void trace(const SliceDescription& slice, float a, float b, std::vector<TracedRay>& out) const override {
    peaks_.trace(slice, a, b, out);
    for (TracedRay& ray : out) ray.azimuth += turn_;
  }
  std::string model_name() const override { return peaks_.model_name(); }

 private:
  testing::MovingPeaks peaks_;
  float turn_;
};

/// Keys of either sign, known in an order of their own; the last slice is added after the first pass.
SliceDescription slice_of(std::uint32_t index) {
  SliceDescription slice = testing::toy_slice(index, 2, index == 1 ? 0.1f : 0.3f);
  slice.key.parameters[0] = index == 0 ? 0.5f : index == 1 ? -0.25f : -1.0f;
  return slice;
}

/// A service and its model, told the same.
class Session {
 public:
  Session(const Options& options, float turn)
      : options_(options), target_(turn), service_(options, target_), model_(options, target_) {}

  void add_slice(std::uint32_t index) {
    if (ids_.size() > index) return;
    ids_.push_back(service_.add_slice(slice_of(index)));
    model_.add_slice(slice_of(index));
  }

  void load(const TableSnapshot& image) {
    RC_ASSERT(!service_.load(image));
    model_.load(image);
    expect_agreement();
  }

  void set_learning(bool on) {
    service_.set_learning(on);
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
        model_.ask(queries.slice, queries.node, queries.how, all.back().u);
        if (queries.light > 0) model_.carry(queries.slice, queries.node, queries.light);
      }
    }
    RandomStream random(number, pass.threads);
    for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[random.next_bits() % i]);
    const auto work = [&](std::size_t first) {
      for (std::size_t i = first; i < all.size(); i += pass.threads) ask(all[i].of, all[i].u);
    };
    std::vector<std::thread> threads;
    for (std::size_t t = 1; t < pass.threads; ++t) threads.emplace_back(work, t);
    work(0);
    for (std::thread& thread : threads) thread.join();
    expect_same(service_.publish(), model_.publish());
    expect_agreement();
  }

  /// What the session saves, checked against the model's.
  TableSnapshot saved() const {
    const std::string bytes = encode_cache(service_.snapshot());
    RC_ASSERT(bytes == encode_cache(model_.snapshot()));
    Result<TableSnapshot> read = decode_cache(bytes, target_.model_name(), "saved");
    RC_ASSERT(read.has_value());
    return std::move(*read);
  }

 private:
  void ask(const Queries& one, float u) const {
    using Ask = ServiceModel::Ask;
    const RowView row = service_.look_up(ids_[one.slice], one.node / 2, one.node % 2);
    if (one.light > 0) service_.carry(ids_[one.slice], one.node, one.light);
    if (one.how == Ask::look || row.state != RowState::open) return;
    const RowView flat;
    const RowView& proposal = one.how == Ask::score ? row : flat;
    const float x = proposal.sample(u, options_.uniform_share_open), g = row.nodes->density(x);
    if (one.how == Ask::observe) return service_.observe(row, x, g);
    service_.score(row, x, g, proposal.proposal_density(x, options_.uniform_share_open));
  }

  static void expect_same(const PassReport& got, const PassReport& wanted) {
    RC_ASSERT(got.queries == wanted.queries);
    RC_ASSERT(got.converged_queries == wanted.converged_queries);
    RC_ASSERT(got.g_evaluations == wanted.g_evaluations);
    RC_ASSERT(got.traces == wanted.traces);
    RC_ASSERT(got.refits == wanted.refits);
    RC_ASSERT(got.creations == wanted.creations);
    RC_ASSERT(got.newly_converged == wanted.newly_converged);
    RC_ASSERT(got.validation_draws == wanted.validation_draws);
    RC_ASSERT(got.rows_queried == wanted.rows_queried);
    RC_ASSERT(got.rows_open == wanted.rows_open);
    RC_ASSERT(got.rows_converged == wanted.rows_converged);
    RC_ASSERT(got.rows_reopened == wanted.rows_reopened);
    RC_ASSERT(got.rows_refused == wanted.rows_refused);
    RC_ASSERT(got.components == wanted.components);
    RC_ASSERT(got.objective_max == wanted.objective_max);
    RC_ASSERT(!got.at_ceiling);
  }

  static bool same_bits(const Mixture& a, const Mixture& b) {
    const auto bytes = [](const Mixture& fit) {
      CachedRow row;
      row.state = RowState::converged;
      row.fit = fit;
      return encode_cache({"a", {{slice_of(0), {row}}}});
    };
    return bytes(a) == bytes(b);
  }

  void expect_agreement() const {
    std::vector<ServiceModel::Change> changes;
    for (const Service::RowChange& change : service_.last_changes()) {
      changes.emplace_back(change.slice, change.node, change.state);
    }
    RC_ASSERT(changes == model_.changes());
    for (std::size_t p = 0; p < ids_.size(); ++p) {
      for (std::uint32_t n = 0; n < host_nodes; ++n) {
        const RowView row = service_.peek(ids_[p], n / 2, n % 2);
        RC_ASSERT(row.state == model_.state(p, n));
        RC_ASSERT(row.objective == model_.objective(p, n));
        const std::optional<Mixture> fit = model_.published(p, n);
        RC_ASSERT((row.fit != nullptr) == fit.has_value());
        if (fit) RC_ASSERT(same_bits(*row.fit, *fit));
      }
    }
    saved();
  }

  Options options_;
  TurnedPeaks target_;
  Service service_;
  ServiceModel model_;
  std::vector<SliceId> ids_;
};

RC_GTEST_PROP(Service, AgreesWithANaiveModel, ()) {
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

}  // namespace
}  // namespace tress::adaptive
