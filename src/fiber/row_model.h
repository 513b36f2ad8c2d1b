// The common part of models with rows: access to rows that always counts and credits them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <string>

#include "base/color.h"
#include "fiber/event_constants.h"
#include "tress/adaptive/service.h"
#include "tress/fiber/fiber_model.h"

namespace tress::inline v0_2::fiber {

/// Returns the error if a model cannot use this service; empty if it can.
std::optional<Error> wrong_service(const adaptive::Service* service, const std::string& target,
                                   adaptive::SliceKind kind);

/// The rows that one direction looks up. A model has no other access to its rows. Look-ups are recorded, and once the
/// direction is drawn each row is credited with the light that it brings (ESTIMATOR.md, E8):
///  importance of the event * S/Q,  S the luminance of the row's lobe.
/// Rows that answer in a form are credited at one event in light_interval, with light_interval times the light; all
/// other rows at every event.
class DirectionRows {
 public:
  /// Serves a direction that is given, not drawn. At most of these M is negligible, so nothing is credited.
  explicit DirectionRows(const adaptive::Service* service) : service_(service), reader_(service) {}
  /// Serves a direction that the event draws. service: null if there are no rows.
  DirectionRows(const adaptive::Service* service, const FiberEvent& event)
      : service_(service),
        reader_(service),
        importance_(event.importance),
        records_formed_(event.importance > 0 && static_cast<std::uint32_t>(event.xi1 * 0x1p24f) % light_interval == 0) {
  }

  /// Gets the existing answers at node b of each run; null if a node has no answer yet. Returns true if all exist.
  /// `Row` is the type that the form writes. lobes: those of the runs.
  template <class Row, std::size_t n>
  bool read(const std::array<adaptive::RowRun, n>& runs, const std::array<Lobe, n>& lobes, std::uint32_t b,
            std::array<const Row*, n>& rows) {
    bool all = true;
    for (std::size_t i = 0; i < n; ++i) {
      const adaptive::RowAnswer answer = reader_.read(runs[i], b);
      rows[i] = static_cast<const Row*>(answer.block());
      all = all && answer;
      if (records_formed_ && answer && answer.has_row()) [[unlikely]]
        write_down(runs[i].slice, runs[i].first_node + b, 0, lobes[i], light_interval);
    }
    return all;
  }
  /// The same for one node; its answer is made now if its row has converged, and is null if it has not.
  adaptive::FormedLookup fetch(const adaptive::FormedRows& rows, std::uint32_t node, Lobe lobe) {
    adaptive::FormedLookup found = service_->fetch(rows, node);
    if (records_formed_ && found.answer && found.answer.has_row())
      write_down(found.row.slice, found.row.node, found.row.pass, lobe, light_interval);
    return found;
  }
  /// The row at a node, in any state.
  adaptive::FormedLookup ask(const adaptive::FormedRows& rows, std::uint32_t node, Lobe lobe) {
    adaptive::FormedLookup found = service_->look_up(rows, node);
    if (importance_ > 0 && !(found.answer && !found.answer.has_row()))
      write_down(found.row.slice, found.row.node, found.row.pass, lobe, 1);
    return found;
  }
  adaptive::RowView ask(adaptive::SliceId slice, std::uint32_t a, std::uint32_t b, Lobe lobe) {
    const adaptive::RowView row = service_->look_up(slice, a, b);
    if (importance_ > 0) write_down(row.slice, row.node, row.pass, lobe, 1);
    return row;
  }
  /// Sets S of a row that was looked up here, if it is not the whole S of its lobe.
  void set_part(const adaptive::RowView& row, const glm::vec3& s) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (asked_[i].slice == row.slice && asked_[i].node == row.node) asked_[i].part = luminance(s);
    }
  }

 private:
  friend class RowModel;
  static constexpr std::uint32_t light_interval = 16;  ///< decided by bits of xi1 that choose no node
  static constexpr std::size_t most = 8;

  struct Asked {
    adaptive::SliceId slice;
    std::uint32_t node, pass;
    Lobe lobe;
    std::uint32_t times;
    float part;  ///< negative: use the lobe's S
  };
  void write_down(adaptive::SliceId slice, std::uint32_t node, std::uint32_t pass, Lobe lobe, std::uint32_t times) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (asked_[i].slice == slice && asked_[i].node == node) return;  // looked up to draw, and again to evaluate
    }
    if (count_ < most) asked_[count_++] = {slice, node, pass, lobe, times, -1};
  }
  /// value: at the direction that was drawn.
  void credit(const FiberValue& value) const {
    if (count_ != 0) [[unlikely]]
      credit_all(value);
  }
  void credit_all(const FiberValue& value) const;

  const adaptive::Service* service_;
  adaptive::AnswerReader reader_;
  float importance_ = 0;
  bool records_formed_ = false;
  std::size_t count_ = 0;
  std::array<Asked, most> asked_;  ///< the first count_ are used
};

