// tress merge: parts of one picture, rendered apart, as the picture.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/checkpoint_session.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "integrate/film.h"
#include "scene/model/parameters.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

constexpr std::size_t most_groups = 64;
/// The cache that a part learns into is its own; whether its table is that of the others is told apart.
const std::vector<std::string> may_differ{"--samples-from", "--samples-to", "--crop", "--warm-cache"};

struct MergeSettings {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path output;
  image::Precision precision = image::Precision::half;
};

struct Part {
  std::filesystem::path file;
  SavedRender saved;
  image::Window window, whole;
  int from = 0, to = 0;
  bool opaque = false, glint = false, frozen = false, moving = false, emission = false;
  std::string table;
  std::vector<std::string> groups;  ///< of light
};

/// So many whole numbers of a JSON array, each in [0, 2^24].
template <std::size_t N>
bool read_numbers(const nlohmann::json& value, std::array<int, N>* numbers) {
  if (!value.is_array() || value.size() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    if (!value[i].is_number_unsigned() || value[i].get<std::uint64_t>() > (1u << 24)) return false;
    (*numbers)[i] = value[i].get<int>();
  }
  return true;
}

bool describe(Part* part) {
  const nlohmann::json& told = part->saved.progress;
  std::array<int, 4> window{};
  std::array<int, 2> whole{}, samples{};
  if (!read_numbers(told.value("window", nlohmann::json()), &window) ||
      !read_numbers(told.value("whole", nlohmann::json()), &whole) ||
      !read_numbers(told.value("samples", nlohmann::json()), &samples))
    return false;
  part->window = {window[0], window[1], window[2], window[3]};
  part->whole = {0, 0, whole[0], whole[1]};
  part->from = samples[0];
  part->to = samples[1];
  for (const auto& [name, flag] :
       {std::pair{"opaque", &part->opaque}, std::pair{"glint", &part->glint}, std::pair{"frozen", &part->frozen},
        std::pair{"moving", &part->moving}, std::pair{"emission", &part->emission}}) {
    if (!told.contains(name) || !told[name].is_boolean()) return false;
    *flag = told[name].get<bool>();
  }
  if (!told.contains("table") || !told["table"].is_string()) return false;
  part->table = told["table"].get<std::string>();
  if (!told.contains("groups") || !told["groups"].is_array() || told["groups"].size() > most_groups) return false;
  for (const nlohmann::json& group : told["groups"]) {
    if (!group.is_string()) return false;
    part->groups.push_back(group.get<std::string>());
  }
  return window[2] > 0 && window[3] > 0 && window[0] + window[2] <= whole[0] && window[1] + window[3] <= whole[1] &&
         std::int64_t{whole[0]} * whole[1] <= scene::most_image_pixels && part->from < part->to;
}

bool meet(const Part& a, const Part& b) {
  const auto along = [](int p, int n, int q, int m) { return p < q + m && q < p + n; };
  return along(a.window.left, a.window.width, b.window.left, b.window.width) &&
         along(a.window.top, a.window.height, b.window.top, b.window.height) && a.from < b.to && b.from < a.to;
}

/// Told, all of them; empty if one is refused.
std::vector<Part> read_parts(const MergeSettings& settings) {
  std::vector<Part> parts;
  bool good = true;
  const auto refuse = [&](const Error& error) {
    log_error(error.message());
    good = false;
  };
  std::optional<Identity> identity;
  for (const std::filesystem::path& file : settings.parts) {
    Result<SavedRender> saved = read_saved_render(file, identity ? &*identity : nullptr, may_differ);
    if (!saved) {
      refuse(saved.error());
      continue;
    }
    Part part;
    part.file = file;
    part.saved = std::move(*saved);
    if (!describe(&part)) {
      refuse({file.string(), "progress", "a part as --part writes it", "another file"});
      continue;
    }
    if (!identity) identity = part.saved.identity;
    for (const Part& other : parts) {
      if (part.whole != other.whole || part.opaque != other.opaque || part.glint != other.glint ||
          part.moving != other.moving || part.groups != other.groups || part.emission != other.emission)
        refuse({file.string(), "", "a part of the same picture as " + other.file.string(), "one of another"});
      if (meet(part, other)) {
        refuse({file.string(), "", "samples that " + other.file.string() + " has not",
                fmt::format("samples {} to {} of pixels of both", part.from, part.to)});
      }
    }
    parts.push_back(std::move(part));
  }
  // Parts that are good differ in this, so that the order in which they were named changes no bit.
  std::ranges::sort(parts, {},
                    [](const Part& part) { return std::tuple(part.from, part.window.top, part.window.left); });
  return good ? std::move(parts) : std::vector<Part>();
}

