#ifndef DARBOUX_SOLVER_REPORT_VIEW_H_
#define DARBOUX_SOLVER_REPORT_VIEW_H_

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"
#include "solver/report_arrays.h"
#include "solver/results.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What a report shows in three dimensions and what it plots, as data: no page, no markup. A Report
// collects views (a solved scene has one, a calibration one for each grasp) and the documents whose
// numbers are shown beside them; tools/html_report.h makes a page of it.

// All of a report.
// The data of one report, as far as it has been collected.
struct Report {
  nlohmann::ordered_json header;  // AddView and whoever fills it; see MakeReport
  ReportArrays arrays;
};

// header = {"format": 1, "tool", "name", "views": [], "documents": {}}. `documents` are what the
// tool writes as JSON: "summary", "fit", "truth", "accuracy", "calibration". Whoever knows the unit
// of length adds "units": {"length": "mm"}.
Report MakeReport(const std::string& tool, const std::string& name);

// Points beside a shape: a scan, in the frame of the shape, and a number for each point.
struct ReportCloud {
  std::string title;
  std::string label;  // of the values, lengths
  std::vector<Eigen::Vector3d> points;
  std::vector<double> values;  // one each; NaN: none
};

// Of at most kCloudPoints points, spread evenly over the list, where there are more; titled so.
constexpr std::size_t kCloudPoints = 30000;
ReportCloud MakeCloud(const std::string& title,
                      const std::string& label,
                      const std::vector<Eigen::Vector3d>& points,
                      const std::vector<double>& values);

// The error map of a scan (MakeScanFields) as one field: no value where the scan shows nothing.
ExtraField CoveredDistance(const std::vector<ExtraField>& scan_fields);

// One state of a shell. Pointers may be null, and outlive the call.
struct ReportState {
  double factor = 1.0;
  std::string label;
  const Eigen::Matrix3Xd* displacements = nullptr;  // control displacements
  const std::vector<FingerReport>* fingers = nullptr;
  const std::vector<ContactPointReport>* contact = nullptr;
};

// One shell of a report.
// A shell in its states, and what is shown beside it: a view to be.
struct ReportShape {
  std::string title;
  const ShellProblem* problem = nullptr;
  const Scene* scene = nullptr;     // whose fingers and probes are shown; null: the problem's
  std::vector<ReportState> states;  // the shell at rest is shown before the first one
  // Lengths at the points of the output mesh, of the last state; NaN: no value there.
  std::vector<ExtraField> distances;
  std::vector<ReportCloud> clouds;  // of the last state
};

// All states of a solution, in which displacements are finite.
std::vector<ReportState> StatesOf(const SolverSummary& summary);

// Bytes of a view's fields before they are written in base64. Where all states would need more,
// fewer are drawn: the last one always, the others spread evenly. Numbers and plots have them all.
constexpr std::size_t kViewBytes = 24u << 20;

// Appends header["views"]:
//
//   title, points, triangles, size (diagonal of the rest shape), thickness
//   rest        f32, 3 components          indices   u32, 3 components
//   elements    [triangles of each element, in order]; absent where all have four
//   drawn, states  how many states are drawn, of how many
//   steps       [{number, label, factor}], the first is "at rest", number 0
//   fields      [{name, label, dimension, components, signed, steps: [u16 array | null]}]; null
//               where the field has no values in that step
//   fingers     [{name, shape, sizes, rotation, position, direction, travel: [of each step]}]:
//               at position + travel * direction; position is that of first touch
//   probes      [{name, position, displacement: [of each step]}]
//   clouds      [{title, label, points: u16 array, values: u16 array}]
//
// dimension: "length", "1", "1/length", "force/length^2", "energy/length^2".
void AddShellView(const ReportShape& shape, Report* report);

// A finger of a surface that is no shell of ours, `shift` along its direction from the scene's
// place.
struct PlacedFinger {
  const FingerSpec* spec = nullptr;
  double shift = 0.0;
};
// Such a surface, in one state, without fields. Without triangles the points of the clouds are all
// there is to be seen.
void AddMeshView(const std::string& title,
                 const TriangleMesh& mesh,
                 const std::vector<PlacedFinger>& fingers,
                 const std::vector<ReportCloud>& clouds,
                 Report* report);

// Of the last view: header["views"].back()["history"], a list of all states with what is plotted
// against what; numbers that are not finite become null.
//
//   step, factor, iterations, converged, energy, relative_gradient, max_displacement,
//   energies {effect}, fingers {name: {travel, normal_force, contact_area, penetration}},
//   probes {name: [x, y, z]}, gas {gauge_pressure, volume_ratio}, limit_point
//
// and ["iterations"], columns of equal length: method, step, factor, iteration, energy,
// relative_gradient, seconds (solver/iteration_log.h).
void AddHistory(const Scene& scene, const SolverSummary& summary, Report* report);

// The report of a scene that was solved: its view, history and summary.
Report MakeSceneReport(const std::string& tool,
                       const ShellProblem& problem,
                       const SolverSummary& solver_summary,
                       const nlohmann::ordered_json& summary);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_REPORT_VIEW_H_
