// Options of the command line by the kind of their values, and those that several commands share. Each refuses a wrong
// value and says what was expected.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/picture.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/options.h"

namespace tress::cli {

/// Parses a finite number; empty if the text has anything else in it.
std::optional<double> parse_number(const std::string& text);
std::optional<std::uint64_t> parse_unsigned(const std::string& text);
/// The same for whole numbers, with or without a "-".
std::optional<std::int64_t> parse_signed(const std::string& text);
/// Comma-separated numbers.
std::optional<std::vector<double>> parse_numbers(const std::string& text);
/// "640x480".
struct Resolution {
  int width, height;
};
std::optional<Resolution> parse_resolution(const std::string& text);
/// Parses "X0,Y0,X1,Y1": pixels [X0, X1) x [Y0, Y1), at least one, of an image of at most 2^24 per side.
std::optional<image::Window> parse_crop(const std::string& text);

std::string joined(const std::vector<std::string>& words, const std::string& between);

/// Makes a check for the parser, which refuses a text with "expected ..., found ...".
CLI::Validator expecting(const std::string& expected, std::function<bool(const std::string&)> is_good);

/// Adds an option with a number, a whole number, or `least` to `most` of them separated by commas. Range, unit, default
/// and sentence come from the table of parameters, where the option must be. `sentence` replaces the table's, for an
/// option that words it differently from a scene file. set_json: takes a text that begins with "{"; may be empty.
CLI::Option* add_number(CLI::App* app, const std::string& name, std::function<void(double)> set,
                        const std::string& sentence = "");
CLI::Option* add_whole(CLI::App* app, const std::string& name, std::function<void(std::uint64_t)> set);
CLI::Option* add_signed(CLI::App* app, const std::string& name, std::function<void(std::int64_t)> set);
CLI::Option* add_numbers(CLI::App* app, const std::string& name, std::size_t least, std::size_t most,
                         std::function<void(const std::vector<double>&)> set, const std::string& sentence,
                         std::function<void(const std::string&)> set_json = {});

/// Adds an option without a value.
CLI::Option* add_flag(CLI::App* app, const std::string& name, std::function<void()> set);

/// Adds an option with one of the words. The error for a wrong word names the nearest one, or, if it is one of
/// `elsewhere`, the laboratory that has it.
CLI::Option* add_choice(CLI::App* app, const std::string& name, const std::vector<std::string>& choices,
                        std::function<void(const std::string&)> set, const std::string& help,
                        std::span<const std::string_view> elsewhere = {});

/// The program with the models, learners and commands that are not in tress, and how to get it.
inline constexpr const char* laboratory_program = "tress-lab (package tress-lab, or ./bootstrap bench builds it)";

/// Adds a path; its name must have one of the `endings`, such as {".exr"}, in small letters or capitals; if there are
/// none, any name is accepted.
CLI::Option* add_file(CLI::App* app, const std::string& name, std::function<void(const std::string&)> set,
                      const std::string& help, const std::vector<std::string>& endings = {});

/// Adds --eccentricity and --roughness, the shape of all fibers, which selects the slices of their rows. Parsing fills
/// `overrides`, which must outlive it.
void add_fiber_shape(CLI::App* app, scene::Overrides& overrides);

/// Adds --learner, --components, --epsilon and --table-memory, for every command that learns rows. The first two are
/// hidden in a program that has one learner. Parsing fills `table`, which must outlive it.
void add_learner(CLI::App* app, adaptive::Options& table);

/// The group of options that are in no help, manual or completion. (CLI11 leaves the name of an option without a group
/// out of errors.)
inline constexpr const char* hidden_group = "hidden";

/// Options that --set has replaced, which work until version 0.4: each sets its key.
inline constexpr std::array keyed_options{
    "--turn",     "--shutter",    "--motion-samples",   "--fps",       "--least-width",   "--curve-error",
    "--exposure", "--view",       "--transparent",      "--max-depth", "--light-samples", "--bcsdf-samples",
    "--roulette", "--deep-light", "--deep-light-depth", "--near",      "--adaptive",      "--rotate"};

/// Adds keyed_options, hidden. Parsing adds a text for scene::parse_setting() for each that is given.
void add_keyed_options(CLI::App* app, std::vector<std::string>* settings);

/// Logs what --set sets in place of each hidden option that was given.
void log_replaced(const CLI::App& app);

/// Adds --threads; unset: one per hardware thread that the process may use.
void add_threads(CLI::App* app, std::optional<int>& threads);
/// Adds --precision of the picture.
void add_precision(CLI::App* app, image::Precision& precision);
/// Adds --quiet.
void add_quiet(CLI::App* app);

}  // namespace tress::cli
