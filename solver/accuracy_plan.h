#ifndef DARBOUX_SOLVER_ACCURACY_PLAN_H_
#define DARBOUX_SOLVER_ACCURACY_PLAN_H_

#include <array>
#include <string>
#include <vector>

#include "solver/scene.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// Which runs a study of accuracy makes of one scene (solver/accuracy_study.h). Nothing is solved
// here.

// What can be varied.
enum class StudyAxis {
  kResolution,
  kGrading,
  kQuadrature,
  kBoundaryRule,
  kStrains,
  kTheory,
  kSolver
};
constexpr int kNumStudyAxes = 7;
const char* ToString(StudyAxis axis);
const char* ToString(SparseBackend backend);

// "resolution,quadrature" in any order. False and *error ("found ...; allowed ...") for an empty
// list or an unknown name.
bool ParseStudyAxes(const std::string& text, std::vector<StudyAxis>* axes, std::string* error);

// One run's settings.
struct StudySettings {
  double refinement = 1.0;              // resolution, times that of the scene
  std::array<double, 2> grading{0, 0};  // parametric kinds
  int quadrature = 3;
  BoundaryRule boundary_rule = BoundaryRule::kIndependent;
  Strains strains = Strains::kKoiter;
  Theory theory = Theory::kAuto;
  Minimizer minimizer = Minimizer::kAuto;
  SparseBackend backend = SparseBackend::kAuto;
};
bool operator==(const StudySettings& a, const StudySettings& b);

// One run of a study.
struct PlannedRun {
  StudySettings settings;
  int level = 0;   // of resolution, 0 = coarsest
  int family = 0;  // runs that differ in nothing but resolution; 0: the scene's own settings
};

// All runs of a study.
struct StudyPlan {
  std::vector<PlannedRun> runs;       // the scene's own first, then level by level
  std::vector<std::string> families;  // how each differs from the scene's own; 0: its settings
  std::vector<std::string> notes;     // what is not varied and why
};

// What a study varies.
struct PlanOptions {
  // Empty: all. Without kResolution the scene's own resolution alone.
  std::vector<StudyAxis> axes;
  bool product = false;  // all combinations; else each axis by itself
  // Parametric kinds and icospheres start at a quarter of the scene's cells per direction, other
  // meshes at their own; each level has twice the one before. 0: five levels, meshes three.
  int levels = 0;
  SparseBackend backend = SparseBackend::kAuto;  // of the scene's own runs
};

// The ends of u and v where cells are worth more, +1 upper, -1 lower, 0 neither: those of the
// scene's grading; else where point loads, pins and fingers, held points and clamped sides lie,
// provided that all of them lie in the same third of the range. 0 if periodic and on meshes.
std::array<int, 2> FavouredEnds(const Scene& scene);

StudyPlan MakeStudyPlan(const Scene& scene, const PlanOptions& options);

// Whether the surface can have fewer elements than the scene says: the kinds with divisions, and
// icospheres that are not refined.
bool CanBeCoarsened(const SurfaceSpec& surface);

// Control vertices times three that a run has, boundary ring included; an estimate for meshes.
double EstimatedDof(const Scene& scene, const StudySettings& settings);

// The scene of one run. Divisions are rounded, at least 1, or 4 where periodic. False and *reason
// where there is none: a mesh cannot be coarsened, or a rounded level repeats the one below it.
bool ApplySettings(const StudySettings& settings, Scene* scene, std::string* reason);

// Cells of a run along u and v; zeros for meshes.
std::array<int, 2> DivisionsOf(const Scene& scene, const StudySettings& settings);

// "divisions 16 x 16, grading 0.85, 3 points, koiter, linear"
std::string DescribeRun(const Scene& scene, const StudySettings& settings, Theory theory_used);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_PLAN_H_
