#ifndef DARBOUX_TOOLS_PYTHON_SOLVER_OPTIONS_H_
#define DARBOUX_TOOLS_PYTHON_SOLVER_OPTIONS_H_

#include <pybind11/pybind11.h>

#include <string>

#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

namespace darboux {

// Python's keyword arguments as options of the solver. They have the names of the tools' flags and
// are checked as these are: InputError "NAME: found ...; allowed ...".

// Value of a key that may be missing or None; InputError where it is of another type.
template <typename T>
bool Get(const pybind11::dict& options, const char* name, const char* allowed, T* value);

// threads, time_limit, max_iterations, gradient_tolerance, sparse_backend.
SolverOptions SolverOptionsOf(const pybind11::dict& options);

// theory, strains, minimizer, quadrature, divisions.
void Override(const pybind11::dict& options, Scene* scene);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_SOLVER_OPTIONS_H_
