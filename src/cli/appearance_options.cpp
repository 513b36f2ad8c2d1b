#include "cli/appearance_options.h"

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "cli/options.h"
#include "scene/model/hair_colors.h"
#include "scene/read/assembly.h"
#include "scene/read/set_keys.h"

namespace tress::cli {
namespace {

glm::vec3 color_of(const std::vector<double>& x) { return glm::vec3(float(x[0]), float(x[1]), float(x[2])); }

}  // namespace

void add_appearance(CLI::App* app, scene::Overrides& o) {
  auto* color = add_numbers(
      app, "--color", 3, 3, [&o](const auto& x) { o.color = color_of(x); },
      "color R,G,B, linear, that a dense lock of the hair shows in even light, or a ramp of them as in a scene file",
      [&o](const std::string& json) { o.color_source = json; });
  auto* melanin = add_numbers(
      app, "--melanin", 1, 2, [&o](const auto& x) { o.melanin = {float(x[0]), x.size() > 1 ? float(x[1]) : 0.0f}; },
      "concentrations: eumelanin[,pheomelanin]");
  auto* sigma_a = add_numbers(
      app, "--sigma-a", 3, 3, [&o](const auto& x) { o.sigma_a = color_of(x); }, "absorption R,G,B per major semi-axis");
  auto* hair = add_choice(
      app, "--hair", scene::hair_color_names(), [&o](const std::string& name) { o.hair = name; },
      "natural color by name");
  color->excludes(melanin)->excludes(sigma_a)->excludes(hair);
  melanin->excludes(sigma_a)->excludes(hair);
  sigma_a->excludes(hair);
  add_fiber_shape(app, o);
  add_number(app, "--cuticle-tilt", [&o](double x) { o.tilt_deg = x; });
  add_number(app, "--light-scale", [&o](double x) { o.light_scale = x; });
  add_file(
      app, "--environment", [&o](const std::string& file) { o.environment_file = file; },
      "latitude-longitude picture that lights the scene");
  add_flag(app, "--spectral", [&o] { o.settings.emplace_back("integrator/spectral=true"); });
  app->add_option_function<std::vector<std::string>>(
         "--set",
         [&o](const std::vector<std::string>& texts) {
           o.settings.insert(o.settings.begin(), texts.begin(), texts.end());
         },
         "any key of the scene file, of one object by its number (materials/0/...) or name, or of all "
         "(materials/*/...); null removes a key; a bare file of strands has materials/0 and grooms/0; may be given "
         "more than once")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE")
      ->check(expecting(scene::setting_words,
                        [](const std::string& text) { return scene::parse_setting(text).has_value(); }));
  add_choice(
      app, "--up", {"y", "z"}, [&o](const std::string& axis) { o.y_up = axis == "y"; },
      "axis of the hair file that points up");
  add_number(app, "--cm-per-unit", [&o](double x) { o.cm_per_unit = x; }, "length of a unit of the hair file, in cm");
  add_flag(app, "--strict", [&o] { o.strict = true; });
  add_number(app, "--radius", [&o](double x) { o.radius_cm = x; }, "of all fibers of hair files, in cm");
  app->add_option_function<std::string>(
         "--widths", [&o](const std::string& text) { o.widths = text; },
         "widths of the hair file: as they are (file), brought to those of hair (clamp), or S times as large (scale=S)")
      ->type_name("WIDTHS")
      ->check(expecting(scene::width_use_words,
                        [](const std::string& text) { return scene::width_use_of(text).has_value(); }));
  for (const char* name : {"--eccentricity", "--roughness", "--cuticle-tilt", "--radius", "--widths"})
    app->get_option(name)->group(hidden_group);
  add_keyed_options(app, &o.settings);
}

}  // namespace tress::cli
