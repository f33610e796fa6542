#include "geometry/mesh_finger.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "geometry/triangle_tree.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where on a triangle: its inside, edge k from corner k to corner k + 1, or corner k.
struct Feature {
  enum Kind { kFace, kEdge, kVertex } kind;
  int k;
};

// C. Ericson, "Real-Time Collision Detection" (2005), Section 5.1.5.
Vector3d ClosestPoint(const std::array<Vector3d, 3>& corners, const Vector3d& x, Feature* feature) {
  const Vector3d &a = corners[0], &b = corners[1], &c = corners[2];
  const Vector3d ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0.0 && d2 <= 0.0) {
    *feature = {Feature::kVertex, 0};
    return a;
  }
  const Vector3d bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0.0 && d4 <= d3) {
    *feature = {Feature::kVertex, 1};
    return b;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    *feature = {Feature::kEdge, 0};
    return a + d1 / (d1 - d3) * ab;
  }
  const Vector3d cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0.0 && d5 <= d6) {
    *feature = {Feature::kVertex, 2};
    return c;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    *feature = {Feature::kEdge, 2};
    return a + d2 / (d2 - d6) * ac;
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    *feature = {Feature::kEdge, 1};
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  *feature = {Feature::kFace, 0};
  const double scale = 1.0 / (va + vb + vc);
  return a + scale * vb * ab + scale * vc * ac;
}

// Distance along the ray x + t direction to a triangle, infinite where it misses.
double RayDistance(const std::array<Vector3d, 3>& corners,
                   const Vector3d& x,
                   const Vector3d& direction) {
  const Vector3d ab = corners[1] - corners[0], ac = corners[2] - corners[0];
  const Vector3d p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0.0) return kInfinity;
  const Vector3d ax = x - corners[0];
  const double u = ax.dot(p) / determinant;
  const Vector3d q = ax.cross(ab);
  const double v = direction.dot(q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0) return kInfinity;
  return ac.dot(q) / determinant;
}

class MeshFinger : public FingerShape {
 public:
  // The mesh has been checked.
  explicit MeshFinger(const TriangleMesh& mesh)
      : mesh_(mesh), tree_(mesh), size_(tree_.nodes()[0].box.diagonal().norm()) {
    MakeNormals();
    max_step_ = HalfThickness();
  }

  bool Evaluate(const Vector3d& x, Distance* out) const override {
    const Nearest nearest = FindNearest(x);
    const int t = nearest.triangle;
    if (nearest.feature.kind == Feature::kFace) {
      out->normal = face_normals_[t];
      out->value = out->normal.dot(x - Corner(t, 0));
      out->hessian.setZero();
      return true;
    }
    const bool edge = nearest.feature.kind == Feature::kEdge;
    const int k = nearest.feature.k;
    const Vector3d& pseudo_normal =
        edge ? edge_normals_[t][k] : vertex_normals_[mesh_.triangles[t][k]];
    const Vector3d d = x - nearest.point;
    const double length = d.norm();
    if (length <= 1e-14 * (size_ + x.norm())) {  // on the feature: d is rounding
      out->value = 0.0;
      out->normal = pseudo_normal;
      out->hessian.setZero();
      return true;
    }
    out->value = d.dot(pseudo_normal) < 0.0 ? -length : length;
    out->normal = d / out->value;
    Matrix3d projector = Matrix3d::Identity() - out->normal * out->normal.transpose();
    if (edge) {
      const Vector3d e = (Corner(t, (k + 1) % 3) - Corner(t, k)).normalized();
      projector -= e * e.transpose();
    }
    out->hessian = projector / out->value;
    return true;
  }

  Ball Bounds() const override {
    Ball ball{tree_.nodes()[0].box.center(), 0.0};
    for (const Vector3d& vertex : mesh_.vertices) {
      ball.radius = std::max(ball.radius, (vertex - ball.center).norm());
    }
    return ball;
  }
  double MaxStep() const override { return max_step_; }
  bool IsConvex() const override { return false; }  // It may be; nobody has to know.

 private:
  struct Nearest {
    double squared = kInfinity;
    int triangle = -1;
    Feature feature{Feature::kFace, 0};
    Vector3d point = Vector3d::Zero();
  };

  const Vector3d& Corner(int triangle, int k) const {
    return mesh_.vertices[mesh_.triangles[triangle][k]];
  }
  std::array<Vector3d, 3> Corners(int triangle) const {
    return {Corner(triangle, 0), Corner(triangle, 1), Corner(triangle, 2)};
  }

