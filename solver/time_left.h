#ifndef DARBOUX_SOLVER_TIME_LEFT_H_
#define DARBOUX_SOLVER_TIME_LEFT_H_

#include <optional>

#include "solver/iteration_log.h"

namespace darboux {

// Estimates how long a solve will still take, from what it has taken to come as far as it is: the
// load factor behind it, and of the way to the next one the part that the gradient has come down,
// in logarithms. Along an equilibrium path, whose load factor rises and falls, steps count. A
// guess: within a factor of two where load steps take alike.
class TimeLeft {
 public:
  // The gradient at which a solution at a load factor ends, SolverOptions::gradient_tolerance.
  explicit TimeLeft(double gradient_tolerance) : gradient_tolerance_(gradient_tolerance) {}

  // Seconds; none before a second has passed or a hundredth of the way is done. `total` = 0 begins
  // another solve.
  std::optional<double> Update(const IterationReport& report);

  // Part of the way done, in [0, 1], after Update.
  double part() const { return part_; }

 private:
  double gradient_tolerance_;
  double reached_ = 0.0;         // load factor behind the solve
  double target_ = 0.0;          // under way to it
  double first_gradient_ = 0.0;  // largest on this way
  double part_ = 0.0;
  double smooth_ = -1.0;  // seconds left, at smooth_at_
  double smooth_at_ = 0.0;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_TIME_LEFT_H_
