#ifndef DARBOUX_GEOMETRY_POINT_CLOUD_H_
#define DARBOUX_GEOMETRY_POINT_CLOUD_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace darboux {

// Measured points: a scan of a surface, or a field of displacements. Any unit of length.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;        // outward, unit; as many as points, or none
  std::vector<Eigen::Vector3d> displacements;  // of the points, which then are at rest; or none
  // False: displacements are known in the plane of x and y only, and their z is 0.
  bool has_uz = true;

  bool empty() const { return points.empty(); }
};

// .csv, .txt, .xyz: one line per point, '#' begins a comment. Values are separated by semicolons,
//   or else commas, or else tabs and spaces, as the first line has it; blanks beside a separator do
//   not count. Numbers have a decimal point whatever the locale. A first line of names says what
//   the columns are: x y z, nx ny nz, ux uy uz, in any order and case, in double quotes or not;
//   other columns are skipped, whatever they hold. Where a short name is missing, a long one does:
//   x-coordinate, x-position, x-displacement, x-normal, x_coord, u_x, n_x, displacement x, ... with
//   any of - _ . and blanks between the parts, and a unit in brackets behind, as in
//   "x-displacement [mm]"; units of positions and displacements must not differ, as they are not
//   converted. z and uz may be missing in a plane field and are 0 then. A line of names may be a
//   comment ("# x y z ux uy uz") of these names alone. No line of names: 3 columns are x y z, 6 are
//   x y z nx ny nz (if the last three are unit vectors, to 1 %: displacements need names), 4 are x
//   y ux uy.
// .ply, .obj, .stl, .off: the vertices, see mesh_io.h, used or not, and where ply has them
//   normals (nx ny nz) and displacements (ux uy uz).
//
// Normals become unit vectors; unit ones already, to 1e-14, stay as they are. Points that are not
// finite are an error: a line that names the first and counts them; so are displacements and
// normals of that kind and normals of no length, and a file without points. False with one line
// "FILE:LINE: found ...; allowed ..." and *cloud unchanged; line 0 where none is to blame, points
// are counted from 0. Any bytes are safe to read, and at most 2 GiB of them.
bool ReadPointCloud(const std::string& file, PointCloud* cloud, std::string* error);

// The text formats from memory; `file` is for messages.
bool ParsePointCloud(std::string_view contents,
                     const std::string& file,
                     PointCloud* cloud,
                     std::string* error);

// .csv or .ply (text) by the ending of the name; reads back bit for bit. comment: lines on top. A
// cloud that could not be read back (empty, not finite) is not written: false with one line.
bool WritePointCloud(const std::string& file,
                     const PointCloud& cloud,
                     const std::vector<std::string>& comment,
                     std::string* error);

// The same as text, for whoever writes it with other files. .ply: with faces, where there are any.
bool FormatPointCloud(const std::string& file,
                      const PointCloud& cloud,
                      const std::vector<std::array<int, 3>>& triangles,
                      const std::vector<std::string>& comment,
                      std::string* text,
                      std::string* error);

// Diagonal of the bounding box; 0 without points.
double Extent(const std::vector<Eigen::Vector3d>& points);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_POINT_CLOUD_H_
