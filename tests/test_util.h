#ifndef DARBOUX_TESTS_TEST_UTIL_H_
#define DARBOUX_TESTS_TEST_UTIL_H_

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "costs/cross_matrix.h"
#include "costs/material.h"
#include "costs/potential.h"
#include "costs/strain_energy.h"
#include "costs/strain_measures.h"
#include "geometry/control_mesh.h"
#include "geometry/loop_basis.h"
#include "geometry/parameter_domain.h"
#include "geometry/parametric_surface.h"
#include "geometry/quadrature.h"
#include "geometry/shell_surface.h"
#include "geometry/strain_point.h"

// What the tests of the costs share. Lengths of the sample patches are in metres, about 1.
namespace darboux {

// ---------------------------------------------------------------------------------------------
// Numbers

inline Eigen::VectorXd SeededUniform(int n, double size, unsigned seed = 38401) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd x(n);
  for (int i = 0; i < n; ++i) x[i] = size * uniform(generator);
  return x;
}

inline Eigen::Matrix3d SeededMatrix(double size, unsigned seed) {
  return Eigen::Map<const Eigen::Matrix3d>(SeededUniform(9, size, seed).data());
}

// About a skew axis: one axis of the coordinates hides exchanged terms.
inline Eigen::Matrix3d SkewRotation(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1.0, 2.0, 3.0).normalized())
      .toRotationMatrix();
}

inline const std::vector<StrainMeasure>& AllMeasures() {
  static const auto* const measures = new std::vector<StrainMeasure>{StrainMeasure::kLinearKoiter,
                                                                     StrainMeasure::kLinearSeed,
                                                                     StrainMeasure::kKoiter,
                                                                     StrainMeasure::kNonlinearSeed};
  return *measures;
}

inline std::string Name(StrainMeasure measure) {
  switch (measure) {
    case StrainMeasure::kLinearKoiter:
      return "linear_koiter";
    case StrainMeasure::kLinearSeed:
      return "linear_seed";
    case StrainMeasure::kKoiter:
      return "koiter";
    case StrainMeasure::kNonlinearSeed:
      return "nonlinear_seed";
  }
  return "unknown";
}

// Rubber by default: nu = 1/2 is the end of the range.
inline Material SampleMaterial(double poisson_ratio = 0.5) {
  Material material;
  material.thickness = 0.02;
  material.young_modulus = 1e6;
  material.poisson_ratio = poisson_ratio;
  return material;
}

// B / 2 e^T C e of (58), per area, for strain (e11, e22, 2 e12): written out, not factored.
inline double EnergyDensity(double stiffness, double poisson_ratio, const Eigen::Vector3d& e) {
  return 0.5 * stiffness *
         (e[0] * e[0] + e[1] * e[1] + 2.0 * poisson_ratio * e[0] * e[1] +
          0.5 * (1.0 - poisson_ratio) * e[2] * e[2]);
}

// A strain (e11, e22, 2 e12) in the frame that is turned by `angle` from its own.
inline Eigen::Vector3d TurnedStrain(const Eigen::Vector3d& e, double angle) {
  Eigen::Matrix2d tensor;
  tensor << e[0], 0.5 * e[2], 0.5 * e[2], e[1];
  const Eigen::Matrix2d turned = Eigen::Rotation2Dd(-angle).toRotationMatrix() * tensor *
                                 Eigen::Rotation2Dd(angle).toRotationMatrix();
  return {turned(0, 0), turned(1, 1), 2.0 * turned(0, 1)};
}

// ---------------------------------------------------------------------------------------------
// Points with given fifteen numbers

using Fifteen = Eigen::Matrix<double, 15, 1>;

// A point whose five control vertices ARE the kinematic vectors d_1, d_2, H_11, H_12, H_22: any
// cost over it takes exact kinematics, without a basis in between.
inline StrainPoint WithDirectInputs(const StrainPoint& point) {
  BasisMatrix weights = BasisMatrix::Zero(6, 5);
  for (int k = 0; k < 5; ++k) weights(kRowD1 + k, k) = 1.0;
  StrainPoint result = point;
  result.weights.swap(weights);
  return result;
}

