// The C interface: the bits of the C++ interface, and a code for every input that is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tress/adaptive/cache.h"
#include "tress/adaptive/service.h"
#include "tress/base/random.h"
#include "tress/fiber/elliptical_model.h"
#include "tress/fiber/principled_hair.h"
#include "tress/fiber/rough_model.h"
#include "tress/tress.h"
#include "tress/version.h"

namespace tress {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

struct Draws {
  float theta, phi, xi1, xi2, h, importance;
  std::array<float, 4> u;
  tress_direction light;
};

Draws draws(std::uint64_t pass, std::uint64_t i) {
  RandomStream random(3, pass, i);
  const auto next = [&] { return random.next(); };
  Draws made{};
  made.theta = 2 * next() - 1;
  made.phi = 6 * next() - 3;
  made.xi1 = next();
  made.xi2 = next();
  made.h = 2 * next() - 1;
  made.importance = next();
  for (float& u : made.u) u = next();
  made.light = {2 * next() - 1, 6 * next() - 3};
  return made;
}

/// All numbers of a session of a few passes, by the one interface or the other.
struct Session {
  std::vector<float> numbers;
  std::string cache;
};

std::string bytes_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

constexpr std::uint64_t passes = 3, events = 300;

/// threads: of publish(), and of the host.
Session by_c(std::uint32_t model, std::uint32_t threads, bool has_tasks = false) {
  Session session;
  tress_options options;
  tress_options_init(&options);
  options.seed = 5;
  options.threads = threads;
  if (has_tasks) {
    options.parallel_for = [](void*, size_t count, void (*task)(void*, size_t), void* data) {
      const auto half = [&](size_t from) {
        for (size_t i = from; i < count; i += 2) task(data, i);
      };
      std::thread other(half, 1);
      half(0);
      other.join();
    };
  }
  tress_service* service = nullptr;
  tress_fibers* fibers = nullptr;
  tress_fiber hair;
  tress_fiber_init(&hair);
  hair.roughness = 0.25f;
  std::uint32_t id = 0;
  EXPECT_EQ(tress_service_create_for_fibers(&options, &service), TRESS_OK);
  EXPECT_EQ(tress_fibers_create(service, model, TRESS_FITTED, &fibers), TRESS_OK);
  EXPECT_EQ(tress_fibers_add(fibers, &hair, &id), TRESS_OK) << tress_last_error();
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    const std::size_t first = session.numbers.size();
    session.numbers.resize(first + events * 11);
    const auto run = [&](std::uint64_t begin) {
      for (std::uint64_t i = begin; i < events; i += threads) {
        const Draws d = draws(pass, i);
        tress_event event;
        tress_fiber_sample sample;
        tress_fiber_value lit;
        EXPECT_EQ(tress_fibers_begin(fibers, id, {d.theta, d.phi}, d.xi1, d.xi2, d.h, d.importance, &event), TRESS_OK);
        EXPECT_EQ(tress_fibers_sample(fibers, &event, d.u.data(), &sample), TRESS_OK);
        EXPECT_EQ(tress_fibers_evaluate(fibers, &event, d.light, &lit), TRESS_OK);
        const float drawn[11] = {sample.direction.theta,
                                 sample.direction.phi,
                                 sample.at.value[0],
                                 sample.at.value[1],
                                 sample.at.value[2],
                                 sample.at.pdf,
                                 static_cast<float>(sample.lobe),
                                 lit.value[0],
                                 lit.value[1],
                                 lit.value[2],
                                 lit.pdf};
        std::ranges::copy(drawn, session.numbers.begin() + static_cast<std::ptrdiff_t>(first + i * 11));
      }
    };
    std::vector<std::thread> others;
    for (std::uint32_t t = 1; t < threads; ++t) others.emplace_back(run, t);
    run(0);
    for (std::thread& other : others) other.join();
    EXPECT_EQ(tress_service_publish(service, events, nullptr), TRESS_OK);
  }
  const std::string file = ::testing::TempDir() + "/by_c.cache";
  std::remove(file.c_str());
  EXPECT_EQ(tress_service_save(service, file.c_str()), TRESS_OK);
  session.cache = bytes_of(file);
  std::remove(file.c_str());
  tress_service_release(service);  // the fibers keep what they need
  tress_event event;
  EXPECT_EQ(tress_fibers_begin(fibers, id, {0, 0}, 0, 0, 0, 1, &event), TRESS_OK);
  tress_fibers_release(fibers);
  return session;
}

Session by_cpp(std::uint32_t model) {
  Session session;
  adaptive::Options options;
  options.seed = 5;
  const auto densities = fiber::make_elliptical_target();
  const auto samples = fiber::make_rough_target();
  adaptive::Service service(options, *densities, *samples);
  const auto made = model == TRESS_ROUGH ? fiber::make_rough_model(fiber::Estimator::fitted, &service)
                                         : fiber::make_elliptical_model(fiber::Estimator::fitted, &service);
  fiber::FiberModel& fibers = **made;
  fiber::FiberParameters hair;
  hair.roughness = 0.25f;
  const fiber::FiberId id = fibers.add_fiber(hair);
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    for (std::uint64_t i = 0; i < events; ++i) {
      const Draws d = draws(pass, i);
      const fiber::FiberEvent event = fibers.begin(id, {d.theta, d.phi}, d.xi1, d.xi2, d.h, d.importance);
      const fiber::FiberSample sample = fibers.sample(event, d.u);
      const fiber::FiberValue lit = fibers.evaluate(event, {d.light.theta, d.light.phi});
      const glm::vec3 drawn = sample.value.total(), value = lit.total();
      session.numbers.insert(session.numbers.end(),
                             {sample.wi.theta, sample.wi.phi, drawn.x, drawn.y, drawn.z, sample.value.pdf,
                              static_cast<float>(sample.lobe), value.x, value.y, value.z, lit.pdf});
    }
    service.publish(events);
  }
  const std::string file = ::testing::TempDir() + "/by_cpp.cache";
  std::remove(file.c_str());
  EXPECT_TRUE(adaptive::merge_into_cache(file, *service.rows()));
  session.cache = bytes_of(file);
  std::remove(file.c_str());
  return session;
}

TEST(CInterface, HasTheBitsOfTheCppInterface) {
  for (const std::uint32_t model : {TRESS_ROUGH, TRESS_ELLIPTICAL}) {
    const Session c = by_c(model, 1), cpp = by_cpp(model);
    ASSERT_EQ(c.numbers.size(), passes * events * 11);
    EXPECT_EQ(std::memcmp(c.numbers.data(), cpp.numbers.data(), c.numbers.size() * sizeof(float)), 0) << model;
    EXPECT_GT(c.cache.size(), 1000u);
    EXPECT_TRUE(c.cache == cpp.cache) << model;
    for (const bool has_tasks : {false, true}) {
      const Session other = by_c(model, 3, has_tasks);
      EXPECT_TRUE(other.numbers == c.numbers && other.cache == c.cache) << model << ' ' << has_tasks;
    }
  }
}

