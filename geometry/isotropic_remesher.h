#ifndef DARBOUX_GEOMETRY_ISOTROPIC_REMESHER_H_
#define DARBOUX_GEOMETRY_ISOTROPIC_REMESHER_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// Makes the triangles of a mesh of a smooth surface even: long edges are split, short ones
// collapsed, edges flipped towards valence 6 (4 at a boundary) and vertices moved within the
// surface to the centre of their neighbours (Botsch & Kobbelt, A remeshing approach to
// multiresolution modeling, 2004); vertices always lie on the surface. The topology is kept. The
// same input gives the same result.
//
// A boundary lies in planes x, y or z = const, as cut by a box: its vertices stay in theirs, and
// those in two planes stay where they are.
class IsotropicRemesher {
 public:
  // Vertex -> set of the sides of the box that it lies in, bit 2 i for the lower end of coordinate
  // i and 2 i + 1 for the upper one.
  using Sides = unsigned char;

  // Moves p, near the surface, onto it within the given sides and sets its unit normal. False, and
  // p unchanged, where there is no such point nearby.
  using Projector = std::function<bool(Sides, Eigen::Vector3d* p, Eigen::Vector3d* normal)>;

  // A 2-manifold, possibly with boundary: the edges of one triangle only, whose vertices have
  // sides in common; inner vertices have none.
  IsotropicRemesher(const TriangleMesh& mesh,
                    std::vector<Sides> sides,
                    double target_edge_length,
                    Projector projector);

  void Run(int num_iterations);

  // Vertices and triangles in use, in the order of their making.
  TriangleMesh Result(std::vector<Eigen::Vector3d>* normals) const;

 private:
  // Half-edge h belongs to the triangle h / 3 and goes from origin_[h] to origin_[Next(h)].
  static int Next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int Previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int NumHalfEdges() const { return static_cast<int>(origin_.size()); }
  int Target(int h) const { return origin_[Next(h)]; }
  bool IsAlive(int h) const { return origin_[h] >= 0; }
  // One half-edge per edge.
  bool IsFirst(int h) const { return IsAlive(h) && twin_[h] < h; }
  double Length(int h) const { return (position_[origin_[h]] - position_[Target(h)]).norm(); }
  bool IsBoundary(int vertex) const { return sides_[vertex] != 0; }

  void Pair(int g, int h);
  void Leave(int vertex, int h);
  // Half-edges that leave the vertex, counterclockwise from the boundary.
  void Fan(int vertex, std::vector<int>* half_edges) const;
  void Neighbours(int vertex, std::vector<int>* vertices) const;
  bool AreNeighbours(int a, int b) const;
  int Valence(int vertex) const;
  int ValenceExcess(int vertex) const { return Valence(vertex) - (IsBoundary(vertex) ? 4 : 6); }

  // Least cosine between the triangle's normal and those at its corners.
  double Alignment(const Eigen::Vector3d (&p)[3], const Eigen::Vector3d (&n)[3]) const;
  double MinAngle(int a, int b, int c) const;

  bool Split(int h);
  // The edge's origin goes; its target moves to the middle unless either end may not move there.
  bool Collapse(int h, double max_length);
  bool CanFlip(int h) const;
  void Flip(int h);

  void SplitLongEdges(double max_length);
  void CollapseShortEdges(double min_length, double max_length);
  void FlipTowardsEvenValences();
  void FlipTowardsWideAngles();
  void RemoveExtremeValences(double max_length);
  void Relax(bool weighted_by_area);

  double target_;
  Projector projector_;
  std::vector<int> origin_, twin_;  // Twin -1 at the boundary; origin -1 of removed triangles.
  std::vector<int> leaving_;  // Per vertex; at the boundary the one without twin. -1: removed.
  std::vector<Eigen::Vector3d> position_, normal_;
  std::vector<Sides> sides_;
  // Work space.
  mutable std::vector<int> fan_, neighbours_, other_neighbours_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_ISOTROPIC_REMESHER_H_