// Frame and curvatures of a surface point, with direct inputs and area 1.
inline StrainPoint DirectPoint(const SurfaceJet& jet, double turn = 0.0) {
  StrainPoint point = MakeStrainPoint({jet.x, jet.x_u, jet.x_v, jet.x_uu, jet.x_uv, jet.x_vv},
                                      BasisMatrix::Zero(6, 5),
                                      {std::cos(turn), std::sin(turn)},
                                      1.0);
  point.area = 1.0;
  return WithDirectInputs(point);
}

// Arbitrary frame and b_ij of size 1: neither principal nor aligned with anything.
inline StrainPoint RandomPoint(unsigned seed) {
  const Eigen::Matrix3d q = SeededMatrix(1.0, seed).householderQr().householderQ();
  const Eigen::Vector3d b = SeededUniform(3, 1.0, seed + 1000);
  StrainPoint point;
  point.t1 = q.col(0);
  point.t2 = q.col(1);
  point.n = q.col(0).cross(q.col(1));
  point.b11 = b[0];
  point.b12 = b[1];
  point.b22 = b[2];
  point.area = 1.0;
  return WithDirectInputs(point);
}

// The flat point of the plane z = 0.
inline StrainPoint PlanePoint() {
  StrainPoint point;
  point.area = 1.0;
  return WithDirectInputs(point);
}

// The fifteen numbers of delta(x) = A x + c: d_i = A t_i, and the covariant Hessian of the position
// is b_ij n, so H_ij = b_ij A n.
inline Fifteen AffineInputs(const StrainPoint& point, const Eigen::Matrix3d& a) {
  const Eigen::Vector3d an = a * point.n;
  Fifteen k;
  k << a * point.t1, a * point.t2, point.b11 * an, point.b12 * an, point.b22 * an;
  return k;
}

inline Fifteen RotationInputs(const StrainPoint& point, double angle_rad) {
  return AffineInputs(point, SkewRotation(angle_rad) - Eigen::Matrix3d::Identity());
}

inline Eigen::Vector3d MembraneStrain(StrainMeasure measure,
                                      const StrainPoint& point,
                                      const Fifteen& k) {
  Eigen::Vector3d e;
  EvaluateMembraneStrain(measure, point, k.data(), e.data());
  return e;
}

inline Eigen::Vector3d BendingStrain(StrainMeasure measure,
                                     const StrainPoint& point,
                                     const Fifteen& k) {
  Eigen::Vector3d e;
  EXPECT_TRUE(EvaluateBendingStrain(measure, point, k.data(), e.data()));
  return e;
}

// ---------------------------------------------------------------------------------------------
// Evaluation of one cost

// Residuals and Jacobian of a cost; of a Potential its energy and gradient, through a
// ceres::Problem with the block's own loss.
struct Evaluation {
  bool ok = false;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
};

inline int NumParameters(const ceres::CostFunction& cost) {
  int n = 0;
  for (const int size : cost.parameter_block_sizes()) n += size;
  return n;
}

