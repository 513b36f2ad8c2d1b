// tress denoise: a picture with half pictures, filtered.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "denoise/half_filter.h"

namespace tress::cli {
namespace {

struct DenoiseSettings {
  std::filesystem::path picture, output;
  image::Precision precision = image::Precision::half;
  std::optional<int> threads;
};

std::string words_of(const denoise::Denoised& found) {
  const auto of_mean = [&](double squared) {
    return found.mean != 0 ? std::sqrt(std::max(squared, 0.0)) / std::abs(found.mean) : 0;
  };
  return fmt::format("a pixel is off by {:.3g} of the mean brightness, by {:.3g} before; brightness {:+.2g} %",
                     of_mean(found.error_after), of_mean(found.error_before), 100 * found.brightness);
}

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
  Result<denoise::Denoised> found = denoise::denoise(*picture, settings.picture.string());
  if (!found) {
    log_error(found.error().message());
    return 1;
  }
  image::Picture& out = found->picture;
  const std::string words = words_of(*found);
  out.metadata["denoised"] = words;
  const auto alpha = out.metadata.find("alpha");
  const bool transparent = alpha != out.metadata.end() && !alpha->second.starts_with("opaque");
  std::optional<Error> error = image::write_exr(settings.output, out, settings.precision);
  if (!error) error = image::write_png(preview, out, {transparent, 0, image::View::standard});
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

}  // namespace tress::cli
