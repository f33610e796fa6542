#ifndef DARBOUX_SOLVER_EQUILIBRIUM_SENSITIVITY_H_
#define DARBOUX_SOLVER_EQUILIBRIUM_SENSITIVITY_H_

#include <Eigen/Core>
#include <memory>
#include <string>

#include "solver/equilibrium_response.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// What an equilibrium depends on besides the shape of the shell.
enum class StateParameter {
  kYoungModulus,  // by its logarithm: E d/dE
  kThickness,     // by its logarithm: h d/dh, the middle surface stays
  kPoissonRatio,
  kGasPressure,  // gauge pressure at the rest volume, i.e. the amount of gas
  kTravel        // of all fingers alike
};
constexpr int kNumStateParameters = 5;
const char* ToString(StateParameter parameter);

// In the scene's units.
struct StateDerivative {
  Eigen::Matrix3Xd displacement;  // of the control vertices
  // Of the force of each finger along its direction, against what the shell does to it.
  Eigen::VectorXd force;
};

// Derivatives of an equilibrium by its parameters p, by the implicit function theorem. With the
// energy U(u, t, p), u the displacements, t the travels of the fingers,
//
//   U_u(u, t, p) = 0           =>   K du/dp = -U_up - U_ut dt/dp,   K = U_uu
//   F_i = U_t_i                =>   dF_i/dp = U_t_i p + U_t_i u du/dp + U_t_i t dt/dp
//
// one factorisation for all of them and a solution each. Stresses S = C(E, h, nu) e are linear in
// C, so that U_up = B^T (dC/dp) e; the gas's is that of its pressure; the thickness moves the face
// that fingers touch as well, by half of it. Travel counts from first touch, which moves with the
// thickness and with a shell that gas inflates before the fingers come: dt/dp. Contact is rigid,
// its points stay, supports hold. Fingers that forces drive are held where they are: F is then what
// the force would have to become.
//
// As long as this lives the problem's contact is stiffened; afterwards it is as it was.
class EquilibriumSensitivity {
 public:
  // The problem is in equilibrium, as Solve leaves it. Null and *error where the matrix is singular
  // or there is friction, which depends on the way that the state was come by.
  static std::unique_ptr<EquilibriumSensitivity> Create(ShellProblem* problem,
                                                        SparseBackend backend,
                                                        int num_threads,
                                                        std::string* error);

  // start: the derivative of the shell that the fingers have found, where gas has inflated it
  // before; else null. False and *error where the scene has no such parameter, or for thickness and
  // Poisson's ratio with prestressed gas, whose stress is not known as a function of them.
  bool Evaluate(StateParameter parameter,
                const Eigen::Matrix3Xd* start,
                StateDerivative* derivative,
                std::string* error);

  // F of each finger.
  Eigen::VectorXd Forces() const;

 private:
  EquilibriumSensitivity(ShellProblem* problem, SparseBackend backend, int num_threads);
  Eigen::VectorXd StrainForces(StateParameter parameter) const;
  // dt/dp of each finger because its first touch moves: by the offset of the face and by the shell.
  Eigen::VectorXd TouchRates(double offset_rate, const Eigen::Matrix3Xd* start) const;

  ShellProblem* problem_;
  TangentStiffness tangent_;
  UpdatedCholesky cholesky_;
  std::unique_ptr<RigidContact> rigid_;  // null without fingers
  TangentStiffness::StressField stresses_;
  std::vector<TravelDerivatives> by_travel_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_EQUILIBRIUM_SENSITIVITY_H_
