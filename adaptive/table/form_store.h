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

/// find() and make(): any thread. All others: one thread, while there is no reader.
class FormStore {
 public:
  /// bytes: the memory of all answers is added to it. It must outlive the store.
  explicit FormStore(std::atomic<std::size_t>& bytes) : bytes_(bytes) {}

  /// Registers a form of the rows of a slice. Without entries no answer is kept, and runs have none. The handle lives
  /// as long as the store.
  const FormedRows* add(SliceId slice, const SliceDescription& description, std::shared_ptr<const RowForm> form,
                        bool has_entries);
  std::size_t size() const { return forms_.size(); }
  const FormedRows& rows(std::size_t form) const { return *forms_[form].rows; }
  /// Whether the handle is of this store.
  bool has(const FormedRows& rows) const {
    return rows.index_ < forms_.size() && forms_[rows.index_].rows.get() == &rows;
  }
  static bool has_entries(const FormedRows& rows) { return rows.stride_ != 0; }

  /// The answer that was made of a node, or that the form has in place of its row; else empty.
  RowAnswer find(const FormedRows& rows, std::uint32_t node) const;
  /// Makes the answer of a row. It is kept if all bytes are then at most `room`; otherwise FormedLookup::kept owns it.
  FormedLookup make(const FormedRows& rows, const RowView& row, std::size_t room);

  /// The nodes whose answers a form (a number below size()) keeps, in ascending order.
  std::vector<std::uint32_t> made_nodes(std::size_t form) const;
  /// Drops the answers of a form for which `goes(node)` holds.
  template <class Goes>
  void drop_if(std::size_t form, const Goes& goes) {
    std::erase_if(forms_[form].made, [&](const Made& one) {
      if (!goes(one.node)) return false;
      forms_[form].rows->entries_[one.node].put({});
      blocks_.give_back(one.block, one.bytes);
      bytes_ -= one.bytes;
      return true;
    });
  }
  void drop(std::size_t form) {
    drop_if(form, [](std::uint32_t) { return true; });
  }

 private:
  struct Made {
    void* block;
    std::size_t bytes;
    std::uint32_t node;
  };
  struct Form {
    std::unique_ptr<FormedRows> rows;
    std::vector<Made> made;
  };

  std::atomic<std::size_t>& bytes_;
  std::vector<Form> forms_;
  static constexpr std::size_t line_bytes = 64;
  BlockStore<line_bytes, 512> blocks_;
  std::mutex mutex_;  ///< guards Form::made against readers
};

}  // namespace tress::inline v0_2::adaptive
