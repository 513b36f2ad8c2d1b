// Options of the command line by the kind of value they take, and those that several commands have. Each refuses a
// wrong value with what was expected.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "image/picture.h"
#include "scene/read/load_scene.h"
#include "tress/adaptive/options.h"

namespace tress::cli {

/// What a number must be. Both ends belong to the range unless open.
struct Range {
  double low, high;
  bool low_open = false, high_open = false;
  std::string words() const;  ///< "0 < x <= 1"
  bool contains(double x) const;
};

/// The number that the whole text spells, finite; nothing else around it.
std::optional<double> parse_number(const std::string& text);
std::optional<std::uint64_t> parse_unsigned(const std::string& text);
/// Comma-separated numbers.
std::optional<std::vector<double>> parse_numbers(const std::string& text);
/// "640x480".
struct Resolution {
  int width, height;
};
std::optional<Resolution> parse_resolution(const std::string& text);
/// "X0,Y0,X1,Y1": pixels [X0, X1) x [Y0, Y1), at least one, of an image of no more than 2^24 a side.
std::optional<image::Window> parse_crop(const std::string& text);

/// Throws the parser's error "OPTION: expected ..., found ...".
[[noreturn]] void refuse(const std::string& option, const std::string& expected, const std::string& found);

std::string joined(const std::vector<std::string>& words, const std::string& between);

CLI::Option* add_number(CLI::App* app, const std::string& name, const Range& range, std::function<void(double)> set,
                        const std::string& help);

CLI::Option* add_integer(CLI::App* app, const std::string& name, int low, int high, std::function<void(int)> set,
                         const std::string& help);

/// From 0 to 2^64 - 1.
CLI::Option* add_unsigned(CLI::App* app, const std::string& name, std::function<void(std::uint64_t)> set,
                          const std::string& help);

/// `least` to `most` numbers in range, separated by commas.
CLI::Option* add_numbers(CLI::App* app, const std::string& name, std::size_t least, std::size_t most,
                         const Range& range, std::function<void(const std::vector<double>&)> set,
                         const std::string& help);

/// One of the words; a wrong one is answered with the nearest.
CLI::Option* add_choice(CLI::App* app, const std::string& name, const std::vector<std::string>& choices,
                        std::function<void(const std::string&)> set, const std::string& help);

/// The shape of all fibers, and with it the slices of their rows: --eccentricity and --roughness; parsing fills
/// `overrides`, which must outlive it.
void add_fiber_shape(CLI::App* app, scene::Overrides& overrides);

/// How rows are learned, of every command that learns: --learner, --components, --epsilon and --table-memory; parsing
/// fills `table`, which must outlive it.
void add_learner(CLI::App* app, adaptive::Options& table);

/// --threads; unset: one per hardware thread that the process may use.
void add_threads(CLI::App* app, std::optional<int>& threads);
/// --quiet.
void add_quiet(CLI::App* app);

}  // namespace tress::cli
