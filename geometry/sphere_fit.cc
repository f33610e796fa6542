#include "geometry/sphere_fit.h"

#include <Eigen/SparseCholesky>
#include <vector>

#include "geometry/shell_surface.h"

namespace darboux {

bool FitToSphere(double radius, LoopMesh* mesh) {
  constexpr int kPoints = 12;  // of a triangle: exact for products of two quartics, almost
  const ShellSurface surface(*mesh);
  const int num_vertices = mesh->mesh.num_vertices;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(num_vertices, 3);
  for (int e = 0; e < surface.num_elements(); ++e) {
    const std::vector<int>& vertices = surface.control_vertices(e);
    const int n = static_cast<int>(vertices.size());
    Eigen::MatrixXd local = Eigen::MatrixXd::Zero(n, n);
    bool defined = true;
    surface.ForEachAreaPoint(e, kPoints, [&](const ShellSurface::AreaPoint& p) {
      const double distance = p.position.norm();
      defined = defined && distance > 0.0;
      local += p.area * p.values.transpose() * p.values;
      for (int i = 0; i < n; ++i) {
        right.row(vertices[i]) += p.area * p.values[i] * radius / distance * p.position.transpose();
      }
    });
    if (!defined) return false;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) entries.emplace_back(vertices[i], vertices[j], local(i, j));
    }
  }
  for (int i = 0; i < num_vertices; ++i) {
    if (!surface.IsActive(i)) entries.emplace_back(i, i, 1.0);
  }
  Eigen::SparseMatrix<double> mass(num_vertices, num_vertices);
  mass.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky(mass);
  if (cholesky.info() != Eigen::Success) return false;
  const Eigen::MatrixX3d points = cholesky.solve(right);
  if (!points.allFinite()) return false;
  if (mesh->folds.empty()) {
    mesh->points = points.transpose();
    return true;
  }
  for (int i = 0; i < num_vertices; ++i) {
    if (mesh->folds[i].size() == 1 && mesh->folds[i][0].first == i && !surface.IsActive(i))
      continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& [vertex, factor] : mesh->folds[i])
      sum += factor * points.row(vertex).transpose();
    mesh->points.col(i) = sum;
  }
  return true;
}

}  // namespace darboux
