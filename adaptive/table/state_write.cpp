// Writes a whole table as bytes, in the order that state.h describes.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cache/format.h"
#include "table/cached_form.h"
#include "table/state.h"
#include "table/table.h"

namespace tress::adaptive {
namespace {

using namespace state_format;

std::string described(const SliceDescription& slice) {
  ByteWriter out;
  format::write_description(out, slice, format::version_of_samples);
  return out.take();
}

class CacheBytes final : public format::ByteSink {
 public:
  bool append(std::string_view bytes) override {
    text.append(bytes);
    return true;
  }
  std::string text;
};

void write_fit(ByteWriter& out, const Mixture& fit) {
  out.u32(fit.component_count);
  for (const float value : {fit.uniform_weight, fit.uniform_attribute_mean, fit.uniform_attribute_variance})
    write_bits(out, value);
  for (const Component& part : fit.parts()) {
    for (const float value : {part.shape.mu, part.shape.s_left, part.shape.s_right, part.weight, part.attribute_mean,
                              part.attribute_variance})
      write_bits(out, value);
  }
}

template <std::size_t N>
void write_words(ByteWriter& out, const std::array<std::uint64_t, N>& words) {
  for (const std::uint64_t word : words) out.u64(word);
}

void write_stop(ByteWriter& out, const StopTest::State& stop) {
  write_words(out, stop.scores);
  out.u8(static_cast<std::uint8_t>(stop.verdict));
  write_bits(out, stop.bound);
  write_bits(out, stop.largest_passed);
  out.u32(stop.passed);
  out.u32(stop.failed);
  out.u8(stop.last_failed ? 1 : 0);
  out.u8(stop.overruled ? 1 : 0);
}

void write_heard(ByteWriter& out, const Slice& slice) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t n = 0; n < slice.description.node_count(); ++n) {
    if (!slice.heard.at(n).empty()) nodes.push_back(n);
  }
  out.u64(slice.heard.paths());
  out.u32(static_cast<std::uint32_t>(nodes.size()));
  for (const std::uint32_t node : nodes) {
    const std::span<const SampledExit> exits = slice.heard.at(node);
    out.u32(node);
    out.u32(static_cast<std::uint32_t>(exits.size()));
    for (const SampledExit& exit : exits) {
      for (const float number : {exit.azimuth, exit.height, exit.weight, exit.attribute}) write_bits(out, number);
      out.u8(static_cast<std::uint8_t>(exit.part));
    }
  }
}

/// False if the state of the learner cannot be saved.
bool write_learning(ByteWriter& out, const Learning& learning) {
  const std::optional<std::vector<std::uint64_t>> learner = learning.learner->state();
  if (!learner) return false;
  const std::vector<SketchBin> bins = learning.sketch.bins();
  out.u32(static_cast<std::uint32_t>(bins.size()));
  for (const SketchBin& bin : bins) {
    out.u32(bin.index);
    out.u64(bin.bits);
  }
  out.u32(static_cast<std::uint32_t>(learner->size()));
  for (const std::uint64_t word : *learner) out.u64(word);
  write_stop(out, learning.stop.state());
  out.u8(learning.has_fit ? 1 : 0);
  write_fit(out, learning.fit);
  write_bits(out, learning.objective);
  out.u64(learning.count);
  out.u8(learning.published != nullptr ? 1 : 0);
  out.u8(learning.earlier ? 1 : 0);
  out.u32(learning.created_pass);
  out.u32(learning.queries_at_creation);
  out.u64(learning.observed.load(std::memory_order_relaxed));
  write_words(out, learning.weights.words());
  return true;
}

}  // namespace

