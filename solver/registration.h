#ifndef DARBOUX_SOLVER_REGISTRATION_H_
#define DARBOUX_SOLVER_REGISTRATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"
#include "geometry/shell_surface.h"

namespace darboux {

// What the paper reports of the distances between a scan and a computed shape, in the scan's unit.
struct DistanceStatistics {
  int count = 0;
  double mean = 0.0;  // signed: > 0 outside
  double mean_abs = 0.0;
  double rms = 0.0;
  double median_abs = 0.0;
  double max = 0.0;  // of |d|
  // Of |d|: bin k is [k, k + 1) * bin_width, the last one with its end, which is max.
  double bin_width = 0.0;
  std::vector<int> histogram;
};
constexpr int kHistogramBins = 20;
DistanceStatistics MakeDistanceStatistics(const std::vector<double>& distances);

// Noise of the scan alone, whatever the shape: differences of the distances of neighbouring points,
// in which everything smooth cancels. Robust (median), for at least 8 points, else 0.
double EstimateNoise(const std::vector<Eigen::Vector3d>& points,
                     const std::vector<double>& distances);

// Robust standard deviation of distances: of those within three of it.
double RobustSigma(const std::vector<double>& distances);

// What of the displacements delta is deformation: they are what is left of them after the rigid
// motion g that minimises
//
//   integral over the middle surface  |sigma + delta - g sigma| dA.
//
// A computed state may have turned as a whole, as a body between two fingers does about their line,
// and a scan has a frame of its own: neither says how much was deformed. Without the square, what
// hardly deformed decides, where it is most of the surface, and a dent does not pull at it.
class Deformation {
 public:
  // The surface must outlive this.
  Deformation(const ShellSurface& surface, const Eigen::Matrix3Xd& displacements);

  // |sigma + delta - g sigma| at a point.
  double At(const ElementPoint& at) const;
  // Of the vertices.
  double largest() const { return largest_; }
  const RigidPose& motion() const { return motion_; }  // g

 private:
  const ShellSurface& surface_;
  Eigen::Matrix3Xd displacements_;
  RigidPose motion_;
  double largest_ = 0.0;
};

// How a scan is matched with a shell.
struct RegistrationOptions {
  enum class Method {
    kRobust,
    // Footnote 11 of the paper: where the computed shape hardly deformed it is aligned with the
    // scan, and the distances of all points are taken in this pose.
    kUndeformedFirst
  };
  Method method = Method::kRobust;
  // kUndeformedFirst: what hardly deformed moved by less than this part of the largest
  // displacement, both without the motion of the whole (Deformation).
  double undeformed_part = 0.05;
  // Standard deviation along normals, in the unit of length; 0: estimated.
  double noise = 0.0;
  // Points taken for the last alignment, drawn evenly; 0: all. Distances are of all points always.
  int max_points = 0;
  // Rotations are not searched but only refined from it.
  std::optional<RigidPose> initial_pose;
  // Of a match sigma is at most this part of the shell's size,
  double max_relative_sigma = 0.01;
  // and at least this part of the points lies within three times as much of the shell.
  double min_inliers = 0.5;
  std::uint64_t seed = 1;
  int num_threads = 1;

  bool IsValid(std::string* error) const;
};

// The pose of a scan, and how well it matches there.
struct RegistrationSummary {
  bool matched = false;
  // In words: why not; or how good, and what is not determined.
  std::string verdict = "not run";

  RigidPose pose;  // scan -> shell
  int iterations = -1;
  // Robust standard deviation of the distances of inliers, which are those within 3 of it (or of
  // the noise that is given, where that is more).
  double sigma = 0.0;
  double noise = 0.0;  // given, or EstimateNoise
  double inlier_fraction = 0.0;
  std::vector<int> outliers;  // numbers of points, ascending

  // Rigid motions of the scan along which distances hardly change (the normal equations have an
  // eigenvalue too small for the noise): a ball turns as it likes. They stay where they were.
  // Names as in rigid_motion.h.
  std::vector<std::string> undetermined;
  Eigen::Matrix<double, 6, 1> eigenvalues = Eigen::Matrix<double, 6, 1>::Zero();  // ascending, of 1
  // Poses, apart from this one and from the undetermined motions, that fit as well: symmetries of
  // the body, or of the part that the scan shows.
  int equivalent_poses = 0;
  int num_starts = 0;
  int num_undeformed = -1;  // kUndeformedFirst: points that decided

  std::vector<double> distances;  // signed, of every point in the final pose
  std::vector<ShellFace::Foot> feet;
  DistanceStatistics all, inliers;

  bool IsSolutionUsable() const { return matched; }
  std::string BriefReport() const;
  std::string FullReport() const;
};

// Finds the rigid motion that brings a scan onto a face:
//
//   min over poses M  sum_i rho(d(M y_i) / sigma),   d the signed distance to the Loop limit face,
//
// rho Tukey's biweight, sigma 1.4826 times the median of |d|, by Gauss-Newton
// (costs/scan_distance.h in Ceres) with feet found anew in every iteration: quadratic convergence
// where the scan is exact. Starts: the pose given, or rotations spread evenly (about 45 degrees
// apart) and those between the principal axes, each first with a few points; the best distinct ones
// are refined. Principal axes alone are wrong for a scan from one side.
//
// A scan that does not belong to the shape is not matched, and the verdict says why: too few
// points, another unit of length, another object, nothing but outliers.
//
// False and *error: options or points that cannot be used (not finite).
bool Register(const ShellFace& face,
              const std::vector<Eigen::Vector3d>& scan,
              const RegistrationOptions& options,
              RegistrationSummary* summary,
              std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_REGISTRATION_H_
