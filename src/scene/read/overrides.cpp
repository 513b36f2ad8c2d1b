#include "scene/read/overrides.h"

#include <fmt/format.h>

#include "scene/model/parameters.h"
#include "scene/read/assembly.h"
#include "scene/read/source_reader.h"

namespace tress::scene {

std::optional<Error> fault_of(const Overrides& o) {
  std::optional<Error> error;
  const auto check = [&](const char* option, const auto& value) {
    const Parameter& parameter = option_parameter(option);
    const auto one = [&](const auto x) {
      Range range = parameter.range;  // with ends in the type of the value
      range.least = static_cast<double>(static_cast<decltype(x)>(range.least));
      range.most = static_cast<double>(static_cast<decltype(x)>(range.most));
      if (!error && !range.contains(x))
        error = Error{"", option, words(parameter), fmt::format("{:g}", static_cast<double>(x))};
    };
    if constexpr (requires { value->length(); }) {
      for (int c = 0; value && c < 3; ++c) one((*value)[c]);
    } else if constexpr (requires { value->second; }) {
      if (value) one(value->first), one(value->second);
    } else if (value) {
      one(*value);
    }
  };
  check("--color", o.color);
  if (!error && o.color_source)
    if (const auto source = parse_color(*o.color_source); !source) error = source.error();
  check("--melanin", o.melanin);
  check("--sigma-a", o.sigma_a);
  check("--eccentricity", o.eccentricity);
  check("--roughness", o.roughness);
  check("--cuticle-tilt", o.tilt_deg);
  check("--light-scale", o.light_scale);
  check("--cm-per-unit", o.cm_per_unit);
  check("--radius", o.radius_cm);
  if (!error && o.widths && !width_use_of(*o.widths))
    error = Error{"", "--widths", width_use_words, "\"" + o.widths->substr(0, 64) + "\""};
  check("--resolution", o.width);
  check("--resolution", o.height);
  check("--spp", o.samples);
  check("--frame", o.frame);
  return error;
}

}  // namespace tress::scene