Result<std::string> Service::Table::state() const {
  if (pass_ == 0) return Error{"", "state", "a pass that was published", "none"};
  ByteWriter out;
  out.u32(state_version);
  write_text(out, model_name());
  write_text(out, options_.learner->name);
  write_totals(out);
  out.u32(static_cast<std::uint32_t>(slices_.size()));
  for (const std::unique_ptr<Slice>& slice : slices_) write_slice(out, *slice);
  out.u32(static_cast<std::uint32_t>(unused_.size()));
  for (const auto& [key, unused] : unused_) {
    PackedSliceRows rows(unused, model_name());
    CacheBytes bytes;
    if (!format::write_cache(rows, bytes)) return Error{"", "state", "rows of a cache that can be read back", "others"};
    write_text(out, bytes.text);
  }
  out.u32(static_cast<std::uint32_t>(rows_.size()));
  for (const Row& row : rows_) {
    if (!write_row(out, row))
      return Error{"", "learner", "one whose rows can be saved as they are", options_.learner->name};
  }
  return out.take();
}

void Service::Table::write_totals(ByteWriter& out) const {
  out.u32(pass_);
  for (const std::uint64_t total : {light_.paths, reopened_, reopened_told_, light_.queried}) out.u64(total);
  out.u8(ceiling_told_ ? 1 : 0);
  out.u8(unusable_told_ ? 1 : 0);
  out.u32(static_cast<std::uint32_t>(absorbed_errors_.counts().size()));
  for (const auto& [bits, count] : absorbed_errors_.counts()) {
    out.u32(bits);
    out.u64(count);
  }
}

void Service::Table::write_slice(ByteWriter& out, const Slice& slice) const {
  write_text(out, described(slice.description));
  out.u8(slice.has_index() ? 1 : 0);
  out.u8(slice.audited ? 1 : 0);
  ByteWriter nodes;
  std::uint32_t asked = 0;
  PackedSlice answers(slice.description), stored(slice.description), earlier(slice.description);
  for (const auto& [node, row] : slice.stored) stored.add(row);
  for (std::uint32_t n = 0; slice.has_index() && n < slice.description.node_count(); ++n) {
    const Slot& slot = slice.slots[n];
    const std::uint32_t queries = slot.queries.load(std::memory_order_relaxed);
    const std::uint64_t light = slice.light_at(n);
    const std::uint32_t events = slice.events[n].load(std::memory_order_relaxed);
    if (queries != 0 || light != 0 || events != 0) {
      ++asked;
      nodes.u32(n);
      nodes.u32(queries);
      nodes.u32(events);
      nodes.u64(light);
    }
    if (slot.row == Slot::no_row) continue;
    const Row& row = rows_[slot.row];
    if (slot.has_answer()) {
      answers.add(cached_form(row, slot));
    } else if (const CachedRow* kept = earlier_of(row); kept != nullptr) {
      earlier.add(*kept);
    }
  }
  out.u32(asked);
  out.text(nodes.bytes());
  for (const PackedSlice* rows : {&answers, &stored, &earlier}) rows->write(out);
  std::vector<std::uint32_t> interpolated = slice.interpolated;
  std::ranges::sort(interpolated);  // so that the bytes do not depend on the order of threads
  out.u32(static_cast<std::uint32_t>(interpolated.size()));
  for (const std::uint32_t node : interpolated) out.u32(node);
  write_heard(out, slice);
  out.u32(static_cast<std::uint32_t>(slice.forms.size()));
  for (const std::uint32_t form : slice.forms) {
    const std::vector<std::uint32_t> made = forms_.made_nodes(form);
    out.u32(static_cast<std::uint32_t>(made.size()));
    for (const std::uint32_t node : made) out.u32(node);
  }
}

bool Service::Table::write_row(ByteWriter& out, const Row& row) const {
  const Slot& slot = slot_of(row);
  const Kind kind = row.learning ? Kind::learning : slot.is_refused() ? Kind::refusal : Kind::answer;
  out.u32(row.slice);
  out.u32(row.node);
  out.u8(static_cast<std::uint8_t>(kind));
  out.u8(static_cast<std::uint8_t>(
      static_cast<std::uint8_t>(Audit(row.audit)) |
      (slot.ribbons() != nullptr && slot.ribbons()->has_converged ? state_format::converged_row : 0)));
  out.u8(static_cast<std::uint8_t>(row.failed));
  write_bits(out, row.energy);
  out.u32(row.generation);
  out.u64(row.count);
  if (kind == Kind::learning) return write_learning(out, *row.learning);
  return true;
}

}  // namespace tress::adaptive
