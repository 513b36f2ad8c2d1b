// A host without the library: the rows of a cache, by one header. Built as C++11 or, where there is one, by a CUDA
// compiler; it runs on the CPU. usage: frozen FILE.cache
#include <stdio.h>

#include <vector>

#include "tress/frozen_rows.h"

using namespace tress::frozen;

static float next(uint64_t* state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return static_cast<float>(*state >> 40) / 16777216.0f;
}

TRESS_ANYWHERE void weigh(const Table& table, const float* u, const float* sigma_a, float* weight) {
  const Direction to_camera = {0.3f, 0.8f};
  const Event event = begin(table, to_camera, u[0], u[1]);
  const Direction wi = sample(table, event, u + 2);
  const float q = pdf(table, event, wi);
  evaluate(table, event, wi, sigma_a, 4, weight);
  for (int c = 0; c < 4; ++c) weight[c] = q > 0 ? weight[c] / q : 0;
}

#ifdef __CUDACC__
__global__ void weigh_all(Table table, const float* u, const float* sigma_a, float* weights) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  weigh(table, u + 5 * i, sigma_a, weights + 4 * i);
}
#endif

int main(int count, char** arguments) {
  FILE* file = count > 1 ? fopen(arguments[1], "rb") : NULL;
  if (file == NULL) return 1;
  std::vector<unsigned char> bytes(1u << 24);
  bytes.resize(fread(bytes.data(), 1, bytes.size(), file));
  fclose(file);
  Slice slice;
  const Outcome found = find(bytes.data(), bytes.size(), nullptr, rough_lobe, nullptr, &slice);
  if (found.status != Status::ok)
    return printf("status %d at byte %zu\n", static_cast<int>(found.status), found.byte), 1;
  std::vector<Row> rows(slice.row_count);
  std::vector<uint32_t> row_of(slice.count_a * slice.count_b);
  std::vector<float> axis_a(slice.count_a), axis_b(slice.count_b);
  read(slice, rows.data(), row_of.data(), axis_a.data(), axis_b.data());
  const Table table = {rows.data(), row_of.data(), axis_a.data(), slice.count_a, slice.count_b};

  // Four channels of one path each: what clear hair and darker ones look like in a furnace.
  const float sigma_a[4] = {0, 0.1f, 0.5f, 2};
  double mean[4] = {0, 0, 0, 0};
  uint64_t random = 1;
  const int paths = 20000;
  for (int i = 0; i < paths; ++i) {
    float u[5], weight[4];
    for (int k = 0; k < 5; ++k) u[k] = next(&random);
    weigh(table, u, sigma_a, weight);
    for (int c = 0; c < 4; ++c) mean[c] += static_cast<double>(weight[c]) / paths;
  }
  printf("%u rows, furnace %.3f %.3f %.3f %.3f\n", slice.row_count, mean[0], mean[1], mean[2], mean[3]);
  // Weights of clear hair are the masses, known to some 0.01 from 512 paths; every darker channel is darker.
  const bool is_right =
      mean[0] > 0.96 && mean[0] < 1.04 && mean[1] < mean[0] && mean[2] < mean[1] && mean[3] < mean[2] && mean[3] > 0.02;
  return is_right ? 0 : 1;
}