inline Evaluation EvaluateAt(const ceres::CostFunction& cost,
                             const Eigen::VectorXd& x,
                             bool with_jacobian = true) {
  EXPECT_EQ(x.size(), NumParameters(cost));
  Eigen::VectorXd storage = x;
  std::vector<double*> blocks;
  int offset = 0;
  for (const int size : cost.parameter_block_sizes()) {
    blocks.push_back(storage.data() + offset);
    offset += size;
  }
  Evaluation result;
  if (dynamic_cast<const Potential*>(&cost) != nullptr) {
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    Potential::AddTo(
        &problem,
        const_cast<Potential*>(static_cast<const Potential*>(&cost)),  // NOLINT: Ceres wants it so
        blocks);
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = blocks;
    double energy = 0.0;
    std::vector<double> gradient;
    result.ok =
        problem.Evaluate(evaluate, &energy, nullptr, with_jacobian ? &gradient : nullptr, nullptr);
    result.residuals = Eigen::VectorXd::Constant(1, energy);
    if (result.ok && with_jacobian) {
      result.jacobian = Eigen::Map<const Eigen::RowVectorXd>(gradient.data(), gradient.size());
    }
    return result;
  }
  const int rows = cost.num_residuals();
  result.residuals.resize(rows);
  if (!with_jacobian) {
    result.ok = cost.Evaluate(blocks.data(), result.residuals.data(), nullptr);
    return result;
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  // NaN marks what the cost forgets to write.
  std::vector<std::vector<double>> jacobians;
  std::vector<double*> pointers;
  for (const int size : cost.parameter_block_sizes()) {
    jacobians.emplace_back(rows * size, std::numeric_limits<double>::quiet_NaN());
  }
  for (auto& jacobian : jacobians) pointers.push_back(jacobian.data());
  result.ok = cost.Evaluate(blocks.data(), result.residuals.data(), pointers.data());
  result.jacobian.resize(rows, x.size());
  offset = 0;
  for (size_t i = 0; i < jacobians.size(); ++i) {
    const int size = cost.parameter_block_sizes()[i];
    result.jacobian.middleCols(offset, size) = Eigen::Map<const RowMajor>(pointers[i], rows, size);
    offset += size;
  }
  return result;
}

// 1/2 |r|^2, or the energy of a Potential. J
inline double Energy(const ceres::CostFunction& cost, const Eigen::VectorXd& x) {
  const Evaluation e = EvaluateAt(cost, x, false);
  EXPECT_TRUE(e.ok);
  return dynamic_cast<const Potential*>(&cost) != nullptr ? e.residuals[0]
                                                          : 0.5 * e.residuals.squaredNorm();
}

inline Eigen::VectorXd Gradient(const ceres::CostFunction& cost, const Eigen::VectorXd& x) {
  const Evaluation e = EvaluateAt(cost, x);
  EXPECT_TRUE(e.ok);
  if (dynamic_cast<const Potential*>(&cost) != nullptr) return e.jacobian.transpose();
  return e.jacobian.transpose() * e.residuals;
}

// Column `column` of the Jacobian by Ridders' extrapolated central differences, componentwise
// with an estimate of the error: of the tableau, or of rounding if that is larger. Starts from
// several step sizes and keeps for each component the derivative that it trusts most.
inline void RiddersColumn(const ceres::CostFunction& cost,
                          const Eigen::VectorXd& x,
                          int column,
                          Eigen::VectorXd* derivative,
                          Eigen::VectorXd* error) {
  constexpr int kLevels = 7;
  constexpr double kShrink = 1.7;
  const int rows = dynamic_cast<const Potential*>(&cost) != nullptr ? 1 : cost.num_residuals();
  derivative->setConstant(rows, std::numeric_limits<double>::quiet_NaN());
  error->setConstant(rows, std::numeric_limits<double>::infinity());
  const double size = std::max(1.0, x.cwiseAbs().maxCoeff());
  for (const double start : {0.3 * size, 0.03 * size, 3e-3 * size}) {
    std::vector<Eigen::VectorXd> previous;
    double step = start;
    for (int level = 0; level < kLevels; ++level, step /= kShrink) {
      Eigen::VectorXd forward = x, backward = x;
      forward[column] += step;
      backward[column] -= step;
      const Evaluation f = EvaluateAt(cost, forward, false);
      const Evaluation b = EvaluateAt(cost, backward, false);
      if (!f.ok || !b.ok) break;
      const Eigen::VectorXd rounding = 4.0 * std::numeric_limits<double>::epsilon() / step *
                                       (f.residuals.cwiseAbs() + b.residuals.cwiseAbs());
      std::vector<Eigen::VectorXd> current = {(f.residuals - b.residuals) /
                                              (forward[column] - backward[column])};
      double factor = 1.0;
      for (int k = 1; k <= level; ++k) {
        factor *= kShrink * kShrink;
        current.push_back((factor * current[k - 1] - previous[k - 1]) / (factor - 1.0));
        for (int row = 0; row < rows; ++row) {
          const double estimate = std::max({std::abs(current[k][row] - current[k - 1][row]),
                                            std::abs(current[k][row] - previous[k - 1][row]),
                                            rounding[row]});
          if (estimate < (*error)[row]) {
            (*error)[row] = estimate;
            (*derivative)[row] = current[k][row];
          }
        }
      }
      previous = std::move(current);
    }
  }
}

// Empty where the Jacobian (of a Potential: the gradient) is right. Entries may be off by
// `tolerance` times the largest of their row; differences that cannot tell count as wrong.
inline std::string JacobianMistake(const ceres::CostFunction& cost,
                                   const Eigen::VectorXd& x,
                                   double tolerance) {
  const Evaluation e = EvaluateAt(cost, x);
  if (!e.ok) return "which cannot be evaluated";
  if (!e.jacobian.allFinite()) return "whose Jacobian is not finite";
  Eigen::MatrixXd derivative(e.jacobian.rows(), e.jacobian.cols()), error = derivative;
  for (int column = 0; column < x.size(); ++column) {
    Eigen::VectorXd d, estimate;
    RiddersColumn(cost, x, column, &d, &estimate);
    derivative.col(column) = d;
    error.col(column) = estimate;
  }
  const double largest = e.jacobian.cwiseAbs().maxCoeff();
  for (int row = 0; row < e.jacobian.rows(); ++row) {
    const double scale = std::max({e.jacobian.row(row).cwiseAbs().maxCoeff(),
                                   derivative.row(row).cwiseAbs().maxCoeff(),
                                   1e-6 * largest});
    for (int column = 0; column < x.size(); ++column) {
      const double difference = std::abs(e.jacobian(row, column) - derivative(row, column));
      const std::string entry = ::testing::PrintToString(std::make_pair(row, column));
      if (!(error(row, column) <= tolerance * scale)) {
        return "whose differences at " + entry + " are only good to " +
               ::testing::PrintToString(error(row, column) / scale);
      }
      if (!(difference <= tolerance * scale)) {
        return "whose Jacobian at " + entry + " is " +
               ::testing::PrintToString(e.jacobian(row, column)) + " and not " +
               ::testing::PrintToString(derivative(row, column));
      }
    }
  }
  return "";
}

// For (smart) pointers to a ceres::CostFunction.
MATCHER_P2(HasCorrectJacobianAt, x, tolerance, "has the Jacobian of its residuals") {
  const std::string mistake = JacobianMistake(*arg, x, tolerance);
  *result_listener << mistake;
  return mistake.empty();
}

// ---------------------------------------------------------------------------------------------
// Patches

// A named piece of a surface.
struct Patch {
  std::string name;
  std::shared_ptr<const ParametricSurface> surface;
  ParameterDomain::Options domain;
};

inline void PrintTo(const Patch& patch, std::ostream* out) { *out << patch.name; }

inline Patch MakePatch(const std::string& name,
                       std::shared_ptr<const ParametricSurface> surface,
                       const std::array<double, 2>& u_range,
                       const std::array<double, 2>& v_range,
                       const std::array<int, 2>& divisions = {2, 2}) {
  Patch patch{name, std::move(surface), {}};
  patch.domain.u_range = u_range;
  patch.domain.v_range = v_range;
  patch.domain.divisions = divisions;
  return patch;
}

// Two by two cells, about 1 m wide.
inline Patch TorusPatch() {
  return MakePatch("torus", MakeTorus(2.0, 0.8), {0.3, 0.8}, {0.4, 1.4});
}
inline Patch CylinderPatch() {
  return MakePatch("cylinder", MakeCylinder(0.9), {0.0, 1.0}, {-0.3, 0.8});
}
inline Patch SpherePatch() { return MakePatch("sphere", MakeSphere(1.2), {0.2, 1.1}, {-0.3, 0.6}); }
inline Patch EllipsoidPatch() {
  return MakePatch("ellipsoid", MakeEllipsoid(2.0, 1.5, 0.7), {0.2, 0.9}, {0.1, 0.8});
}
// Has the flat umbilic, the origin, inside.
inline Patch MonkeySaddlePatch() {
  return MakePatch("monkey_saddle", MakeMonkeySaddle(0.3), {-0.4, 0.7}, {-0.5, 0.6});
}
inline Patch PlanePatch() { return MakePatch("plane", MakePlane(), {0.0, 1.2}, {0.0, 0.9}); }

inline std::vector<Patch> SamplePatches() {
  return {TorusPatch(),
          CylinderPatch(),
          SpherePatch(),
          EllipsoidPatch(),
          MonkeySaddlePatch(),
          PlanePatch()};
}

// For INSTANTIATE_TEST_SUITE_P over patches.
inline std::string PatchName(const ::testing::TestParamInfo<Patch>& info) {
  return info.param.name;
}

// Points where the kernels are tried: three of each sample patch, in turned frames, and random.
inline std::vector<StrainPoint> SamplePoints() {
  std::vector<StrainPoint> points;
  for (const Patch& patch : SamplePatches()) {
    for (const double f : {0.1, 0.45, 0.8}) {
      const auto& u = patch.domain.u_range;
      const auto& v = patch.domain.v_range;
      points.push_back(DirectPoint(
          patch.surface->Evaluate(u[0] + f * (u[1] - u[0]), v[1] - f * (v[1] - v[0])), 5.0 * f));
    }
  }
  for (unsigned seed = 0; seed < 10; ++seed) points.push_back(RandomPoint(seed));
  return points;
}

// Product Gauss rule of 6 x 6 points on the triangle, exact to degree 10: the volume under a
// regular Loop element, where triangle rules of the solver are not.
inline const std::vector<TrianglePoint>& ExactTriangleRule() {
  static const auto* const rule = [] {
    constexpr int kPoints = 6;
    Eigen::MatrixXd legendre = Eigen::MatrixXd::Zero(kPoints, kPoints);  // Golub and Welsch
    for (int i = 1; i < kPoints; ++i) {
      legendre(i, i - 1) = legendre(i - 1, i) = i / std::sqrt(4.0 * i * i - 1.0);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(legendre);
    auto* points = new std::vector<TrianglePoint>;
    for (int i = 0; i < kPoints; ++i) {
      for (int j = 0; j < kPoints; ++j) {
        const double a = 0.5 * (1.0 + solver.eigenvalues()[i]);
        const double b = 0.5 * (1.0 + solver.eigenvalues()[j]);
        const double weight = std::pow(solver.eigenvectors()(0, i), 2) *
                              std::pow(solver.eigenvectors()(0, j), 2) * (1.0 - a);
        points->push_back({a, b * (1.0 - a), weight});
      }
    }
    return points;
  }();
  return *rule;
}

// A shell whose rest surface lies in the Loop space itself, sigma = sum N_i X_i: the control
// displacements A X_i + c are exactly the displacement A sigma + c, rigid motions among them.
struct LoopPatch {
  ControlMesh mesh;
  std::shared_ptr<const LoopBasis> basis;
  Eigen::Matrix3Xd positions;  // X_i

  // Keep the result in a variable: `for (... : *patch.Points(e))` runs over freed memory.
  // `turn`: how t1 is turned away from the element's first axis (an angle of the parameters).
  StrainPoints Points(int element,
                      const std::vector<TrianglePoint>& rule,
                      double turn = 0.0) const {
    const std::vector<int>& vertices = basis->control_vertices(element);
    auto points = std::make_shared<std::vector<StrainPoint>>();
    for (const TrianglePoint& p : rule) {
      const BasisMatrix b = basis->Evaluate(element, p.s, p.t);
      Eigen::Matrix<double, 3, 6> jet = Eigen::Matrix<double, 3, 6>::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        jet += positions.col(vertices[i]) * b.col(i).transpose();
      }
      points->push_back(
          MakeStrainPoint({jet.col(0), jet.col(1), jet.col(2), jet.col(3), jet.col(4), jet.col(5)},
                          b,
                          {std::cos(turn), std::sin(turn)},
                          p.weight));
    }
    return points;
  }
  StrainPoints Points(int element, int num_points = 3, double turn = 0.0) const {
    return Points(element, TriangleQuadrature(num_points), turn);
  }

  // Parameters of a block on the element, from one displacement per control vertex.
  Eigen::VectorXd Parameters(int element, const Eigen::Matrix3Xd& displacements) const {
    const std::vector<int>& vertices = basis->control_vertices(element);
    Eigen::VectorXd x(3 * vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
      x.segment<3>(3 * i) = displacements.col(vertices[i]);
    }
    return x;
  }

  // Displacement A X + c of all control vertices.
  Eigen::Matrix3Xd Affine(const Eigen::Matrix3d& a,
                          const Eigen::Vector3d& c = Eigen::Vector3d::Zero()) const {
    return (a * positions).colwise() + c;
  }
  Eigen::Matrix3Xd RigidMotion(double angle_rad) const {
    return Affine(SkewRotation(angle_rad) - Eigen::Matrix3d::Identity(), {0.1, -0.2, 0.3});
  }
  // Components in [-size, size], from one seed.
  Eigen::Matrix3Xd RandomField(double size) const {
    const Eigen::VectorXd x = SeededUniform(static_cast<int>(positions.size()), size);
    return Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, positions.cols());
  }

  double Area(int num_points = 3) const {
    double area = 0.0;
    for (int e = 0; e < mesh.num_elements; ++e) {
      const StrainPoints points = Points(e, num_points);
      for (const StrainPoint& point : *points) area += point.area;
    }
    return area;
  }
};

