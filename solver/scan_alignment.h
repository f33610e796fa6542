#ifndef DARBOUX_SOLVER_SCAN_ALIGNMENT_H_
#define DARBOUX_SOLVER_SCAN_ALIGNMENT_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "costs/scan_distance.h"
#include "geometry/point_tree.h"
#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"

namespace darboux {

// A scan brought onto a face from a pose near to the right one. Inside of the solver.

// Translation and rotation vector times a length; and some of these as columns.
using Motion = Eigen::Matrix<double, 6, 1>;
using Motions = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// A pose on trial, with the feet of the points it is tried with.
struct PoseTrial {
  RigidPose pose;
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
  double score = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool stays = false;  // not dropped for a worse score
};

// Points of the face with their normals, in place of feet while poses are far from right.
struct FaceSamples {
  explicit FaceSamples(const ShellFace& face);
  // To the tangent plane of the nearest sample; beyond its neighbours, to its disc.
  ShellFace::Foot Nearest(const Eigen::Vector3d& x) const;

  std::vector<ShellFace::Foot> feet;
  std::vector<double> reach;
  PointTree tree;
};

// Moves a scan so that it lies on a face, by robust least squares from a pose of departure.
class ScanAligner {
 public:
  // samples: in place of feet; or null.
  ScanAligner(const ShellFace& face,
              const std::vector<Eigen::Vector3d>& points,
              int num_threads,
              const FaceSamples* samples = nullptr);

  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  // Feet in the trial's pose; those it has are hints.
  void FindFeet(PoseTrial* trial) const;

  // How long and how robustly.
  struct Schedule {
    int iterations = 20;
    double first_factor = 1.0;  // of sigma, halved until it is 1: graduated non-convexity
    double prior = 1e-6;        // what keeps motions that nothing determines still
    double tolerance = 1e-5;    // of the size: a step that ends it
  };
  // Reweighted Gauss-Newton. weights: of points, or none. kept: motions that are not wanted, about
  // the frame of `MakeFrame`, orthonormal columns.
  void Align(const Schedule& schedule,
             const std::vector<double>& weights,
             const Motions& kept,
             PoseTrial* trial) const;

  // About the middle of the points in the trial's pose.
  ScanDistance::Frame MakeFrame(const PoseTrial& trial) const;

  // Direction along which the distance of a point changes: the normal, or beyond a boundary the
  // way to it.
  static Eigen::Vector3d Direction(const Eigen::Vector3d& x, const ShellFace::Foot& foot);

 private:
  static double Sigma(const std::vector<double>& distances, const std::vector<double>& weights);

  // Moves the trial's pose; returns how far.
  double Step(double sigma,
              double prior,
              const std::vector<double>& weights,
              const Motions& kept,
              PoseTrial* trial) const;

  const ShellFace& face_;
  const std::vector<Eigen::Vector3d>& points_;
  int num_threads_;
  const FaceSamples* samples_;
  double size_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCAN_ALIGNMENT_H_
