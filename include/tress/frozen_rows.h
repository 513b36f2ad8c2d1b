// Rows of the rough fiber, and of any other target of samples, read from a warm cache without the library: C++11, CUDA
// and HIP, one header that includes the C library alone. Nothing here allocates, throws or changes global state; any
// thread. The format is that of adaptive/cache/CACHE_FORMAT.md, the mathematics that of E9 in adaptive/ESTIMATOR.md;
// values are those of Ribbon and GammaDecay, to 1e-6.
//
//   frozen::Slice slice;                                                        // on the host: the bytes of a file
//   if (find(bytes, size, XXH3_64bits, frozen::rough_lobe, parameters, &slice).status != frozen::Status::ok) return;
//   read(slice, rows, row_of, axis_a, axis_b);  // memory of the host: row_count rows, count_a * count_b numbers, axes
//   const frozen::Table table{rows, row_of, axis_a, slice.count_a, slice.count_b};  // copied to a device, pointers too
//   // anywhere:
//   const frozen::Event event = begin(table, {theta_r, phi_r}, xi1, xi2);
//   const frozen::Direction wi = sample(table, event, u);
//   const float q = pdf(table, event, wi);
//   evaluate(table, event, wi, sigma_a, 3, s);                                     // weight s / q, by channel
//
// The host makes up for what a cache has not: gains, a glint apart from TRT, and the energies by which the library
// corrects rows of few paths. The rows of the library for one color are packed more coarsely: S of a direction differs
// by 1 % at the median, 5 % at 90 % and 30 % at most, for rows of many paths. Masses are those of the row's paths;
// divide by their sum for a clear fiber that keeps all light to rounding.
#pragma once

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__CUDACC__) || defined(__HIPCC__)
#define TRESS_ANYWHERE __host__ __device__
#else
#define TRESS_ANYWHERE
#endif