image::Window around(const std::vector<Part>& parts) {
  image::Window all = parts.front().window;
  for (const Part& part : parts) {
    const int right = std::max(all.left + all.width, part.window.left + part.window.width);
    const int bottom = std::max(all.top + all.height, part.window.top + part.window.height);
    all.left = std::min(all.left, part.window.left);
    all.top = std::min(all.top, part.window.top);
    all.width = right - all.left;
    all.height = bottom - all.top;
  }
  return all;
}

std::optional<Error> missing_pixel(const integrate::Film& film, const std::filesystem::path& output) {
  const image::Window& window = film.window();
  for (int y = window.top; y < window.top + window.height; ++y) {
    for (int x = window.left; x < window.left + window.width; ++x) {
      const integrate::PixelSums& sums = film.pixel(x, y);
      if (sums.samples + sums.dropped == 0)
        return Error{output.string(), fmt::format("pixel {},{}", x, y), "a part that has it", "none"};
    }
  }
  return std::nullopt;
}

void describe(const std::vector<Part>& parts, const integrate::Film& film, image::Picture* picture) {
  picture->whole_width = parts.front().whole.width;
  picture->whole_height = parts.front().whole.height;
  Identity identity = parts.front().saved.identity;
  for (const std::string& name : may_differ) identity.erase(name);
  picture->metadata["settings"] = identity_text(identity);
  picture->metadata["version"] = version();
  picture->metadata["stopped_by"] = "samples";
  picture->metadata["samples"] = fmt::format("{}", film.samples_per_pixel());
  picture->metadata["dropped_samples"] = std::to_string(film.dropped_samples());
  picture->metadata["noise"] = fmt::format("{:.4g}", film.relative_noise());
  picture->metadata["parts"] = std::to_string(parts.size());
}

int run_merge(const MergeSettings& settings) {
  if (const auto error = check_output(settings.output)) {
    log_error(error->message());
    return 1;
  }
  std::vector<Part> parts = read_parts(settings);
  if (parts.empty()) return 1;
  const integrate::Ground ground = parts.front().opaque ? integrate::Ground::backdrop : integrate::Ground::nothing;
  integrate::Film::Extra extra;
  extra.emission = parts.front().emission;
  extra.groups = parts.front().groups;
  integrate::Film film(around(parts), parts.front().glint, false, ground, 0, parts.front().moving, extra);
  bool one_table = true;
  for (Part& part : parts) {
    integrate::Film own(part.window, part.glint, false, ground, 0, part.moving, extra);
    part.saved.render.sections.erase("film.objects");  // mattes need the scene: they are not merged
    if (!own.set_sections(part.saved.render.sections)) {
      log_error(fmt::format("{}: film.sums: expected the sums of {} x {} pixels, found others", part.file.string(),
                            part.window.width, part.window.height));
      return 1;
    }
    film.add(own);
    part.saved.render.sections.clear();
    one_table = one_table && part.frozen && part.table == parts.front().table;
  }
  if (const auto missing = missing_pixel(film, settings.output)) {
    log_error(missing->message());
    return 1;
  }
  image::Picture picture = film.picture();
  describe(parts, film, &picture);
  if (const auto error = image::write_exr(settings.output, picture, settings.precision)) {
    log_error(error->message());
    return 1;
  }
  std::filesystem::path preview = settings.output;
  if (const auto error = image::write_png(preview.replace_extension(".png"), picture)) {
    log_error(error->message());
    return 1;
  }
  log_note(fmt::format("{}: {} parts, {:.4g} samples a pixel; {}", settings.output.string(), parts.size(),
                       film.samples_per_pixel(),
                       one_table ? "of one frozen table: the picture of one render"
                                 : "tables that learned apart: of the mean of one render, with noise of its own"));
  return 0;
}

}  // namespace

Command add_merge(CLI::App& tress) {
  const auto settings = std::make_shared<MergeSettings>();
  MergeSettings& s = *settings;
  CLI::App* merge = tress.add_subcommand("merge", "Parts of one picture (render --part) as the picture");
  merge
      ->add_option_function<std::vector<std::string>>(
          "PART", [&s](const std::vector<std::string>& files) { s.parts.assign(files.begin(), files.end()); },
          "samples or crops of one picture, each once, in any order")
      ->required();
  add_file(
      merge, "-o,--output", [&s](const std::string& file) { s.output = file; }, "picture; a .png is written beside it",
      ".exr")
      ->required();
  add_precision(merge, s.precision);
  add_quiet(merge);
  return {merge, [settings] { return run_merge(*settings); }};
}

}  // namespace tress::cli
