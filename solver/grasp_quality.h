#ifndef DARBOUX_SOLVER_GRASP_QUALITY_H_
#define DARBOUX_SOLVER_GRASP_QUALITY_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "geometry/force_closure.h"
#include "solver/grasp.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// What a planner asks of a grasp in one state, in the scene's units.
struct GraspReport {
  // Column j: change of the force of each finger along its direction (against what the shell does
  // to it) by the travel of finger j, while the others stand still. Empty where the shell gives way
  // to any of them without bound.
  Eigen::MatrixXd stiffness;
  // Work of the fingers from first touch on. Where nothing but strain and gas can take it, the
  // energy stored; with friction, other loads or supports that move, the integral of the forces,
  // see GraspQuality.
  double squeeze_work = 0.0;
  double stored_energy = 0.0;  // strain and gas, since then; less than the work by what is lost
  Eigen::Vector3d center_before = Eigen::Vector3d::Zero();  // centroid of the middle surface
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double length = 0.0;  // the largest distance of the undeformed surface from its centroid
  // A soft finger each: at first touch, with the arm 2/3 sqrt(area / pi) of the later patch; and at
  // the centre of the contact pressure, along its mean normal, with the arm of the pressure (see
  // FingerReport). Fingers that do not touch the shell have none in `after`. One soft finger for a
  // patch cannot shift its pressure, so that margins are too small rather than too large.
  std::vector<GraspContact> before, after;
  ForceClosure closure_before, closure_after;
};

// Derivatives of the fingers' forces by their travel, at an equilibrium. With U the energy, t the
// travels and K = d2U/du2,
//
//   F_i = dU/dt_i,   dF_i/dt_j = d2U/dt_i dt_j - (d2U/dt_i du) K^-1 (d2U/du dt_j),
//
// one factorisation and a solution per finger. The points in contact stay; contact is stiffened,
// and supports are given the multipliers that hold them, as far as rounding allows, so that neither
// gives way. Friction is that of closing on: its normal forces and normals follow contact by a
// fixed point with the same factor (where there is none, they stay as they are), which makes the
// matrix unsymmetric. Means that stand for missing supports are weighted down to nothing. In the
// units of *problem, which is left as it was; tangent: of the same problem; cholesky: has analysed
// its matrix. False where that is singular.
bool GraspStiffness(ShellProblem* problem,
                    TangentStiffness* tangent,
                    UpdatedCholesky* cholesky,
                    Eigen::MatrixXd* stiffness);

// The same where the fingers only begin to touch the undeformed shell, each at one point and
// without friction: what the forces grow with at first.
bool TouchStiffness(ShellProblem* problem,
                    TangentStiffness* tangent,
                    UpdatedCholesky* cholesky,
                    Eigen::MatrixXd* stiffness);

// Follows the fingers through the states that a solver accepts.
class GraspQuality {
 public:
  // The problem, which has fingers, must outlive this.
  GraspQuality(ShellProblem* problem, SparseBackend backend);

  // The problem is in the next equilibrium on its way; in the one recorded last, nothing happens.
  // is_result: of a state that is reported, not just passed on the way. Where work is the integral
  // of the forces both count. At load factor zero the work begins. The integral over the travels is
  // cubic between two states from forces and stiffnesses, i.e. the trapezoid rule with a
  // correction,
  //
  //   sum_i dt_i [(F_i0 + F_i1) / 2 + (F'_i0 - F'_i1) / 12],   F'_i = sum_j dF_i/dt_j dt_j,
  //
  // from first touch, where the nearest contact point touches, with the stiffness of that;
  // quadratic, dt_i (2/3 F_i1 - F'_i1 / 6), where a finger comes to touch on the way. Loads that
  // grow at the same time have no part in F'.
  void Record(TangentStiffness* tangent, bool is_result);

  // fingers, energy (strain and gas): of the present state. with_stiffness: it was recorded as a
  // result.
  GraspReport Report(const std::vector<FingerReport>& fingers,
                     double energy,
                     bool with_stiffness) const;

 private:
  struct Sample {
    Eigen::Matrix3Xd displacements;
    Eigen::VectorXd travel, force;
    bool has_stiffness = false;  // it was asked for
    Eigen::MatrixXd stiffness;   // empty: not asked for, or singular
    bool begins = false;         // load factor zero
  };
  Eigen::Vector3d Centroid(bool deformed) const;

  ShellProblem* problem_;
  bool integrates_;  // nothing else tells the work
  std::unique_ptr<UpdatedCholesky> cholesky_;
  Sample last_;
  double work_ = 0.0;           // in the problem's units
  double energy_before_ = 0.0;  // in the scene's
  Eigen::Vector3d center_before_;
  double length_ = 0.0;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_GRASP_QUALITY_H_
