#include "solver/gas_start.h"

#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

// The scene with nothing on it but its gas.
Scene Bare(const Scene& scene) {
  Scene bare = scene;
  bare.fingers.clear();
  bare.loads = {*FindGas(scene)};
  bare.path = PathSpec();
  return bare;
}

}  // namespace

bool FindPrestress(const Scene& scene,
                   const ShellProblem::Options& problem_options,
                   SparseBackend backend,
                   Eigen::Matrix3Xd* displacements,
                   std::string* error) {
  displacements->resize(3, 0);
  const LoadSpec* const gas = FindGas(scene);
  if (gas == nullptr || !gas->prestressed || gas->gauge_pressure == 0.0) return true;
  Scene design = Bare(scene);
  design.loads.front().law = GasLaw::kIsobaric;
  design.supports.clear();  // What holds the shell has no share in it.
  const std::unique_ptr<ShellProblem> problem =
      ShellProblem::Create(design, problem_options, error);
  if (problem == nullptr) return false;
  // The first step of Newton's method from rest, without stress stiffness.
  TangentStiffness tangent(problem.get(), backend, problem_options.num_threads);
  UpdatedCholesky cholesky(SparseCholesky::Create(backend));
  Eigen::VectorXd gradient;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  request.matrix = true;
  request.stress_factor = 0.0;
  bool solved = tangent.Evaluate(request);
  if (solved) {
    cholesky.SetUpdate(tangent.update_vectors(), tangent.update_weights());
    cholesky.Analyze(tangent.matrix());
    solved = cholesky.Factorize(tangent.matrix());
  }
  if (solved) *displacements = tangent.Expand(cholesky.Solve(-gradient));
  if (solved && displacements->allFinite()) return true;
  *error = gas->location.file + ":" + std::to_string(gas->location.line) + ": " +
           gas->location.key +
           ".rest: found no initial stress in the linear theory, whose matrix is singular; allowed "
           "for this shell: stress_free";
  return false;
}

std::unique_ptr<ShellProblem> InflateBare(const Scene& scene,
                                          const ShellProblem::Options& problem_options,
                                          const SolverOptions& options,
                                          const Deadline& deadline,
                                          std::vector<std::string>* decisions,
                                          LoadStepping::Result* result,
                                          std::string* error) {
  std::unique_ptr<ShellProblem> problem = ShellProblem::Create(Bare(scene), problem_options, error);
  if (problem == nullptr) return nullptr;
  LoadStepping stepping(problem.get(), options, deadline, decisions);
  *result = stepping.Advance(0.0);
  return problem;
}

}  // namespace darboux
