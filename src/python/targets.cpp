#include "python/targets.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <array>
#include <cmath>
#include <utility>

#include "python/raised.h"

namespace py = pybind11;

namespace tress::python {
namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Checks columns that a target gave: of equal length, of finite numbers, the last `positive` of them >= 0. A missing
/// attribute is 0.
template <std::size_t columns>
std::array<Floats, columns> columns_of(const py::object& given, const char* method, const char* names,
                                       std::size_t positive) {
  const auto wrong = [&](const std::string& expected, const std::string& found) {
    return Raised({"", method, expected, found});
  };
  if (!py::isinstance<py::sequence>(given)) throw wrong(names, std::string(py::str(py::type::of(given))));
  const auto sequence = py::cast<py::sequence>(given);
  if (sequence.size() != columns && sequence.size() + 1 != columns)
    throw wrong(names, fmt::format("{} arrays", sequence.size()));
  std::array<Floats, columns> arrays;
  for (std::size_t c = 0; c < sequence.size(); ++c) arrays[c] = Floats::ensure(sequence[c]);
  if (sequence.size() < columns && arrays[0]) {
    arrays[columns - 1] = Floats(arrays[0].size());
    std::fill_n(arrays[columns - 1].mutable_data(), arrays[0].size(), 0.0f);
  }
  for (std::size_t c = 0; c < columns; ++c) {
    if (!arrays[c]) {
      PyErr_Clear();
      throw wrong(names, "what is no array of numbers");
    }
    if (arrays[c].size() != arrays[0].size())
      throw wrong("arrays of one length", fmt::format("{} and {}", arrays[0].size(), arrays[c].size()));
    for (py::ssize_t i = 0; i < arrays[c].size(); ++i) {
      const float x = arrays[c].data()[i];
      if (!std::isfinite(x) || (c + positive >= columns && x < 0))
        throw wrong(c + positive >= columns ? "finite numbers >= 0" : "finite numbers", fmt::format("{}", x));
    }
  }
  return arrays;
}

}  // namespace

thread_local int Calls::depth = 0;

void Calls::keep(std::exception_ptr raised) const {
  const std::lock_guard lock(mutex_);
  if (!raised_ && !failed_) raised_ = std::move(raised);
  failed_ = true;
}

std::exception_ptr Calls::take_failure() {
  const std::lock_guard lock(mutex_);
  return std::exchange(raised_, nullptr);
}

void PythonTarget::trace(const adaptive::SliceDescription& slice, float a, float b,
                         std::vector<adaptive::TracedRay>& out) const {
  const auto take = [&](const py::object& given) {
    const auto rays = columns_of<3>(given, "trace", "azimuths, weights and, if wanted, attributes", 2);
    for (py::ssize_t i = 0; i < rays[0].size(); ++i)
      out.push_back({rays[0].data()[i], rays[1].data()[i], rays[2].data()[i]});
  };
  calls_.call("trace", take, slice, a, b);
}

void PythonSamples::draw(const adaptive::SliceDescription& slice, float a, float b, std::uint64_t stream,
                         std::uint32_t first, std::uint32_t count, std::vector<adaptive::SampledExit>& out) const {
  const auto take = [&](const py::object& given) {
    const auto exits = columns_of<5>(given, "draw", "azimuths, heights, parts, weights and, if wanted, attributes", 3);
    for (py::ssize_t i = 0; i < exits[0].size(); ++i) {
      const float part = exits[2].data()[i];
      if (part >= static_cast<float>(parts_) || part != std::floor(part))
        throw Raised({"", "draw", fmt::format("parts below {}", parts_), fmt::format("{}", part)});
      out.push_back({exits[0].data()[i], exits[1].data()[i], static_cast<std::uint32_t>(part), exits[3].data()[i],
                     exits[4].data()[i]});
    }
  };
  calls_.call("draw", take, slice, a, b, stream, first, count);
}

}  // namespace tress::python
