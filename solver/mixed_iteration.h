#ifndef DARBOUX_SOLVER_MIXED_ITERATION_H_
#define DARBOUX_SOLVER_MIXED_ITERATION_H_

#include <functional>
#include <memory>
#include <string>

#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"
#include "solver/unilateral_step.h"

namespace darboux {

// Newton's method with stresses that are unknowns of their own ("mixed integration points";
// Magisano, Leonetti, Garcea, 2017). With r the strain residuals and sigma a stress per quadrature
// point,
//
//   K = J^T J + S(sigma),   K du = -gradient(u),   sigma <- C (e(u) + B du),   u <- u + du
//
// The converged states are those of the plain method, but on the way the stress stiffness feels
// the stress of the linearised strains, not that of a bent shell stretched by its own straight
// step: the number of iterations is nearly independent of the thickness. Steps have a second order
// ("geodesic acceleration"; Transtrum, Sethna, 2012) from the strains that the straight step leaves
// behind, with the same factor:
//
//   K w = -B^T C (e(u + du) - e(u) - B du),   u <- u + du + w
//
// A short step that has reduced the gradient to a tenth or less is followed by one with the same
// matrix and factor (chord): it gains about as much again, for a gradient and a pair of triangular
// solves, a twentieth of an assembly and factorisation. One that does not is taken back.
//
// Steps that turn the surface too far, or whose second order is no longer small against the first,
// are cut. Where K is not positive definite, S is halved down to nothing. Not a descent method:
// what it finds is checked by the caller.
class MixedIteration {
 public:
  // When to stop.
  struct Options {
    int max_iterations = 40;  // chords included
    // Of |gradient|, relative to |supports| + |loads|; or kRoundings times what one rounding of the
    // unknowns changes, where that is more and the iteration gains nothing any more.
    double gradient_tolerance = 1e-7;
    // The state has hardly changed since the last Solve, nor has anything else been factorised: the
    // first step may be a chord with its factor.
    bool has_factor = false;
    // A solution found by chords, which end just below the tolerance, is refined by more of them,
    // to where Newton's last step would have ended. Not for one that is only on the way.
    bool polish = true;
    std::function<bool()> stop;  // asked once an iteration
    // Told the iteration, the energy and the relative gradient of the state it starts from.
    std::function<void(int iteration, double energy, double relative_gradient)> on_iteration;
  };
  // How it ended.
  struct Summary {
    bool converged = false;
    bool stopped = false;
    int iterations = 0;  // with a matrix of their own; chords are not counted
    int chords = 0;
    double iteration_s = 0.0, chord_s = 0.0;  // all of them took
    int factorisations = 0;
    int limited = 0;  // steps cut, to one radian of rotation or because of their second order
    int scaled = 0;   // iterations whose stress stiffness had to be scaled down
    double relative_gradient = -1.0;
    std::string message;
  };

  // Moves the problem's displacements and multipliers. *problem must outlive this.
  MixedIteration(ShellProblem* problem, SparseBackend backend, int num_threads);

  // At the problem's present load factor, from its present displacements and from stresses().
  Summary Solve(const Options& options);

  // Fills the gas in, at the present load factor: from the pressure outside to the full charge, in
  // one step or as many as it takes. The states on the way are no results. Without gas: nothing.
  Summary Inflate(const Options& options);

  // Independent stresses: kept from one Solve to the next. Zero: the first iteration is linear.
  TangentStiffness::StressField& stresses() { return stresses_; }
  // Those of the present strains.
  bool SetStresses();

  // Factorises the true Hessian of the present state, of forces without potential its symmetric
  // part; cholesky() solves with it from then on. Returns the number of negative eigenvalues, zero
  // where the state is stable; -1 where the matrix is singular.
  int FactorizeHessian();

  // Rates of the unknown travels of fingers when their forces change at these rates and the dead
  // loads by `dead_force`, after FactorizeHessian: tangent to the path of equilibria.
  Eigen::VectorXd TravelRates(const Eigen::VectorXd& force_rates,
                              const Eigen::Matrix3Xd& dead_force);

  // Factorises the matrix that tangent() evaluated last: the number of negative eigenvalues, or -1.
  int Factorize();
  // The same where only a positive definite matrix will do: false for any other.
  bool FactorizePositive(double part_of_means = 1.0);

  // Multipliers of the supports and the displacements that belong to them, with the last factor.
  void SettleSupports();

  TangentStiffness& tangent() { return tangent_; }
  SparseCholesky& cholesky() { return *cholesky_; }
  // Whether a gradient is as small as asked, or as rounding allows and no smaller than in the
  // iteration before.
  bool IsBalanced(const Eigen::VectorXd& gradient,
                  double relative_gradient,
                  double previous,
                  double tolerance);
  // Change of RelativeGradient when every unknown moves by one unit of rounding. Springs of the
  // supports and stiff membranes under large displacements raise it.
  double RoundingFloor(const Eigen::VectorXd& gradient);
  // |gradient| relative to the forces, in the present state.
  double RelativeGradient(const Eigen::VectorXd& gradient) const;

 private:
  // Adds its second order to a step that turns the surface by `rotation`, with the last factor, and
  // fingers as they are in *contact, unless that is null. True where the step had to be cut.
  bool Bend(double rotation, const UnilateralStep* contact, Eigen::VectorXd* step);

  ShellProblem* problem_;
  TangentStiffness tangent_;
  std::unique_ptr<UpdatedCholesky> cholesky_;
  TangentStiffness::StressField stresses_;
  bool analysed_ = false;
  bool has_factor_ = false;          // of Solve, and all of it: for chords
  std::vector<int> factor_contact_;  // points in contact when it was made, ascending
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MIXED_ITERATION_H_
