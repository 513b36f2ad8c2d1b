// The tress command: render, fit, diff, cache.
#pragma once

namespace tress::cli {

/// Exit status: 0 done, 1 could not, 2 wrong usage, 130/143/129 interrupted with picture, cache and telemetry saved.
int run(int argc, char** argv);

}  // namespace tress::cli
