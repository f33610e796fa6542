#ifndef DARBOUX_GEOMETRY_TRIANGLE_INTERSECTION_H_
#define DARBOUX_GEOMETRY_TRIANGLE_INTERSECTION_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace darboux {

// Pairs (i < j, ascending) of triangles that pass through each other or lie on each other, by more
// than `tolerance`, a length. Touching is none: a vertex or an edge on a face, sides that meet
// crosswise, and whatever lies within the tolerance of it. Neighbours count as well:
//   - triangles that share a vertex and meet again, along a line from it;
//   - triangles that share an edge and are folded onto each other;
//   - where a surface passes through another along its own edges, no triangle of it lies on both
//     sides; then one of those at the edge is named.
// T. Moeller, "A fast triangle-triangle intersection test" (1997), with distances below the
// tolerance set to zero, over a tree of boxes. The search ends at max_pairs.
//
// Triangles have three different, finite vertices; those without an area are skipped.
std::vector<std::array<int, 2>> IntersectingTriangles(
    const std::vector<Eigen::Vector3d>& vertices,
    const std::vector<std::array<int, 3>>& triangles,
    double tolerance,
    std::size_t max_pairs);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_TRIANGLE_INTERSECTION_H_
