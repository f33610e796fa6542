#ifndef DARBOUX_COSTS_LOAD_WORK_H_
#define DARBOUX_COSTS_LOAD_WORK_H_

#include <Eigen/Core>

#include "costs/potential.h"

namespace darboux {

// Work of dead loads on one control vertex: U = -f.u, the last term of the potential energy (57).
// f is the generalised force on the control displacement, sum of N_i(q) * force(q) over the loaded
// points. All dead loads (point, traction, line, edge, gravity) add up in f, so there is one block
// per loaded control vertex and no dense rows. [f] = N, [u] = m, [U] = J.
// Parameters: the displacement of the control vertex (3).
class LoadWork : public Potential {
 public:
  // `force` (3) is read at every evaluation and may change between solves; it must outlive the
  // block.
  LoadWork(const double* force, double s) : Potential(s), force_(force) {
    mutable_parameter_block_sizes()->push_back(3);
  }

 protected:
  bool EvaluateEnergy(double const* const* parameters,
                      double* energy,
                      double** gradients) const override {
    const Eigen::Map<const Eigen::Vector3d> u(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> force(force_);
    *energy = -force.dot(u);
    if (gradients != nullptr && gradients[0] != nullptr) {
      Eigen::Map<Eigen::Vector3d>{gradients[0]} = -force;
    }
    return true;
  }

 private:
  const double* force_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_LOAD_WORK_H_
