// Eigen in a namespace of our own; include it instead of Eigen's headers. Eigen's functions are weak symbols: the
// linker would use those of a host for ours, and a host that is compiled for wider vectors lays out its matrices
// differently.
#pragma once

#define Eigen tress_eigen
#include <Eigen/Cholesky>
#include <Eigen/Core>
