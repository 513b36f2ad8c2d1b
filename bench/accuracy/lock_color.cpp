// The absorption that makes a lock show a color, for fibers of every shape: what src/fiber/lock_color.cpp is fitted to
// (bench/figures/lock_color.py), by paths through clear locks.
//
// Printed as JSON: for each fiber the absorption per major semi-axis at each color.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "references/lock_ways.h"

int main(int argc, char** argv) {
  using namespace tress;
  CLI::App app("absorptions of locks by their color");
  references::LockRequest request;
  std::vector<double> eccentricities{0.5, 0.575, 0.65, 0.8, 1}, roughnesses{0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1},
      tilts_deg{0, 1.5, 3, 5, 8}, etas{1.35, 1.55, 1.8};
  std::vector<double> colors{0.02, 0.035, 0.05, 0.075, 0.1,  0.15, 0.2,  0.3, 0.4,
                             0.5,  0.6,   0.7,  0.8,   0.85, 0.9,  0.95, 0.98};
  std::string output;
  app.add_option("--paths", request.paths);
  app.add_option("--seed", request.seed);
  app.add_option("--depth", request.depth);
  double widest_deg = 0;
  const auto* one_range = app.add_option("--widest-deg", widest_deg,
                                         "inclinations of the camera, straight on across; else those of a color");
  app.add_option("--eccentricity", eccentricities)->delimiter(',');
  app.add_option("--roughness", roughnesses)->delimiter(',');
  app.add_option("--tilt", tilts_deg)->delimiter(',');
  app.add_option("--eta", etas)->delimiter(',');
  app.add_option("--json", output);
  CLI11_PARSE(app, argc, argv);
  request.widest_theta = widest_deg * std::numbers::pi / 180;

  nlohmann::ordered_json json;
  json["depth"] = request.depth;
  json["paths"] = request.paths;
  json["colors"] = colors;
  for (const double eta : etas) {
    for (const double tilt : tilts_deg) {
      for (const double e : eccentricities) {
        for (const double alpha : roughnesses) {
          fiber::FiberParameters fiber;
          fiber.eta = static_cast<float>(eta);
          fiber.eccentricity = static_cast<float>(e);
          fiber.roughness = static_cast<float>(alpha);
          fiber.tilt = static_cast<float>(tilt * std::numbers::pi / 180);
          const references::LockRequest seen =
              one_range->count() == 0 ? references::seen_as_color(fiber, request) : request;
          const std::vector<float> ways = references::lock_ways(fiber, seen);
          std::vector<double> absorptions;
          for (const double color : colors) absorptions.push_back(references::lock_absorption(ways, color));
          json["fibers"].push_back({{"eta", eta},
                                    {"tilt_deg", tilt},
                                    {"eccentricity", e},
                                    {"roughness", alpha},
                                    {"surface", references::lock_radiance(ways, 1e3)},
                                    {"sigma_a", absorptions}});
          fmt::print("eta {} tilt {} e {} alpha {}: sigma_a at 0.5 {:.5f}\n", eta, tilt, e, alpha, absorptions[9]);
          std::fflush(stdout);
        }
      }
    }
  }
  if (!output.empty()) std::ofstream(output) << json.dump(1) << "\n";
}
