#ifndef DARBOUX_GEOMETRY_POINT_CLOUD_H_
#define DARBOUX_GEOMETRY_POINT_CLOUD_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace darboux {

// Measured points: a scan of a surface, or a field of displacements. Any unit of length.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;        // outward, unit; as many as points, or none
  std::vector<Eigen::Vector3d> displacements;  // of the points, which then are at rest; or none

  bool empty() const { return points.empty(); }
};

// .csv: one line per point, separated by commas, semicolons, tabs or spaces; '#' begins a comment.
//   A first line of names says what the columns are: x y z, nx ny nz, ux uy uz, in any order and
//   case; other columns are skipped. z and uz may be missing in a plane field and are 0 then. No
//   line of names: 3 columns are x y z, 6 are x y z nx ny nz, 4 are x y ux uy.
// .ply, .obj, .stl, .off: the vertices, see mesh_io.h, and normals where ply has them.
// Points that are not finite are an error: a line that names the first and counts them. So is a
// file without points. False with one line "FILE:LINE: found ...; allowed ...".
bool ReadPointCloud(const std::string& file, PointCloud* cloud, std::string* error);

// .csv or .ply by the ending of the name; reads back bit for bit. comment: lines on top.
bool WritePointCloud(const std::string& file,
                     const PointCloud& cloud,
                     const std::vector<std::string>& comment,
                     std::string* error);

// Diagonal of the bounding box.
double Extent(const std::vector<Eigen::Vector3d>& points);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_POINT_CLOUD_H_
