#ifndef DARBOUX_GEOMETRY_TRIANGLE_MESH_H_
#define DARBOUX_GEOMETRY_TRIANGLE_MESH_H_

#include <Eigen/Core>
#include <array>
#include <vector>

namespace darboux {

// A triangle mesh in space: control points of a Loop surface, points that one is to interpolate, or
// the shape of a finger. Triangles are wound counterclockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

// What a file may give at its vertices besides (PLY: nx ny nz and ux uy uz). As many as vertices,
// or none.
struct VertexVectors {
  std::vector<Eigen::Vector3d> normals;        // of any length, as the file has them
  std::vector<Eigen::Vector3d> displacements;  // of the vertices, which then are at rest
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_TRIANGLE_MESH_H_
