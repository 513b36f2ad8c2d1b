// What forms made of rows (row_form.h). The first thread that needs an answer makes it; it is dropped when its row
// changes.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "density/block_store.h"
#include "tress/adaptive/row_form.h"

namespace tress::inline v0_2::adaptive {

/// By node, while memory has no room for all that readers may make: what they have asked for since the last publish(),
/// and what they may make until the next.
class FormMarks {
 public:
  using Marks = std::unique_ptr<std::atomic<std::uint8_t>[]>;
  static constexpr std::uint8_t asked = 1, granted = 2;

  static Marks make(std::uint32_t nodes) { return std::make_unique<std::atomic<std::uint8_t>[]>(nodes); }
  /// Notes that a node was asked for. Returns whether it is granted. Any thread.
  static bool ask(const Marks& marks, std::uint32_t node) {
    const std::uint8_t now = marks[node].load(std::memory_order_relaxed);
    if ((now & asked) == 0) marks[node].fetch_or(asked, std::memory_order_relaxed);
    return (now & granted) != 0;
  }
  static bool has(const Marks& marks, std::uint32_t node, std::uint8_t mark) {
    return marks != nullptr && (marks[node].load(std::memory_order_relaxed) & mark) != 0;
  }
};

/// find(), make() and ask(): any thread. All others: one thread, while there is no reader.
class FormStore {
 public:
  /// bytes: the memory of all entries and answers is added to it. It must outlive the store.
  explicit FormStore(std::atomic<std::size_t>& bytes) : bytes_(bytes) {}

  /// Registers a form of the rows of a slice. The handle lives as long as the store. has_entries: whether there is room
  /// for entries; without them nothing is made. shows: whether runs have the answers.
  const FormedRows* add(SliceId slice, const SliceDescription& description, std::shared_ptr<const RowForm> form,
                        bool has_entries, bool shows);
  std::size_t size() const { return forms_.size(); }
  const FormedRows& rows(std::size_t form) const { return *forms_[form].rows; }
  /// Whether the handle is of this store.
  bool has(const FormedRows& rows) const {
    return rows.index_ < forms_.size() && forms_[rows.index_].rows.get() == &rows;
  }
  static bool has_entries(const FormedRows& rows) { return rows.entries_ != nullptr; }
  std::size_t entry_bytes() const { return entry_bytes_; }
  /// The bytes that the answer of a row takes.
  static std::size_t bytes_of(const FormedRows& rows, const RowView& row) {
    return decltype(blocks_)::rounded(rows.form_->bytes(row));
  }

  /// The answer that was made of a node and does not rest, or that the form has in place of its row; else empty.
  RowAnswer find(const FormedRows& rows, std::uint32_t node) const;
  /// The answer of a node that rests, which is then found again; else empty.
  RowAnswer wake(const FormedRows& rows, std::uint32_t node) const;
  /// Makes the answer of a row, and keeps it. Precondition: it has entries.
  RowAnswer make(const FormedRows& rows, const RowView& row);
  /// Notes that the form of a node was asked for; whether it may be made.
  bool ask(const FormedRows& rows, std::uint32_t node) const {
    return rows.marks_ == nullptr || FormMarks::ask(rows.marks_, node);
  }
  /// Whether the form of a node was asked for since the last mark_all(); before the first, whether it was made.
  bool was_asked(const FormedRows& rows, std::uint32_t node) const {
    return rows.marks_ == nullptr ? static_cast<bool>(rows.entries_[node].get())
                                  : FormMarks::has(rows.marks_, node, FormMarks::asked);
  }
  bool is_granted(const FormedRows& rows, std::uint32_t node) const {
    return FormMarks::has(rows.marks_, node, FormMarks::granted);
  }

  /// Lets readers make no more than the nodes that grant() names afterwards. Drops nothing.
  void mark_all();
  /// Whether readers may make no more than what is granted.
  bool is_marked() const { return is_marked_; }
  void grant(const FormedRows& rows, std::uint32_t node) {
    rows.marks_[node].store(FormMarks::granted, std::memory_order_relaxed);
  }
  /// Lets readers make all again, and wakes what rests.
  void free_all();
  /// Drops what is not granted. The rest is not found until it is asked for, so that marks show what is in use.
  void rest_all();

  /// The nodes whose answers a form (a number below size()) keeps, in ascending order.
  std::vector<std::uint32_t> made_nodes(std::size_t form) const;
  /// Drops the answers of a form for which `goes(node)` holds.
  template <class Goes>
  void drop_if(std::size_t form, const Goes& goes) {
    for (std::vector<Made>* kept : {&forms_[form].made, &forms_[form].resting}) {
      std::erase_if(*kept, [&](const Made& one) {
        if (!goes(one.node)) return false;
        forms_[form].rows->entries_[one.node].put({});
        blocks_.give_back(one.block, one.bytes);
        bytes_ -= one.bytes;
        return true;
      });
    }
  }
  void drop(std::size_t form) {
    drop_if(form, [](std::uint32_t) { return true; });
  }

 private:
  struct Made {
    void* block;
    std::size_t bytes;
    std::uint32_t node;
    bool has_converged;
    RowAnswer answer() const { return RowAnswer::of_row(block, has_converged); }
  };
  struct Form {
    std::unique_ptr<FormedRows> rows;
    std::vector<Made> made;     ///< since the last rest_all()
    std::vector<Made> resting;  ///< before, by node
  };

  std::atomic<std::size_t>& bytes_;
  std::size_t entry_bytes_ = 0;
  bool is_marked_ = false;
  std::vector<Form> forms_;
  static constexpr std::size_t line_bytes = 64;
  BlockStore<line_bytes, 512> blocks_;
  std::mutex mutex_;  ///< guards Form::made against readers
};

}  // namespace tress::inline v0_2::adaptive
