#ifndef DARBOUX_GEOMETRY_ICOSPHERE_H_
#define DARBOUX_GEOMETRY_ICOSPHERE_H_

#include "geometry/triangle_mesh.h"

namespace darboux {

// A sphere about the origin as a geodesic mesh: every face of the icosahedron is divided into
// frequency^2 triangles. 10 n^2 + 2 vertices, at the radius; 20 n^2 triangles, seen
// counterclockwise from outside; valence 5 at the twelve corners of the icosahedron and 6
// elsewhere.
//
// The point with barycentric coordinates (b_1, b_2, b_3) on the face with the corners c_i goes to
//
//   sum_i sin(b_i theta) c_i, normalised;  theta = acos(1/sqrt 5), the angle between two corners,
//
// which divides the edges of the icosahedron evenly and uses its symmetry: for n from 1 to
// infinity edges differ at most by the factor 1.18, triangles by 1.21 in area, and all angles are
// above 53.9 degrees (projecting the plane faces from the centre: 1.47, 2.0 and 54). Doubling n
// keeps all vertices.
//
// The coordinate planes are mirror planes. The points on the axes are midpoints of edges of the
// icosahedron: vertices, of valence 6, for even n. Vertices are numbered deterministically:
// corners, then the edges' inner points, then those of the faces.
//
// Requires a finite radius > 0 and 1 <= n <= kMaxIcosphereFrequency.
TriangleMesh MakeIcosphere(double radius, int frequency);

// Moves the vertices of a closed mesh on a sphere about the origin to the direction of the mean of
// their neighbours, so often. A geodesic mesh is smooth within the faces of the icosahedron and
// kinked across their edges, where second derivatives of a Loop surface through its vertices are
// first-order wrong; ten times over, the curvature of such a sphere is six times nearer to its own,
// at the price of edges that differ by the factor 1.5. The mesh keeps its symmetries.
void SmoothOnSphere(int iterations, TriangleMesh* mesh);

// MakeIcosphere, smoothed ten times: the surface of kind icosphere of a scene.
TriangleMesh MakeSmoothIcosphere(double radius, int frequency);

// Numbers of triangles beyond it would not fit an int.
constexpr int kMaxIcosphereFrequency = 10000;

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_ICOSPHERE_H_