TEST(CInterface, ItsDefaultsAreThoseOfCpp) {
  tress_options options;
  tress_options_init(&options);
  const adaptive::Options defaults;
  EXPECT_EQ(options.epsilon, defaults.epsilon);
  EXPECT_EQ(options.memory_bytes, defaults.memory_bytes);
  EXPECT_EQ(options.heard_share, defaults.heard_share);
  EXPECT_EQ(tress_version(), static_cast<std::uint32_t>(TRESS_VERSION));
  EXPECT_STREQ(tress_result_name(TRESS_CANCELLED), "TRESS_CANCELLED");
  tress_fiber hair;
  tress_fiber_init(&hair);
  const float brown[3] = {0.5f, 0.3f, 0.15f};
  EXPECT_EQ(tress_fiber_set_color(&hair, brown), TRESS_OK);
  EXPECT_GT(hair.sigma_a[2], hair.sigma_a[0]);
  hair.eccentricity = 0.853f;
  const float u[3] = {0.6f, 0, 0}, beyond[3] = {0, 1, 0};
  EXPECT_EQ(tress_fiber_round(&hair, u), TRESS_OK);
  EXPECT_FLOAT_EQ(hair.eccentricity, 0.85f);
  EXPECT_NE(tress_fiber_round(&hair, beyond), TRESS_OK);
}

TEST(CInterface, APrincipledFiberIsThatOfCpp) {
  tress_fiber hair;
  tress_fiber_init(&hair);
  ASSERT_EQ(tress_fiber_set_principled(&hair, 0.3f, 0.4f, 0.5f), TRESS_OK);
  const fiber::FiberParameters expected = fiber::fiber_of(fiber::PrincipledHair{
      .roughness = 0.3f, .radial_roughness = 0.4f, .coat = 0.5f, .widths = fiber::PrincipledWidths::equal});
  EXPECT_EQ(hair.longitudinal_shape, static_cast<std::uint32_t>(expected.longitudinal_shape));
  EXPECT_EQ(hair.roughness, expected.roughness);
  EXPECT_EQ(hair.eccentricity, 1);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(hair.longitudinal_lambda[p], expected.longitudinal_lambda[p]) << p;
  for (std::size_t p = 0; p < 3; ++p) EXPECT_EQ(hair.azimuthal_sigma[p], expected.azimuthal_sigma[p]) << p;
  for (int i = 0; i < 3; ++i) {
    const float wrong[] = {nan, -0.1f, 1.1f};
    float at[3] = {0, 0, 0};
    at[i] = wrong[i];
    EXPECT_EQ(tress_fiber_set_principled(&hair, at[0], at[1], at[2]), TRESS_INVALID_ARGUMENT) << i;
  }

  // The law reaches the lobes: of equal half width, a Gaussian has less of its light far out than a logistic.
  tress_fibers* fibers = nullptr;
  ASSERT_EQ(tress_fibers_create(nullptr, TRESS_ELLIPTICAL, TRESS_EXACT, &fibers), TRESS_OK);
  float far_out[2] = {0, 0};
  for (const std::uint32_t shape : {TRESS_LOGISTIC, TRESS_GAUSSIAN}) {
    hair.longitudinal_shape = shape;
    for (float& sigma : hair.sigma_a) sigma = 50;  // R alone
    std::uint32_t id = 0;
    ASSERT_EQ(tress_fibers_add(fibers, &hair, &id), TRESS_OK);
    tress_event event;
    ASSERT_EQ(tress_fibers_begin(fibers, id, {0, 0}, 0.5f, 0.5f, 0, 1, &event), TRESS_OK);
    tress_fiber_value value;
    ASSERT_EQ(tress_fibers_evaluate(fibers, &event, {1, 0}, &value), TRESS_OK);
    far_out[shape] = value.value[0];
  }
  EXPECT_LT(far_out[TRESS_GAUSSIAN], 0.1f * far_out[TRESS_LOGISTIC]);
  hair.longitudinal_shape = 3;
  std::uint32_t id = 0;
  EXPECT_EQ(tress_fibers_add(fibers, &hair, &id), TRESS_INVALID_ARGUMENT);
  EXPECT_STREQ(tress_last_error(),
               "tress_fiber::longitudinal_shape: expected TRESS_LOGISTIC, TRESS_GAUSSIAN or TRESS_CAUCHY, found 3");
  tress_fibers_release(fibers);
}

