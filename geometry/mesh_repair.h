#ifndef DARBOUX_GEOMETRY_MESH_REPAIR_H_
#define DARBOUX_GEOMETRY_MESH_REPAIR_H_

#include <string>
#include <vector>

#include "geometry/mesh_doctor.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// What may be mended besides.
struct MeshRepairOptions {
  // Boundary loops of at most so many edges are filled, 0 to 500. Unless the mesh has to be closed,
  // the longest loop of each piece is its rim and stays.
  int max_hole_edges = 0;
};

// What was done to a mesh, and what is wrong with it still.
struct MeshReport {
  std::vector<std::string> mended;  // One line for each thing done, in this order; empty: nothing.
  std::vector<MeshDefect> defects;  // That are left.
};

// Mends what has one sensible cure:
//   - seams are sewn: coincident vertices become the lower one of them
//   - triangles with vertices that do not exist or are not finite, with repeated vertices, and
//     repeated triangles are dropped
//   - a triangle without area is flattened away: its shortest side shrinks to a point where its
//     ends coincide; else its longest side and the neighbour there are cut in two at the third
//     corner, so that no crack opens
//   - triangles are wound alike, closed pieces outwards
//   - on request holes are filled without new vertices (TriangulatePolygon)
//   - vertices without triangles are dropped, and the others keep their order
// Non-manifold edges and vertices, surfaces with one side, separate pieces and self-intersections
// stay as defects. Vertices and triangles in `mended` count as in the mesh before the step that the
// line tells of; numbers of vertices do not change before the last line, which says when they do.
MeshReport RepairMesh(TriangleMesh* mesh,
                      const MeshDoctorOptions& options,
                      const MeshRepairOptions& repair_options = {});

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_REPAIR_H_
