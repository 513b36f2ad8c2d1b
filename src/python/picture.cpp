#include "python/picture.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "denoise/denoised_layer.h"
#include "image/view_transform.h"
#include "python/bindings.h"
#include "python/raised.h"

namespace py = pybind11;

namespace tress::python {
namespace {

using Handle = std::shared_ptr<SharedPicture>;

/// The pixels of a channel, (height, width), without a copy. They are writable.
py::array_t<float> channel(const Handle& self, const std::string& name) {
  const image::Picture& picture = self->picture;
  for (const image::Channel& found : picture.channels) {
    if (found.name != name) continue;
    return py::array_t<float>({py::ssize_t{picture.height}, py::ssize_t{picture.width}}, found.pixels.data(),
                              py::cast(self));
  }
  std::string names;
  for (const image::Channel& found : picture.channels) names += (names.empty() ? "" : ", ") + found.name;
  throw Raised({"", "channel", "one of " + names, "\"" + name + "\""});
}

std::vector<std::string> channel_names(const SharedPicture& self) {
  std::vector<std::string> names;
  for (const image::Channel& found : self.picture.channels) names.push_back(found.name);
  return names;
}

image::Precision precision_of(const std::string& name) {
  if (name == "half") return image::Precision::half;
  if (name == "float") return image::Precision::full;
  throw Raised({"", "precision", "one of half, float", "\"" + name + "\""});
}

image::View view_named(const std::string& name) {
  if (const auto view = image::view_of(name)) return *view;
  throw Raised({"", "view", "one of standard, neutral, agx", "\"" + name + "\""});
}

void write_exr(const Handle& self, const std::filesystem::path& file, const std::string& precision) {
  const image::Precision bits = precision_of(precision);
  const py::gil_scoped_release released;
  check(image::write_exr(file, self->picture, bits));
}

void write_png(const Handle& self, const std::filesystem::path& file, std::optional<double> exposure,
               const std::optional<std::string>& view) {
  image::Preview preview = self->preview;
  if (exposure) preview.exposure_stops = *exposure;
  if (view) preview.view = view_named(*view);
  preview.layer = denoise::denoised_layer;
  const py::gil_scoped_release released;
  check(image::write_png(file, self->picture, preview));
}

Handle read_exr(const std::filesystem::path& file) {
  auto picture = [&] {
    const py::gil_scoped_release released;
    return checked(image::read_exr(file));
  }();
  return std::make_shared<SharedPicture>(SharedPicture{std::move(picture), {}, py::dict()});
}

py::dict compare(const SharedPicture& a, const SharedPicture& b) {
  const image::Difference difference = checked(image::compare(a.picture, b.picture, "a", "b"));
  py::dict result;
  result["identical"] = difference.identical;
  result["rel_mse"] = difference.rel_mse;
  result["mae"] = difference.mae;
  result["bias"] = py::make_tuple(difference.bias[0], difference.bias[1], difference.bias[2]);
  result["largest"] = difference.largest;
  return result;
}

}  // namespace

void bind_picture(py::module_& module) {
  py::class_<SharedPicture, Handle>(module, "Picture", "A layered picture. Arrays over its channels keep it alive.")
      .def_property_readonly("width", [](const SharedPicture& self) { return self.picture.width; })
      .def_property_readonly("height", [](const SharedPicture& self) { return self.picture.height; })
      .def_property_readonly("channels", &channel_names, "The names of its channels, as in an EXR.")
      .def_property_readonly("metadata", [](const SharedPicture& self) { return self.picture.metadata; })
      .def_property_readonly(
          "stats", [](const SharedPicture& self) { return self.stats; },
          "What the render reported at its end; empty of a file.")
      .def("channel", &channel, py::arg("name"), "(height, width) float32, top row first, without a copy.")
      .def("write_exr", &write_exr, py::arg("file"), py::arg("precision") = "half",
           "half: 16 bits where they are enough; float: 32 everywhere.")
      .def("write_png", &write_png, py::arg("file"), py::arg("exposure") = py::none(), py::arg("view") = py::none(),
           "A preview as a display shows it.");
  module.def("read_exr", &read_exr, py::arg("file"), "Any EXR of float or half channels.");
  module.def("compare", &compare, py::arg("a"), py::arg("b"), "B against A over R, G, B, as tress diff has it.");
}

}  // namespace tress::python
