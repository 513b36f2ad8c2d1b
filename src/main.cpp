#include "cli/commands.h"

int main(int argc, char** argv) { return tress::cli::run(argc, argv); }
