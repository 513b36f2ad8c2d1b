// tress-lab: all commands of tress, with the paper's rivals among the models and learners, and the commands of the
// laboratory.
#include "cli/commands.h"
#include "lab/commands.h"
#include "models/catalog.h"
#include "references/registry.h"

int main(int argc, char** argv) {
  tress::fiber::use_catalog(tress::references::catalog());
  return tress::cli::run(
      argc, argv,
      {"tress-lab", {tress::lab::add_fit, tress::lab::add_far_field, tress::lab::add_lobes, tress::lab::add_measure}});
}
