// A service takes any cache that can be read, whatever its values, and saves back what it did not use: slices that the
// scene has not, rows that memory has no room for. What it takes it takes by the rules of the naive model.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "adaptive/toy_samples.h"
#include "adaptive/toy_target.h"
#include "properties/generators.h"
#include "properties/service_model.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

/// As a session finds it: read from its bytes.
TableSnapshot read_image() {
  Result<TableSnapshot> read = decode_cache(encode_cache(*any_image()), any_model, "a.cache");
  RC_ASSERT(read.has_value());
  return std::move(*read);
}

bool fits(const CachedSlice& slice, std::size_t index) {
  return slice.description.axis_b == description_of(index).axis_b;
}

RC_GTEST_PROP(Cache, OfSlicesThatNobodyAddsIsSavedBackToTheByte, ()) {
  const TableSnapshot image = read_image();
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  RC_ASSERT(!service.load(image));
  service.publish();
  RC_ASSERT(encode_cache(service.snapshot()) == encode_cache(image));
}

RC_GTEST_PROP(Cache, OfRowsThatMemoryHasNoRoomForIsSavedBackToTheByte, ()) {
  const TableSnapshot image = read_image();
  const testing::MovingPeaks target;
  Options options;
  options.memory_bytes = 0;
  const testing::MovingLobes samples;
  Service service(options, target, samples);
  TableSnapshot wanted{image.model, {}};
  for (const CachedSlice& slice : image.slices) {
    if (!fits(slice, 0)) continue;
    service.add_slice(slice.description);
    if (!slice.rows.empty()) wanted.slices.push_back(slice);  // a slice without rows says nothing
  }
  TableSnapshot usable = image;
  std::erase_if(usable.slices, [](const CachedSlice& slice) { return !fits(slice, 0); });
  RC_ASSERT(!service.load(usable));
  service.publish();
  RC_ASSERT(encode_cache(service.snapshot()) == encode_cache(wanted));
}

RC_GTEST_PROP(Cache, OfAnyRowsIsTakenByTheRulesOfTheNaiveModel, ()) {
  const TableSnapshot image = read_image();
  const std::vector<std::uint32_t> added = *any_numbers(keys, 3);
  const testing::MovingPeaks target;
  const Options options;
  Service service(options, target);
  ServiceModel model(options, target);
  RC_ASSERT(!service.load(image));
  model.load(image);
  std::vector<std::size_t> used;
  for (std::size_t index = 0; index < keys; ++index) {
    bool usable = added[index] > 0;
    for (const CachedSlice& slice : image.slices) {
      usable = usable && (slice.description.key != key_of(index) || fits(slice, index));
    }
    if (!usable) continue;
    service.add_slice(description_of(index));
    model.add_slice(description_of(index));
    used.push_back(index);
  }
  model.check_loaded(service);
  model.check_saved(service);
  // Twice asked: what is due is audited, what fails is reopened, and rows of its slice after it.
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t p = 0; p < used.size(); ++p) {
      for (std::uint32_t n = 0; n < description_of(used[p]).node_count(); ++n) {
        service.look_up(static_cast<SliceId>(p), n / 3, n % 3);
        model.ask(p, n, ServiceModel::Ask::look);
      }
    }
    model.check_pass(service, service.publish());
    model.check_saved(service);
    const std::string bytes = encode_cache(service.snapshot());
    RC_ASSERT(decode_cache(bytes, any_model, "saved").has_value());
  }
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
