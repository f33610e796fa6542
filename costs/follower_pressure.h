#ifndef DARBOUX_COSTS_FOLLOWER_PRESSURE_H_
#define DARBOUX_COSTS_FOLLOWER_PRESSURE_H_

#include <Eigen/Core>
#include <vector>

#include "costs/follower_force.h"
#include "costs/potential.h"
#include "costs/strain_energy.h"

namespace darboux {

// Pressure that stays normal to the deformed surface, force p N dA on rest area dA with
// N = x_1 x x_2, over the points of one element. Its potential is -p times the volume swept,
//
//   U = -p/3 [ (x - o) . N - (X - o) . n ] dA,   x = X + u   [J]
//
// whose gradient is the force exactly where the boundary is held, or slides in planes through o
// (mirror planes), and p is uniform. On free boundaries, and for a pressure that varies over the
// surface, the gradient lacks a term; ExactForce has it all, and the solver adds the difference as
// a dead force that it updates until it settles (no energy exists there to minimise).
// linear: the pressure acts on the rest surface, force p n dA, U = -p u . n dA.
// Parameters: one block of 3 per control vertex.
class FollowerPressure : public Potential, public FollowerForce {
 public:
  // pressure: per point, Pa, along +n. factor: load factor, read at every evaluation; must outlive
  // the block.
  FollowerPressure(StrainPoints points,
                   std::vector<double> pressure,
                   const Eigen::Vector3d& origin,
                   const double* factor,
                   double s,
                   bool linear = false);

  // Force on control vertex i of the element as column i.
  Eigen::Matrix3Xd ExactForce(double const* const* displacements) const;

  // 1/3 (X - o) . n dA over the element, and the change of 1/3 (x - o) . N dA: summed over a closed
  // surface the enclosed volume at rest and what the deformation adds to it, m^3.
  double RestVolume() const;
  // linear: to first order. gradients, where not null: its derivatives by the parameter blocks.
  double SweptVolume(double const* const* displacements, double** gradients = nullptr) const;

  // ExactForce and its derivative.
  bool Linearise(double const* const* displacements,
                 Eigen::Matrix3Xd* force,
                 Eigen::MatrixXd* stiffness) const override;

 protected:
  bool EvaluateEnergy(double const* const* displacements,
                      double* energy,
                      double** gradients) const override;

 private:
  // The sum over the points of weight(q) * area * (x . N - X . n), and its gradient.
  template <typename Weight>
  double Sum(double const* const* displacements, const Weight& weight, double** gradients) const;

  StrainPoints points_;
  std::vector<double> pressure_;
  Eigen::Vector3d origin_;
  const double* factor_;
  bool linear_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_FOLLOWER_PRESSURE_H_
