// The table as plain data and back: pages, load and snapshot.
#include <algorithm>
#include <cassert>
#include <string>

#include "table/table.h"

namespace tress::adaptive {
namespace {

constexpr std::size_t least_index_bytes = std::size_t{16} << 20;

bool same_axes(const PageDescription& a, const PageDescription& b) {
  return a.axis_a == b.axis_a && a.axis_b == b.axis_b && a.blur_rad == b.blur_rad;
}

std::string describe(const PageDescription& page) {
  std::string text = "page of lobe " + std::to_string(page.key.lobe);
  for (const float parameter : page.key.parameters) text += ", " + std::to_string(parameter);
  return text;
}

std::string describe_axes(const PageDescription& page) {
  return std::to_string(page.axis_a.size()) + " x " + std::to_string(page.axis_b.size()) + " nodes, blur " +
         std::to_string(page.blur_rad) + " rad";
}

Error other_axes(const PageDescription& own, const PageDescription& cached) {
  return {"", describe(own), describe_axes(own), describe_axes(cached) + " (or other coordinates of as many)"};
}

void keep_dormant(Page& page, CachedPage&& cached) {
  for (CachedRow& row : cached.rows) {
    const bool has_row =
        page.has_index() && row.node < page.description.node_count() && page.slots[row.node].row != Slot::no_row;
    if (row.node < page.description.node_count() && !has_row) {
      page.dormant.insert_or_assign(row.node, std::move(row));
    }
  }
}

CachedRow cached_form(const Row& row, const Slot& slot) {
  if (row.learning && row.learning->earlier) return *row.learning->earlier;
  CachedRow cached;
  cached.node = row.node;
  cached.generation = row.generation;
  cached.energy = row.energy;
  cached.count = row.taught();
  if (row.learning) {
    cached.sketch = row.learning->sketch.bins();
    return cached;
  }
  cached.state = RowState::converged;
  if (const KnotRow* knots = slot.knots()) {
    cached.knots = knots->table;
    cached.objective = knots->objective;
  } else {
    cached.fit = *slot.mixture();
    cached.objective = slot.mixture()->objective;
  }
  return cached;
}

}  // namespace

PageId Service::Table::add_page(const PageDescription& description) {
  assert(description.node_count() > 0);
  if (const auto found = page_of_key_.find(description.key); found != page_of_key_.end()) {
    assert(same_axes(pages_[found->second]->description, description));
    return found->second;
  }
  const auto id = static_cast<PageId>(pages_.size());
  const std::size_t index = Page::index_bytes(description);
  const bool has_index = index_bytes_ + index <= std::max(options_.memory_bytes, least_index_bytes);
  if (has_index) index_bytes_ += index;
  pages_.push_back(std::make_unique<Page>(description, has_index));
  page_of_key_.emplace(description.key, id);
  if (const auto cached = unused_.find(description.key); cached != unused_.end()) {
    // A page on other axes cannot be used, nor saved beside this one.
    if (same_axes(cached->second.description, description)) {
      keep_dormant(*pages_.back(), std::move(cached->second));
      wake({id});
    } else {
      refusals_.push_back(other_axes(description, cached->second.description));
    }
    unused_.erase(cached);
  }
  return id;
}

void Service::Table::wake(const std::vector<PageId>& pages) {
  std::vector<Candidate> candidates;
  for (const PageId p : pages) {
    if (!pages_[p]->has_index()) continue;
    for (const auto& [node, cached] : pages_[p]->dormant) {
      // What a coarse row is good for is not known before the light of its node is.
      if (is_light_driven() && !answers(p, cached)) continue;
      candidates.push_back({p, node, pages_[p]->slots[node].touches.load(std::memory_order_relaxed), 0, nullptr});
    }
  }
  std::ranges::sort(candidates, [&](const Candidate& x, const Candidate& y) {
    const bool x_open = needs_nodes(x), y_open = needs_nodes(y);
    if (x_open != y_open) return y_open;
    const auto order = compare_keys(pages_[x.page]->description.key, pages_[y.page]->description.key);
    return order != 0 ? order < 0 : x.node < y.node;
  });
  PassReport woken;
  admit(candidates, woken);
  between_passes_.g_evaluations += woken.g_evaluations;
  between_passes_.refits += woken.refits;
  between_passes_.bad_fits += woken.bad_fits;
  between_passes_.traces += woken.traces;
  std::ranges::sort(changes_, [](const RowChange& x, const RowChange& y) {
    return x.page != y.page ? x.page < y.page : x.node < y.node;
  });
}

std::optional<Error> Service::Table::load(TableImage image) {
  if (image.model != target_.model_name()) {
    return Error{"", "model", target_.model_name(), image.model};
  }
  for (const CachedPage& cached : image.pages) {
    const auto found = page_of_key_.find(cached.description.key);
    if (found == page_of_key_.end()) continue;
    const PageDescription& own = pages_[found->second]->description;
    if (!same_axes(own, cached.description)) return other_axes(own, cached.description);
  }
  changes_.clear();
  std::vector<PageId> used;
  for (CachedPage& cached : image.pages) {
    const auto found = page_of_key_.find(cached.description.key);
    if (found == page_of_key_.end()) {
      unused_.insert_or_assign(cached.description.key, std::move(cached));
      continue;
    }
    keep_dormant(*pages_[found->second], std::move(cached));
    used.push_back(found->second);
  }
  wake(used);
  return std::nullopt;
}

TableImage Service::Table::snapshot() const {
  std::map<PageKey, CachedPage, KeyLess> all = unused_;
  for (const auto& [key, id] : page_of_key_) {
    const Page& page = *pages_[id];
    CachedPage cached{page.description, {}};
    if (!page.has_index()) {
      for (const auto& [node, row] : page.dormant) cached.rows.push_back(row);
    }
    for (std::uint32_t n = 0; page.has_index() && n < page.description.node_count(); ++n) {
      if (page.slots[n].row != Slot::no_row) {
        cached.rows.push_back(cached_form(rows_[page.slots[n].row], page.slots[n]));
      } else if (const auto dormant = page.dormant.find(n); dormant != page.dormant.end()) {
        cached.rows.push_back(dormant->second);
      }
    }
    // A page without rows says nothing: the next session describes it anew.
    if (!cached.rows.empty()) all.insert_or_assign(key, std::move(cached));
  }
  TableImage image;
  image.model = target_.model_name();
  for (auto& [key, page] : all) image.pages.push_back(std::move(page));
  return image;
}

}  // namespace tress::adaptive
