// What saving, merging and loading a table of 100,000 rows take of memory: no more than one of 1,000 rows. A whole
// TableSnapshot of it takes some 450 bytes a row and its encoding some 110, and saving used to make three and two of
// them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "adaptive/cache_images.h"
#include "adaptive/counted_heap.h"
#include "adaptive/toy_target.h"
#include "tress/adaptive/service.h"

namespace tress::inline v0_2::adaptive {
namespace {

namespace fs = std::filesystem;
using testing::heap_bytes;
using testing::peak_of;

constexpr std::uint32_t many = 100'000;
/// Of a save, a merge, a hash or a load, whatever the number of rows: six buffers of 32 KB for a file that is read and
/// what is written, states of checksums, names; the 256 rows that a load holds at once, of 0.5 KB each.
constexpr std::size_t constant = std::size_t{1} << 20;

/// Two slices of 250 x 200 nodes. Each row has four components and `count`; every 50th is open, with 64 bins.
class ManyRows final : public RowSource {
 public:
  ManyRows(std::uint32_t rows, std::uint64_t count) : rows_(rows) {
    row_ = converged_row(0, 0.001f);
    row_.density()->fit.component_count = 4;
    row_.density()->fit.components[2] = row_.density()->fit.components[0];
    row_.density()->fit.components[3] = row_.density()->fit.components[1];
    row_.count = count;
    open_ = open_row(0, {});
    for (std::uint32_t i = 0; i < 64; ++i) open_.density()->sketch.push_back(sketch_bin(2 * i, i, 0.0f));
    open_.count = count;
    for (std::uint32_t lobe = 0; lobe < 2; ++lobe) {
      slices_[lobe] = testing::toy_slice(lobe, 250);
      slices_[lobe].axis_b.resize(200);
    }
  }
  const std::string& model() const override { return model_; }
  void rewind() override { slice_ = 0; }
  const SliceDescription* next_slice() override {
    node_ = 0;
    return slice_ < 2 ? &slices_[slice_++] : nullptr;
  }
  const CachedRow* next_row() override {
    if (slice_ == 0 || node_ == rows_ / 2) return nullptr;
    CachedRow& row = node_ % 50 == 49 ? open_ : row_;
    row.node = node_++;
    row.generation = row.node % 7;
    return &row;
  }

 private:
  std::uint32_t rows_;
  std::string model_ = testing::MovingPeaks{}.model_name();
  SliceDescription slices_[2];
  std::uint32_t slice_ = 0, node_ = 0;
  CachedRow row_, open_;
};

class SavingMemory : public ::testing::Test {
 protected:
  SavingMemory() {
    folder_ = fs::temp_directory_path() / ("tress-memory-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    file_ = folder_ / "hair.cache";
  }
  ~SavingMemory() override { fs::remove_all(folder_); }

  std::string content() const {
    std::ifstream stream(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  fs::path folder_, file_;
};

TEST_F(SavingMemory, OfATableDoesNotGrowWithItsRows) {
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  ManyRows rows(many, 64);
  // Slices that nobody uses are kept in no more than their bytes.
  const std::size_t kept = peak_of([&] { EXPECT_FALSE(service.load(rows)); });
  EXPECT_LT(kept, encode_cache(collect(rows)).size() + constant);
  EXPECT_LT(peak_of([&] { EXPECT_EQ(merge_into_cache(file_, *service.rows())->contents.rows(), many); }), constant);
  EXPECT_EQ(content(), encode_cache(collect(rows))) << "unused";
  fs::remove(file_);
  for (std::uint32_t lobe = 0; lobe < 2; ++lobe) {
    SliceDescription slice = testing::toy_slice(lobe, 250);
    slice.axis_b.resize(200);
    service.add_slice(slice);
  }
  EXPECT_EQ(service.peek(0, 0, 0).state, RowState::converged);
  EXPECT_EQ(service.peek(1, 0, 49).state, RowState::open);

  EXPECT_LT(peak_of([&] { EXPECT_EQ(merge_into_cache(file_, *service.rows())->contents.rows(), many); }), constant);
  EXPECT_EQ(content(), encode_cache(service.snapshot())) << "created";
  EXPECT_LT(peak_of([&] { EXPECT_TRUE(replace_cache(file_, *service.rows())); }), constant);
  EXPECT_EQ(content(), encode_cache(service.snapshot())) << "replaced";
  std::string hash;
  EXPECT_LT(peak_of([&] { hash = cache_hash(*service.rows()); }), constant);
  EXPECT_EQ(hash, cache_hash(service.snapshot()));

  // As many rows of another session, each of which wins at its node or is joined with what is there.
  ManyRows others(many, 65);
  ASSERT_TRUE(replace_cache(file_, others));
  const TableSnapshot wanted = merge_caches(service.snapshot(), *load_cache(file_, ""));
  EXPECT_LT(peak_of([&] { EXPECT_EQ(merge_into_cache(file_, *service.rows())->contents.rows(), many); }), constant);
  EXPECT_EQ(content(), encode_cache(wanted)) << "merged";
}

TEST_F(SavingMemory, OfLoadingIsTheTableAlone) {
  ManyRows rows(many, 64);
  ASSERT_TRUE(replace_cache(file_, rows));
  EXPECT_LT(peak_of([&] { EXPECT_TRUE(CacheFile::open(file_, "")); }), constant);
  const testing::MovingPeaks target;
  Service service(Options{}, target);
  for (std::uint32_t lobe = 0; lobe < 2; ++lobe) {
    SliceDescription slice = testing::toy_slice(lobe, 250);
    slice.axis_b.resize(200);
    service.add_slice(slice);
  }
  const std::size_t before = heap_bytes();
  const std::size_t peak = peak_of([&] {
    const auto cache = CacheFile::open(file_, target.model_name());
    ASSERT_TRUE(cache);
    ASSERT_FALSE(service.load(**cache));
  });
  const std::size_t table = heap_bytes() - before;
  EXPECT_GT(table, many * 100);
  EXPECT_LT(peak, table + constant);
}

}  // namespace
}  // namespace tress::inline v0_2::adaptive
