#include "solver/inp_finger.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace darboux {
namespace {

using Eigen::Vector3d;

// A division of the surface of a box along one axis: where the flat core is, and in which direction
// the rounding points, as the tangent of the angle to the face's normal.
struct Tick {
  double core;   // -1 .. 1, of the core's half size
  double slope;  // -1 .. 1
};

std::vector<Tick> Ticks(double half_core, double rounding, int arc, double cell) {
  const double pi = std::acos(-1.0);
  std::vector<Tick> ticks;
  // Down to the first of the flat ones.
  for (int i = arc; rounding > 0.0 && i > 0; --i)
    ticks.push_back({-1.0, -std::tan(0.25 * pi * i / arc)});
  const int flat =
      half_core > 0.0 ? std::clamp(static_cast<int>(std::ceil(2 * half_core / cell)), 1, 200) : 0;
  for (int i = 0; i <= flat; ++i) ticks.push_back({flat > 0 ? -1.0 + 2.0 * i / flat : 0.0, 0.0});
  for (int i = 1; rounding > 0.0 && i <= arc; ++i)
    ticks.push_back({1.0, std::tan(0.25 * pi * i / arc)});
  return ticks;
}

// All points within `rounding` of a box of the half sizes `core`, which may be nil: sphere,
// capsule, box. Every one of the six sides is a grid; those of neighbours meet along the edges of a
// cube.
TriangleMesh RoundedBox(const Vector3d& core, double rounding, int arc) {
  const double pi = std::acos(-1.0);
  const double cell = rounding > 0.0
                          ? std::max(0.5 * pi * rounding / (2 * arc), core.maxCoeff() / 40)
                          : core.maxCoeff() / 20;
  std::array<std::vector<Tick>, 3> ticks;
  for (int k = 0; k < 3; ++k) ticks[k] = Ticks(core[k], rounding, arc, cell);
  TriangleMesh mesh;
  std::map<std::tuple<int, int, int>, int> index;  // on the surface of a lattice of ticks
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    for (const int side : {-1, 1}) {
      const int fixed = side < 0 ? 0 : static_cast<int>(ticks[k].size()) - 1;
      const auto vertex = [&](int i, int j) {
        std::array<int, 3> at{};
        at[k] = fixed;
        at[a] = i;
        at[b] = j;
        const auto [it, is_new] =
            index.insert({{at[0], at[1], at[2]}, static_cast<int>(mesh.vertices.size())});
        if (is_new) {
          Vector3d base, direction;
          base[k] = side * core[k];
          direction[k] = side;
          base[a] = ticks[a][i].core * core[a];
          base[b] = ticks[b][j].core * core[b];
          direction[a] = ticks[a][i].slope;
          direction[b] = ticks[b][j].slope;
          mesh.vertices.push_back(base + rounding * direction.normalized());
        }
        return it->second;
      };
      for (size_t i = 0; i + 1 < ticks[a].size(); ++i) {
        for (size_t j = 0; j + 1 < ticks[b].size(); ++j) {
          std::array<int, 4> q = {
              vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)};
          if (side < 0) std::swap(q[1], q[3]);
          if ((i + j) % 2 == 0) {
            mesh.triangles.push_back({q[0], q[1], q[2]});
            mesh.triangles.push_back({q[0], q[2], q[3]});
          } else {
            mesh.triangles.push_back({q[0], q[1], q[3]});
            mesh.triangles.push_back({q[1], q[2], q[3]});
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace

TriangleMesh MakeFingerSurface(const FingerSpec& finger,
                               const Vector3d& position,
                               const Eigen::Matrix3d& rotation,
                               const Vector3d& center,
                               double reach,
                               int arc) {
  TriangleMesh mesh;
  switch (finger.shape) {
    case FingerSpec::Shape::kPin:
      break;
    case FingerSpec::Shape::kSphere:
      mesh = RoundedBox(Vector3d::Zero(), finger.radius, arc);
      break;
    case FingerSpec::Shape::kCapsule:
      mesh = RoundedBox({0.0, 0.0, 0.5 * finger.length}, finger.radius, arc);
      break;
    case FingerSpec::Shape::kBox: {
      const Vector3d half(finger.half_sizes[0], finger.half_sizes[1], finger.half_sizes[2]);
      mesh = RoundedBox(half - Vector3d::Constant(finger.rounding), finger.rounding, arc);
      break;
    }
    case FingerSpec::Shape::kPlane: {
      // Its body is below z = 0; the square lies about the foot of the centre.
      const Vector3d local = rotation.transpose() * (center - position);
      constexpr int kCells = 8;
      for (int j = 0; j <= kCells; ++j) {
        for (int i = 0; i <= kCells; ++i) {
          mesh.vertices.emplace_back(local.x() + reach * (2.0 * i / kCells - 1.0),
                                     local.y() + reach * (2.0 * j / kCells - 1.0),
                                     0.0);
        }
      }
      for (int j = 0; j < kCells; ++j) {
        for (int i = 0; i < kCells; ++i) {
          const int a = j * (kCells + 1) + i, b = a + kCells + 1;
          mesh.triangles.push_back({a, a + 1, b + 1});
          mesh.triangles.push_back({a, b + 1, b});
        }
      }
      break;
    }
    case FingerSpec::Shape::kMesh:
      mesh = *finger.mesh;
      break;
  }
  for (Vector3d& x : mesh.vertices) x = position + rotation * x;
  return mesh;
}

std::vector<Vector3d> InnerPoints(const TriangleMesh& surface, double depth) {
  std::vector<Vector3d> normals(surface.vertices.size(), Vector3d::Zero());
  for (const std::array<int, 3>& t : surface.triangles) {
    const Vector3d& a = surface.vertices[t[0]];
    const Vector3d normal =
        (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).stableNormalized();
    for (const int vertex : t) normals[vertex] += normal;
  }
  std::vector<Vector3d> inner;
  for (size_t i = 0; i < normals.size(); ++i) {
    inner.push_back(surface.vertices[i] - depth * normals[i].stableNormalized());
  }
  return inner;
}

}  // namespace darboux