// Energy of all elements of a patch; Cost is MembraneEnergy or BendingEnergy.
template <typename Cost>
double PatchEnergy(const LoopPatch& patch,
                   StrainMeasure measure,
                   const Material& material,
                   const Eigen::Matrix3Xd& displacements,
                   double turn = 0.0) {
  double energy = 0.0;
  for (int e = 0; e < patch.mesh.num_elements; ++e) {
    const Cost cost(patch.Points(e, 3, turn), measure, material);
    energy += Energy(cost, patch.Parameters(e, displacements));
  }
  return energy;
}

// Control vertices on the surface, at the parameters of the lattice and one cell beyond.
inline LoopPatch MakeLoopPatch(const Patch& patch) {
  const ParameterDomain domain(patch.domain);
  LoopPatch result;
  result.mesh = domain.mesh();
  result.basis = std::make_shared<LoopBasis>(result.mesh);
  result.positions = Eigen::Matrix3Xd::Zero(3, result.mesh.num_vertices);
  const auto& options = domain.options();
  const int first[2] = {options.periodic[0] ? 0 : -1, options.periodic[1] ? 0 : -1};
  const int last[2] = {options.divisions[0] + (options.periodic[0] ? -1 : 1),
                       options.divisions[1] + (options.periodic[1] ? -1 : 1)};
  for (int j = first[1]; j <= last[1]; ++j) {
    for (int i = first[0]; i <= last[0]; ++i) {
      const int vertex = domain.VertexIndex(i, j);
      if (vertex < 0) continue;
      result.positions.col(vertex) =
          patch.surface->Evaluate(domain.Parameter(0, i)[0], domain.Parameter(1, j)[0]).x;
    }
  }
  return result;
}

