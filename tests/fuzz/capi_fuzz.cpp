// Any bytes as a sequence of calls of the C interface, in passes and out of them, on two services: one of a host's
// target, which may fail, throw, change its mind or call back, and one for fibers. No call ends the program; one that
// fails says why and gives zero, and one that does not gives numbers.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>

#include "fuzz/fuzz.h"
#include "tress/tress.h"

namespace {

using tress::fuzz::require;

/// The bytes, from which everything is taken; zeros at their end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool any() const { return left_ > 0; }
  std::uint32_t next(std::uint32_t below) {
    if (left_ == 0) return 0;
    --left_;
    return *data_++ % below;
  }
  float number() {
    constexpr float most = std::numeric_limits<float>::max(), infinity = std::numeric_limits<float>::infinity();
    constexpr std::array<float, 18> numbers{
        0,     0.5f,   1,     -1,       3.1415927f, -3.1415927f,
        7,     -100,   1e-4f, 1e-30f,   1e-45f,     0.99999994f,
        1e30f, -1e30f, most,  infinity, -infinity,  std::numeric_limits<float>::quiet_NaN()};
    const std::uint32_t i = next(64);
    return i < numbers.size() ? numbers[i] : static_cast<float>(i - numbers.size()) / 23 - 1;
  }
  template <std::size_t n>
  std::array<float, n> numbers() {
    std::array<float, n> all;
    for (float& one : all) one = number();
    return all;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/// What a result claims of what the call has written: zero if it failed.
template <class Written>
void check(tress_result result, const Written& written) {
  require(std::strcmp(tress_result_name(result), "unknown") != 0);
  if (result == TRESS_OK) return;
  require(*tress_last_error() != '\0');
  const auto* bytes = reinterpret_cast<const unsigned char*>(&written);
  require(std::all_of(bytes, bytes + sizeof written, [](unsigned char byte) { return byte == 0; }));
}

void check_sound(tress_result result, const tress_value& value) {
  check(result, value);
  require(std::isfinite(value.density) && value.density >= 0 && std::isfinite(value.pdf) && value.pdf >= 0);
  require(std::isfinite(value.azimuth) && std::isfinite(value.height));
}

void check_sound(tress_result result, const tress_fiber_value& value) {
  check(result, value);
  require(std::isfinite(value.value[0]) && std::isfinite(value.value[2]) && std::isfinite(value.pdf) && value.pdf >= 0);
}

void check_sound(tress_result result, const tress_fiber_sample& sample) {
  check(result, sample);
  require(std::isfinite(sample.direction.theta) && std::isfinite(sample.direction.phi));
  require(std::isfinite(sample.weight[1]) && std::isfinite(sample.at.pdf) && sample.at.pdf >= 0);
}

/// A host with a target of its own, as bad as the bytes say.
struct Host {
  tress_service* service = nullptr;
  std::uint32_t mood = 0;  ///< what the callbacks do
  int depth = 0, calls = 0;

  /// Whatever is called from inside a callback, at first: a thousand failures would publish a thousand times.
  void call_back() {
    if (depth > 0 || ++calls > 64) return;
    ++depth;
    tress_value value;
    check(tress_service_evaluate(service, {0, 0, 0}, 0, 0, &value), value);
    (void)tress_service_publish(service, 0, nullptr);
    (void)tress_service_prepare(service);
    (void)tress_service_publish_pays(service);
    --depth;
  }
  int ends() {
    if (mood == 1) return 0;
    if (mood == 2) throw 3;
    if (mood == 3) call_back();
    return 1;
  }
  float weight() const {
    constexpr std::array<float, 4> wrong{std::numeric_limits<float>::quiet_NaN(), -1,
                                         std::numeric_limits<float>::infinity(), 0};
    return mood >= 4 && mood < 8 ? wrong[mood - 4] : 0.25f;
  }
  static int trace(void* user, const tress_place* place, tress_rays* rays) {
    auto& self = *static_cast<Host*>(user);
    const float azimuth = self.mood == 8 ? INFINITY : place->a;
    const std::array<tress_ray, 3> all{{{azimuth, self.weight(), 0}, {place->b, 0.25f, 1}, {azimuth + 1, 0.25f, 2}}};
    if (self.mood != 9) tress_add_rays(rays, all.data(), all.size());
    return self.ends();
  }
  static int draw(void* user, const tress_place* place, std::uint64_t stream, std::uint32_t first, std::uint32_t count,
                  tress_exits* exits) {
    auto& self = *static_cast<Host*>(user);
    for (std::uint32_t i = first; i < first + count; ++i) {
      const auto bits = static_cast<std::uint32_t>((stream + i + 1) * 0x9e3779b97f4a7c15u >> 32);
      const tress_exit exit{place->a + static_cast<float>(bits & 0xffff) * 1e-5f,
                            self.mood == 8 ? INFINITY : static_cast<float>(bits >> 16) * 1e-5f,
                            self.mood == 10 ? 9 : bits & 1, self.weight(), 1};
      if (self.mood != 9) tress_add_exits(exits, &exit, 1);
    }
    return self.ends();
  }
  static void fail(void* user, tress_result, const char* message) {
    require(*message != '\0');
    auto& self = *static_cast<Host*>(user);
    if (self.mood == 2) throw 4;
    if (self.mood == 3) self.call_back();
  }
  static void log(void* user, const char* sentence) {
    require(*sentence != '\0');
    if (static_cast<Host*>(user)->mood == 3) static_cast<Host*>(user)->call_back();
  }
  static int progress(void* user, double done) {
    require(done >= 0 && done < 1);
    return static_cast<Host*>(user)->ends();
  }
  static int memory(void* user, std::int64_t bytes, int post) {
    require(bytes != 0 && (post != 0 || bytes > 0));
    const auto& self = *static_cast<Host*>(user);
    if (self.mood == 2) throw 3;
    return self.mood == 1 ? 0 : 1;
  }
};

tress_options options_of(Bytes& bytes, Host* host) {
  tress_options options;
  tress_options_init(&options);
  if (bytes.next(4) == 0) options.epsilon = static_cast<double>(bytes.number());
  if (bytes.next(4) == 0) options.sampled_epsilon = static_cast<double>(bytes.number());
  if (bytes.next(8) == 0) options.heard_share = bytes.number();
  if (bytes.next(4) == 0) options.memory_bytes = std::size_t{1} << bytes.next(24);
  options.threads = 1;
  options.check_passes = static_cast<int>(bytes.next(2));
  options.user = host;
  options.on_error = Host::fail;
  options.on_log = Host::log;
  if (bytes.next(2) == 0) options.on_progress = Host::progress;
  options.on_memory = Host::memory;
  return options;
}

/// One call on a service.
void call_service(Bytes& bytes, Host& host, tress_service* service, const std::string& file) {
  const tress_node node{bytes.next(4), bytes.next(4), bytes.next(4)};
  tress_value value{};
  switch (bytes.next(16)) {
    case 0: {
      tress_slice slice;
      tress_slice_init(&slice);
      std::array<float, 4> axis{0, 1, 2, 3};
      if (bytes.next(4) == 0) axis = bytes.numbers<4>();
      slice.kind = bytes.next(3);
      slice.lobe = bytes.next(3);
      slice.axis_a = slice.axis_b = axis.data();
      slice.count_a = bytes.next(5);
      slice.count_b = bytes.next(5);
      if (bytes.next(4) == 0) slice.blur = bytes.number();
      if (bytes.next(4) == 0) slice.parameters[bytes.next(8)] = bytes.number();
      if (bytes.next(2) == 0) slice.coarse_steps[0] = bytes.next(5);
      std::uint32_t id = 0;
      check(tress_service_add_slice(service, &slice, &id), id);
      break;
    }
    case 1:
      (void)tress_service_load(service, file.c_str());
      break;
    case 2:
      (void)tress_service_save(service, file.c_str());
      break;
    case 3:
      (void)tress_service_prepare(service);
      break;
    case 4:
      (void)tress_service_set_learning(service, static_cast<int>(bytes.next(2)));
      break;
    case 5:
    case 6: {
      tress_report report;
      const tress_result result = tress_service_publish(service, bytes.next(200), &report);
      require(result == TRESS_OK || *tress_last_error() != '\0');
      require(result != TRESS_INTERNAL);
      require(tress_service_telemetry(service) != nullptr);
      break;
    }
    case 7: {  // the life of rows: many queries of one node
      for (std::uint32_t i = bytes.next(64) * 16; i > 0; --i) {
        const float u = static_cast<float>(i % 97) / 97;
        const std::array<float, 3> uniforms{u, 1 - u, u};
        check_sound(tress_service_sample(service, node, uniforms.data(), &value), value);
        (void)tress_service_credit(service, node, 1, 8);
      }
      break;
    }
    case 8: {
      const auto u = bytes.numbers<5>();
      check_sound(tress_service_sample_mean(service, node.slice, bytes.number(), bytes.number(), u.data(), &value),
                  value);
      break;
    }
    case 9:
      check_sound(tress_service_mean(service, node.slice, bytes.number(), bytes.number(), bytes.number(),
                                     bytes.number(), &value),
                  value);
      break;
    case 10: {
      tress_node chosen;
      const auto xi = bytes.numbers<2>();
      check(tress_service_choose(service, node.slice, bytes.number(), bytes.number(), xi.data(), &chosen), chosen);
      break;
    }
    case 11: {
      const std::array<tress_node, 2> nodes{node, {bytes.next(3), bytes.next(3), bytes.next(3)}};
      const auto places = bytes.numbers<4>();
      std::array<tress_value, 2> values;
      (void)tress_service_evaluate_n(service, nodes.data(), places.data(), places.data() + 2, bytes.next(3),
                                     values.data());
      const auto u = bytes.numbers<6>();
      (void)tress_service_sample_n(service, nodes.data(), bytes.next(2) == 0 ? u.data() : nullptr, 2, values.data());
      break;
    }
    case 12:
      (void)tress_service_credit(service, node, bytes.number(), bytes.next(256));
      break;
    case 13: {
      const tress_exit exit{bytes.number(), bytes.number(), bytes.next(6), bytes.number(), bytes.number()};
      (void)tress_service_hear(host.service, node, bytes.next(8) == 0 ? nullptr : &exit);
      break;
    }
    case 14:
      host.mood = bytes.next(11);
      break;
    default:
      check_sound(tress_service_evaluate(service, node, bytes.number(), bytes.number(), &value), value);
      (void)tress_service_publish_pays(service);
  }
}

/// Fibers of every kind, made once: a shape takes a second.
struct Fibers {
  Host host;
  std::array<tress_fibers*, 5> all{};
  std::uint32_t id = 0;
  std::array<tress_event, 4> events{};
  Fibers() {
    tress_options options;
    tress_options_init(&options);
    options.user = &host;
    options.on_error = Host::fail;
    options.threads = 1;
    options.memory_bytes = std::size_t{8} << 20;
    options.heard_share = 0;  // oneTBB has paths that were heard where LeakSanitizer does not look
    require(tress_service_create_for_fibers(&options, &host.service) == TRESS_OK);
    constexpr std::array<std::array<std::uint32_t, 2>, 5> kinds{{{TRESS_ROUGH, TRESS_FITTED},
                                                                 {TRESS_ROUGH, TRESS_EXACT},
                                                                 {TRESS_ELLIPTICAL, TRESS_FITTED},
                                                                 {TRESS_ELLIPTICAL, TRESS_EXACT},
                                                                 {TRESS_ELLIPTICAL, TRESS_CORRECTED}}};
    tress_fiber hair;
    tress_fiber_init(&hair);
    hair.eccentricity = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
      require(tress_fibers_create(host.service, kinds[i][0], kinds[i][1], &all[i]) == TRESS_OK);
      require(tress_fibers_add(all[i], &hair, &id) == TRESS_OK);
    }
  }
};

void call_fibers(Bytes& bytes, Fibers& of) {
  tress_fibers* fibers = of.all[bytes.next(5)];
  tress_event& event = of.events[bytes.next(4)];
  const std::uint32_t id = bytes.next(8) == 0 ? of.id + bytes.next(3) : of.id;
  const tress_direction wr{bytes.number(), bytes.number()}, wi{bytes.number(), bytes.number()};
  const auto u = bytes.numbers<6>();
  tress_fiber_value value{};
  tress_fiber_sample sample{};
  switch (bytes.next(9)) {
    case 0:
    case 1:
      check(tress_fibers_begin(fibers, id, wr, u[0], u[1], u[2], u[3], &event), event);
      break;
    case 2:
      check_sound(tress_fibers_sample(fibers, &event, u.data(), &sample), sample);
      break;
    case 3:
      // corrected may be negative, but is a number as well
      check_sound(tress_fibers_evaluate(fibers, &event, wi, &value), value);
      break;
    case 4:
      check_sound(tress_fibers_mean(fibers, id, wr, wi, &value), value);
      check_sound(tress_fibers_sample_mean(fibers, id, wr, u.data(), u[5], &sample), sample);
      break;
    case 5: {
      const std::array<tress_vertex, 2> vertices{
          {{of.id, wr, u[0], u[1], u[2], u[3]}, {id, wi, u[3], u[2], u[1], u[0]}}};
      std::array<tress_fiber_value, 2> values{};
      const std::array<tress_direction, 2> lights{wi, wr};
      (void)tress_fibers_begin_n(fibers, vertices.data(), 2, of.events.data());
      (void)tress_fibers_evaluate_n(fibers, of.events.data(), lights.data(), 2, values.data());
      break;
    }
    case 6: {
      tress_fiber hair;
      tress_fiber_init(&hair);
      hair.eccentricity = 1;
      (&hair.eta)[bytes.next(7)] = NAN;  // of the seven numbers that follow each other
      std::uint32_t none = 0;
      require(tress_fibers_add(fibers, &hair, &none) == TRESS_INVALID_ARGUMENT && none == UINT32_MAX);
      (void)tress_fiber_set_color(&hair, u.data());
      (void)tress_fiber_set_principled(&hair, u[0], u[1], u[2]);
      break;
    }
    case 7:
      std::memset(&event, 0, sizeof event);
      (void)tress_fibers_takes_lights(fibers, &event);
      break;
    default:
      (void)tress_service_publish(of.host.service, 1, nullptr);
      (void)tress_fibers_bytes(fibers);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Fibers fibers;
  static const std::string file = "/tmp/tress_capi_fuzz." + std::to_string(getpid());
  if (size > 512) return 0;
  Bytes bytes(data, size);
  Host host;
  const tress_options options = options_of(bytes, &host);
  const std::uint32_t kinds = bytes.next(4);
  const tress_target target{bytes.next(16) == 0 ? "" : "fuzz-1", &host, kinds & 1 ? nullptr : Host::trace,
                            kinds & 2 ? nullptr : Host::draw, bytes.next(6)};
  check(tress_service_create(&target, &options, &host.service), host.service);
  tress_fibers* wrong = nullptr;
  check(tress_fibers_create(host.service, bytes.next(3), bytes.next(4), &wrong), wrong);
  tress_fibers_release(wrong);
  while (bytes.any()) {
    if (bytes.next(3) == 0) {
      call_fibers(bytes, fibers);
    } else {
      call_service(bytes, host, bytes.next(8) == 0 ? fibers.host.service : host.service, file);
    }
  }
  tress_service_release(host.service);
  std::remove(file.c_str());
  return 0;
}
