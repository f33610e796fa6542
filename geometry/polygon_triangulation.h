#ifndef DARBOUX_GEOMETRY_POLYGON_TRIANGULATION_H_
#define DARBOUX_GEOMETRY_POLYGON_TRIANGULATION_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

namespace darboux {

// Whether the fan of triangles (0, k, k + 1) covers a polygon in space without folding back: all of
// them turn the same way as the polygon as a whole (Newell's normal). True for every polygon with
// three corners and for convex ones, planar or nearly so.
bool IsFan(const std::vector<Eigen::Vector3d>& corners);

// What lies around a polygon that is to be closed.
struct PolygonSurroundings {
  // Empty, or for each side (k, k + 1) the third corner of the triangle on its other side.
  std::vector<Eigen::Vector3d> opposite;
  // Null, or says whether a triangle must not have the side (i, j), corners that are no neighbours.
  std::function<bool(int, int)> is_forbidden;
};

// Cuts a closed polygon in space, convex or not, planar or not, into corners.size() - 2 triangles
// of its corners that are wound like it. Empty where the forbidden sides leave no way.
//
// Dynamic programming over all triangulations as by P. Liepa, "Filling holes in meshes" (2003),
// sec. 3: the largest angle between normals of neighbouring triangles comes first, in steps of
// 0.01 rad; then, instead of the area, which is the same for all triangulations of a planar
// polygon, the sum of squared lengths of the triangles' sides. O(n^3) time, O(n^2) memory.
std::vector<std::array<int, 3>> TriangulatePolygon(const std::vector<Eigen::Vector3d>& corners,
                                                   const PolygonSurroundings& surroundings = {});

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_POLYGON_TRIANGULATION_H_
