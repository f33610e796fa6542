#ifndef DARBOUX_SOLVER_SUMMARY_JSON_H_
#define DARBOUX_SOLVER_SUMMARY_JSON_H_

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "solver/shell_solver.h"

namespace darboux {

// What summary.json and the files beside it have in common. Inside of the solver.

// Null where there is no finite value.
nlohmann::ordered_json Optional(const std::optional<double>& value);

// Of the fingers, against each other.
bool HasStiffness(const LoadStep& step);

// Where `count` > 0 the results are no longer converged, and their message says "COUNT`what`".
void MarkNotFinite(std::size_t count, const std::string& what, nlohmann::ordered_json* json);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SUMMARY_JSON_H_