inline LoopPatch MakeClosedTorus(double major_radius, double minor_radius, int m, int n) {
  Patch patch = MakePatch("closed_torus",
                          MakeTorus(major_radius, minor_radius),
                          {0.0, 2.0 * M_PI},
                          {0.0, 2.0 * M_PI},
                          {m, n});
  patch.domain.periodic = {true, true};
  return MakeLoopPatch(patch);
}

// An icosahedron, split `splits` times, with control vertices on the sphere: twelve vertices of
// valence five.
inline LoopPatch MakeIcosphere(double radius, int splits) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Eigen::Vector3d> x = {{-1, g, 0},
                                    {1, g, 0},
                                    {-1, -g, 0},
                                    {1, -g, 0},
                                    {0, -1, g},
                                    {0, 1, g},
                                    {0, -1, -g},
                                    {0, 1, -g},
                                    {g, 0, -1},
                                    {g, 0, 1},
                                    {-g, 0, -1},
                                    {-g, 0, 1}};
  std::vector<std::array<int, 3>> triangles = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto inserted = middles.emplace(std::minmax(a, b), static_cast<int>(x.size()));
      if (inserted.second) x.push_back(0.5 * (x[a] + x[b]));
      return inserted.first->second;
    };
    std::vector<std::array<int, 3>> fine;
    for (const auto& t : triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      fine.push_back({t[0], a, c});
      fine.push_back({t[1], b, a});
      fine.push_back({t[2], c, b});
      fine.push_back({a, b, c});
    }
    triangles = std::move(fine);
  }
  LoopPatch result;
  result.mesh.num_vertices = static_cast<int>(x.size());
  result.mesh.num_elements = static_cast<int>(triangles.size());
  result.mesh.triangles = std::move(triangles);
  result.basis = std::make_shared<LoopBasis>(result.mesh);
  result.positions.resize(3, x.size());
  for (size_t i = 0; i < x.size(); ++i) result.positions.col(i) = radius * x[i].normalized();
  return result;
}

