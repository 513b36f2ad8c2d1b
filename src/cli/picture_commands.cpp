// tress merge: makes one picture of parts that were rendered separately.
#include "cli/picture_commands.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/checkpoint_session.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/part_header.h"
#include "cli/picture_preview.h"
#include "denoise/denoised_layer.h"
#include "image/picture.h"
#include "integrate/cryptomatte.h"
#include "integrate/film.h"
#include "tress/version.h"

namespace tress::cli {
namespace {

/// Each part learns into its own cache; whether all parts have one table is checked separately.
const std::vector<std::string> may_differ{"--samples-from", "--samples-to", "--crop", "--warm-cache"};

struct MergeSettings {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path output;
  image::Precision precision = image::Precision::half;
};

struct Part {
  std::filesystem::path file;
  SavedRender saved;
  PartHeader header;
};

bool meet(const PartHeader& a, const PartHeader& b) {
  const auto along = [](int p, int n, int q, int m) { return p < q + m && q < p + n; };
  return along(a.window.left, a.window.width, b.window.left, b.window.width) &&
         along(a.window.top, a.window.height, b.window.top, b.window.height) && a.from < b.to && b.from < a.to;
}

/// Logs all errors; empty if one part is refused.
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
    std::optional<PartHeader> header = parse_part_header(saved->progress);
    if (!header) {
      refuse({file.string(), "progress", "a part as --part writes it", "another file"});
      continue;
    }
    Part part{file, std::move(*saved), std::move(*header)};
    if (!identity) identity = part.saved.identity;
    for (const Part& other : parts) {
      if (!part.header.fits(other.header))
        refuse({file.string(), "", "a part of the same picture as " + other.file.string(), "one of another"});
      if (meet(part.header, other.header)) {
        refuse({file.string(), "", "samples that " + other.file.string() + " has not",
                fmt::format("samples {} to {} of pixels of both", part.header.from, part.header.to)});
      }
    }
    parts.push_back(std::move(part));
  }
  // Valid parts differ in this, so the order in which they were named changes no bit.
  std::ranges::sort(parts, {}, [](const Part& part) {
    return std::tuple(part.header.from, part.header.window.top, part.header.window.left);
  });
  return good ? std::move(parts) : std::vector<Part>();
}

