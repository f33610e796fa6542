#ifndef DARBOUX_TESTS_FINGER_UTIL_H_
#define DARBOUX_TESTS_FINGER_UTIL_H_

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "geometry/finger_shape.h"
#include "geometry/mesh_finger.h"
#include "geometry/triangle_mesh.h"
#include "tests/test_util.h"

// What the tests of fingers share.
namespace darboux {

// phi and its gradient as residuals, so that HasCorrectJacobianAt checks gradient and Hessian.
class DistanceAndNormal : public ceres::CostFunction {
 public:
  DistanceAndNormal(const FingerShape& shape, const FingerPose& pose) : shape_(shape), pose_(pose) {
    set_num_residuals(4);
    mutable_parameter_block_sizes()->push_back(3);
  }
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Distance d;
    if (!pose_.Evaluate(shape_, Eigen::Map<const Eigen::Vector3d>(parameters[0]), &d)) return false;
    Eigen::Map<Eigen::Vector4d>{residuals} << d.value, d.normal;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>>{jacobians[0]}
          << d.normal.transpose(),
          d.hessian;
    }
    return true;
  }

 private:
  const FingerShape& shape_;
  FingerPose pose_;
};

// The parameters of a cost, one block after the other.
inline std::vector<const double*> Blocks(const ceres::CostFunction& cost,
                                         const Eigen::VectorXd& x) {
  std::vector<const double*> blocks;
  int offset = 0;
  for (const int size : cost.parameter_block_sizes()) {
    blocks.push_back(x.data() + offset);
    offset += size;
  }
  return blocks;
}

inline FingerPose SkewPose() { return {{0.3, -0.2, 0.1}, SkewRotation(0.8)}; }

inline Distance DistanceAt(const FingerShape& shape,
                           const Eigen::Vector3d& x,
                           const FingerPose& pose = FingerPose()) {
  Distance d;
  EXPECT_TRUE(pose.Evaluate(shape, x, &d));
  return d;
}

// Points on the sphere, 20 * 4^splits triangles.
inline TriangleMesh SphereMesh(double radius, int splits) {
  const LoopPatch patch = MakeIcosphere(radius, splits);
  TriangleMesh mesh;
  for (int i = 0; i < patch.positions.cols(); ++i) mesh.vertices.push_back(patch.positions.col(i));
  mesh.triangles = patch.mesh.triangles;
  // Outward, however the sphere is wound.
  const auto& t = mesh.triangles.front();
  const Eigen::Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
  if (a.dot(b.cross(c)) < 0.0) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

// Twelve triangles; `dent` pushes a corner in, past the centre: a body that is not convex.
inline TriangleMesh CuboidMesh(const Eigen::Vector3d& half_sizes, bool dent = false) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(half_sizes.cwiseProduct(
        Eigen::Vector3d(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0)));
  }
  mesh.triangles = {{0, 2, 1},
                    {1, 2, 3},
                    {4, 5, 6},
                    {5, 7, 6},
                    {0, 1, 4},
                    {1, 5, 4},
                    {2, 6, 3},
                    {3, 6, 7},
                    {0, 4, 2},
                    {2, 4, 6},
                    {1, 3, 5},
                    {3, 7, 5}};
  if (dent) mesh.vertices[7] = -0.2 * half_sizes;
  return mesh;
}

inline std::shared_ptr<const FingerShape> MeshShape(const TriangleMesh& mesh) {
  std::string error;
  auto shape = MakeMeshFinger(mesh, &error);
  EXPECT_NE(shape, nullptr) << error;
  return shape;
}

struct NamedShape {
  std::string name;
  std::shared_ptr<const FingerShape> shape;
};

inline void PrintTo(const NamedShape& shape, std::ostream* out) { *out << shape.name; }

// Every kind, about 1 in size.
inline std::vector<NamedShape> SampleShapes() {
  return {{"pin", MakePinFinger()},
          {"sphere", MakeSphereFinger(0.7)},
          {"capsule", MakeCapsuleFinger(0.4, 1.1)},
          {"box", MakeBoxFinger({0.5, 0.7, 0.9}, 0.0)},
          {"rounded_box", MakeBoxFinger({0.5, 0.7, 0.9}, 0.3)},
          {"ball_box", MakeBoxFinger({0.5, 0.5, 0.5}, 0.5)},
          {"plane", MakePlaneFinger()},
          {"mesh_sphere", MeshShape(SphereMesh(0.7, 1))},
          {"mesh_cuboid", MeshShape(CuboidMesh({0.5, 0.7, 0.9}))},
          {"mesh_dent", MeshShape(CuboidMesh({0.5, 0.7, 0.9}, true))}};
}

inline std::string ShapeName(const ::testing::TestParamInfo<NamedShape>& info) {
  return info.param.name;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_FINGER_UTIL_H_
