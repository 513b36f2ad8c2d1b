#include "cli/groom_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/console.h"
#include "cli/options.h"
#include "geometry/fiber_scene.h"
#include "integrate/near_rule.h"
#include "integrate/renderer.h"
#include "models/default_model.h"
#include "models/model_options.h"
#include "scene/model/framed_points.h"
#include "scene/read/assembly.h"
#include "scene/read/groom_files.h"
#include "scene/read/groom_writers.h"
#include "scene/read/load_scene.h"
#include "scene/read/scene_strands.h"
#include "scene/read/shared_strands.h"

namespace tress::cli {
namespace {

struct GroomSettings {
  std::filesystem::path file, output;
  bool json = false;
  std::optional<std::uint32_t> points_per_strand = {};
  std::optional<double> cm_per_unit = {};
  std::optional<bool> y_up = {};
  std::optional<double> frame = {}, frames_per_second = {};
  bool strict = false;
};

scene::Box bounds_of(const scene::GroomFile& groom) {
  const scene::StrandBasis basis = groom.basis.value_or(scene::StrandBasis::linear);
  return scene::box_of_instances(groom, basis).value_or(scene::Box{});
}

std::string basis_of(const scene::GroomFile& groom) {
  if (!groom.basis) return "not said (taken for B-splines through root and tip; \"basis\" in a scene says otherwise)";
  switch (*groom.basis) {
    case scene::StrandBasis::linear:
      return "linear";
    case scene::StrandBasis::bspline:
      return "cubic B-splines through root and tip";
    case scene::StrandBasis::open_bspline:
      return "cubic B-splines, open";
    default:
      return "cubic Bezier segments";
  }
}

std::string unit_of(const scene::GroomFile& groom) {
  return groom.cm_per_unit ? fmt::format("{:g} cm", *groom.cm_per_unit)
                           : "not said (its longest side is taken for 30 cm; --cm-per-unit says otherwise)";
}

std::string up_of(const scene::GroomFile& groom) {
  if (!groom.y_up) return "not said (by how the strands fall; --up says otherwise)";
  return *groom.y_up ? "y" : "z";
}

/// How a render uses the widths, in the file's unit or the assumed one.
std::string use_of(const scene::GroomFile& groom) {
  const double longest = bounds_of(groom).longest_side(),
               cm_per_unit = groom.cm_per_unit ? *groom.cm_per_unit : scene::usual_longest_side_cm / longest;
  if (!(longest > 0)) return "";
  const scene::WidthPlan plan = scene::plan_widths(groom, {}, cm_per_unit, groom.cm_per_unit.has_value());
  return fmt::format(": a radius of {:.3g} cm{}{}", plan.typical_radius_cm, groom.width.empty() ? "" : " in the middle",
                     plan.are_used
                         ? ""
                         : fmt::format(" in a unit that is guessed, {:g} cm is used; --widths file takes them "
                                       "as they are",
                                       scene::usual_radius_cm));
}

std::string widths_of(const scene::GroomFile& groom) {
  if (groom.width.empty())
    return groom.default_width > 0 ? fmt::format("{:g} units across everywhere{}", groom.default_width, use_of(groom))
                                   : fmt::format("none (a radius of {:g} cm is taken)", scene::usual_radius_cm);
  const auto said = [](float width) { return std::max(width, 0.0f); };
  const auto [low, high] = std::ranges::minmax(groom.width, {}, said);
  return fmt::format("per point, {:g} to {:g} units across{}", said(low), said(high), use_of(groom));
}

/// "4 to 16 a strand".
std::string points_a_strand(const scene::GroomFile& groom) {
  if (groom.strand_count() == 0) return "none";
  std::uint32_t fewest = UINT32_MAX, most = 0;
  for (std::size_t s = 0; s < groom.strand_count(); ++s) {
    const std::uint32_t count = groom.first_point[s + 1] - groom.first_point[s];
    fewest = std::min(fewest, count);
    most = std::max(most, count);
  }
  return fewest == most ? fmt::format("{} a strand", most) : fmt::format("{} to {} a strand", fewest, most);
}

std::string colors_of(const scene::GroomFile& groom) {
  if (!groom.has_color) return "none";
  const char* use = " (linear RGB, used by a material with \"color\": \"file\")";
  if (groom.color.empty())
    return fmt::format("one, {:g} {:g} {:g}{}", groom.default_color.x, groom.default_color.y, groom.default_color.z,
                       use);
  return (groom.color.size() == groom.points.size() ? "per point" : "per strand") + std::string(use);
}

/// The number of strands that are drawn: those of all instances.
std::uint64_t drawn_strands(const scene::GroomFile& groom) {
  std::uint64_t drawn = groom.strand_count();
  for (const scene::SharedStrands& shared : groom.shared)
    drawn += (shared.places.size() - 1) * std::uint64_t{shared.end - shared.first};
  return drawn;
}

void print_text(const scene::GroomFile& groom) {
  const scene::Box box = bounds_of(groom);
  fmt::print(
      "format    {}\nstrands   {}{}\npoints    {}, {}\ncurves    {}\nbounds    ({:g}, {:g}, {:g}) to ({:g}, {:g}, "
      "{:g}) "
      "units\n",
      groom.format, groom.strand_count(),
      groom.shared.empty() ? "" : fmt::format(", {} with all instances", drawn_strands(groom)), groom.points.size(),
      points_a_strand(groom), basis_of(groom), box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z);
  fmt::print("unit      {}\nup        {}\nwidths    {}\ncolors    {}\nnormals   {}\nids       {}\nroot uv   {}\n",
             unit_of(groom), up_of(groom), widths_of(groom), colors_of(groom),
             groom.normal.empty() ? "none" : "per point (minor axes of the fibers; \"normals\": false leaves them out)",
             groom.id.empty() ? "none" : "per strand", groom.root_uv.empty() ? "none" : "per strand");
  constexpr std::size_t most_parts = 50;
  for (std::size_t i = 0; i < std::min(groom.parts.size(), most_parts); ++i) {
    const scene::GroomPart& part = groom.parts[i];
    if (part.name.empty() && groom.parts.size() == 1) break;
    fmt::print("part      {}: {} strand{}, {} point{}, {}{}\n", part.name, part.strands, plural(part.strands),
               part.points, plural(part.points), part.curve,
               part.instances == 1 ? "" : fmt::format(", {} instances that share them", part.instances));
  }
  if (groom.parts.size() > most_parts) fmt::print("part      and {} more\n", groom.parts.size() - most_parts);
  for (const std::string& material : groom.materials) fmt::print("material  {}\n", material);
  for (const std::string& remark : groom.remarks) fmt::print("note      {}\n", remark);
  for (const scene::IgnoredAttribute& ignored : groom.ignored)
    fmt::print("not used  {}: {}\n", ignored.name, ignored.why);
}

void print_json(const scene::GroomFile& groom) {
  const scene::Box box = bounds_of(groom);
  nlohmann::ordered_json parts = nlohmann::ordered_json::array(), ignored = nlohmann::ordered_json::array();
  for (const scene::GroomPart& part : groom.parts)
    parts.push_back({{"name", part.name},
                     {"strands", part.strands},
                     {"points", part.points},
                     {"curve", part.curve},
                     {"instances", part.instances}});
  for (const scene::IgnoredAttribute& one : groom.ignored) ignored.push_back({{"name", one.name}, {"why", one.why}});
  nlohmann::ordered_json json = {{"format", groom.format},
                                 {"strands", groom.strand_count()},
                                 {"strands_of_all_instances", drawn_strands(groom)},
                                 {"points", groom.points.size()},
                                 {"curves", basis_of(groom)},
                                 {"bounds", {{box.low.x, box.low.y, box.low.z}, {box.high.x, box.high.y, box.high.z}}}};
  json["cm_per_unit"] = groom.cm_per_unit ? nlohmann::ordered_json(*groom.cm_per_unit) : nullptr;
  json["up"] = groom.y_up ? nlohmann::ordered_json(*groom.y_up ? "y" : "z") : nullptr;
  json["widths"] = widths_of(groom);
  json["colors"] = colors_of(groom);
  json["normals"] = !groom.normal.empty();
  json["ids"] = !groom.id.empty();
  json["root_uv"] = !groom.root_uv.empty();
  json["parts"] = parts;
  json["materials"] = groom.materials;
  json["notes"] = groom.remarks;
  json["not_used"] = ignored;
  fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

bool is_scene(const GroomSettings& settings) {
  return settings.file.extension() == ".json" || std::filesystem::is_directory(settings.file);
}

scene::Overrides overrides_of(const GroomSettings& settings) {
  scene::Overrides overrides;
  overrides.strict = settings.strict;
  if (settings.frame) overrides.frame = static_cast<int>(*settings.frame);
  if (settings.frames_per_second)
    overrides.settings = {fmt::format("camera/frames_per_second={}", *settings.frames_per_second)};
  return overrides;
}

Result<scene::Scene> read_scene(const GroomSettings& settings) {
  if (settings.points_per_strand || settings.cm_per_unit || settings.y_up)
    return Error{settings.file.string(), "", "a file of strands for --points-per-strand, --cm-per-unit and --up",
                 "a scene, which says these itself"};
  return scene::load_scene(settings.file, overrides_of(settings));
}

Result<scene::GroomFile> read_file_of_strands(const GroomSettings& settings) {
  auto groom =
      scene::read_groom_file(settings.file, settings.points_per_strand, settings.frame, settings.frames_per_second);
  if (groom && settings.strict && !groom->ignored.empty())
    return Error{settings.file.string(), "--strict", "a file of which everything is used",
                 groom->ignored[0].name + " (" + groom->ignored[0].why + ")"};
  return groom;
}

/// Reads a file of strands, or all grooms of a scene.
Result<scene::GroomFile> read_strands(const GroomSettings& settings) {
  if (!is_scene(settings)) return read_file_of_strands(settings);
  const auto scene = read_scene(settings);
  return scene ? scene::strands_of(*scene) : scene.error();
}

/// What a render of a scene models by default and why, in three lines: its fibers, its hits, its strands and bounces.
std::array<std::string, 3> modelled(const scene::Scene& scene) {
  std::vector<fiber::FiberParameters> materials;
  for (const scene::Material& material : scene.materials) materials.push_back(material.fiber);
  const fiber::ChosenModel chosen = fiber::default_model(materials, scene.fibers);
  std::string parts;
  const auto add = [&](const char* name, auto&& has) {
    if (std::ranges::any_of(scene.fibers, has)) parts += (parts.empty() ? "" : ", ") + std::string(name);
  };
  add("medulla", [](const fiber::FiberParameters& one) { return one.medulla_radius > 0; });
  add("scattering cortex", [](const fiber::FiberParameters& one) { return one.cortex_scattering > 0; });
  add("water", [](const fiber::FiberParameters& one) { return one.wetness > 0; });
  std::string fibers =
      fmt::format("model {}: {}", chosen.info->name, chosen.why.empty() ? "no material asks for another" : chosen.why);
  fibers +=
      parts.empty() ? ", no medulla" : fmt::format(", {} {}", parts, chosen.info->has_parts ? "traced" : "left out");
  integrate::RenderOptions options;
  integrate::set_asked(scene.integrator, chosen.info->has_rows(), &options);
  if (fiber::has(*chosen.info, fiber::Asks::samples))
    integrate::measure_needs(options.near, scene, geometry::FiberScene(scene));
  else
    options.near.where = integrate::NearOptions::Where::nowhere;
  std::string paths = fmt::format("up to {} bounces, {}, ", options.max_depth,
                                  scene.integrator.learns_deep_light()
                                      ? fmt::format("their light learned from hit {} on", options.deep_light_depth)
                                      : "all traced (no deep_light)");
  paths += scene.image.least_width_px > 0
               ? fmt::format("strands at least {:g} pixels wide, hit as rarely as their own width",
                             scene.image.least_width_px)
               : "every strand of its own width (no least_width)";
  return {fibers, integrate::words_of(options.near), paths};
}

int run_info(const GroomSettings& settings) {
  const auto print = [&](const Result<scene::GroomFile>& groom) {
    if (!groom) {
      log_error(groom.error().message());
      return 1;
    }
    settings.json ? print_json(*groom) : print_text(*groom);
    return 0;
  };
  if (!is_scene(settings)) return print(read_file_of_strands(settings));
  const auto scene = read_scene(settings);
  const int status = print(scene ? scene::strands_of(*scene) : scene.error());
  if (status != 0 || settings.json) return status;
  for (const std::string& line : modelled(*scene)) fmt::print("modelled  {}\n", line);
  return 0;
}

int run_convert(const GroomSettings& settings) {
  auto groom = read_strands(settings);
  if (!groom) {
    log_error(groom.error().message());
    return 1;
  }
  if (auto error = scene::write_out(settings.file.string(), &*groom)) {
    log_error(error->message());
    return 1;
  }
  if (settings.cm_per_unit) groom->cm_per_unit = settings.cm_per_unit;
  if (settings.y_up) groom->y_up = settings.y_up;
  std::vector<std::string> notes = groom->remarks;
  for (const scene::IgnoredAttribute& ignored : groom->ignored)
    notes.push_back(fmt::format("not used: {} ({})", ignored.name, ignored.why));
  if (!groom->y_up && settings.output.extension() != ".hair") {  // .hair does not record axes, other formats must
    groom->y_up = scene::falls_along_y(*groom);
    notes.push_back(fmt::format("{} is written as up, by how the strands fall; --up {} if they lie on their side",
                                *groom->y_up ? "y" : "z", *groom->y_up ? "z" : "y"));
  }
  scene::say_widths(&*groom);
  const auto error = scene::write_groom_file(*groom, settings.output, &notes);
  for (const std::string& note : notes) log_note(note);
  if (error) log_error(error->message());
  return error ? 1 : 0;
}

void add_input(CLI::App* command, GroomSettings* settings) {
  command->add_option("FILE", settings->file, "groom of any format that can be read, or a scene")
      ->required()
      ->type_name("FILE");
  add_whole(command, "--points-per-strand",
            [settings](std::uint64_t points) { settings->points_per_strand = static_cast<std::uint32_t>(points); });
  add_number(
      command, "--frame", [settings](double frame) { settings->frame = frame; },
      "frame of what is animated, in place of its first sample");
  add_number(command, "--fps", [settings](double rate) { settings->frames_per_second = rate; });
  add_flag(command, "--strict", [settings] { settings->strict = true; });
}

}  // namespace

Command add_info(CLI::App& tress) {
  const auto settings = std::make_shared<GroomSettings>();
  CLI::App* info = tress.add_subcommand("info", "List what is in a file of strands, and what of it will not be used");
  add_input(info, settings.get());
  info->add_flag("--json", settings->json, "print JSON");
  return {info, [settings] { return run_info(*settings); }};
}

Command add_convert(CLI::App& tress) {
  const auto settings = std::make_shared<GroomSettings>();
  CLI::App* convert = tress.add_subcommand("convert", "Write the strands of a file as .hair or .usda");
  add_input(convert, settings.get());
  convert->add_option("OUT", settings->output, "its ending sets the format: .hair or .usda")
      ->required()
      ->type_name("OUT")
      ->check(expecting("a name that ends with .hair or .usda", [](const std::string& name) {
        const auto& endings = scene::groom_output_endings();
        return std::ranges::any_of(endings, [&](const std::string& ending) { return name.ends_with(ending); });
      }));
  add_number(
      convert, "--cm-per-unit", [settings](double x) { settings->cm_per_unit = x; },
      "length of a unit of FILE, in cm, where it says none or another");
  add_choice(
      convert, "--up", {"y", "z"}, [settings](const std::string& axis) { settings->y_up = axis == "y"; },
      "axis of FILE that points up, where it says none or another");
  return {convert, [settings] { return run_convert(*settings); }};
}

}  // namespace tress::cli