namespace tress {
inline namespace v0_2 {
namespace frozen {

// ---- Rows: plain data ---------------------------------------------------------------------------------------------

enum { most_parts = 4, main_knots = 32, broad_knots = 8 };
static const uint32_t rough_lobe = 16;  ///< SliceKey::lobe of the rough fiber; parts are R, TT, TRT and the rest
static const uint32_t no_row = 0xffffffffu;

/// RibbonKnot, with GammaDecay in place of its decays.
struct Knot {
  float azimuth, density, mode, scale_below, scale_above;
  float shape, scale;  ///< absorption at the rate r leaves (1 + scale r)^-shape
  float below;         ///< mass of the layer from its first knot to this one
};
/// A Ribbon of mass 1, and its mass for unit flux without absorption.
struct Part {
  Knot main[main_knots], broad[broad_knots];
  float main_mass, broad_mass;
  float mass;
  uint32_t is_logistic;  ///< the law of the main layer; else it is normal
};
struct Row {
  Part part[most_parts];
  uint32_t parts, node;  ///< node: a * count_b + b
  float objective;       ///< bound of chi^2 of the row's last test
  uint64_t paths;
};

// ---- Reading, on the host -----------------------------------------------------------------------------------------

enum class Status : uint32_t {
  ok = 0,
  not_a_cache = 1,     ///< the first bytes are others
  other_version = 2,   ///< without slices of samples, or of a later release
  truncated = 3,       ///< bytes are missing
  wrong_checksum = 4,  ///< of a section
  invalid = 5,         ///< a value out of its range, or bytes after the end
  no_such_slice = 6,
  no_rows = 7  ///< the slice has none that answers, or is one of densities
};
/// `byte`: the place in the file that is at fault.
struct Outcome {
  Status status;
  size_t byte;
};
/// XXH3_64bits() of xxhash.h, by which sections are checked; null: they are not, but every count and value is.
typedef uint64_t (*Hash)(const void* bytes, size_t size);

/// A slice of a file that was checked, whose bytes must outlive it.
struct Slice {
  const unsigned char* bytes;
  float parameters[16];
  uint32_t lobe, has_samples, count_a, count_b;
  uint32_t row_count;  ///< rows that answer
  uint32_t stored_rows;
  size_t axes_at, rows_at;
};

namespace detail {

struct Cursor {
  const unsigned char* bytes;
  size_t end, at;
  bool has(uint64_t count) const { return count <= end - at; }
  uint64_t number(int count) {
    uint64_t x = 0;
    for (int i = 0; i < count; ++i) x |= static_cast<uint64_t>(bytes[at++]) << 8 * i;
    return x;
  }
  uint32_t u32() { return static_cast<uint32_t>(number(4)); }
  float f32() {
    const uint32_t word = u32();
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
  }
  Outcome fault(Status status) const {
    const Outcome outcome = {status, at};
    return outcome;
  }
};

enum { part_bytes = 344, row_bytes = 28 };
/// Numbers of the packed form in a file.
struct Codes {
  uint32_t azimuth, density, mode, below, above, first, second;
};
/// Knot k of both layers, the main one first.
inline Codes codes_of(const unsigned char* part, int k) {
  if (k >= main_knots) {
    const int b = k - main_knots;
    const unsigned char* c = part + 8 + 9 * main_knots + 6 * b;
    const Codes codes = {static_cast<uint32_t>(b) * 8192, c[0], c[1], c[2], c[3], c[4], c[5]};
    return codes;
  }
  Cursor at = {part + 8 + 9 * k, 9, 0};
  const uint64_t all = at.number(8);
  const Codes codes = {static_cast<uint32_t>(all & 65535),       static_cast<uint32_t>(all >> 16 & 255),
                       static_cast<uint32_t>(all >> 24 & 16383), static_cast<uint32_t>(all >> 38 & 255),
                       static_cast<uint32_t>(all >> 46 & 255),   static_cast<uint32_t>(all >> 54),
                       static_cast<uint32_t>(at.number(1))};
  return codes;
}
inline uint32_t main_share(const unsigned char* part) { return part[1] | static_cast<uint32_t>(part[2]) << 8; }

/// Whether these are codes of a part with light.
inline bool is_part(const unsigned char* part) {
  uint32_t largest[2] = {0, 0}, last = 0;
  for (int k = 0; k < main_knots + broad_knots; ++k) {
    const Codes c = codes_of(part, k);
    if (k < main_knots && c.azimuth < last) return false;
    last = c.azimuth;
    uint32_t& most = largest[k < main_knots ? 0 : 1];
    most = c.density > most ? c.density : most;
  }
  return part[0] <= 1 && largest[0] == (main_share(part) > 0 ? 255u : 0u) &&
         largest[1] == (main_share(part) < 65535 ? 255u : 0u);
}

/// Goes past a row of a slice and checks it. row: gets node, count of parts, their masses, objective and paths; parts
/// is 0 where it does not answer. part_at: of its first packed part.
inline Outcome pass_row(Cursor* at, const Slice& slice, uint64_t least_node, Row* row, size_t* part_at) {
  const Cursor from = *at;
  if (!at->has(row_bytes)) return from.fault(Status::truncated);
  row->node = at->u32();
  const uint64_t state = at->number(1), count = at->number(1), kind = at->number(1), zero = at->number(1);
  at->at += 8;  // generation, energy
  row->objective = at->f32();
  row->paths = at->number(8);
  row->parts = 0;
  const bool is_open = state == 1, is_mixture = kind == 0;
  const bool is_known = is_open ? count == 0 && is_mixture
                                : state == 2 && kind == (slice.has_samples != 0 ? 2 : 0) &&
                                      count <= (is_mixture ? 8 : most_parts) && (is_mixture || count > 0);
  if (zero != 0 || row->node < least_node || row->node >= slice.count_a * slice.count_b || !is_known)
    return from.fault(Status::invalid);
  const uint64_t rest = is_open ? 0 : is_mixture ? 12 + 24 * count : count * (4 + part_bytes);
  if (!at->has(rest)) return from.fault(Status::truncated);
  *part_at = at->at + 4 * count;
  if (!is_open && !is_mixture) {
    row->parts = static_cast<uint32_t>(count);
    Cursor mass = *at;
    float sum = 0;
    for (size_t p = 0; p < count; ++p) {
      const unsigned char* part = at->bytes + *part_at + p * part_bytes;
      uint32_t any = 0;
      for (int i = 0; i < part_bytes; ++i) any |= part[i];
      sum += row->part[p].mass = mass.f32();
      if (!(row->part[p].mass > 0 ? is_part(part) : row->part[p].mass == 0 && any == 0))
        return from.fault(Status::invalid);
    }
    if (!(sum > 0 && sum <= 3.4028234e38f)) return from.fault(Status::invalid);
  }
  at->at += rest;
  return from.fault(Status::ok);
}

/// GammaDecay::from().
inline void set_decay(float first_decay, float second_decay, Knot* knot) {
  const double rate1 = double(0.15f), rate2 = double(0.9f), least = double(1e-30f);
  knot->shape = 0, knot->scale = 1e-3f;
  const double first = -log(fmax(double(first_decay), least)), second = -log(fmax(double(second_decay), least));
  if (!(first > 0)) return;
  double low = log(log1p(rate1 * double(1e-3f))), high = log(log1p(rate1 * 1e12));
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high), l = exp(middle);
    (log1p(rate2 / rate1 * expm1(l)) / l > second / first ? low : high) = middle;
  }
  const double l = exp(0.5 * (low + high));
  knot->shape = static_cast<float>(first / l);
  knot->scale = static_cast<float>(expm1(l) / rate1);
}

TRESS_ANYWHERE inline float two_pi() { return 6.28318530718f; }
TRESS_ANYWHERE inline float pi() { return 3.14159265359f; }
TRESS_ANYWHERE inline Knot& knot_of(Part* part, int k) {
  return k < main_knots ? part->main[k] : part->broad[k - main_knots];
}

/// The mass of a layer; `below`: that before each knot.
TRESS_ANYWHERE inline double mass_of(const Knot* knots, int count, double* below) {
  double sum = 0;
  for (int k = 0; k < count; ++k) {
    const Knot& next = knots[k + 1 < count ? k + 1 : 0];
    const double width = double(next.azimuth) + (k + 1 < count ? 0.0 : 6.283185307179586) - double(knots[k].azimuth);
    below[k] = sum;
    sum += 0.5 * (width > 0 ? width : 0.0) * (double(knots[k].density) + double(next.density));
  }
  return sum;
}
/// Scales both layers together to mass 1, and returns what it was.
TRESS_ANYWHERE inline double scale_to_one(Part* part) {
  double below[main_knots + broad_knots];
  const double main = mass_of(part->main, main_knots, below),
               broad = mass_of(part->broad, broad_knots, below + main_knots), whole = main + broad;
  if (!(whole > 0)) return 0;
  for (int k = 0; k < main_knots + broad_knots; ++k) {
    Knot& knot = knot_of(part, k);
    knot.density = static_cast<float>(double(knot.density) * (1 / whole));
    knot.below = static_cast<float>(below[k] * (1 / whole));
  }
  part->main_mass = static_cast<float>(main * (1 / whole));
  part->broad_mass = static_cast<float>(broad * (1 / whole));
  return whole;
}

inline void read_part(const unsigned char* bytes, Part* part) {
  const double least_scale = double(1e-3f), scale_step = log(double(0.9f) / least_scale) / 255, reach = asinh(24.0),
               ratio = double(0.15f) / double(0.9f);
  for (int k = 0; k < main_knots + broad_knots; ++k) {
    const Codes c = codes_of(bytes, k);
    const double half = k < main_knots ? 8191 : 127, last_first = k < main_knots ? 1022 : 254;
    Knot& knot = knot_of(part, k);
    knot.azimuth = static_cast<float>(-3.141592653589793 + c.azimuth * (2 * 3.141592653589793 / 65536));
    knot.density = c.density == 0 ? 0 : static_cast<float>(exp((double(c.density) - 255) * 0.05));
    knot.mode = static_cast<float>(fmin(fmax(0.5 * sinh((c.mode / half - 1) * reach), -12.0), 12.0));
    knot.scale_below = static_cast<float>(least_scale * exp(c.below * scale_step));
    knot.scale_above = static_cast<float>(least_scale * exp(c.above * scale_step));
    const double first = c.first == 0 ? 0 : 0.02 * exp((c.first - 1) * (log(100 / 0.02) / last_first));
    const double second = first * (ratio + (1 - ratio) * c.second / 255);
    set_decay(static_cast<float>(exp(-first * double(0.15f))), static_cast<float>(exp(-second * double(0.9f))), &knot);
  }
  double none[main_knots];
  const double share = main_share(bytes) / 65535.0, main = mass_of(part->main, main_knots, none),
               broad = mass_of(part->broad, broad_knots, none);
  for (int k = 0; k < main_knots + broad_knots; ++k) {
    const double mass = k < main_knots ? main : broad, factor = (k < main_knots ? share : 1 - share) / mass;
    knot_of(part, k).density = mass > 0 ? static_cast<float>(double(knot_of(part, k).density) * factor) : 0;
  }
  part->is_logistic = bytes[0];
  scale_to_one(part);
}

inline Outcome read_description(Cursor* at, uint32_t parameters, Slice* slice) {
  const Cursor from = *at;
  if (!at->has(20 + 4 * parameters)) return from.fault(Status::truncated);
  slice->lobe = at->u32();
  slice->has_samples = at->u32();
  for (uint32_t i = 0; i < parameters; ++i) slice->parameters[i] = at->f32();
  at->at += 4;  // blur
  slice->count_a = at->u32();
  slice->count_b = at->u32();
  slice->axes_at = at->at;
  const uint64_t nodes = uint64_t(slice->count_a) * slice->count_b, numbers = uint64_t(slice->count_a) + slice->count_b;
  if (slice->has_samples > 1 || nodes == 0 || nodes > 1u << 20) return from.fault(Status::invalid);
  if (!at->has(4 * numbers)) return from.fault(Status::truncated);
  float last = 0;
  for (uint32_t i = 0; i < numbers; ++i) {
    const float x = at->f32();
    if (!isfinite(x) || (i != 0 && i != slice->count_a && !(x > last))) return from.fault(Status::invalid);
    last = x;
  }
  return from.fault(Status::ok);
}

}  // namespace detail

/// Checks a file, its sections, slices and ribbons, and finds the slice of a lobe with these 16 parameters; null: the
/// first one of that lobe. rough_lobe: eta, eccentricity, roughness, tilt; the medulla's radius, scattering, asymmetry
/// and absorption, 0 without one; the cortex's scattering and asymmetry; the wetness; zeros.
inline Outcome find(const void* bytes, size_t size, Hash hash, uint32_t lobe, const float* parameters, Slice* found) {
  memset(found, 0, sizeof *found);
  detail::Cursor at = {static_cast<const unsigned char*>(bytes), size, 0}, section[4];
  if (!at.has(24)) return at.fault(Status::truncated);
  if (memcmp(bytes, "\x89TRESS\r\n", 8) != 0) return at.fault(Status::not_a_cache);
  at.at = 8;
  const uint32_t version = at.u32();
  if (version != 3 && version != 4) return at.fault(Status::other_version);
  if (at.u32() != 4) return at.fault(Status::invalid);
  at.at = 24;
  for (uint32_t i = 0; i < 4; ++i) {
    const detail::Cursor from = at;
    if (!at.has(24)) return from.fault(Status::truncated);
    if (at.u32() != i + 1 || at.u32() != 0) return from.fault(Status::invalid);
    const uint64_t length = at.number(8), sum = at.number(8);
    if (!at.has(length)) return from.fault(Status::truncated);
    if (hash != nullptr && hash(at.bytes + at.at, length) != sum) return from.fault(Status::wrong_checksum);
    section[i] = at;
    section[i].end = at.at += length;
  }
  if (at.at != size) return at.fault(Status::invalid);
  detail::Cursor &slices = section[1], &rows = section[2];
  if (!slices.has(4)) return slices.fault(Status::truncated);
  bool is_there = false;
  for (uint32_t left = slices.u32(); left > 0; --left) {
    Slice slice = {};
    slice.bytes = at.bytes;
    const Outcome described = detail::read_description(&slices, version == 3 ? 8 : 16, &slice);
    if (described.status != Status::ok) return described;
    if (!rows.has(4)) return rows.fault(Status::truncated);
    slice.stored_rows = rows.u32();
    slice.rows_at = rows.at;
    uint64_t least_node = 0;
    for (uint32_t i = 0; i < slice.stored_rows; ++i) {
      Row row;
      size_t part_at = 0;
      const Outcome passed = detail::pass_row(&rows, slice, least_node, &row, &part_at);
      if (passed.status != Status::ok) return passed;
      least_node = uint64_t(row.node) + 1;
      slice.row_count += row.parts > 0 ? 1 : 0;
    }
    if (slice.lobe != lobe || is_there) continue;
    if (parameters != nullptr && memcmp(slice.parameters, parameters, sizeof slice.parameters) != 0) continue;
    *found = slice;
    is_there = true;
  }
  if (slices.at != slices.end) return slices.fault(Status::invalid);
  if (rows.at != rows.end) return rows.fault(Status::invalid);
  return slices.fault(!is_there ? Status::no_such_slice : found->row_count == 0 ? Status::no_rows : Status::ok);
}

/// Reads the rows of a slice that was found, row_count of them, the row that answers each node, count_a * count_b
/// numbers, and both axes. A node without a row is answered by that of a node near it. Takes some 0.6 ms a row.
inline void read(const Slice& slice, Row* rows, uint32_t* row_of, float* axis_a, float* axis_b) {
  if (slice.row_count == 0) return;
  detail::Cursor at = {slice.bytes, ~size_t(0), slice.axes_at};
  for (uint32_t i = 0; i < slice.count_a; ++i) axis_a[i] = at.f32();
  for (uint32_t i = 0; i < slice.count_b; ++i) axis_b[i] = at.f32();
  const uint32_t width = slice.count_b, nodes = slice.count_a * width;
  for (uint32_t node = 0; node < nodes; ++node) row_of[node] = no_row;
  at.at = slice.rows_at;
  for (uint32_t i = 0, count = 0; i < slice.stored_rows; ++i) {
    Row row = {};
    size_t part_at = 0;
    detail::pass_row(&at, slice, 0, &row, &part_at);
    if (row.parts == 0) continue;
    for (uint32_t p = 0; p < row.parts; ++p, part_at += detail::part_bytes) {
      if (row.part[p].mass > 0) detail::read_part(slice.bytes + part_at, &row.part[p]);
    }
    row_of[row.node] = count;
    rows[count++] = row;
  }
  // Rows spread to their neighbors, one step of the grid a round.
  for (bool is_whole = false; !is_whole;) {
    is_whole = true;
    for (uint32_t node = 0; node < nodes; ++node) {
      if (row_of[node] != no_row) continue;
      const uint32_t b = node % width,
                     beside[4] = {b > 0 ? node - 1 : node, b + 1 < width ? node + 1 : node,
                                  node >= width ? node - width : node, node + width < nodes ? node + width : node};
      for (int k = 0; k < 4 && row_of[node] == no_row; ++k) row_of[node] = row_of[beside[k]];
      is_whole = is_whole && row_of[node] != no_row;
    }
  }
}

// ---- Answers, anywhere --------------------------------------------------------------------------------------------

namespace detail {

TRESS_ANYWHERE inline float clamp(float x, float least, float most) { return x < least ? least : x > most ? most : x; }
TRESS_ANYWHERE inline float wrap(float x) {  // into [-pi, pi)
  if (x >= -pi() && x < pi()) return x;
  x = static_cast<float>(x - 6.283185307179586 * floor((x + 3.141592653589793) / 6.283185307179586));
  return x >= -pi() && x < pi() ? x : -pi();
}

/// Any number as one in [0, 1).
TRESS_ANYWHERE inline float uniform(float u) { return u >= 0 ? (u < 1 ? u : 0.99999994f) : 0; }

struct Between {
  float density, mode, scale_below, scale_above;
};
struct Layer {
  const Knot* knots;
  int count;
  float mass;

