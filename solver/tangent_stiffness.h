#ifndef DARBOUX_SOLVER_TANGENT_STIFFNESS_H_
#define DARBOUX_SOLVER_TANGENT_STIFFNESS_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/stiffness_pattern.h"

namespace darboux {

// Second-order model of a ShellProblem's energy, assembled element by element from the kernels of
// costs/strain_derivatives.h: what Ceres' normal equations are, an order of magnitude cheaper to
// assemble, and with the stress stiffness that no J^T J can hold. All of it in the units of
// ShellProblem::problem(): energy / force_unit().
//
// Unknowns are the components of the free control vertices, ordered to keep the factor sparse.
class TangentStiffness {
 public:
  // Stress resultants (N_11, N_22, N_12, M_11, M_22, M_12) times the area of the point.
  using Stress = Eigen::Matrix<double, 6, 1>;
  // One per quadrature point, elements in order.
  using StressField = std::vector<Stress>;

  // *problem must outlive this. Reads its supports and blocks once.
  TangentStiffness(const ShellProblem* problem, SparseBackend backend, int num_threads);

  int num_unknowns() const { return static_cast<int>(matrix_.cols()); }
  int num_points() const { return point_begin_.back(); }

  // What Evaluate is to compute; null where it is not wanted.
  struct Request {
    // Strain energy + springs and multipliers of supports - work of dead forces. Forces that follow
    // the deformation have no part in it, because they need not have an energy.
    double* energy = nullptr;
    Eigen::VectorXd* gradient = nullptr;
    StressField* stresses = nullptr;  // of the present strains
    // K = sum of B^T C B + springs, in matrix(), and times stress_factor minus the derivative of
    // forces that follow and the stress stiffness of *initial_stresses, where that is given.
    bool matrix = false;
    const StressField* initial_stresses = nullptr;
    double stress_factor = 1.0;
    bool control_spring = false;  // the matrix has the spring of SetControlSpring as well
  };
  // At the problem's present displacements, load factor and multipliers. False where a strain or a
  // force is undefined; then nothing is set. Of a force without potential the matrix has the
  // symmetric part.
  bool Evaluate(const Request& request);

  // A spring along a linear form of the displacements of one element, a column per control vertex.
  // Where that form is prescribed, the spring makes the matrix positive definite past limit points.
  void SetControlSpring(int element, const Eigen::Matrix3Xd& coefficients, double stiffness);

  // B^T C (e(u + step) - e(u) - B step), u the present displacements: the forces of the strains
  // that a straight step leaves behind because strains are not linear in it. False where the
  // strains at u + step are undefined.
  bool StrainDefect(const Eigen::VectorXd& step, Eigen::VectorXd* forces);

  // B^T S: the forces that resist stresses S, on the unknowns, in the present state. Precondition:
  // Evaluate succeeds here.
  Eigen::VectorXd StressForces(const StressField& stresses) const;

  // The part of the gradient that depends on the load factor, and linearly so: supports, dead
  // forces and forces that follow; the gas's forces, which do not, as well. Precondition: Evaluate
  // succeeds here.
  Eigen::VectorXd ExternalGradient() const;
  // Sizes of the forces of the supports and of the loads (N / force_unit): the scale that a
  // gradient is measured against.
  double ForceScale() const;

  // Stresses that the linearised strains take on when the unknowns change by `step`.
  void LinearisedStresses(const Eigen::VectorXd& step, StressField* stresses) const;

  // The largest angle, rad to first order, that the normal turns by when the unknowns change by
  // `step`: over the elements, at one point of each.
  double LargestRotation(const Eigen::VectorXd& step) const;

  // Adds a symmetric matrix over the control displacements of one element, 3 rows per control
  // vertex, to the values of a matrix of the pattern of matrix(): energies that the problem does
  // not have. Those of vertices that are not unknown are left out.
  void AddElementMatrix(int element, const Eigen::MatrixXd& block, Eigen::VectorXd* values) const;

