// Eigen under a name of our own, to be included in place of its own headers. Its functions are weak symbols: the linker
// takes those of a host for ours, and of a host that is compiled for wider vectors they lay matrices out otherwise.
#pragma once

#define Eigen tress_eigen
#include <Eigen/Cholesky>
#include <Eigen/Core>
