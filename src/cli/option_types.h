// Options of the command line by the kind of value they take. Each refuses a wrong value with what was expected.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cli/argument.h"

namespace tress::cli {

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

}  // namespace tress::cli
