#ifndef DARBOUX_TOOLS_PYTHON_MODULE_H_
#define DARBOUX_TOOLS_PYTHON_MODULE_H_

#include <pybind11/pybind11.h>

#include <string>

#include "tools/python/convert.h"

namespace darboux {

// The parts of the extension module darboux._darboux, which the Python package darboux is made on:
// what is public, and documented, is there.
void BindScene(pybind11::module_* module);
void BindSolution(pybind11::module_* module);
void BindScan(pybind11::module_* module);
void BindFit(pybind11::module_* module);
void BindCalibration(pybind11::module_* module);
void BindStudy(pybind11::module_* module);

// What messages call texts that the package has made from Python's objects. Their lines are nothing
// that anybody has seen.
inline constexpr char kSceneLabel[] = "<scene>";
inline constexpr char kCalibrationLabel[] = "<calibration>";

// The message without "<scene>:LINE: " wherever it stands.
InputError MakeInputError(const std::string& message);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_MODULE_H_
