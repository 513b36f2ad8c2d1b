// tress denoise: filters a picture that has half pictures.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/options.h"
#include "cli/output_files.h"
#include "cli/picture_preview.h"
#include "denoise/denoised_layer.h"

namespace tress::cli {
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

}  // namespace tress::cli
