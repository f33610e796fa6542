#include "costs/potential.h"

namespace darboux {

class Potential::Loss : public ceres::LossFunction {
 public:
  explicit Loss(const double* energy) : energy_(energy) {}
  void Evaluate(double, double rho[3]) const override {
    rho[0] = 2.0 * *energy_;
    rho[1] = 1.0;
    rho[2] = 0.0;
  }

 private:
  const double* energy_;  // of the block's cost function, which lives as long as the block
};

ceres::ResidualBlockId Potential::AddTo(ceres::Problem* problem,
                                        Potential* potential,
                                        const std::vector<double*>& parameters) {
  return problem->AddResidualBlock(potential, new Loss(&potential->energy_), parameters);
}

bool Potential::Evaluate(double const* const* parameters,
                         double* residuals,
                         double** jacobians) const {
  if (!EvaluateEnergy(parameters, &energy_, jacobians)) return false;
  residuals[0] = s_;
  if (jacobians == nullptr) return true;
  for (size_t i = 0; i < parameter_block_sizes().size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    for (int k = 0; k < parameter_block_sizes()[i]; ++k) jacobians[i][k] /= s_;
  }
  return true;
}

}  // namespace darboux