/// A model with rows. It draws and evaluates through DirectionRows, so that every look-up is counted and all light is
/// credited.
class RowModel : public FiberModel {
 public:
  /// service null: the model answers without rows.
  explicit RowModel(adaptive::Service* service) : service_(service) {}
  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const final {
    DirectionRows rows(service_, event);
    FiberSample drawn = draw(event, u, rows);
    rows.credit(drawn.value);
    return drawn;
  }
  FiberValue evaluate_event(const FiberEvent& event, const FiberDirection& wi) const final {
    DirectionRows rows(service_);
    return value(event, wi, rows);
  }

 protected:
  adaptive::Service* service_;

 private:
  /// These do the same as sample() and evaluate().
  virtual FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u, DirectionRows& rows) const = 0;
  virtual FiberValue value(const FiberEvent& event, const FiberDirection& wi, DirectionRows& rows) const = 0;
};

/// The one row that an event looks up when it begins, for all its directions. It is the first member of the constants
/// of an EventRowModel.
struct EventRow {
  const adaptive::FormedRows* formed = nullptr;  ///< null if no row was looked up
  const void* block = nullptr;                   ///< from the form; null if not converged, or for lack of memory
  std::uint32_t node = 0, pass = 0;
  bool has_converged = false;
  std::uint8_t times = 0;  ///< how often the light of a direction is credited, see RowOfEvent
};

/// The access of an EventRowModel to its row, once per event. A converged row is credited at one event in
/// light_interval, with light_interval times the light.
class RowOfEvent {
 public:
  /// Counts a query. The result is the same whether another thread has looked up the row before or not.
  const EventRow& ask(const adaptive::FormedRows& rows, std::uint32_t node) {
    adaptive::RowAnswer answer;
    {
      adaptive::AnswerReader reader(service_);
      answer = reader.read(rows.run(node / rows.width()), node % rows.width());
    }
    if (answer) {
      row_ = {&rows, answer.block(), node, 0, true, records_formed_ ? light_interval : std::uint8_t{0}};
      return row_;
    }
    const adaptive::FormedLookup found = service_->look_up(rows, node);
    const bool has_converged = static_cast<bool>(found.answer), is_kept = has_converged && !found.kept;
    row_ = {&rows,         is_kept ? found.answer.block() : nullptr,
            node,          found.row.pass,
            has_converged, has_converged ? (records_formed_ ? light_interval : std::uint8_t{0}) : std::uint8_t{1}};
    return row_;
  }

 private:
  friend class EventRowModel;
  static constexpr std::uint8_t light_interval = 16;  ///< decided by bits of xi1 that choose no node
  RowOfEvent(const adaptive::Service* service, float xi1)
      : service_(service), records_formed_(static_cast<std::uint32_t>(xi1 * 0x1p24f) % light_interval == 0) {}

  const adaptive::Service* service_;
  bool records_formed_;
  EventRow row_;
};

/// A model whose events look up one row each. Every look-up is counted, and each direction that is drawn credits the
/// row with all of its light, importance * S/Q, S the luminance of all lobes.
class EventRowModel : public FiberModel {
 public:
  /// service null: the model answers without rows.
  explicit EventRowModel(adaptive::Service* service) : service_(service) {}
  FiberSample sample_event(const FiberEvent& event, const std::array<float, 4>& u) const final {
    FiberSample drawn = draw(event, u);
    const EventRow& row = constants_in<EventRow>(event);
    if (row.times != 0 && event.importance > 0) [[unlikely]]
      credit(row, event.importance * luminance(drawn.value.total()) / drawn.value.pdf);
    return drawn;
  }

 protected:
  /// What an event traces from h: nothing (begin()), directions that it draws (begin_drawn_near()), or all that it is
  /// asked (begin_near()).
  enum class Traced { nothing, drawn, all };

  /// Makes the form's block for a converged row whose block is not kept (EventRow::block), without counting a query.
  /// Valid until this thread's next call.
  const void* made_anew(const EventRow& row) const;

  adaptive::Service* service_;

 private:
  FiberEvent make_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const final {
    return with_row(fiber, wr, xi1, xi2, h, Traced::nothing);
  }
  FiberEvent make_drawn_near_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const final {
    return with_row(fiber, wr, xi1, xi2, h, Traced::drawn);
  }
  FiberEvent make_near_event(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h) const final {
    FiberEvent event = start(fiber, wr, xi1, xi2, h, Traced::all, nullptr);
    new (place_of<EventRow>(event)) EventRow();
    return event;
  }
  FiberEvent with_row(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h, Traced traced) const {
    RowOfEvent row(service_, xi1);
    FiberEvent event = start(fiber, wr, xi1, xi2, h, traced, &row);
    new (place_of<EventRow>(event)) EventRow(row.row_);
    return event;
  }
  void credit(const EventRow& row, float light) const;

  /// Makes the event, with constants that begin with an EventRow, which is filled in afterwards. row: null if no row
  /// may be looked up (Traced::all).
  virtual FiberEvent start(FiberId fiber, const FiberDirection& wr, float xi1, float xi2, float h, Traced traced,
                           RowOfEvent* row) const = 0;
  /// Does the same as sample().
  virtual FiberSample draw(const FiberEvent& event, const std::array<float, 4>& u) const = 0;
};

}  // namespace tress::inline v0_2::fiber
