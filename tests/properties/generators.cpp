#include "properties/generators.h"

#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>
#include <utility>

#include "adaptive/random_ribbons.h"
#include "observations/sketch.h"
#include "properties/combinators.h"

namespace tress::inline v0_2::adaptive {

rc::Gen<float> any_azimuth() {
  const float pi = std::numbers::pi_v<float>;
  return testing::either(testing::pick<float>({0.0f, -pi, std::nextafter(pi, 0.0f), 1.5f, -1e-7f}),
                         testing::between(-pi, std::nextafter(pi, 0.0f)));
}
rc::Gen<float> any_scale() {
  return testing::either(testing::pick<float>({0.5f, 0.004f, 0.17f, 0.02f}), testing::between(0.004f, 0.5f));
}
/// Masses from nothing to the far ends of what a sum of nine can bear.
rc::Gen<float> any_weight() {
  return testing::either(testing::pick<float>({0.0f, 1.0f, 0.25f, 1e-30f, 1e-6f, 1e30f}), testing::between(0, 1));
}
/// Means and variances of an attribute: as path lengths are, and any float that a file may hold.
rc::Gen<float> any_attribute() {
  return testing::either(testing::pick<float>({0.0f, 1.0f, 2.5f, 1e-40f, 3.4e38f}), testing::between(0, 8));
}

rc::Gen<Component> any_component(rc::Gen<float> weight, rc::Gen<float> attribute) {
  return rc::gen::apply([](float mu, float left, float right, float weight, float mean,
                           float variance) { return Component{{mu, left, right}, weight, mean, variance}; },
                        any_azimuth(), any_scale(), any_scale(), std::move(weight), attribute, attribute);
}

rc::Gen<Mixture> mixtures_of(rc::Gen<Component> component, rc::Gen<float> weight, rc::Gen<float> attribute) {
  return rc::gen::apply(
      [](const std::vector<Component>& parts, float uniform, float mean, float variance) {
        Mixture fit;
        for (const Component& part : parts) fit.components[fit.component_count++] = part;
        fit.uniform_weight = uniform;
        fit.uniform_attribute_mean = mean;
        fit.uniform_attribute_variance = variance;
        return fit;
      },
      testing::up_to(Mixture::max_components, std::move(component)), std::move(weight), attribute, attribute);
}

rc::Gen<Mixture> any_mixture() {
  return mixtures_of(any_component(any_weight(), any_attribute()), any_weight(), any_attribute());
}

rc::Gen<Mixture> common_mixture() {
  const rc::Gen<float> weight = testing::either(testing::pick<float>({0.0f, 1.0f, 1e-4f}), testing::between(0, 1));
  const rc::Gen<float> attribute = testing::between(0, 8);
  return mixtures_of(any_component(weight, attribute), weight, attribute);
}

rc::Gen<RibbonRow> any_ribbons() {
  return rc::gen::apply(
      [](std::uint64_t seed, float mass, float other) {
        return RibbonRow(std::array<RibbonRow::Part, 2>{
            {{random_ribbon(seed, seed > 2), mass}, {random_ribbon(seed + 1, seed > 2), other}}});
      },
      testing::below(std::uint64_t{6}), testing::pick<float>({0.5f, 1e-6f, 20.0f}),
      testing::pick<float>({0.25f, 0.0f, 1e-30f}));
}

/// Bits of a bin: few, so that ties and equal offsets on either side are met, and the bounds.
rc::Gen<std::uint64_t> any_bin_bits() {
  return rc::gen::apply([](std::uint64_t offset, std::uint64_t sign,
                           float g) { return offset << 33 | sign << 32 | std::bit_cast<std::uint32_t>(g); },
                        testing::pick<std::uint64_t>({0, 1, 2, 0x7fffffff}), testing::below(std::uint64_t{2}),
                        testing::pick<float>({0.0f, 1.0f, 1e-45f, 3.4028234e38f}));
}

rc::Gen<std::vector<SketchBin>> any_sketch(std::uint32_t bins) {
  return rc::gen::map(rc::gen::container<std::vector<rc::Maybe<std::uint64_t>>>(8, rc::gen::maybe(any_bin_bits())),
                      [bins](const std::vector<rc::Maybe<std::uint64_t>>& bits) {
                        std::vector<SketchBin> sketch;
                        if (bins == 0) return sketch;
                        for (std::uint32_t i = 0; i < bits.size(); ++i) {
                          // Neighbours, and the last one.
                          if (bits[i]) sketch.push_back({i < 7 ? i : bins - 1, *bits[i]});
                        }
                        return sketch;
                      });
}

rc::Gen<std::uint64_t> any_count() {
  const std::uint64_t bits48 = std::uint64_t{1} << 48;
  return testing::pick<std::uint64_t>({0, 1, 2, bits48 - 1, bits48, ~std::uint64_t{0}});
}
rc::Gen<std::uint32_t> any_generation() { return testing::pick<std::uint32_t>({0, 1, ~0u}); }
rc::Gen<float> any_objective() { return testing::pick<float>({0.0f, 0.001f, 0.01f, 1.0f, 3.4e38f}); }

rc::Gen<CachedRow> any_open_row(std::uint32_t bins) {
  return rc::gen::apply(
      [](bool refused, std::uint32_t generation, std::uint64_t count, float energy, std::vector<SketchBin> sketch) {
        CachedRow row;
        row.state = refused ? RowState::refused : RowState::open;
        row.generation = generation;
        row.count = count;
        row.energy = energy;
        row.density()->sketch = std::move(sketch);
        return row;
      },
      testing::pick<bool>({false, true}), any_generation(), any_count(), testing::pick<float>({0.0f, 0.25f, 1.0f}),
      any_sketch(bins));
}

CachedRow converged(std::uint32_t generation, std::uint64_t count, float objective) {
  CachedRow row;
  row.state = RowState::converged;
  row.generation = generation;
  row.count = count;
  row.objective = objective;
  return row;
}

rc::Gen<CachedRow> any_mixture_row() {
  return rc::gen::apply(
      [](std::uint32_t generation, std::uint64_t count, float objective, const Mixture& fit) {
        CachedRow row = converged(generation, count, objective);
        row.density()->fit = fit;
        row.energy = fit.energy();
        return row;
      },
      any_generation(), any_count(), any_objective(),
      // Few, so that rows of two tables are often equal but for one thing.
      testing::either(any_mixture(), rc::gen::map(testing::below(3), [](int i) {
                        Mixture fit;
                        fit.uniform_weight = 0.5f;
                        fit.component_count = static_cast<std::uint32_t>(i);
                        for (int d = 0; d < i; ++d)
                          fit.components[static_cast<std::size_t>(d)] = {{1, 0.1f, 0.2f}, 0.5f};
                        return fit;
                      })));
}

rc::Gen<CachedRow> any_ribbon_row() {
  return rc::gen::apply(
      [](std::uint32_t generation, std::uint64_t count, float objective, const RibbonRow& ribbons) {
        CachedRow row = converged(generation, count, objective);
        row.learned = CachedSamples{std::make_shared<const RibbonRow>(ribbons)};
        row.energy = ribbons.total_mass();
        return row;
      },
      any_generation(), any_count(), any_objective(), any_ribbons());
}

rc::Gen<CachedRow> any_row_of_samples() {
  const auto of_samples = [](CachedRow row) {
    row.learned = CachedSamples{};
    return row;
  };
  return testing::either(rc::gen::map(any_open_row(0), of_samples), any_ribbon_row());
}

/// Open, refused, converged to a mixture; of node 0.
rc::Gen<CachedRow> any_row(std::uint32_t bins) {
  return rc::gen::oneOf(any_open_row(bins), any_open_row(bins), any_mixture_row(), any_mixture_row());
}

SliceKey key_of(std::size_t index) {
  const std::vector<SliceKey> keys{{0, {-1.5f, 1, 0.2f}}, {0, {-0.5f, 1, 0.2f}}, {0, {0, 1, 0.2f}},
                                   {1, {0.3f, 1, 0.2f}},  {~0u, {0, 0, 0}},      {~0u, {0, 0, 0, 1, -1, 0, 0, 0.5f}}};
  return keys.at(index);
}

/// `other`: axes that no slice of this key should have, in one model.
SliceDescription description_of(std::size_t index, bool other) {
  SliceDescription slice;
  slice.key = key_of(index);
  slice.axis_a = {0.0f, 0.5f};
  slice.axis_b = {0.0f, other ? 0.4f : 0.3f, 1.0f};
  slice.blur_rad = index == 3 ? 0.2f : 0.5f;
  if (index < keys) return slice;
  slice.kind = SliceKind::samples;
  slice.blur_rad = 0;
  return slice;
}

rc::Gen<CachedSlice> any_slice(std::size_t index) {
  const SliceDescription usual = description_of(index);
  const bool samples = usual.kind == SliceKind::samples;
  return rc::gen::apply(
      [index](int axes, const std::vector<rc::Maybe<CachedRow>>& rows) {
        CachedSlice slice{description_of(index, axes == 3), {}};
        for (std::uint32_t node = 0; node < rows.size(); ++node) {
          if (!rows[node]) continue;
          slice.rows.push_back(*rows[node]);
          slice.rows.back().node = node;
        }
        return slice;
      },
      testing::below(4),
      rc::gen::container<std::vector<rc::Maybe<CachedRow>>>(
          usual.node_count(),
          rc::gen::maybe(samples ? any_row_of_samples() : any_row(Sketch::bin_count(usual.blur_rad)))));
}

/// A whole table, the empty one included; slices without rows, keys that two tables share or not.
rc::Gen<TableSnapshot> any_image() {
  return rc::gen::apply(
      [](const rc::Maybe<CachedSlice>& a, const rc::Maybe<CachedSlice>& b, const rc::Maybe<CachedSlice>& c,
         const rc::Maybe<CachedSlice>& d, const rc::Maybe<CachedSlice>& e, const rc::Maybe<CachedSlice>& f) {
        TableSnapshot image{any_model, {}};
        for (const rc::Maybe<CachedSlice>* slice : {&a, &b, &c, &d, &e, &f}) {
          if (*slice) image.slices.push_back(**slice);
        }
        return image;
      },
      rc::gen::maybe(any_slice(0)), rc::gen::maybe(any_slice(1)), rc::gen::maybe(any_slice(2)),
      rc::gen::maybe(any_slice(3)), rc::gen::maybe(any_slice(4)), rc::gen::maybe(any_slice(5)));
}

rc::Gen<std::vector<TableSnapshot>> any_images(std::size_t most) {
  return rc::gen::apply(
      [](const TableSnapshot& first, std::vector<TableSnapshot> more) {
        more.push_back(first);
        return more;
      },
      any_image(), testing::up_to(most - 1, any_image()));
}

rc::Gen<std::vector<std::uint32_t>> any_numbers(std::size_t count, std::uint32_t n) {
  return rc::gen::container<std::vector<std::uint32_t>>(count, testing::below(n));
}

/// The bytes of the merge, what equality of tables means here.
std::string merged(const TableSnapshot& a, const TableSnapshot& b) { return encode_cache(merge_caches(a, b)); }

// How RapidCheck shows a counterexample.
void showValue(const Mixture& fit, std::ostream& out) {
  out << "{uniform " << fit.uniform_weight << " (" << fit.uniform_attribute_mean << ", "
      << fit.uniform_attribute_variance << ")";
  for (const Component& part : fit.parts()) {
    out << ", " << part.weight << " at " << part.shape.mu << " scales " << part.shape.s_left << " "
        << part.shape.s_right << " (" << part.attribute_mean << ", " << part.attribute_variance << ")";
  }
  out << "}";
}
void showValue(const RibbonRow& row, std::ostream& out) {
  out << "{" << row.parts() << " ribbons of mass " << row.total_mass() << "}";
}
void showValue(const SketchBin& bin, std::ostream& out) {
  out << bin.index << ": " << (bin.bits >> 33) << ((bin.bits >> 32 & 1) != 0 ? "-" : "+") << " "
      << std::bit_cast<float>(static_cast<std::uint32_t>(bin.bits));
}
void showValue(const CachedRow& row, std::ostream& out) {
  const char* states[] = {"unborn", "open", "converged", "refused"};
  out << "\n    node " << row.node << " " << states[static_cast<int>(row.state)] << " generation " << row.generation
      << " objective " << row.objective << " count " << row.count << " energy " << row.energy;
  if (row.ribbons() != nullptr) {
    rc::show(*row.ribbons(), out << " ribbons ");
  } else if (row.state == RowState::converged) {
    rc::show(row.density()->fit, out << " fit ");
  } else {
    rc::show(row.density()->sketch, out << " sketch ");
  }
}
void showValue(const TableSnapshot& image, std::ostream& out) {
  for (const CachedSlice& slice : image.slices) {
    out << "\n  page " << slice.description.key.lobe << " " << slice.description.key.parameters[0] << " of "
        << slice.description.axis_a.size() << " x " << slice.description.axis_b.size() << " nodes, axis b at "
        << slice.description.axis_b[1];
    for (const CachedRow& row : slice.rows) rc::show(row, out);
  }
  out << "\n";
}

}  // namespace tress::inline v0_2::adaptive