  // Lower triangle of the sparse part of the matrix made by the last Evaluate that asked for it.
  const Eigen::SparseMatrix<double>& matrix() const { return matrix_; }
  // The rest of it, vectors * diag(weights) * vectors^T: minus the pins that keep the sparse part
  // regular, mean conditions; then what changes with the state: the gas's, and minus the coupling
  // with the unknown travels of fingers, which are eliminated (Schur):
  //
  //   K_uu - K_ut K_tt^-1 K_tu,   the travels in balance (Grasp::Close) at the state itself.
  const Eigen::MatrixXd& update_vectors() const { return update_vectors_; }
  const Eigen::VectorXd& update_weights() const { return update_weights_; }
  // With the mean conditions' reduced to a part.
  Eigen::VectorXd UpdateWeights(double part_of_means) const;
  // Changes of the unknown travels that belong to a step of the other unknowns, after the last
  // Evaluate that asked for the matrix.
  Eigen::VectorXd TravelChanges(const Eigen::VectorXd& step) const;
  // The same of a unit of force on each finger, were the shell rigid: 1 / K_tt; and the forces on
  // the other unknowns that it passes on, a column per finger: -K_ut / K_tt.
  const Eigen::VectorXd& travel_compliances() const { return travel_compliances_; }
  const Eigen::MatrixXd& travel_forces() const { return travel_changes_; }

  // Unknowns <-> control displacements, a column per control vertex.
  Eigen::Matrix3Xd Expand(const Eigen::VectorXd& x) const;
  Eigen::VectorXd Reduce(const Eigen::Matrix3Xd& covector) const;
  // The same of a covector that has columns for these control vertices alone.
  Eigen::VectorXd Reduce(const std::vector<int>& vertices, const Eigen::Matrix3Xd& covector) const;

 private:
  template <int kComponents>
  bool EvaluateElements(int begin, int end, const Request& request, int thread);
  // Of the initial strains. Precondition: there are some.
  Stress InitialStress(const StrainPoint& point, int index) const;
  void BuildPattern(SparseBackend backend);
  // Adds the matrix of a spring to values.
  void AddSpring(const std::vector<int>& vertices,
                 const Eigen::Matrix3Xd& coefficients,
                 double stiffness,
                 Eigen::VectorXd* values) const;
  // The forces that follow; adds minus their derivative to the matrix, where that is asked for.
  bool AddFollowerForces(const Request& request, Eigen::Matrix3Xd* force);
  bool FollowerForces(Eigen::Matrix3Xd* force) const;
  Eigen::Matrix3Xd GasForce() const;
  // Calls use(placed force, force, stiffness) for each of them that is not nil.
  template <typename Use>
  bool ForEachFollower(bool with_stiffness, double stiffness_part, const Use& use) const;
  const ShellProblem& problem_;
  int num_threads_;
  int components_;                      // unknowns per vertex
  Eigen::MatrixXd basis_;               // 3 x components_
  Eigen::Matrix3d membrane_, bending_;  // stiffness per area
  std::vector<int> point_begin_;        // of each element, and behind the last
  std::unique_ptr<StiffnessPattern> pattern_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::VectorXd support_values_;  // the springs' share of the matrix: constant
  Eigen::VectorXd shell_values_;    // the elements', where they are constant and made
  Eigen::VectorXd control_values_;  // that of the control spring
  Eigen::MatrixXd update_vectors_;
  Eigen::VectorXd update_weights_;
  int num_travels_ = 0;
  Eigen::MatrixXd travel_changes_;  // -K_ut / K_tt, a column per unknown travel
  Eigen::VectorXd travel_compliances_;
  struct Workspace {
    Eigen::VectorXd values;
    Eigen::MatrixXd gradient;  // components in basis_, a column per control vertex
    double energy = 0.0;
  };
  std::vector<Workspace> workspaces_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_TANGENT_STIFFNESS_H_