// Black fibers reflect alone: from h = 0.8, asin 0.8 = 53 degrees towards rising azimuth, by twice that.
TEST(CInterface, TheOffsetRisesWithTheAzimuth) {
  tress_fibers* fibers = nullptr;
  ASSERT_EQ(tress_fibers_create(nullptr, TRESS_ROUGH, TRESS_EXACT, &fibers), TRESS_OK);
  tress_fiber black;
  tress_fiber_init(&black);
  black.eccentricity = 1;
  black.roughness = 0.05f;
  for (float& sigma : black.sigma_a) sigma = 50;
  std::uint32_t id = 0;
  ASSERT_EQ(tress_fibers_add(fibers, &black, &id), TRESS_OK);
  for (const float h : {0.8f, -0.8f}) {
    tress_event event;
    ASSERT_EQ(tress_fibers_begin(fibers, id, {0, 0.5f}, 0.5f, 0.5f, h, 1, &event), TRESS_OK);
    const float u[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    tress_fiber_sample drawn;
    ASSERT_EQ(tress_fibers_sample(fibers, &event, u, &drawn), TRESS_OK);
    EXPECT_NEAR(drawn.direction.phi, 0.5f + std::copysign(1.855f, h), 0.4f);
  }
  tress_fibers_release(fibers);
}

// A host that samples lights where it is asked to finds the light of a white furnace, before any row answers: the mean
// of S over uniform directions, theta and phi, is 1/(2 pi^2). Seed 3; 5 standard errors: 6e-7 of false alarms.
TEST(CInterface, LightSamplesReachFibersThatNoRowAnswers) {
  tress_options options;
  tress_options_init(&options);
  tress_service* service = nullptr;
  tress_fibers* fibers = nullptr;
  ASSERT_EQ(tress_service_create_for_fibers(&options, &service), TRESS_OK);
  ASSERT_EQ(tress_fibers_create(service, TRESS_ROUGH, TRESS_FITTED, &fibers), TRESS_OK);
  tress_fiber white;
  tress_fiber_init(&white);
  for (float& sigma : white.sigma_a) sigma = 0;
  std::uint32_t id = 0;
  ASSERT_EQ(tress_fibers_add(fibers, &white, &id), TRESS_OK);
  constexpr int events = 20000;
  constexpr double pi = 3.14159265358979;
  double sum = 0, squares = 0;
  RandomStream random(3, 0, 0);
  for (int i = 0; i < events; ++i) {
    const float xi1 = random.next(), xi2 = random.next(), h = 2 * random.next() - 1;
    const float theta = static_cast<float>(pi) * (random.next() - 0.5f),
                phi = static_cast<float>(2 * pi) * random.next();
    tress_event event;
    ASSERT_EQ(tress_fibers_begin(fibers, id, {0.3f, 0.8f}, xi1, xi2, h, 1, &event), TRESS_OK);
    ASSERT_EQ(tress_fibers_takes_lights(fibers, &event), 1);
    tress_fiber_value value;
    ASSERT_EQ(tress_fibers_evaluate(fibers, &event, {theta, phi}, &value), TRESS_OK);
    EXPECT_GT(value.pdf, 0);
    const double light = 2 * pi * pi * double{value.value[1]};
    sum += light / events;
    squares += light * light / events;
  }
  EXPECT_NEAR(sum, 1, 5 * std::sqrt((squares - sum * sum) / events));
  EXPECT_LT(squares, 30) << "too wide a spread to find a loss";
  tress_fibers_release(fibers);
  tress_service_release(service);
}

/// A service with a slice of densities and one of samples, whose target does what a test asks of it.
struct Host {
  Host() {
    tress_options_init(&options);
    options.user = this;
    options.on_error = [](void* user, tress_result result, const char* message) {
      auto& self = *static_cast<Host*>(user);
      ++self.failures;
      self.last = result;
      EXPECT_STREQ(message, tress_last_error());
    };
  }
  ~Host() { tress_service_release(service); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  tress_result create() {
    target.user = this;
    const tress_result result = tress_service_create(&target, &options, &service);
    if (result != TRESS_OK) return result;
    slice.axis_a = slice.axis_b = axis.data();
    slice.count_a = slice.count_b = axis.size();
    EXPECT_EQ(tress_service_add_slice(service, &slice, &densities), TRESS_OK);
    slice.kind = TRESS_SAMPLES;
    slice.lobe = 1;
    EXPECT_EQ(tress_service_add_slice(service, &slice, &samples), TRESS_OK);
    return result;
  }

  static int trace(void* user, const tress_place* place, tress_rays* rays) {
    auto& self = *static_cast<Host*>(user);
    if (self.calls_inside) {
      EXPECT_EQ(tress_service_publish(self.service, 0, nullptr), TRESS_INVALID_CALL);
      EXPECT_EQ(tress_service_credit(self.service, {0, 0, 0}, 1, 1), TRESS_INVALID_CALL);
      EXPECT_EQ(tress_service_save(self.service, "never"), TRESS_INVALID_CALL);
    }
    const tress_ray ray{place->a, self.weight, 0};
    tress_add_rays(rays, &ray, 1);
    tress_add_rays(nullptr, &ray, 1);
    tress_add_rays(rays, nullptr, 1);
    if (self.throws) throw 3;
    return self.fails ? 0 : 1;
  }
  static int draw(void* user, const tress_place* place, std::uint64_t stream, std::uint32_t first, std::uint32_t count,
                  tress_exits* exits) {
    const auto& self = *static_cast<const Host*>(user);
    for (std::uint32_t i = first; i < first + count; ++i) {
      RandomStream random(stream, i);
      const tress_exit exit{place->a + random.next(), random.next(), self.part, 0.5f, 0};
      tress_add_exits(exits, &exit, 1);
    }
    tress_add_exits(nullptr, nullptr, 1);
    return self.fails ? 0 : 1;
  }

  std::vector<float> axis{0, 1, 2};
  tress_target target{"host-1", nullptr, trace, draw, 1};
  tress_options options{};
  tress_slice slice = [] {
    tress_slice made;
    tress_slice_init(&made);
    return made;
  }();
  tress_service* service = nullptr;
  std::uint32_t densities = 0, samples = 0, part = 0;
  float weight = 0.5f;
  bool fails = false, throws = false, calls_inside = false;
  int failures = 0;
  tress_result last = TRESS_OK;
};

TEST(CInterface, NullIsRefusedEverywhere) {
  const float u[4] = {0.1f, 0.2f, 0.3f, 0.4f}, color[3] = {0.5f, 0.5f, 0.5f};
  const tress_exit exit{};
  tress_target target{"host-1", nullptr, Host::trace, nullptr, 0};
  tress_slice slice{};
  tress_fiber fiber;
  tress_value value;
  tress_event event;
  tress_fiber_sample sample;
  tress_fiber_value lit;
  tress_service* service = nullptr;
  tress_fibers* fibers = nullptr;
  std::uint32_t id = 0;
  tress_options_init(nullptr);
  tress_slice_init(nullptr);
  tress_fiber_init(nullptr);
  tress_fiber_init(&fiber);
  tress_service_release(nullptr);
  tress_fibers_release(nullptr);
  for (const tress_result result : {tress_service_create(nullptr, nullptr, &service),
                                    tress_service_create(&target, nullptr, nullptr),
                                    tress_service_create_for_fibers(nullptr, nullptr),
                                    tress_service_add_slice(nullptr, &slice, &id),
                                    tress_service_load(nullptr, "file"),
                                    tress_service_save(nullptr, "file"),
                                    tress_service_prepare(nullptr),
                                    tress_service_set_learning(nullptr, 0),
                                    tress_service_sample(nullptr, {}, u, &value),
                                    tress_service_evaluate(nullptr, {}, 0, 0, &value),
                                    tress_service_sample_n(nullptr, nullptr, u, 1, &value),
                                    tress_service_evaluate_n(nullptr, nullptr, u, u, 1, &value),
                                    tress_service_choose(nullptr, 0, 0, 0, u, nullptr),
                                    tress_service_mean(nullptr, 0, 0, 0, 0, 0, &value),
                                    tress_service_sample_mean(nullptr, 0, 0, 0, nullptr, &value),
                                    tress_service_credit(nullptr, {}, 1, 1),
                                    tress_service_hear(nullptr, {}, &exit),
                                    tress_service_publish(nullptr, 0, nullptr),
                                    tress_fibers_create(nullptr, TRESS_ROUGH, TRESS_FITTED, &fibers),
                                    tress_fibers_create(nullptr, TRESS_ROUGH, TRESS_EXACT, nullptr),
                                    tress_fiber_set_color(nullptr, color),
                                    tress_fiber_round(nullptr, color),
                                    tress_fiber_round(&fiber, nullptr),
                                    tress_fiber_set_principled(nullptr, 0, 0, 0),
                                    tress_fiber_set_color(&fiber, nullptr),
                                    tress_fibers_add(nullptr, &fiber, &id),
                                    tress_fibers_begin(nullptr, 0, {}, 0, 0, 0, 1, &event),
                                    tress_fibers_sample(nullptr, &event, u, &sample),
                                    tress_fibers_evaluate(nullptr, &event, {}, &lit),
                                    tress_fibers_begin_n(nullptr, nullptr, 1, &event),
                                    tress_fibers_sample_n(nullptr, nullptr, u, 1, &sample),
                                    tress_fibers_evaluate_n(nullptr, nullptr, nullptr, 1, &lit),
                                    tress_fibers_pdf(nullptr, &event, {}, nullptr),
                                    tress_fibers_evaluate_spectrum(nullptr, &event, {}, u, 0, nullptr, nullptr),
                                    tress_fibers_sample_spectrum(nullptr, &event, u, u, 0, &sample, nullptr),
                                    tress_service_pdf(nullptr, {}, 0, 0, nullptr),
                                    tress_fibers_mean(nullptr, 0, {}, {}, &lit),
                                    tress_fibers_sample_mean(nullptr, 0, {}, nullptr, 1, &sample)})
    EXPECT_EQ(result, TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(service, nullptr);
  EXPECT_EQ(fibers, nullptr);
  EXPECT_EQ(sample.at.pdf, 0);
  EXPECT_STREQ(tress_service_telemetry(nullptr), "");
  EXPECT_EQ(tress_fibers_takes_lights(nullptr, nullptr), 0);
  EXPECT_EQ(tress_fibers_bytes(nullptr), 0u);
  EXPECT_EQ(tress_service_publish_pays(nullptr), 0);

  Host host;
  ASSERT_EQ(host.create(), TRESS_OK);
  for (const tress_result result :
       {tress_service_add_slice(host.service, nullptr, &id),
        tress_service_add_slice(host.service, &host.slice, nullptr), tress_service_load(host.service, nullptr),
        tress_service_save(host.service, nullptr), tress_service_sample(host.service, {}, nullptr, &value),
        tress_service_sample(host.service, {}, u, nullptr), tress_service_evaluate(host.service, {}, 0, 0, nullptr),
        tress_service_hear(host.service, {1, 0, 0}, nullptr), tress_service_choose(host.service, 0, 0, 0, u, nullptr),
        tress_service_mean(host.service, 0, 0, 0, 0, 0, nullptr),
        tress_service_sample_mean(host.service, 0, 0, 0, nullptr, &value)})
    EXPECT_EQ(result, TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(host.failures, 11);
  ASSERT_EQ(tress_fibers_create(nullptr, TRESS_ROUGH, TRESS_EXACT, &fibers), TRESS_OK);
  ASSERT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_OK);
  ASSERT_EQ(tress_fibers_begin(fibers, id, {}, 0, 0, 0, 1, &event), TRESS_OK);
  for (const tress_result result :
       {tress_fibers_add(fibers, nullptr, &id), tress_fibers_add(fibers, &fiber, nullptr),
        tress_fibers_begin(fibers, 0, {}, 0, 0, 0, 1, nullptr), tress_fibers_sample(fibers, nullptr, u, &sample),
        tress_fibers_sample(fibers, &event, nullptr, &sample), tress_fibers_sample(fibers, &event, u, nullptr),
        tress_fibers_evaluate(fibers, &event, {}, nullptr), tress_fibers_pdf(fibers, &event, {}, nullptr),
        tress_fibers_evaluate_spectrum(fibers, &event, {}, nullptr, 1, &lit.pdf, nullptr),
        tress_fibers_sample_spectrum(fibers, &event, u, u, 1, &sample, nullptr),
        tress_fibers_evaluate_spectrum(fibers, &event, {}, &nan, 1, &lit.pdf, nullptr),
        tress_fibers_begin_n(fibers, nullptr, 1, &event), tress_fibers_mean(fibers, id, {}, {}, nullptr),
        tress_fibers_sample_mean(fibers, id, {}, nullptr, 1, &sample)})
    EXPECT_EQ(result, TRESS_INVALID_ARGUMENT);
  tress_fibers_release(fibers);
}

TEST(CInterface, NumbersOutOfRangeAreRefused) {
  for (int i = 0; i < 12; ++i) {
    Host host;
    if (i == 0) host.options.epsilon = 0;
    if (i == 1) host.options.epsilon = std::numeric_limits<double>::quiet_NaN();
    if (i == 2) host.options.sampled_epsilon = -1;
    if (i == 3) host.options.picture_error = std::numeric_limits<double>::infinity();
    if (i == 4) host.options.heard_share = nan;
    if (i == 5) host.options.heard_share = 2;
    if (i == 6) host.options.threads = 1u << 31;
    if (i == 7) host.target.name = nullptr;
    if (i == 8) host.target.name = "";
    if (i == 9) host.target.trace = nullptr, host.target.draw = nullptr;
    if (i == 10) host.target.parts = 0;
    if (i == 11) host.target.parts = 5;
    EXPECT_EQ(host.create(), TRESS_INVALID_ARGUMENT) << i;
    EXPECT_EQ(host.service, nullptr);
    EXPECT_EQ(host.last, TRESS_INVALID_ARGUMENT);
    EXPECT_NE(std::strstr(tress_last_error(), "expected"), nullptr) << i;
  }
  Host host;
  ASSERT_EQ(host.create(), TRESS_OK);
  for (int i = 0; i < 13; ++i) {
    tress_slice slice = host.slice;
    slice.lobe = 7;
    const float wrong[3] = {0, nan, 1}, falls[3] = {2, 1, 0};
    if (i == 0) slice.kind = 2;
    if (i == 1) slice.axis_a = nullptr;
    if (i == 2) slice.axis_b = wrong;
    if (i == 3) slice.axis_b = falls;
    if (i == 4) slice.count_a = 0;
    if (i == 5) slice.count_b = SIZE_MAX;
    if (i == 6) slice.kind = TRESS_DENSITIES, slice.blur = 0;
    if (i == 7) slice.kind = TRESS_DENSITIES, slice.blur = nan;
    if (i == 8) slice.parameters[7] = infinity;
    if (i == 9) slice.kind = TRESS_DENSITIES, slice.parameters[3] = 1;
    if (i == 10) slice.coarse_steps[0] = 1;
    if (i == 11) slice.coarse_steps[0] = 4, slice.coarse_steps[1] = 3;
    if (i == 12) slice.kind = TRESS_DENSITIES, slice.coarse_steps[0] = 2;
    std::uint32_t id = 9;
    EXPECT_EQ(tress_service_add_slice(host.service, &slice, &id), TRESS_INVALID_ARGUMENT) << i;
    EXPECT_EQ(id, 0u);
  }
  tress_value value;
  const float u[3] = {nan, infinity, -1};
  for (const tress_node node : {tress_node{9, 0, 0}, tress_node{0, 3, 0}, tress_node{0, 0, ~0u}, tress_node{1, 3, 3}}) {
    EXPECT_EQ(tress_service_sample(host.service, node, u, &value), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(tress_service_evaluate(host.service, node, 0, 0, &value), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(tress_service_credit(host.service, node, 1, 1), TRESS_INVALID_ARGUMENT);
  }
  for (const std::uint32_t slice : {host.densities, host.samples}) {
    EXPECT_EQ(tress_service_sample(host.service, {slice, 0, 0}, u, &value), TRESS_OK);
    EXPECT_TRUE(std::isfinite(value.azimuth) && std::isfinite(value.density));
    for (const float wrong : {nan, infinity}) {
      EXPECT_EQ(tress_service_evaluate(host.service, {slice, 0, 0}, wrong, 0, &value), TRESS_INVALID_ARGUMENT);
      EXPECT_EQ(tress_service_evaluate(host.service, {slice, 0, 0}, 0, wrong, &value), TRESS_INVALID_ARGUMENT);
      EXPECT_EQ(tress_service_credit(host.service, {slice, 0, 0}, wrong, 1), TRESS_INVALID_ARGUMENT);
    }
  }
  EXPECT_EQ(tress_service_credit(host.service, {0, 0, 0}, -1, 1), TRESS_INVALID_ARGUMENT);
  const tress_exit right{0, 0, 0, 1, 0};
  EXPECT_EQ(tress_service_hear(host.service, {host.samples, 0, 0}, &right), TRESS_OK);
  EXPECT_EQ(tress_service_hear(host.service, {host.densities, 0, 0}, &right), TRESS_INVALID_ARGUMENT);
  for (const tress_exit& wrong : {tress_exit{nan, 0, 0, 1, 0}, tress_exit{0, infinity, 0, 1, 0},
                                  tress_exit{0, 0, 0, -1, 0}, tress_exit{0, 0, 0, 1, -1}})
    EXPECT_EQ(tress_service_hear(host.service, {host.samples, 0, 0}, &wrong), TRESS_INVALID_ARGUMENT);
  const tress_exit of_no_part{0, 0, 77, 1, 0};
  EXPECT_EQ(tress_service_hear(host.service, {host.samples, 0, 0}, &of_no_part), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_service_publish(host.service, 1, nullptr), TRESS_OK);
}

TEST(CInterface, TargetsThatFailAreReportedAndCallsFromInsideThemRefused) {
  for (int i = 0; i < 5; ++i) {
    Host host;
    ASSERT_EQ(host.create(), TRESS_OK);
    if (i == 0) host.fails = true;
    if (i == 1) host.throws = true;
    if (i == 2) host.weight = nan;
    if (i == 3) host.weight = -1;
    if (i == 4) host.calls_inside = true;
    tress_value value;
    EXPECT_EQ(tress_service_evaluate(host.service, {host.densities, 1, 1}, 1, 0, &value), TRESS_OK);
    EXPECT_EQ(value.density > 0, i == 4);
    tress_report report;
    EXPECT_EQ(tress_service_publish(host.service, 1, &report), i == 4 ? TRESS_OK : TRESS_MISUSE) << i;
    EXPECT_EQ(report.queries, 1u);
    host.fails = host.throws = host.calls_inside = false;
    host.weight = 0.5f;
    EXPECT_EQ(tress_service_evaluate(host.service, {host.densities, 1, 1}, 1, 0, &value), TRESS_OK);
    EXPECT_GT(value.density, 0);
  }
  Host host;
  host.part = 3;  // there is one part
  ASSERT_EQ(host.create(), TRESS_OK);
  tress_report report{};
  const float u[3] = {};
  tress_value value;
  for (int i = 0; i < 1000; ++i) tress_service_sample(host.service, {host.samples, 1, 1}, u, &value);
  tress_service_publish(host.service, 1, &report);
  EXPECT_EQ(value.answered, 0);
  EXPECT_EQ(report.rows_refused, 1u);
}

TEST(CInterface, EventsOfOthersAndOfBeforeAreRefused) {
  tress_service* service = nullptr;
  ASSERT_EQ(tress_service_create_for_fibers(nullptr, &service), TRESS_OK);
  Host other;
  ASSERT_EQ(other.create(), TRESS_OK);
  tress_fibers *rough = nullptr, *elliptical = nullptr, *none = nullptr;
  std::uint32_t slice = 9;
  EXPECT_EQ(tress_service_add_slice(service, &other.slice, &slice), TRESS_INVALID_ARGUMENT) << "lobe 1, all zero";
  ASSERT_EQ(tress_fibers_create(service, TRESS_ROUGH, TRESS_FITTED, &rough), TRESS_OK);
  ASSERT_EQ(tress_fibers_create(service, TRESS_ELLIPTICAL, TRESS_CORRECTED, &elliptical), TRESS_OK);
  EXPECT_EQ(tress_fibers_create(service, 2, TRESS_FITTED, &none), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_fibers_create(service, TRESS_ROUGH, 3, &none), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_fibers_create(service, TRESS_ROUGH, TRESS_CORRECTED, &none), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_fibers_create(other.service, TRESS_ROUGH, TRESS_FITTED, &none), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(none, nullptr);

  tress_fiber hair;
  std::uint32_t id = 0;
  for (int i = 0; i < 8; ++i) {
    tress_fiber_init(&hair);
    if (i == 0) hair.eta = nan;
    if (i == 1) hair.eccentricity = 3;
    if (i == 2) hair.roughness = 0;
    if (i == 3) hair.tilt = -1;
    if (i == 4) hair.sigma_a[1] = infinity;
    if (i == 5) hair.azimuthal_sigma[0] = nan;
    if (i == 6) hair.gain[5][2] = -1;
    if (i == 7) hair.medulla_radius = 1;
    EXPECT_EQ(tress_fibers_add(rough, &hair, &id), TRESS_INVALID_ARGUMENT) << i;
    EXPECT_NE(std::strstr(tress_last_error(), "tress_fiber::"), nullptr);
  }
  tress_fiber_init(&hair);
  const float wrong_color[3] = {0.5f, nan, 0.5f};
  EXPECT_EQ(tress_fiber_set_color(&hair, wrong_color), TRESS_INVALID_ARGUMENT);
  std::uint32_t id_of_elliptical = 0;
  ASSERT_EQ(tress_fibers_add(rough, &hair, &id), TRESS_OK);
  ASSERT_EQ(tress_fibers_add(elliptical, &hair, &id_of_elliptical), TRESS_OK);

  const float u[4] = {0.2f, 0.7f, 0.4f, 0.5f}, no_numbers[4] = {nan, infinity, -infinity, 7};
  tress_event event, copied, garbage;
  tress_fiber_sample sample;
  tress_fiber_value lit;
  EXPECT_EQ(tress_fibers_begin(rough, id + 1, {}, 0, 0, 0, 1, &event), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_fibers_sample(rough, &event, u, &sample), TRESS_INVALID_CALL) << "it is no event";
  std::memset(&garbage, 0xa5, sizeof garbage);
  EXPECT_EQ(tress_fibers_evaluate(rough, &garbage, {}, &lit), TRESS_INVALID_CALL);
  EXPECT_EQ(tress_fibers_takes_lights(rough, &garbage), 0);

  EXPECT_EQ(tress_fibers_begin(rough, id, {nan, infinity}, nan, -infinity, nan, nan, &event), TRESS_OK);
  EXPECT_EQ(tress_fibers_sample(rough, &event, no_numbers, &sample), TRESS_OK);
  EXPECT_TRUE(std::isfinite(sample.direction.theta) && std::isfinite(sample.weight[0]) && std::isfinite(sample.at.pdf));
  EXPECT_EQ(tress_fibers_evaluate(rough, &event, {nan, infinity}, &lit), TRESS_OK);
  EXPECT_TRUE(std::isfinite(lit.value[0]) && std::isfinite(lit.pdf));
  copied = event;
  EXPECT_EQ(tress_fibers_sample(rough, &copied, u, &sample), TRESS_OK);
  EXPECT_EQ(tress_fibers_takes_lights(rough, &copied), 1);
  EXPECT_EQ(tress_fibers_sample(elliptical, &event, u, &sample), TRESS_INVALID_CALL);
  EXPECT_EQ(sample.at.pdf, 0);
  EXPECT_EQ(tress_service_publish(service, 1, nullptr), TRESS_OK);
  EXPECT_EQ(tress_fibers_sample(rough, &event, u, &sample), TRESS_INVALID_CALL);
  tress_fibers_release(rough);
  tress_fibers_release(elliptical);
  tress_service_release(service);
}

TEST(CInterface, BatchesHaveTheBitsOfOneByOneAndEachItemItsOwnRefusal) {
  constexpr std::size_t count = 6;
  Host one, many;
  ASSERT_EQ(one.create(), TRESS_OK);
  ASSERT_EQ(many.create(), TRESS_OK);
  std::array<tress_node, count> nodes{};
  std::array<float, 3 * count> u{};
  std::array<float, count> azimuths{}, heights{};
  std::array<tress_value, count> drawn, lit;
  for (int pass = 0; pass < 10; ++pass) {
    RandomStream random(7, static_cast<std::uint64_t>(pass));
    for (int k = 0; k < 200; ++k) {
      for (std::uint32_t i = 0; i < count; ++i) nodes[i] = {i % 2, i / 2, i / 3};
      nodes[4].a = 77;
      for (float& x : u) x = random.next();
      for (float& x : azimuths) x = 6 * random.next();
      for (float& x : heights) x = random.next();
      azimuths[1] = nan;
      EXPECT_EQ(tress_service_sample_n(many.service, nodes.data(), u.data(), count, drawn.data()),
                TRESS_INVALID_ARGUMENT);
      EXPECT_EQ(
          tress_service_evaluate_n(many.service, nodes.data(), azimuths.data(), heights.data(), count, lit.data()),
          TRESS_INVALID_ARGUMENT);
      for (std::size_t i = 0; i < count; ++i) {
        tress_value value;
        EXPECT_EQ(tress_service_sample(one.service, nodes[i], &u[3 * i], &value) == TRESS_OK, i != 4);
        EXPECT_EQ(std::memcmp(&value, &drawn[i], sizeof value), 0);
        EXPECT_EQ(tress_service_evaluate(one.service, nodes[i], azimuths[i], heights[i], &value) == TRESS_OK,
                  i != 4 && i != 1);
        EXPECT_EQ(std::memcmp(&value, &lit[i], sizeof value), 0);
      }
    }
    EXPECT_EQ(tress_service_publish(one.service, 1, nullptr), TRESS_OK);
    EXPECT_EQ(tress_service_publish(many.service, 1, nullptr), TRESS_OK);
  }
  EXPECT_EQ(drawn[0].state, static_cast<std::uint32_t>(TRESS_CONVERGED));
  EXPECT_EQ(tress_service_evaluate_n(many.service, nodes.data(), heights.data(), nullptr, 2, lit.data()), TRESS_OK);
  tress_value value;
  tress_node node;
  EXPECT_EQ(tress_service_mean(many.service, 0, 0.5f, 9, 1, 0, &value), TRESS_OK);
  EXPECT_GT(value.pdf, 0);
  EXPECT_EQ(tress_service_sample_mean(many.service, 0, 0.5f, 9, u.data(), &value), TRESS_OK);
  EXPECT_GT(value.pdf, 0);
  EXPECT_EQ(tress_service_choose(many.service, 1, 9, -9, u.data(), &node), TRESS_OK);
  EXPECT_EQ(node.a, 2u);
  EXPECT_EQ(node.b, 0u);
  EXPECT_EQ(tress_service_mean(many.service, 9, 0, 0, 1, 0, &value), TRESS_INVALID_ARGUMENT);
  float pdf = 0;
  EXPECT_EQ(tress_service_evaluate(many.service, {0, 0, 0}, 1, 0, &value), TRESS_OK);
  EXPECT_EQ(tress_service_pdf(many.service, {0, 0, 0}, 1, 0, &pdf), TRESS_OK);
  EXPECT_FLOAT_EQ(pdf, value.pdf);
  EXPECT_EQ(tress_service_pdf(many.service, {0, 0, 99}, 1, 0, &pdf), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_service_mean(many.service, 0, nan, 0, 1, 0, &value), TRESS_INVALID_ARGUMENT);
  EXPECT_EQ(tress_service_mean(many.service, 0, 0, 0, nan, 0, &value), TRESS_INVALID_ARGUMENT);
}

TEST(CInterface, BatchesOfFibersAndValuesWithoutAnEvent) {
  tress_service* service = nullptr;
  ASSERT_EQ(tress_service_create_for_fibers(nullptr, &service), TRESS_OK);
  for (const std::uint32_t model : {TRESS_ROUGH, TRESS_ELLIPTICAL}) {
    tress_fibers* fibers = nullptr;
    tress_fiber hair;
    tress_fiber_init(&hair);
    std::uint32_t id = 0;
    ASSERT_EQ(tress_fibers_create(service, model, TRESS_FITTED, &fibers), TRESS_OK);
    ASSERT_EQ(tress_fibers_add(fibers, &hair, &id), TRESS_OK);
    ASSERT_EQ(tress_service_prepare(service), TRESS_OK);
    constexpr std::size_t count = 20;
    std::vector<tress_vertex> vertices(count);
    std::vector<tress_event> begun(count);
    std::vector<float> u;
    std::vector<tress_direction> lights;
    for (std::size_t i = 0; i < count; ++i) {
      const Draws d = draws(0, i);
      vertices[i] = {id, {d.theta, d.phi}, d.xi1, d.xi2, d.h, d.importance};
      u.insert(u.end(), d.u.begin(), d.u.end());
      lights.push_back(d.light);
    }
    vertices[3].fiber = id + 1;
    std::vector<tress_fiber_sample> drawn(count);
    std::vector<tress_fiber_value> lit(count);
    EXPECT_EQ(tress_fibers_begin_n(fibers, vertices.data(), count, begun.data()), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(tress_fibers_sample_n(fibers, begun.data(), u.data(), count, drawn.data()), TRESS_INVALID_CALL);
    EXPECT_EQ(tress_fibers_evaluate_n(fibers, begun.data(), lights.data(), count, lit.data()), TRESS_INVALID_CALL);
    for (std::size_t i = 0; i < count; ++i) {
      const tress_vertex& at = vertices[i];
      tress_event event;
      tress_fiber_sample sample;
      tress_fiber_value value;
      EXPECT_EQ(tress_fibers_begin(fibers, at.fiber, at.wr, at.xi1, at.xi2, at.h, at.importance, &event) == TRESS_OK,
                i != 3);
      EXPECT_EQ(tress_fibers_sample(fibers, &event, &u[4 * i], &sample) == TRESS_OK, i != 3);
      EXPECT_EQ(tress_fibers_evaluate(fibers, &event, lights[i], &value) == TRESS_OK, i != 3);
      EXPECT_EQ(std::memcmp(&sample, &drawn[i], sizeof sample), 0);
      EXPECT_EQ(std::memcmp(&value, &lit[i], sizeof value), 0);
    }
    const float sigma_a[4] = {0, 0.2f, 0.5f, 2};
    float s[4], weights[4], pdf = 0, alone = 0;
    const tress_result expected = model == TRESS_ROUGH ? TRESS_OK : TRESS_INVALID_ARGUMENT;
    EXPECT_EQ(tress_fibers_evaluate_spectrum(fibers, begun.data(), lights[0], sigma_a, 4, s, &pdf), expected);
    tress_fiber_sample again;
    EXPECT_EQ(tress_fibers_sample_spectrum(fibers, begun.data(), u.data(), sigma_a, 4, &again, weights), expected);
    EXPECT_EQ(tress_fibers_pdf(fibers, begun.data(), lights[0], &alone), TRESS_OK);
    EXPECT_EQ(alone, lit[0].pdf);
    if (expected == TRESS_OK) {
      EXPECT_EQ(pdf, alone);
      EXPECT_EQ(std::memcmp(&again, drawn.data(), sizeof again), 0);
      for (int c = 1; c < 4; ++c) EXPECT_TRUE(s[c] <= s[c - 1] && weights[c] <= weights[c - 1] && weights[3] > 0);
    }
    const float six[6] = {0.3f, 0.6f, 0.2f, 0.9f, 0.1f, 0.7f};
    tress_fiber_sample sample;
    tress_fiber_value value;
    EXPECT_EQ(tress_fibers_sample_mean(fibers, id, {0.3f, 0.8f}, six, 1, &sample), TRESS_OK);
    EXPECT_EQ(tress_fibers_mean(fibers, id, {0.3f, 0.8f}, sample.direction, &value), TRESS_OK);
    EXPECT_GT(value.pdf, 0);
    EXPECT_EQ(std::memcmp(&value, &sample.at, sizeof value), 0);
    EXPECT_EQ(tress_fibers_mean(fibers, id + 1, {}, {}, &value), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(value.pdf, 0);
    EXPECT_EQ(tress_fibers_sample_mean(fibers, id + 1, {}, six, 1, &sample), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(tress_service_publish_pays(service), model == TRESS_ELLIPTICAL ? 1 : 0) << "20 events";
    tress_fibers_release(fibers);
  }
  tress_service_release(service);
}

TEST(CInterface, NamesThatNoCacheCanHaveAreRefusedAtOnce) {
  for (const std::string& name :
       {std::string(), std::string("m\xc3\xa4hne"), std::string("a\nb"), std::string(257, 'a')}) {
    Host host;
    host.target.name = name.c_str();
    EXPECT_EQ(host.create(), TRESS_INVALID_ARGUMENT) << name;
    EXPECT_EQ(host.service, nullptr);
  }
  Host host;
  const std::string longest(256, 'a');
  host.target.name = longest.c_str();
  EXPECT_EQ(host.create(), TRESS_OK);
}

TEST(CInterface, MessagesHaveTheRangeAndWhatWasFound) {
  tress_fibers* fibers = nullptr;
  ASSERT_EQ(tress_fibers_create(nullptr, TRESS_ROUGH, TRESS_EXACT, &fibers), TRESS_OK);
  tress_fiber fiber;
  tress_fiber_init(&fiber);
  fiber.eta = 1;
  std::uint32_t id = 0;
  EXPECT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_INVALID_ARGUMENT);
  EXPECT_STREQ(tress_last_error(), "tress_fiber::eta: expected a number from 1.05 to 3, found 1");
  tress_fiber_init(&fiber);
  fiber.gain[0][1] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_INVALID_ARGUMENT);
  EXPECT_STREQ(tress_last_error(), "tress_fiber::gain: expected a number from 0 to 1e+15, found inf");
  tress_fibers_release(fibers);
  Host host;
  host.options.threads = 100000;
  EXPECT_EQ(host.create(), TRESS_INVALID_ARGUMENT);
  EXPECT_STREQ(tress_last_error(), "tress_options::threads: expected a number from 0 to 4096, found 100000");
}

TEST(CInterface, AFailureInsideOnErrorIsNotReportedToItAgain) {
  Host host;
  static int calls;
  calls = 0;
  host.options.on_error = [](void* user, tress_result, const char*) {
    ++calls;
    EXPECT_EQ(tress_service_load(static_cast<Host*>(user)->service, "/no/such/file"), TRESS_FILE_MISSING);
  };
  ASSERT_EQ(host.create(), TRESS_OK);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(tress_service_load(host.service, nullptr), TRESS_INVALID_ARGUMENT);
    EXPECT_EQ(calls, i);
  }
}

TEST(CInterface, TheLargestGainGivesNumbersAndALargerOneIsRefused) {
  for (const std::uint32_t model : {TRESS_ROUGH, TRESS_ELLIPTICAL}) {
    tress_service* service = nullptr;
    tress_fibers* fibers = nullptr;
    ASSERT_EQ(tress_service_create_for_fibers(nullptr, &service), TRESS_OK);
    ASSERT_EQ(tress_fibers_create(service, model, TRESS_FITTED, &fibers), TRESS_OK);
    tress_fiber fiber;
    tress_fiber_init(&fiber);
    fiber.eccentricity = 1;
    fiber.roughness = 0.01f;
    std::uint32_t id = 0;
    std::fill_n(&fiber.gain[0][0], 18, std::numeric_limits<float>::max());
    EXPECT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_INVALID_ARGUMENT);
    EXPECT_NE(std::string(tress_last_error()).find("gain: expected a number from 0 to 1e+15"), std::string::npos)
        << tress_last_error();
    std::fill_n(&fiber.gain[0][0], 18, 1e15f);
    fiber.gain[1][1] = 0;
    ASSERT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_OK);
    ASSERT_EQ(tress_service_prepare(service), TRESS_OK);
    RandomStream random(3);
    for (int pass = 0; pass < 3; ++pass) {
      for (int i = 0; i < 500; ++i) {
        const tress_direction wr{3.1f * (random.next() - 0.5f), 6.2f * random.next()},
            wi{3.1f * (random.next() - 0.5f), 6.2f * random.next()};
        const float u[4] = {random.next(), random.next(), random.next(), random.next()};
        tress_event event;
        tress_fiber_sample sample;
        tress_fiber_value value;
        ASSERT_EQ(tress_fibers_begin(fibers, id, wr, random.next(), random.next(), 0.3f, 1e15f, &event), TRESS_OK);
        ASSERT_EQ(tress_fibers_sample(fibers, &event, u, &sample), TRESS_OK);
        ASSERT_EQ(tress_fibers_evaluate(fibers, &event, wi, &value), TRESS_OK);
        for (int c = 0; c < 3; ++c) {
          ASSERT_TRUE(std::isfinite(sample.weight[c]) && std::isfinite(sample.at.value[c]));
          ASSERT_TRUE(std::isfinite(value.value[c]));
        }
        ASSERT_TRUE(std::isfinite(sample.at.pdf) && std::isfinite(value.pdf));
      }
      tress_report report;
      ASSERT_EQ(tress_service_publish(service, 500, &report), TRESS_OK);
      EXPECT_TRUE(std::isfinite(report.bias_bound));
    }
    tress_fibers_release(fibers);
    tress_service_release(service);
  }
}

TEST(CInterface, AnswersThatAreMadeAgainAtEachQueryAreReportedAsTheCeiling) {
  for (const bool is_small : {false, true}) {
    tress_options options;
    tress_options_init(&options);
    if (is_small) options.memory_bytes = 300'000;
    tress_service* service = nullptr;
    tress_fibers* fibers = nullptr;
    ASSERT_EQ(tress_service_create_for_fibers(&options, &service), TRESS_OK);
    ASSERT_EQ(tress_fibers_create(service, TRESS_ROUGH, TRESS_FITTED, &fibers), TRESS_OK);
    tress_fiber fiber;
    tress_fiber_init(&fiber);
    std::uint32_t id = 0;
    ASSERT_EQ(tress_fibers_add(fibers, &fiber, &id), TRESS_OK);
    ASSERT_EQ(tress_service_prepare(service), TRESS_OK);
    RandomStream random(3);
    tress_report report;
    int at_ceiling = 0;
    for (int pass = 0; pass < 4; ++pass) {
      for (int i = 0; i < 2000; ++i) {
        const tress_direction wr{1.4f * (random.next() - 0.5f), 6.2f * random.next()};
        const float u[4] = {random.next(), random.next(), random.next(), random.next()};
        tress_event event;
        tress_fiber_sample sample;
        ASSERT_EQ(tress_fibers_begin(fibers, id, wr, random.next(), random.next(), 0.3f, 1, &event), TRESS_OK);
        ASSERT_EQ(tress_fibers_sample(fibers, &event, u, &sample), TRESS_OK);
      }
      ASSERT_EQ(tress_service_publish(service, 2000, &report), TRESS_OK);
      at_ceiling += report.at_ceiling;
    }
    EXPECT_EQ(at_ceiling > 0, is_small);
    tress_fibers_release(fibers);
    tress_service_release(service);
  }
}

TEST(CInterface, RowsOfSamplesLearnToTheirEpsilonIfAsked) {
  std::uint64_t learned[2] = {};
  for (const int to_epsilon : {0, 1}) {
    Host host;
    host.options.learns_to_epsilon = to_epsilon;
    ASSERT_EQ(host.create(), TRESS_OK);
    tress_report report;
    for (int pass = 0; pass < 6; ++pass) {
      const float u[3] = {0.5f, 0.5f, 0.5f};
      tress_value value;
      for (int i = 0; i < 16; ++i) (void)tress_service_sample(host.service, {host.samples, 1, 1}, u, &value);
      EXPECT_EQ(tress_service_publish(host.service, 1, &report), TRESS_OK);
    }
    learned[to_epsilon] = report.rows_converged;
  }
  EXPECT_GT(learned[1], learned[0]);
}

TEST(CInterface, FilesThatAreNoCachesAreRefused) {
  const std::string file = ::testing::TempDir() + "/no.cache";
  Host host, named;
  ASSERT_EQ(host.create(), TRESS_OK);
  std::remove(file.c_str());
  EXPECT_EQ(tress_service_load(host.service, file.c_str()), TRESS_FILE_MISSING);
  EXPECT_EQ(tress_service_save(host.service, "/no/such/folder/x.cache"), TRESS_FILE_INVALID);
  std::ofstream(file) << "no cache";
  EXPECT_EQ(tress_service_load(host.service, file.c_str()), TRESS_FILE_INVALID);
  EXPECT_EQ(tress_service_save(host.service, file.c_str()), TRESS_FILE_INVALID);
  EXPECT_EQ(bytes_of(file), "no cache");
  std::remove(file.c_str());
  EXPECT_EQ(tress_service_save(host.service, file.c_str()), TRESS_OK);
  named.target.name = "host-2";
  ASSERT_EQ(named.create(), TRESS_OK);
  EXPECT_EQ(tress_service_load(named.service, file.c_str()), TRESS_FILE_INVALID) << "it is of host-1";
  std::remove(file.c_str());
}

// What was cut off is learned in later passes, so that the service ends where one ends that nobody stopped.
TEST(CInterface, AProgressCallbackMayEndAPass) {
  Host host;
  static int asked;
  static bool goes_on;
  asked = 0;
  goes_on = false;
  host.options.on_progress = [](void*, double done) {
    EXPECT_TRUE(done >= 0 && done < 1);
    ++asked;
    return goes_on ? 1 : 0;
  };
  ASSERT_EQ(host.create(), TRESS_OK);
  const float u[3] = {0.5f, 0.5f, 0.5f};
  tress_value value;
  tress_report report;
  for (int pass = 0; pass < 8; ++pass) {
    goes_on = pass > 1;
    for (int i = 0; i < 1000; ++i) {
      EXPECT_EQ(tress_service_sample(host.service, {host.densities, 1, 1}, u, &value), TRESS_OK);
      EXPECT_EQ(tress_service_sample(host.service, {host.samples, 1, 1}, u, &value), TRESS_OK);
    }
    EXPECT_EQ(tress_service_publish(host.service, 1, &report), goes_on ? TRESS_OK : TRESS_CANCELLED);
    if (pass == 0) {
      EXPECT_EQ(tress_service_prepare(host.service), TRESS_CANCELLED);
    }
    EXPECT_EQ(report.rows_open + report.rows_converged > 0, goes_on);
  }
  EXPECT_GT(asked, 8);
  EXPECT_EQ(value.answered, 1);
  EXPECT_EQ(report.rows_open + report.rows_converged, 2u);
}

// The sum of what it is given is the figure of the report, and 0 in the end; a refusal holds rows back.
TEST(CInterface, AMemoryCallbackFollowsTheTableAndMayHoldItBack) {
  static std::int64_t sum;
  static int asked;
  static bool agrees;
  static tress_service* inside;
  sum = asked = 0;
  agrees = false;
  inside = nullptr;
  {
    Host host;
    host.options.on_memory = [](void*, std::int64_t bytes, int post) {
      if (inside != nullptr) {
        EXPECT_EQ(tress_service_publish(inside, 0, nullptr), TRESS_INVALID_CALL);
      }
      asked += post == 0 ? 1 : 0;
      if (post != 0 || agrees) sum += bytes;
      return agrees ? 1 : 0;
    };
    ASSERT_EQ(host.create(), TRESS_OK);
    inside = host.service;
    const float u[3] = {0.5f, 0.5f, 0.5f};
    tress_value value;
    tress_report report;
    for (int pass = 0; pass < 8; ++pass) {
      agrees = pass > 1;
      for (int i = 0; i < 1000; ++i) {
        EXPECT_EQ(tress_service_sample(host.service, {host.densities, 1, 1}, u, &value), TRESS_OK);
        EXPECT_EQ(value.answered, 1);
        EXPECT_EQ(tress_service_sample(host.service, {host.samples, 1, 1}, u, &value), TRESS_OK);
      }
      EXPECT_EQ(tress_service_publish(host.service, 1, &report), TRESS_OK);
      EXPECT_EQ(report.rows_open + report.rows_converged > 0, agrees);
      EXPECT_EQ(report.at_ceiling != 0, !agrees);
      EXPECT_EQ(sum, static_cast<std::int64_t>(report.bytes)) << pass;
    }
    EXPECT_EQ(asked, 4) << "once in each pass that it refuses, then for both rows";
    EXPECT_GT(sum, 0);
    inside = nullptr;
  }
  EXPECT_EQ(sum, 0);
}

}  // namespace
}  // namespace tress
