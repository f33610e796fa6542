#ifndef DARBOUX_GEOMETRY_SCAN_SIMULATOR_H_
#define DARBOUX_GEOMETRY_SCAN_SIMULATOR_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/finger_shape.h"
#include "geometry/point_cloud.h"
#include "geometry/rigid_pose.h"
#include "geometry/shell_surface.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// A scanner that is not there: points measured on the outer face of a deformed shell, with all that
// makes measured points differ from the face, and the truth about each of them. For tests of
// whoever registers, fits and calibrates; so nothing here uses how these work.

// A point of the face that is scanned.
struct FacePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, outward; zero: not known
};

// What is scanned, in any unit of length, in the frame of the model.
struct ScanSurface {
  // The outer face as triangles, wound counterclockwise seen from outside: points are spread over
  // it by area, and it hides what lies behind it. Without triangles it hides nothing.
  TriangleMesh mesh;
  // The exact face over a triangle at corner 0 + b1 (corner 1 - corner 0) + b2 (corner 2 - corner
  // 0). Empty: the triangle is the face.
  std::function<FacePoint(int triangle, double b1, double b2)> evaluate;
  // Where there are any, these are scanned instead of random points of the triangles.
  std::vector<FacePoint> points;
};

// A point of the face at `offset` (h/2: the outer one) from the middle surface sigma + delta, with
// control displacements delta, a column per control vertex:
//
//   x = sigma + delta + offset n',   n' the unit normal of the deformed middle surface.
FacePoint EvaluateFace(const ShellSurface& surface,
                       const Eigen::Matrix3Xd& displacements,
                       double offset,
                       const ElementPoint& at);

// This face, every element cut into parts^2 triangles. Points lie on x itself, not on the
// triangles; they are uniform by area but for the variation of the area element within a triangle.
// The surface must outlive the result.
ScanSurface ScanSurfaceOf(const ShellSurface& surface,
                          const Eigen::Matrix3Xd& displacements,
                          double offset,
                          int parts = 4);

// The surface of a triangle mesh, moved by `offset` along the normals of its vertices (means of the
// triangles' with the weights that are exact on spheres where `normals` is empty).
ScanSurface ScanSurfaceOf(TriangleMesh mesh, std::vector<Eigen::Vector3d> normals, double offset);
// Makes the vertices that triangles have the points to scan.
void ScanVertices(ScanSurface* surface);

// A body that hides what lies behind it.
struct Occluder {
  std::shared_ptr<const FingerShape> shape;
  FingerPose pose;
};

// `count` viewpoints about the surface, `distance` times its radius (half the diagonal of its
// bounding box) from the centre of that box: 6 along the axes, 8 along the diagonals, other numbers
// on a spiral.
std::vector<Eigen::Vector3d> ViewpointsAround(const ScanSurface& surface,
                                              int count,
                                              double distance);

// The scanner: where it stands, what it gets wrong, and in which frame it measures.
struct ScanOptions {
  std::uint64_t seed = 1;
  // Points of the scan, 1 to 1e7, outliers included. Of given points as many as are seen, at most
  // this.
  int num_points = 20000;
  // None: everything is seen, and a point's ray is its normal. A point is seen from a viewpoint if
  // the angle between its normal and the ray is at most `grazing_deg`, and neither a triangle nor
  // an occluder cuts the ray. It is measured from the viewpoint with the smallest such angle;
  // without normals, from the nearest one.
  std::vector<Eigen::Vector3d> viewpoints;
  double grazing_deg = 75.0;  // (0, 90]
  // Standard deviation along the ray, Gaussian, independent from point to point. A length.
  double noise = 0.0;
  // A smooth random field over space, which shifts points along their normals or rays: Gaussian
  // with the correlation exp(-r^2 / (2 bias_length^2)); its root mean square over the points of
  // this scan is exactly `bias`. Lengths.
  double bias = 0.0;
  double bias_length = 0.0;  // 0: a quarter of the extent
  bool bias_along_ray = false;
  // This part of the points is wrong: first `spike_share` of them as spikes, points shifted along
  // their rays by a uniform length within +- spike_size times the extent; the others uniform in the
  // bounding box, enlarged by `outlier_box` about its centre.
  double outliers = 0.0;
  double spike_share = 0.5;
  double spike_size = 0.05;
  double outlier_box = 1.5;
  // The scanner's frame: the model is turned about the centre of its bounding box by a rotation
  // vector uniform in the ball of radius max_angle_deg, then shifted by a vector uniform in the
  // ball of radius max_translation times the extent.
  bool moves = true;
  double max_angle_deg = 180.0;
  double max_translation = 1.0;

  // *error: "NAME: found ...; allowed ...", NAME as above.
  bool IsValid(std::string* error) const;
};

// What is wrong with a point: shifted along its ray (spike) or anywhere (stray).
enum class OutlierKind { kNone = 0, kSpike = 1, kStray = 2 };

// What is known about a point, in the frame of the model.
struct ScanTruth {
  FacePoint face;  // before noise, bias and spike; of a stray point where it is, no normal
  // Of the point among those given, or of the random draw.
  std::uint64_t number = 0;
  int view = -1;       // that it is measured from; -1: none
  double noise = 0.0;  // along the ray, away from the viewpoint (along the normal: outward)
  double bias = 0.0;   // along the normal, outward, or as the noise
  OutlierKind outlier = OutlierKind::kNone;
};

// The measured points, and the truth about them.
struct Scan {
  PointCloud cloud;  // in the scanner's frame; normals are those of the face, where it has any
  std::vector<ScanTruth> truth;  // of each point
  RigidPose model_from_scan;     // what a registration has to find
  int num_spikes = 0, num_strays = 0;
  double extent = 0.0;       // diagonal of the bounding box of the surface
  double bias_length = 0.0;  // the one used
  int num_tried = 0;         // points of the face of which some were not seen
};

// The same options and surface give the same scan, bit for bit, on any machine whose compiler fuses
// no operations: each point has its own random numbers. In other units of length it is the same
// scan. False and *error (one line, "found ...; allowed ...") where less than 1 in 200 random
// points is seen, nothing is there to be scanned, or something needs normals that are not known.
bool SimulateScan(const ScanSurface& surface,
                  const std::vector<Occluder>& occluders,
                  const ScanOptions& options,
                  Scan* scan,
                  std::string* error);

// Whether the body cuts the straight line from a point to another, or contains the first one. To
// 1e-9 of `scale`, a length; exact but for rounding for convex shapes.
bool CutsSegment(const Occluder& body,
                 const Eigen::Vector3d& from,
                 const Eigen::Vector3d& to,
                 double scale);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SCAN_SIMULATOR_H_
