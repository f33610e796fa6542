#ifndef DARBOUX_SOLVER_ACCURACY_RESULTS_H_
#define DARBOUX_SOLVER_ACCURACY_RESULTS_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/accuracy_study.h"
#include "solver/results.h"

namespace darboux {

// A study of accuracy (solver/accuracy_study.h) in files and in words.

// A row per run, a column per setting, count, error, quantity, second. Empty where there is no
// value.
std::string MakeAccuracyCsv(const Study& study);
// The same, and reference, extrapolation, Pareto fronts (indices into `runs`), cheapest settings.
nlohmann::ordered_json MakeAccuracyJson(const Study& study);
// Error against dof and against seconds, a series for each family.
std::string MakeAccuracySvg(const Study& study);

// Of one run, for tables and progress: label, dof, iterations, error, seconds.
std::string RunLine(const StudyRun& run);
// Table, notes, reference, cheapest settings.
std::string StudyReport(const Study& study);

// accuracy.csv, accuracy.json and accuracy.svg, and those of `more`, all or none of them; false and
// *error.
bool WriteStudy(const std::string& folder,
                const Study& study,
                std::string* error,
                const std::vector<NamedFile>& more = {});

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_RESULTS_H_