// ---------------------------------------------------------------------------------------------
// Displacement fields on exact surfaces

// Control displacements whose limit values fit the field, a function of the rest position, in the
// least-squares sense over twelve points of every element: exact where the field is in the space.
inline Eigen::Matrix3Xd FitField(
    const ShellSurface& surface,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& field) {
  const int rows = 12 * surface.num_elements();
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(rows, surface.mesh().num_vertices);
  Eigen::MatrixXd targets(rows, 3);
  int row = 0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const std::vector<int>& vertices = surface.control_vertices(e);
    for (const StrainPoint& point : surface.QuadraturePoints(e, 12)) {
      for (size_t i = 0; i < vertices.size(); ++i) {
        values(row, vertices[i]) = point.weights(kRowValue, i);
      }
      targets.row(row++) = field(point.position).transpose();
    }
  }
  return values.colPivHouseholderQr().solve(targets).transpose();
}

// The rigid motion about a skew axis; not in the space on a curved surface.
inline Eigen::Matrix3Xd FitRigidMotion(const ShellSurface& surface, double angle_rad) {
  const Eigen::Matrix3d r = SkewRotation(angle_rad) - Eigen::Matrix3d::Identity();
  return FitField(surface, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return r * x + Eigen::Vector3d(0.1, -0.2, 0.3);
  });
}

// The fifteen numbers of a field of control displacements at a point of an element.
inline Fifteen InputsAt(const StrainPoint& point,
                        const std::vector<int>& vertices,
                        const Eigen::Matrix3Xd& displacements) {
  Eigen::Matrix<double, 3, 5> k = Eigen::Matrix<double, 3, 5>::Zero();
  for (size_t i = 0; i < vertices.size(); ++i) {
    k += displacements.col(vertices[i]) * point.weights.col(i).tail<5>().transpose();
  }
  return Eigen::Map<const Fifteen>(k.data());
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_TEST_UTIL_H_
