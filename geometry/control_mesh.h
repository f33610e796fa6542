#ifndef DARBOUX_GEOMETRY_CONTROL_MESH_H_
#define DARBOUX_GEOMETRY_CONTROL_MESH_H_

#include <array>
#include <vector>

namespace darboux {

// Connectivity of a Loop control mesh. Triangles are wound counterclockwise seen from the side the
// normal points to. The first num_elements triangles carry the shell; the others (ghost triangles)
// only complete the neighbourhoods of elements at an open boundary, so that the control vertices
// of the ghost ring are unknowns of their own and the displacement space on the shell is the full
// Loop space (design rule: no folding of ghost vertices, which would fix the curvature at the rim).
struct ControlMesh {
  int num_vertices = 0;
  int num_elements = 0;
  std::vector<std::array<int, 3>> triangles;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_CONTROL_MESH_H_
