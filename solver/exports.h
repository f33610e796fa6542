#ifndef DARBOUX_SOLVER_EXPORTS_H_
#define DARBOUX_SOLVER_EXPORTS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "solver/inp_mesh.h"
#include "solver/results.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What a scene and its results are besides, for other programs: files that WriteResults takes.
//
//   inp  shell.inp        the scene as an input deck of CalculiX and Abaqus (solver/inp_export.h)
//   csv  fields_NNNN.csv  the fields of each load step, a row per point of shell_NNNN.vtu;
//        fields.csv       of the final state
//   npz  fields.npz       all of them as arrays of NumPy, and the triangles
struct ExportOptions {
  bool inp = false, csv = false, npz = false;
  bool numbered = true;  // fields_NNNN.csv; else fields.csv alone
  std::optional<InpElement> inp_element;

  bool any() const { return inp || csv || npz; }
};

// "csv,npz", in any order, each once; nothing for an empty list. False and *error: what was found,
// what is allowed.
bool ParseExports(const std::string& list,
                  bool inp_allowed,
                  ExportOptions* options,
                  std::string* error);
// "auto" or the name of an element.
bool ParseInpElement(const std::string& name, ExportOptions* options, std::string* error);
// Whether the scene's surface has such elements.
bool CheckExports(const ExportOptions& options, const Scene& scene, std::string* error);

// A state whose fields are written.
struct ExportState {
  double factor = 1.0;
  bool converged = true;
  const Eigen::Matrix3Xd* displacements = nullptr;
};
std::vector<ExportState> ExportStatesOf(const SolverSummary& summary);

// Appends the files. `remarks`: what the deck says otherwise than the scene. `extra`: more fields,
// of the final state (npz: names as they are).
bool MakeFieldExports(const ShellProblem& problem,
                      const ExportOptions& options,
                      const std::vector<ExportState>& states,
                      const std::vector<ExtraField>& extra,
                      std::vector<NamedFile>* files,
                      std::string* error);
// `summary` may be null: nothing was solved.
bool MakeInpExport(const ShellProblem& problem,
                   const ExportOptions& options,
                   const SolverSummary* summary,
                   std::vector<NamedFile>* files,
                   std::vector<std::string>* remarks,
                   std::string* error);

// The scene's deck alone, without a solution. False and *error as ShellProblem::Create.
bool ExportScene(const Scene& scene,
                 const ExportOptions& options,
                 int num_threads,
                 std::vector<NamedFile>* files,
                 std::vector<std::string>* remarks,
                 std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_EXPORTS_H_
