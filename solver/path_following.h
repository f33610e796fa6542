#ifndef DARBOUX_SOLVER_PATH_FOLLOWING_H_
#define DARBOUX_SOLVER_PATH_FOLLOWING_H_

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "solver/minimisation.h"
#include "solver/mixed_iteration.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/stability.h"

namespace darboux {

// Follows the equilibrium path of a nonlinear problem, load factor and displacements together, past
// limit points (displacement control) and snap-backs (arc length). With q = -d gradient / d factor
// every iteration solves the mixed iteration's matrix for two right-hand sides,
//
//   du = K^-1 (-gradient) + dfactor K^-1 q,   c . du = what is left of the step,
//
// c the controlled displacement, or the direction of the predictor (Riks). Along the arc length the
// matrix may be indefinite: on unstable branches it is L D L^T. A controlled displacement has a
// spring of its own in K, which changes no step and keeps K positive definite wherever the
// controlled shell is stable; elsewhere its stress stiffness is scaled down as in the mixed
// iteration. Inside of the solver.
class PathFollowing {
 public:
  // An equilibrium on the path.
  struct Point {
    double factor = 0.0;
    int iterations = 0;
    Stability stability;
    bool limit_point = false;        // the load factor has an extremum here
    double relative_gradient = 0.0;  // by Ceres
  };
  // The problem is in the state of the point.
  using OnPoint = std::function<void(const Point& point)>;

  PathFollowing(ShellProblem* problem,
                const SolverOptions& options,
                const Deadline& deadline,
                std::vector<std::string>* decisions);

  // From rest to the end that the scene names: full load, or the last value of the controlled
  // displacement. False and a message where it is not reached; the problem then is in the last good
  // state.
  bool Follow(const OnPoint& on_point, std::string* message);

 private:
  struct State {
    double factor = 0.0;
    Eigen::Matrix3Xd displacements;
    std::vector<double> multipliers;
    Eigen::VectorXd tangent;  // K^-1 q: du / dfactor
    double slope = 0.0;       // dfactor / d(path): +-1 / |tangent|, arc length only
    int negative_modes = 0;
  };

  bool FollowDisplacement(const OnPoint& on_point, std::string* message);
  bool FollowArcLength(const OnPoint& on_point, std::string* message);
  // Solves for c . (u - from) = step with the load factor free; c null: at a fixed load factor.
  // A spring of the stiffness given along c: as said above.
  MixedIteration::Summary Correct(const Eigen::VectorXd* control,
                                  const State& from,
                                  double step,
                                  int max_iterations,
                                  double spring = 0.0);
  Eigen::VectorXd LoadVector();
  // The present state with its tangent.
  State Present(const State* previous);
  void Restore(const State& state);
  void Report(const State& state, int iterations, bool limit, const OnPoint& on_point);

  ShellProblem* problem_;
  SolverOptions options_;
  Deadline deadline_;
  std::vector<std::string>* decisions_;
  MixedIteration mixed_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_PATH_FOLLOWING_H_