  void MakeNormals() {
    std::map<std::pair<int, int>, Vector3d> edges;
    vertex_normals_.assign(mesh_.vertices.size(), Vector3d::Zero());
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const std::array<Vector3d, 3> x = Corners(static_cast<int>(t));
      const Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
      face_normals_.push_back(normal);
      for (int k = 0; k < 3; ++k) {
        const int i = mesh_.triangles[t][k], j = mesh_.triangles[t][(k + 1) % 3];
        edges.emplace(std::minmax(i, j), Vector3d::Zero()).first->second += normal;
        const Vector3d to_next = x[(k + 1) % 3] - x[k], to_last = x[(k + 2) % 3] - x[k];
        const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
        vertex_normals_[i] += angle * normal;
      }
    }
    for (Vector3d& normal : vertex_normals_) normal.normalize();
    edge_normals_.resize(mesh_.triangles.size());
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const int i = mesh_.triangles[t][k], j = mesh_.triangles[t][(k + 1) % 3];
        edge_normals_[t][k] = edges.at(std::minmax(i, j)).normalized();
      }
    }
  }

  Nearest FindNearest(const Vector3d& x) const {
    Nearest best;
    SearchNode(0, x, &best);
    return best;
  }

  void SearchNode(int index, const Vector3d& x, Nearest* best) const {
    const TriangleTree::Node& node = tree_.nodes()[index];
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        Feature feature;
        const Vector3d point = ClosestPoint(Corners(tree_.order()[i]), x, &feature);
        const double squared = (x - point).squaredNorm();
        if (squared < best->squared) *best = {squared, tree_.order()[i], feature, point};
      }
      return;
    }
    const double left = tree_.nodes()[node.left].box.squaredExteriorDistance(x);
    const double right = tree_.nodes()[node.right].box.squaredExteriorDistance(x);
    const bool left_first = left <= right;
    if (std::min(left, right) < best->squared) {
      SearchNode(left_first ? node.left : node.right, x, best);
    }
    if (std::max(left, right) < best->squared) {
      SearchNode(left_first ? node.right : node.left, x, best);
    }
  }

  // First triangle that the ray meets, other than `from`.
  void SearchRay(
      int index, int from, const Vector3d& x, const Vector3d& d, double* best, int* hit) const {
    const TriangleTree::Node& node = tree_.nodes()[index];
    double enter = 0.0, leave = *best;
    for (int axis = 0; axis < 3; ++axis) {
      if (d[axis] == 0.0) {
        if (x[axis] < node.box.min()[axis] || x[axis] > node.box.max()[axis]) return;
        continue;
      }
      const double a = (node.box.min()[axis] - x[axis]) / d[axis];
      const double b = (node.box.max()[axis] - x[axis]) / d[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter > leave + 1e-12 * size_) return;
    if (node.left >= 0) {
      SearchRay(node.left, from, x, d, best, hit);
      SearchRay(node.right, from, x, d, best, hit);
      return;
    }
    for (int i = node.begin; i < node.end; ++i) {
      if (tree_.order()[i] == from) continue;
      const double distance = RayDistance(Corners(tree_.order()[i]), x, d);
      if (distance > 0.0 && distance < *best) {
        *best = distance;
        *hit = tree_.order()[i];
      }
    }
  }

  // Half the distance between a face and the one behind it, at its thinnest. Faces that are more
  // than 60 degrees from parallel are the two sides of an edge, which is always thin, and not
  // front and back; they count only where nothing else does, as in a tetrahedron.
  double HalfThickness() const {
    double between_walls = kInfinity, any = kInfinity;
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      double distance = kInfinity;
      int hit = -1;
      const Vector3d inward = -face_normals_[t];
      SearchRay(0, static_cast<int>(t), tree_.center(static_cast<int>(t)), inward, &distance, &hit);
      if (hit < 0) continue;
      any = std::min(any, distance);
      if (face_normals_[hit].dot(inward) > 0.5) between_walls = std::min(between_walls, distance);
    }
    const double thickness = between_walls < kInfinity ? between_walls : any;
    return 0.5 * (thickness < kInfinity ? thickness : size_);
  }

  TriangleMesh mesh_;
  TriangleTree tree_;
  double size_;
  std::vector<Vector3d> face_normals_, vertex_normals_;
  std::vector<std::array<Vector3d, 3>> edge_normals_;  // per triangle and edge
  double max_step_ = 0.0;
};

bool IsClosed(const TriangleMesh& mesh, std::string* error) {
  const int n = static_cast<int>(mesh.vertices.size());
  if (mesh.triangles.empty()) {
    *error = "the mesh has no triangles";
    return false;
  }
  for (int i = 0; i < n; ++i) {
    if (!mesh.vertices[i].allFinite()) {
      *error = "vertex " + std::to_string(i) + " is not finite";
      return false;
    }
  }
  std::map<std::pair<int, int>, int> halfedges;
  double volume = 0.0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::string name = "triangle " + std::to_string(t);
    const auto& triangle = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      if (triangle[k] < 0 || triangle[k] >= n) {
        *error = name + " has vertex " + std::to_string(triangle[k]) + " of " + std::to_string(n);
        return false;
      }
    }
    const Vector3d& a = mesh.vertices[triangle[0]];
    const Vector3d ab = mesh.vertices[triangle[1]] - a, ac = mesh.vertices[triangle[2]] - a;
    const double longest_squared =
        std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    if (!(ab.cross(ac).norm() > 1e-12 * longest_squared)) {
      *error = name + " has no area";
      return false;
    }
    volume += (a - mesh.vertices[mesh.triangles[0][0]]).dot(ab.cross(ac)) / 6.0;
    for (int k = 0; k < 3; ++k) ++halfedges[{triangle[k], triangle[(k + 1) % 3]}];
  }
  for (const auto& [halfedge, count] : halfedges) {
    const auto opposite = halfedges.find({halfedge.second, halfedge.first});
    if (count != 1 || opposite == halfedges.end() || opposite->second != 1) {
      *error = "the edge between vertices " + std::to_string(halfedge.first) + " and " +
               std::to_string(halfedge.second) +
               " does not belong to exactly two triangles wound alike: the mesh is not closed";
      return false;
    }
  }
  if (!(volume > 0.0)) {
    *error = "the triangles are wound clockwise seen from outside: the volume is negative";
    return false;
  }
  return true;
}

}  // namespace

std::shared_ptr<const FingerShape> MakeMeshFinger(const TriangleMesh& mesh, std::string* error) {
  if (!IsClosed(mesh, error)) return nullptr;
  return std::make_shared<MeshFinger>(mesh);
}

}  // namespace darboux
