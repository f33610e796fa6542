#ifndef DARBOUX_SOLVER_RESULTS_H_
#define DARBOUX_SOLVER_RESULTS_H_

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "solver/accuracy.h"
#include "solver/file_set.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// How one `expect` of a scene came out.
struct ExpectResult {
  std::string quantity;
  std::optional<double> value;  // none where summary.json has no such number
  double expected = 0.0;
  // |value - expected|, over |expected| where the tolerance is relative.
  std::optional<double> error;
  double tolerance = 0.0;
  bool relative = true;
  bool holds = false;
  std::string message;  // why there is no value; empty where there is one
};

// Looks up every quantity of scene.expect in summary.json: names joined by dots, [i] for the entry
// i >= 0 of an array, e.g. "load_steps[0].factor"; true and false count as 1 and 0. A quantity that
// is not there, or no number, does not hold; its message lists what is there. Returns whether all
// hold.
bool EvaluateExpectations(const Scene& scene,
                          const nlohmann::ordered_json& summary,
                          std::vector<ExpectResult>* results);
// How they come out as summary.json has it under `expect`.
nlohmann::ordered_json MakeExpectJson(const std::vector<ExpectResult>& results);

// The contents of summary.json but for `expect` and for time_s.output. Keys are stable; those of
// effects that are off are there, empty or zero. A number that is not finite becomes null, and
// then "converged" is false ("nonlinearity_estimate" is null where no finite estimate was made,
// which says nothing about convergence). `accuracy` may be null.
nlohmann::ordered_json MakeSummaryJson(const Scene& scene,
                                       const SolverSummary& summary,
                                       const AccuracyReport* accuracy);

// The contents of history.csv.
std::string MakeHistoryCsv(const Scene& scene, const SolverSummary& summary);

// What was written.
struct Results {
  nlohmann::ordered_json summary;
  std::vector<ExpectResult> expectations;
  bool converged = false;
  bool expectations_hold = false;
  std::vector<std::string> files;  // written, without the folder
};

// The contents of shell.vtu in a state that somebody else has found, and of deformed.ply, as
// WriteResults has them; `extra`: more point fields. Values of a field that are not finite are
// written as 0.
struct ExtraField {
  std::string name;
  std::vector<double> values;  // at MakeOutputMesh(surface).points
};
std::string MakeVtu(const ShellProblem& problem,
                    const Eigen::Matrix3Xd& displacements,
                    const std::vector<ExtraField>& extra);
std::string MakeDeformedPly(const ShellProblem& problem, const Eigen::Matrix3Xd& displacements);

// Files with these names and contents, in a folder that is created when missing: all of them or,
// with *error, none.
struct NamedFile {
  std::string name, content;
};
bool WriteFiles(const std::string& folder, const std::vector<NamedFile>& files, std::string* error);

// More files to go with the others, made of the contents of summary.json.
using MoreFiles = std::function<std::vector<NamedFile>(const nlohmann::ordered_json& summary)>;

// Writes what was solved into a folder, created when missing:
//
//   summary.json    MakeSummaryJson, `expect`, times
//   shell_0001.vtu  one per load step: VTK unstructured grid of triangles over the rest surface,
//   ...             every element cut in four, with the displacement and the fields of
//                   solver/fields.h (same units and frames) at its points; with fingers also
//                   contact_pressure (solver/contact_pressure.h)
//   shell.vtu       the final state
//   shell.pvd       the list of the steps, the load factor as time; opens in ParaView
//   deformed.ply    the final state: deformed points, normals, triangles
//   history.csv     a row per load step; columns are named like the paths into summary.json
//   and those of `more`, where it is given
//
// All files appear together, under temporary names (NAME.part) until the last one is complete;
// shell_NNNN.vtu of an earlier run with more steps and its report.html are removed. Where the final
// state is not finite, the last one that is stands for it. Values that are not finite are written
// as 0 in files of fields and left out in history.csv; summary.json then says so and is not
// converged.
//
// False and *error, and the folder's earlier results as they were, where a file cannot be written.
// `accuracy` may be null. `more`: files that appear with the others (solver/exports.h).
bool WriteResults(const std::string& folder,
                  const ShellProblem& problem,
                  const SolverSummary& summary,
                  const AccuracyReport* accuracy,
                  Results* results,
                  std::string* error,
                  const MoreFiles& more = nullptr);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_RESULTS_H_