image::Window around(const std::vector<Part>& parts) {
  image::Window all = parts.front().header.window;
  for (const Part& part : parts) {
    const image::Window& window = part.header.window;
    const int right = std::max(all.left + all.width, window.left + window.width);
    const int bottom = std::max(all.top + all.height, window.top + window.height);
    all.left = std::min(all.left, window.left);
    all.top = std::min(all.top, window.top);
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

/// Whether all paths could belong to one render.
bool have_one_table(const std::vector<Part>& parts) {
  return std::ranges::all_of(
      parts, [&](const Part& part) { return part.header.frozen && part.header.table == parts.front().header.table; });
}

/// Writes the header of one render, with the totals of all parts.
void describe(const std::vector<Part>& parts, const integrate::Film& film, image::Picture* picture) {
  const PartHeader& first = parts.front().header;
  picture->whole_width = first.whole_width;
  picture->whole_height = first.whole_height;
  picture->matrices = first.request.matrices;
  picture->screen_width = first.request.screen_width;
  picture->screen_center = first.request.screen_center;
  picture->metadata = first.request.metadata;
  picture->metadata.erase("command");
  Identity identity = parts.front().saved.identity;
  for (const std::string& name : may_differ) identity.erase(name);
  picture->metadata["settings"] = identity_text(identity);
  picture->metadata["version"] = version();
  picture->metadata["stopped_by"] = "samples";
  picture->metadata["samples"] = fmt::format("{}", film.samples_per_pixel());
  picture->metadata["dropped_samples"] = std::to_string(film.dropped_samples());
  picture->metadata["noise"] = fmt::format("{:.4g}", film.relative_noise());
  picture->metadata["parts"] = std::to_string(parts.size());
  if (have_one_table(parts)) picture->metadata["cache_hash"] = first.table;
  if (const integrate::Brightening excess = film.excess(); excess.error > 0)
    picture->metadata["bias_estimate"] = fmt::format("{:.4f} +- {:.4f}", excess.value, excess.error);
  if (const std::optional<integrate::DeepLightBias> bias = film.deep_light_bias())
    picture->metadata["deep_light_bias"] = fmt::format("{:.4f} +- {:.4f}", bias->value, bias->error);
}

/// Adds up the sums of all parts and frees them. Null, with an error logged, if the sums of one cannot be read.
std::unique_ptr<integrate::Film> joined_film(std::vector<Part>& parts) {
  const PartHeader& first = parts.front().header;
  const integrate::Ground ground = first.opaque ? integrate::Ground::backdrop : integrate::Ground::nothing;
  integrate::Film::Extra extra;
  extra.emission = first.emission;
  extra.halves = first.halves;
  extra.deep_light = first.deep_light;
  extra.groups = first.groups;
  extra.data = first.data;
  const auto film_of = [&](const image::Window& window) {
    return std::make_unique<integrate::Film>(window, first.glint, false, ground, first.object_count(), first.moving,
                                             extra);
  };
  std::unique_ptr<integrate::Film> film = film_of(around(parts));
  std::size_t lacking = 0;
  for (Part& part : parts) {
    const std::unique_ptr<integrate::Film> own = film_of(part.header.window);
    if (!own->set_sections(part.saved.render.sections)) {
      log_error(fmt::format("{}: film.sums: expected the sums of {} x {} pixels, found others", part.file.string(),
                            part.header.window.width, part.header.window.height));
      return nullptr;
    }
    lacking += film->add(*own);
    part.saved.render.sections.clear();
  }
  if (lacking > 0) {
    log_warning(fmt::format(
        "mattes: {} pixels have {} objects or {} strands or more in a part, which has counted no others there: "
        "CryptoObject, CryptoMaterial and CryptoStrand may have smaller shares in them than those of one render",
        lacking, integrate::ObjectCounts::most_objects, integrate::ObjectCounts::most_strands));
  }
  return film;
}

/// Writes picture and preview.
std::optional<Error> write(const MergeSettings& settings, const PartHeader& first, const image::Picture& picture) {
  image::Picture kept = picture;
  if (first.layers) image::keep_layers(*first.layers, &kept);
  if (std::optional<Error> error = image::write_exr(settings.output, kept, settings.precision)) return error;
  std::filesystem::path preview = settings.output;
  return image::write_png(preview.replace_extension(".png"), picture, first.look);
}

int run_merge(const MergeSettings& settings) {
  if (const auto error = check_output(settings.output)) {
    log_error(error->message());
    return 1;
  }
  std::vector<Part> parts = read_parts(settings);
  if (parts.empty()) return 1;
  const std::unique_ptr<integrate::Film> sums = joined_film(parts);
  if (sums == nullptr) return 1;
  const integrate::Film& film = *sums;
  if (const auto missing = missing_pixel(film, settings.output)) {
    log_error(missing->message());
    return 1;
  }
  image::Picture picture = film.picture();
  describe(parts, film, &picture);
  for (const integrate::MatteKind& kind : parts.front().header.mattes) integrate::add_mattes(film, kind, &picture);
  integrate::add_strand_mattes(film, &picture);
  if (const auto error = write(settings, parts.front().header, picture)) {
    log_error(error->message());
    return 1;
  }
  log_note(fmt::format(
      "{}: {} parts, {:.4g} samples a pixel; {}", settings.output.string(), parts.size(), film.samples_per_pixel(),
      have_one_table(parts) ? "of one frozen table: the picture of one render"
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
  add_file(merge, "-o,--output", [&s](const std::string& file) { s.output = file; },
           "picture; a .png is written beside it", {".exr"})
      ->required();
  add_precision(merge, s.precision);
  add_quiet(merge);
  return {merge, [settings] { return run_merge(*settings); }};
}

// tress denoise: filters a picture that has half pictures.
namespace {

struct DenoiseSettings {
  std::filesystem::path picture, output;
  image::Precision precision = image::Precision::half;
  std::optional<int> threads;
};

int run_denoise(const DenoiseSettings& settings) {
  std::filesystem::path preview = settings.output;
  preview.replace_extension(".png");
  for (const std::filesystem::path& file : {settings.output, preview}) {
    if (const auto error = check_output(file)) {
      log_error(error->message());
      return 1;
    }
  }
  std::optional<tbb::global_control> limit;
  if (settings.threads)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(*settings.threads));
  const Result<image::Picture> picture = image::read_exr(settings.picture);
  if (!picture) {
    log_error(picture.error().message());
    return 1;
  }
  const Result<denoise::Denoised> found = denoise::denoise(*picture, settings.picture.string());
  if (!found) {
    log_error(found.error().message());
    return 1;
  }
  image::Picture out = denoise::with_filtered(*picture, *found);
  const std::string words = denoise::denoised_words(*found);
  out.metadata["denoised"] = words;
  std::optional<Error> error = image::write_exr(settings.output, out, settings.precision);
  if (!error) error = image::write_png(preview, out, preview_of(out.metadata));
  if (error) {
    log_error(error->message());
    return 1;
  }
  log_note(fmt::format("{}: {}", settings.output.string(), words));
  return 0;
}

}  // namespace

Command add_denoise(CLI::App& tress) {
  const auto settings = std::make_shared<DenoiseSettings>();
  DenoiseSettings& s = *settings;
  CLI::App* denoise = tress.add_subcommand("denoise", "Filter a picture of hair by its half pictures");
  denoise->add_option("PICTURE", s.picture, "an EXR of tress render --layers all,half")->required()->type_name("FILE");
  add_file(denoise, "-o,--output", [&s](const std::string& file) { s.output = file; },
           "the picture with R, G, B filtered and without the halves and variances; a .png is written beside it",
           {".exr"})
      ->required();
  add_precision(denoise, s.precision);
  add_threads(denoise, s.threads);
  add_quiet(denoise);
  return {denoise, [settings] {
            std::error_code code;
            if (std::filesystem::equivalent(settings->picture, settings->output, code))
              throw WrongUsage(fmt::format("{}: expected another file for the output: the halves would be lost",
                                           settings->output.string()));
            return run_denoise(*settings);
          }};
}

// tress diff: measures the difference of two pictures.
namespace {

struct DiffSettings {
  std::filesystem::path a, b;
  bool json = false;
};

/// Returns the number farthest from 0.
double largest_of(const std::array<double, 3>& x) {
  return *std::ranges::max_element(x, {}, [](double value) { return std::abs(value); });
}

/// Prints relMSE, MAE, bias (mean of B - A by channel), the largest difference and whether all channels are identical.
/// Parts of one image (--crop) are compared with each other, and with the whole, where both have pixels. Exit status 0
/// whatever the difference; 1 if a picture cannot be read, or if the pictures have images of different size or no pixel
/// in common.
int run_diff(const DiffSettings& settings) {
  const Result<image::Picture> a = image::read_exr(settings.a);
  if (!a) {
    log_error(a.error().message());
    return 1;
  }
  const Result<image::Picture> b = image::read_exr(settings.b);
  if (!b) {
    log_error(b.error().message());
    return 1;
  }
  const Result<image::Difference> difference = image::compare(*a, *b, settings.a.string(), settings.b.string());
  if (!difference) {
    log_error(difference.error().message());
    return 1;
  }
  const image::Difference& d = *difference;
  if (settings.json) {
    const nlohmann::ordered_json json = {
        {"relMSE", d.rel_mse}, {"MAE", d.mae}, {"bias", d.bias}, {"largest", d.largest}, {"identical", d.identical}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print(
        "relMSE     {:<9.3g} mean of (B - A)^2 / A^2: B is off by {:.2g} % of the brightness of A, root mean square\n"
        "MAE        {:<9.3g} mean of |B - A|, linear color values as in the files\n"
        "bias       {:<9.2g} mean of B - A, the largest of R {:+.2g}, G {:+.2g}, B {:+.2g}: near 0 beside MAE where "
        "only\n"
        "                     noise differs, which falls on both sides; else B is brighter (+) or darker (-)\n"
        "largest    {:<9.3g} |B - A| of the channel and pixel where it is largest\n"
        "identical  {:<9} {}\n"
        "0 is best everywhere: the pictures are the same.\n",
        d.rel_mse, 100 * std::sqrt(d.rel_mse), d.mae, largest_of(d.bias), d.bias[0], d.bias[1], d.bias[2], d.largest,
        d.identical ? "yes" : "no",
        d.identical ? "every channel of every pixel, to the bit" : "at least one value of one channel differs");
  }
  return 0;
}

}  // namespace

Command add_diff(CLI::App& tress) {
  const auto settings = std::make_shared<DiffSettings>();
  CLI::App* diff = tress.add_subcommand("diff", "Compare two pictures");
  diff->add_option("A", settings->a, "picture")->required()->type_name("A.exr");
  diff->add_option("B", settings->b, "picture held against A")->required()->type_name("B.exr");
  diff->add_flag("--json", settings->json, "print JSON");
  return {diff, [settings] { return run_diff(*settings); }};
}

}  // namespace tress::cli