  TRESS_ANYWHERE const Knot& after(int k) const { return knots[k + 1 < count ? k + 1 : 0]; }
  TRESS_ANYWHERE float width(int k) const {
    return k + 1 < count ? knots[k + 1].azimuth - knots[k].azimuth : knots[0].azimuth + two_pi() - knots[k].azimuth;
  }
  /// How many knots have at most x of a member that ascends, without branches; count is a power of 2.
  TRESS_ANYWHERE int count_up_to(float x, float Knot::* member) const {
    int low = 0;
    for (int half = count / 2; half > 0; half /= 2) low += knots[low + half - 1].*member <= x ? half : 0;
    return low + (knots[low].*member <= x ? 1 : 0);
  }
  /// The segment of x, and the share of it before x.
  TRESS_ANYWHERE int find(float x, float* share) const {
    const int low = count_up_to(x, &Knot::azimuth), k = low == 0 ? count - 1 : low - 1;
    const float from = x - knots[k].azimuth + (low == 0 ? two_pi() : 0), all = width(k);
    *share = all > 0 ? clamp(from / all, 0, 1) : 0;
    return k;
  }
  TRESS_ANYWHERE Between at(int k, float s) const {
    const Knot &a = knots[k], &b = after(k);
    const Between between = {a.density + s * (b.density - a.density), a.mode + s * (b.mode - a.mode),
                             a.scale_below + s * (b.scale_below - a.scale_below),
                             a.scale_above + s * (b.scale_above - a.scale_above)};
    return between;
  }
  /// The azimuth that has the share u of the mass before it, and the law there.
  TRESS_ANYWHERE float sample(float u, Between* law) const {
    const float v = uniform(u) * mass;
    const int k = count_up_to(v, &Knot::below) - 1;
    const float here = (k + 1 < count ? knots[k + 1].below : mass) - knots[k].below;
    const float r = here > 0 ? clamp((v - knots[k].below) / here, 0, 0.99999994f) : 0.5f;
    const float a = knots[k].density, b = after(k).density, root = sqrtf(a * a + r * (b - a) * (b + a));
    const float both = a + root, along = both > 0 ? r * (a + b) / both : r, s = along < 1 ? along : 1;
    *law = at(k, s);
    return wrap(knots[k].azimuth + s * width(k));
  }
};
TRESS_ANYWHERE inline Layer main_of(const Part& part) {
  const Layer layer = {part.main, main_knots, part.main_mass};
  return layer;
}
TRESS_ANYWHERE inline Layer broad_of(const Part& part) {
  const Layer layer = {part.broad, broad_knots, part.broad_mass};
  return layer;
}

TRESS_ANYWHERE inline float height_density(bool is_logistic, const Between& law, float t) {
  const float z = fabsf(t - law.mode) / (t < law.mode ? law.scale_below : law.scale_above);
  const float both = law.scale_below + law.scale_above;
  if (!is_logistic) return 0.797884561f / both * expf(-0.5f * z * z);
  const float e = expf(-z);
  return 2 * e / (both * (1 + e) * (1 + e));
}
/// Giles 2010: the z that a half normal law exceeds with probability q.
TRESS_ANYWHERE inline float half_normal_beyond(float q) {
  float w = -logf(q * (2 - q)), p;
  if (w < 5) {
    w -= 2.5f;
    p = 3.43273939e-07f + 2.81022636e-08f * w;
    p = -3.5233877e-06f + p * w, p = -4.39150654e-06f + p * w, p = 0.00021858087f + p * w;
    p = -0.00125372503f + p * w, p = -0.00417768164f + p * w, p = 0.246640727f + p * w, p = 1.50140941f + p * w;
  } else {
    w = sqrtf(w) - 3;
    p = 0.000100950558f - 0.000200214257f * w;
    p = 0.00134934322f + p * w, p = -0.00367342844f + p * w, p = 0.00573950773f + p * w;
    p = -0.0076224613f + p * w, p = 0.00943887047f + p * w, p = 1.00167406f + p * w, p = 2.83297682f + p * w;
  }
  return 1.41421356237f * p * (1 - q);
}
TRESS_ANYWHERE inline float sample_height(bool is_logistic, const Between& law, float u) {
  const float both = law.scale_below + law.scale_above;
  const bool is_below = u * both < law.scale_below;
  const float side = is_below ? law.scale_below : law.scale_above;
  const float beyond = clamp((is_below ? u : 1 - u) * both / side, 2.98023224e-8f, 1);
  const float z = is_logistic ? logf((2 - beyond) / beyond) : half_normal_beyond(beyond);
  return law.mode + (is_below ? -z : z) * side;
}

}  // namespace detail

/// The share of light at a knot that absorption leaves; rate >= 0, per major semi-axis.
TRESS_ANYWHERE inline float kept(const Knot& knot, float rate) { return expf(-knot.shape * log1pf(knot.scale * rate)); }

/// Ribbon::density() of a part: mass 1. x: radians, any turn; t: the height.
TRESS_ANYWHERE inline float density(const Part& part, float x, float t) {
  x = detail::wrap(x);
  float in_main, in_broad;
  const detail::Layer main = detail::main_of(part), broad = detail::broad_of(part);
  const int k = main.find(x, &in_main), b = broad.find(x, &in_broad);
  const detail::Between at = main.at(k, in_main), under = broad.at(b, in_broad);
  return at.density * detail::height_density(part.is_logistic != 0, at, t) +
         under.density * detail::height_density(true, under, t);
}
/// Adds weight times the density, times what each rate of absorption leaves, to `out`; any number of channels. Over all
/// places the latter two add up to the share of the part's light that is left.
TRESS_ANYWHERE inline void add_densities(const Part& part, float x, float t, float weight, const float* rates,
                                         int channels, float* out) {
  x = detail::wrap(x);
  float in_main, in_broad;
  const detail::Layer main = detail::main_of(part), broad = detail::broad_of(part);
  const int k = main.find(x, &in_main), b = broad.find(x, &in_broad);
  const float of_main = weight * detail::height_density(part.is_logistic != 0, main.at(k, in_main), t);
  const float of_broad = weight * detail::height_density(true, broad.at(b, in_broad), t);
  const Knot &main0 = main.knots[k], &main1 = main.after(k), &broad0 = broad.knots[b], &broad1 = broad.after(b);
  for (int c = 0; c < channels; ++c) {
    const float m0 = main0.density * kept(main0, rates[c]), m1 = main1.density * kept(main1, rates[c]);
    const float b0 = broad0.density * kept(broad0, rates[c]), b1 = broad1.density * kept(broad1, rates[c]);
    out[c] += (m0 + in_main * (m1 - m0)) * of_main + (b0 + in_broad * (b1 - b0)) * of_broad;
  }
}
/// Draws from density(): Ribbon::sample(). u in [0, 1), clamped.
TRESS_ANYWHERE inline void sample(const Part& part, float u_azimuth, float u_height, float* x, float* t) {
  const float v = u_azimuth * (part.main_mass + part.broad_mass);
  const bool from_main = v < part.main_mass || !(part.broad_mass > 0);
  const float share = from_main ? v / part.main_mass : (v - part.main_mass) / part.broad_mass;
  detail::Between law;
  *x = (from_main ? detail::main_of(part) : detail::broad_of(part)).sample(share, &law);
  *t = detail::sample_height(from_main ? part.is_logistic != 0 : true, law, detail::uniform(u_height));
}

/// The masses of all parts.
TRESS_ANYWHERE inline float total_mass(const Row& row) {
  float sum = 0;
  for (uint32_t p = 0; p < row.parts; ++p) sum += row.part[p].mass;
  return sum;
}
/// Colors a row: one of one channel, whose masses are what the absorption leaves. It answers and draws as a clear one,
/// and more rates add to this one. A part without light gets mass 0. out may be &row.
TRESS_ANYWHERE inline void color(const Row& row, float rate, Row* out) {
  *out = row;
  for (uint32_t p = 0; p < out->parts; ++p) {
    for (int k = 0; k < main_knots + broad_knots; ++k) {
      Knot& knot = detail::knot_of(&out->part[p], k);
      knot.density *= kept(knot, rate);
      knot.scale /= 1 + knot.scale * rate;
    }
    out->part[p].mass = static_cast<float>(double(out->part[p].mass) * detail::scale_to_one(&out->part[p]));
  }
}

/// The rows of a slice of the rough fiber, as read() gave them or colored. Pointers are the host's or a device's.
struct Table {
  const Row* rows;
  const uint32_t* row_of;  ///< by node
  const float* axis_a;     ///< theta_r
  uint32_t count_a, count_b;
};
/// Angles about the fiber as FiberDirection has them: theta within +-pi/2, phi any turn.
struct Direction {
  float theta, phi;
};
/// A node for all directions of one event. Tables of one slice in several colors share it.
struct Event {
  uint32_t row;
  float azimuth_sign, height_sign;  ///< -1: the row is mirrored
  float specular_height, phi;
};

namespace detail {
/// asinh(tan theta), at most 12 from 0.
TRESS_ANYWHERE inline float height_of(float theta) {
  const float cosine = cosf(theta);
  return cosine > 0 ? clamp(asinhf(sinf(theta) / cosine), -12, 12) : copysignf(12, theta);
}
TRESS_ANYWHERE inline void place_of(const Event& event, const Direction& wi, float* x, float* t) {
  *x = wrap(event.azimuth_sign * (wi.phi - event.phi));
  *t = event.height_sign * (height_of(wi.theta) - event.specular_height);
}
/// dheight/dtheta.
TRESS_ANYWHERE inline float per_theta(float theta) {
  const float cosine = cosf(theta);
  return 1 / (cosine > 1e-7f ? cosine : 1e-7f);
}
}  // namespace detail

/// Chooses a node around the known direction wr, towards the camera, by xi in [0, 1), as RoughGrid does: its mean over
/// xi is linear between nodes.
TRESS_ANYWHERE inline Event begin(const Table& table, const Direction& wr, float xi1, float xi2) {
  Event event = {0, 1, 1, detail::height_of(-wr.theta), wr.phi};
  float theta = wr.theta;
  if (table.axis_a[0] >= 0 && theta < 0) {
    event.height_sign = -1;
    theta = -theta;
  }
  uint32_t a = 0;
  while (a + 2 < table.count_a && table.axis_a[a + 1] <= theta) ++a;
  if (a + 1 < table.count_a && xi1 * (table.axis_a[a + 1] - table.axis_a[a]) < theta - table.axis_a[a]) ++a;
  const float wrapped = detail::wrap(wr.phi), from_axis = fabsf(wrapped), quarter = 1.57079632679f;
  const bool is_beyond = from_axis > quarter;
  const float folded = detail::clamp(is_beyond ? detail::pi() - from_axis : from_axis, 0, quarter);
  event.azimuth_sign = (wrapped < 0) != is_beyond ? -1.0f : 1.0f;
  const uint32_t last_b = table.count_b - 1;
  const uint32_t b =
      static_cast<uint32_t>(folded * static_cast<float>(last_b / 1.5707963267948966) + detail::uniform(xi2));
  event.row = table.row_of[a * table.count_b + (b < last_b ? b : last_b)];
  return event;
}
/// S at wi, per dtheta dphi, under each absorption; channels: any number. f is S / cos^2 theta_i.
TRESS_ANYWHERE inline void evaluate(const Table& table, const Event& event, const Direction& wi, const float* sigma_a,
                                    int channels, float* s) {
  float x, t;
  detail::place_of(event, wi, &x, &t);
  const Row& row = table.rows[event.row];
  for (int c = 0; c < channels; ++c) s[c] = 0;
  for (uint32_t p = 0; p < row.parts; ++p) {
    const float weight = row.part[p].mass * detail::per_theta(wi.theta);
    if (weight > 0) add_densities(row.part[p], x, t, weight, sigma_a, channels, s);
  }
}
/// The density with which sample() draws wi, per dtheta dphi; the solid-angle one is pdf / cos theta_i.
TRESS_ANYWHERE inline float pdf(const Table& table, const Event& event, const Direction& wi) {
  float x, t, sum = 0;
  detail::place_of(event, wi, &x, &t);
  const Row& row = table.rows[event.row];
  for (uint32_t p = 0; p < row.parts; ++p) {
    if (row.part[p].mass > 0) sum += row.part[p].mass * density(row.part[p], x, t);
  }
  return sum > 0 ? sum * detail::per_theta(wi.theta) / total_mass(row) : 0;
}
/// Draws by the masses of the table's rows, without absorption unless they are colored. u: three uniforms in [0, 1),
/// clamped.
TRESS_ANYWHERE inline Direction sample(const Table& table, const Event& event, const float* u) {
  const Row& row = table.rows[event.row];
  float below = u[0] * total_mass(row), x = 0, t = 0;
  uint32_t p = 0;
  while (p + 1 < row.parts && below >= row.part[p].mass) below -= row.part[p++].mass;
  while (p > 0 && !(row.part[p].mass > 0)) --p;
  if (row.part[p].mass > 0) sample(row.part[p], u[1], u[2], &x, &t);
  const Direction wi = {atanf(sinhf(event.height_sign * t + event.specular_height)),
                        detail::wrap(event.phi + event.azimuth_sign * x)};
  return wi;
}

}  // namespace frozen
}  // namespace v0_2
}  // namespace tress
