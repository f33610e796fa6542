#ifndef DARBOUX_GEOMETRY_MESH_IO_H_
#define DARBOUX_GEOMETRY_MESH_IO_H_

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// Triangle meshes from and to files. The ending of the name, in any case, says what a file holds:
//
//   .obj  v and f lines, negative indices, texture and normal indices skipped; free-form surfaces
//         are refused; lines (l), points (p), groups and materials are skipped
//   .ply  ascii, binary_little_endian, binary_big_endian; numbers of any type; other properties and
//         elements skipped
//   .stl  text or binary. Corners with exactly equal coordinates become one vertex (-0 is 0), in
//         the order of first appearance; the normals in the file are skipped, the winding counts
//   .off  also with colours (COFF), normals (NOFF), texture coordinates (STOFF), all skipped
//
// Coordinates are doubles throughout, so that a scene in millimetres is the one in metres. Numbers
// are read with a decimal point whatever the locale. Coordinates may be nan or inf: the mesh doctor
// names such vertices. Vertices keep the order of the file (but see .stl), used or not, and are
// counted from 0 in all messages about a mesh; only messages about a line of an OBJ file count them
// as that line does, from 1. Polygons become triangles: fans about their first corner where that
// is possible (convex ones), otherwise TriangulatePolygon, up to 64 corners. A winding is kept.
//
// False with one line, "FILE:LINE: found ...; allowed ..." (in binary data "FILE:byte OFFSET: ...",
// line 0 where the file cannot be read), and *mesh unchanged. Any bytes are safe to read, and at
// most 2 GiB of them: time and memory are bounded by the length of the file, not by its counts.
bool ReadMesh(const std::string& file, TriangleMesh* mesh, std::string* error);

// The same from memory; `file` serves for messages and for its ending.
bool ParseMesh(std::string_view contents,
               const std::string& file,
               TriangleMesh* mesh,
               std::string* error);

// Only the vertices, from the same formats; faces need not be there (point clouds).
bool ReadPoints(const std::string& file, std::vector<Eigen::Vector3d>* points, std::string* error);

// Vertices, what stands at them in a PLY file, and the faces where there are any.
bool ReadVertices(const std::string& file,
                  TriangleMesh* mesh,
                  VertexVectors* vectors,
                  std::string* error);

// Writes text that reads back bit for bit (shortest digits that do; the sign of a nan aside).
// False with one line "FILE:0: ..." where the file cannot be written.
bool WriteObj(const std::string& file, const TriangleMesh& mesh, std::string* error);
bool WritePly(const std::string& file, const TriangleMesh& mesh, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_IO_H_
