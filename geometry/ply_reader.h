#ifndef DARBOUX_GEOMETRY_PLY_READER_H_
#define DARBOUX_GEOMETRY_PLY_READER_H_

#include <string_view>

#include "geometry/mesh_builder.h"

namespace darboux {

// Reads the vertices and faces of a PLY file (ReadMesh in mesh_io.h says which) into the builder,
// and normals (properties nx ny nz of the vertices) and displacements (ux uy and, or 0, uz) where
// all of them are there; `end` is the place after them. G. Turk, "The PLY polygon file format"
// (1994); int8 ... float64 as other names of the types, and 64 bit integers, are later additions.
bool ReadPly(std::string_view contents, MeshBuilder* builder, std::size_t* end);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_PLY_READER_H_
