// Rows in the form that a host reads. The table makes them from its rows, keeps them, and drops them when the rows
// change.
//
//   struct Halved final : RowForm { ... };                                    // what a converged row becomes
//   const FormedRows* rows = *service.add_form(slice, std::make_shared<Halved>());
//   // any number of threads, during a pass:
//   AnswerReader reader(service);                                             // counts what it reads
//   RowAnswer answer = reader.read(rows->run(a), b);                          // an atomic load
//   if (!answer) { FormedLookup found = service.look_up(*rows, node); ... }   // made now, or open: found.row
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "tress/adaptive/row_view.h"

namespace tress::inline v0_2::adaptive {

class FormStore;
class Service;

/// Converts a converged row into the block that a host reads. Pure: the same row gives the same bytes on every thread.
/// Readers call it during a pass; any thread.
class RowForm {
 public:
  virtual ~RowForm() = default;
  /// The size of the block, > 0; it is rounded up to lines of 64 bytes.
  virtual std::size_t bytes(const RowView& row) const = 0;
  /// Fills the block. memory: aligned to 64 bytes, of bytes(row), not constructed. The object that is put there is
  /// never destroyed.
  virtual void write(const RowView& row, void* memory) const = 0;
  /// The block that answers a node for good instead of a row; such a node is never learned or counted. Null for a node
  /// that has a row. Aligned to 4 bytes; it lives as long as the form.
  virtual const void* instead_of_row(std::uint32_t /*node*/) const { return nullptr; }
};

/// The answer of a node in some form, a value of eight bytes. It converts to false if the node has no answer yet.
class RowAnswer {
 public:
  RowAnswer() = default;
  static RowAnswer of_row(const void* block, bool has_converged) {
    return RowAnswer(reinterpret_cast<std::uintptr_t>(block) | (has_converged ? 2 : 0));
  }
  /// Makes an answer without a row of the table.
  static RowAnswer without_row(const void* block) { return RowAnswer(reinterpret_cast<std::uintptr_t>(block) | 1); }
  explicit operator bool() const { return word_ != 0; }
  bool has_row() const { return (word_ & 1) == 0; }
  /// Whether that row has converged; false without one.
  bool has_converged() const { return (word_ & 3) == 2; }
  /// The block that RowForm wrote, or gave instead of a row.
  const void* block() const { return reinterpret_cast<const void*>(word_ & ~std::uintptr_t{3}); }

 private:
  friend class RowEntry;
  explicit RowAnswer(std::uintptr_t word) : word_(word) {}
  std::uintptr_t word_ = 0;
};

/// The place of an answer once it has been made.
class RowEntry {
 public:
  RowEntry() = default;
  explicit RowEntry(RowAnswer answer) : word_(answer.word_) {}
  void put(RowAnswer answer) { word_.store(answer.word_, std::memory_order_release); }
  /// Puts the answer unless there is one already. Returns the answer that is then there.
  RowAnswer put_first(RowAnswer answer) {
    std::uintptr_t seen = 0;
    const bool is_first =
        word_.compare_exchange_strong(seen, answer.word_, std::memory_order_acq_rel, std::memory_order_acquire);
    return is_first ? answer : RowAnswer(seen);
  }

 private:
  friend class AnswerReader;
  friend class FormStore;
  RowAnswer get() const { return RowAnswer(word_.load(std::memory_order_acquire)); }
  std::atomic<std::uintptr_t> word_{0};
};

/// The entries of the nodes (a, 0), (a, 1), ... of one slice in one form. Valid as long as the service.
struct RowRun {
  const RowEntry* entries = nullptr;
  SliceId slice = 0;
  std::uint32_t first_node = 0;  ///< (a, 0)
};

/// The rows of a slice in one form: a handle that the service owns. Reading it: any thread.
class FormedRows {
 public:
  /// a: an index into axis_a. Beyond its end, the run has no answers.
  RowRun run(std::uint32_t a) const { return {entries_ + (a < height_ ? a * stride_ : 0), slice_, a * width_}; }
  SliceId slice() const { return slice_; }
  std::uint32_t width() const { return width_; }  ///< number of nodes of axis_b
  const RowForm& form() const { return *form_; }
  FormedRows(const FormedRows&) = delete;
  FormedRows& operator=(const FormedRows&) = delete;

 private:
  friend class FormStore;
  FormedRows() = default;
  SliceId slice_ = 0;
  std::uint32_t index_ = 0;  ///< in its store
  std::uint32_t width_ = 0, height_ = 0;
  std::uint32_t stride_ = 0;  ///< width_, or 0 if there was no room for entries: all runs then share one empty entry
  RowEntry* entries_ = nullptr;
  std::shared_ptr<const RowForm> form_;
  std::unique_ptr<RowEntry[]> owned_;
};

/// The result of a look-up in a form: the answer of a converged row, or else the row itself, which is answered by g.
struct FormedLookup {
  RowAnswer answer;
  RowView row;  ///< observe, score and credit it in any state
  /// Set if the table had no room for the answer: its block then lives as long as this, and otherwise until publish().
  /// Whoever keeps the block must keep this too.
  std::shared_ptr<const void> kept;
};

/// Reads answers that have already been made. It counts the queries and adds them all at once when it is destroyed. One
/// thread; short-lived.
class AnswerReader {
 public:
  /// service: if null, nothing is counted.
  explicit AnswerReader(const Service* service) : service_(service) {}
  ~AnswerReader() {
    if (queries_ != 0) count();
  }
  AnswerReader(const AnswerReader&) = delete;
  AnswerReader& operator=(const AnswerReader&) = delete;

  /// b: an index into axis_b, in range.
  RowAnswer read(const RowRun& run, std::uint32_t b) {
    const RowAnswer answer = run.entries[b].get();
    queries_ += answer && answer.has_row() ? 1 : 0;
    converged_ += answer.has_converged() ? 1 : 0;
    return answer;
  }

 private:
  void count() const;
  const Service* service_;
  std::uint32_t queries_ = 0, converged_ = 0;
};

}  // namespace tress::inline v0_2::adaptive
