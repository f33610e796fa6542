#include "solver/tangent_stiffness.h"

#include <ceres/crs_matrix.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <memory>
#include <string>
#include <vector>

#include "tests/solve_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

// A curved shell with every kind of term: supports on sides and near a point, prescribed values.
const char kScene[] = R"(
name: patch
surface: {kind: torus, radii: [2, 0.7], u: [0.2, 1.1], v: [-0.5, 0.9], divisions: [4, 3]}
shell: {thickness: 0.05, young_modulus: 3.0e4, poisson_ratio: 0.3}
supports:
  - {on: u_min, clamped: true, displacement: [0.01, -0.02, 0.005]}
  - {on: {near: [1.5, 2, 0.5], radius: 0.2}, fix: [z]}
loads:
  - {kind: traction, force: [1, 2, -3]}
)";
const char kPlate[] = R"(
name: plate
surface: {kind: plane, u: [0, 2], v: [0, 1], divisions: [5, 4]}
shell: {thickness: 0.05, young_modulus: 3.0e4, poisson_ratio: 0.3}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: traction, force: FORCE}
)";

struct Case {
  std::string name;
  std::string text;
  bool nonlinear;
  Strains strains;
  BoundaryRule rule;
};

class TangentStiffnessTest : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    Scene scene = SceneFromText(GetParam().text);
    scene.model.strains = GetParam().strains;
    scene.model.boundary_rule = GetParam().rule;
    ShellProblem::Options options;
    options.nonlinear = GetParam().nonlinear;
    options.tension_rows = false;
    std::string error;
    problem_ = ShellProblem::Create(scene, options, &error);
    ASSERT_NE(problem_, nullptr) << error;
    // Some state of the unknowns, with multipliers.
    tangent_ = std::make_unique<TangentStiffness>(problem_.get(), SparseBackend::kAuto, 2);
    problem_->displacements() = tangent_->Expand(SeededUniform(tangent_->num_unknowns(), 0.02, 77));
    problem_->SetLoadFactor(0.7);
    std::vector<double> multipliers = problem_->multipliers();
    const Eigen::VectorXd values = SeededUniform(static_cast<int>(multipliers.size()), 3.0, 5);
    for (size_t i = 0; i < multipliers.size(); ++i) {
      if (problem_->conditions()[i].stiffness != 0.0) multipliers[i] = values[i];
    }
    problem_->SetMultipliers(multipliers);
  }

  Eigen::VectorXd Gradient() {
    Eigen::VectorXd gradient;
    TangentStiffness::Request request;
    request.gradient = &gradient;
    EXPECT_TRUE(tangent_->Evaluate(request));
    return gradient;
  }

  // J^T J of Ceres' problem in the tangent's unknowns.
  Eigen::MatrixXd NormalMatrix() {
    ceres::CRSMatrix j;
    EXPECT_TRUE(problem_->problem()->Evaluate({}, nullptr, nullptr, nullptr, &j));
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(j.num_rows, j.num_cols);
    for (int row = 0; row < j.num_rows; ++row) {
      for (int k = j.rows[row]; k < j.rows[row + 1]; ++k) dense(row, j.cols[k]) += j.values[k];
    }
    // Ceres' columns: free vertices in the order they were added.
    const int n = tangent_->num_unknowns();
    const int components = static_cast<int>(problem_->unknown_basis().cols());
    Eigen::MatrixXd to_ceres = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      const Eigen::Matrix3Xd field = tangent_->Expand(Eigen::VectorXd::Unit(n, i));
      int column = 0;
      for (int v = 0; v < field.cols(); ++v) {
        if (!problem_->IsFree(v)) continue;
        to_ceres.block(column, i, components, 1) =
            problem_->unknown_basis().transpose() * field.col(v);
        column += components;
      }
    }
    return to_ceres.transpose() * dense.transpose() * dense * to_ceres;
  }

  Eigen::MatrixXd Matrix() const {
    const Eigen::MatrixXd lower = tangent_->matrix();
    return lower.selfadjointView<Eigen::Lower>();
  }

  std::unique_ptr<ShellProblem> problem_;
  std::unique_ptr<TangentStiffness> tangent_;
};

TEST_P(TangentStiffnessTest, EnergyAndGradientAreThoseOfCeres) {
  double energy;
  TangentStiffness::Request request;
  request.energy = &energy;
  ASSERT_TRUE(tangent_->Evaluate(request));
  double expected = 0.0;
  for (int e = 0; e < kNumEffects; ++e) expected += problem_->Energy(static_cast<Effect>(e));
  EXPECT_NEAR(energy * problem_->force_unit(), expected, 1e-12 * std::abs(expected));
  const Eigen::VectorXd gradient = tangent_->Reduce(problem_->Gradient()) / problem_->force_unit();
  EXPECT_LE((Gradient() - gradient).norm(), 1e-12 * gradient.norm());
}

TEST_P(TangentStiffnessTest, MatrixWithoutStressIsTheNormalMatrix) {
  TangentStiffness::Request request;
  request.matrix = true;
  ASSERT_TRUE(tangent_->Evaluate(request));
  const Eigen::MatrixXd expected = NormalMatrix();
  EXPECT_LE((Matrix() - expected).norm(), 1e-12 * expected.norm());
}

TEST_P(TangentStiffnessTest, MatrixWithTheStressIsTheDerivativeOfTheGradient) {
  TangentStiffness::StressField stresses;
  TangentStiffness::Request request;
  request.stresses = &stresses;
  ASSERT_TRUE(tangent_->Evaluate(request));
  request.stresses = nullptr;
  request.matrix = true;
  request.initial_stresses = &stresses;
  ASSERT_TRUE(tangent_->Evaluate(request));
  const Eigen::Matrix3Xd state = problem_->displacements();
  const Eigen::MatrixXd matrix = Matrix();
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Eigen::VectorXd direction = SeededUniform(tangent_->num_unknowns(), 1.0, seed);
    const auto gradient = [&](double step) {
      problem_->displacements() = state + tangent_->Expand(step * direction);
      const Eigen::VectorXd result = Gradient();
      problem_->displacements() = state;
      return result;
    };
    constexpr double kStep = 1e-4;
    const Eigen::VectorXd wide = (gradient(2.0 * kStep) - gradient(-2.0 * kStep)) / (4.0 * kStep);
    const Eigen::VectorXd narrow = (gradient(kStep) - gradient(-kStep)) / (2.0 * kStep);
    const Eigen::VectorXd expected = (4.0 * narrow - wide) / 3.0;
    EXPECT_LE((matrix * direction - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST_P(TangentStiffnessTest, LinearisedStressesAreThoseOfALinearChange) {
  // To the second order of the change.
  const Eigen::VectorXd step = SeededUniform(tangent_->num_unknowns(), 1e-6, 3);
  TangentStiffness::StressField linearised, before, after;
  tangent_->LinearisedStresses(step, &linearised);
  TangentStiffness::Request request;
  request.stresses = &before;
  ASSERT_TRUE(tangent_->Evaluate(request));
  problem_->displacements() += tangent_->Expand(step);
  request.stresses = &after;
  ASSERT_TRUE(tangent_->Evaluate(request));
  double off = 0.0, change = 0.0;
  for (size_t i = 0; i < after.size(); ++i) {
    off += (after[i] - linearised[i]).squaredNorm();
    change += (after[i] - before[i]).squaredNorm();
  }
  EXPECT_LE(std::sqrt(off), 1e-3 * std::sqrt(change));
}

// The defect at every point from the stresses of three states, its forces by virtual work with
// strains differenced along each unknown.
TEST_P(TangentStiffnessTest, StrainDefectDoesTheWorkOfWhatAStraightStepLeaves) {
  const Eigen::VectorXd step = SeededUniform(tangent_->num_unknowns(), 0.02, 3);
  const Eigen::Matrix3Xd state = problem_->displacements();
  const auto stresses_at = [&](const Eigen::VectorXd& change) {
    TangentStiffness::StressField stresses;
    TangentStiffness::Request request;
    request.stresses = &stresses;
    problem_->displacements() = state + tangent_->Expand(change);
    EXPECT_TRUE(tangent_->Evaluate(request));
    problem_->displacements() = state;
    return stresses;
  };
  TangentStiffness::StressField linearised;
  tangent_->LinearisedStresses(step, &linearised);
  const TangentStiffness::StressField moved = stresses_at(step);

  // Stress = area C strain; compliance of the plane stress matrix and its bending multiple.
  const Material& material = problem_->scaled_material();
  const double nu = material.poisson_ratio;
  Eigen::Matrix3d c;
  c << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  const Eigen::Matrix3d inverse = c.inverse();
  Eigen::VectorXd expected(tangent_->num_unknowns());
  constexpr double kStep = 1e-4;
  for (int i = 0; i < expected.size(); ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(expected.size(), i);
    const auto up = stresses_at(kStep * unit), down = stresses_at(-kStep * unit);
    expected[i] = 0.0;
    int index = 0;
    for (const StrainPoints& points : problem_->strain_points()) {
      for (const StrainPoint& point : *points) {
        const TangentStiffness::Stress rate = (up[index] - down[index]) / (2.0 * kStep);
        const TangentStiffness::Stress defect = moved[index] - linearised[index];
        expected[i] += rate.head<3>().dot(inverse * defect.head<3>()) /
                           (point.area * material.MembraneStiffness()) +
                       rate.tail<3>().dot(inverse * defect.tail<3>()) /
                           (point.area * material.BendingStiffness());
        ++index;
      }
    }
  }
  Eigen::VectorXd forces;
  ASSERT_TRUE(tangent_->StrainDefect(step, &forces));
  if (IsLinear(problem_->measure())) {
    TangentStiffness::Request request;
    request.matrix = true;
    ASSERT_TRUE(tangent_->Evaluate(request));
    const Eigen::VectorXd straight = Matrix() * step;
    EXPECT_LE(forces.norm(), 1e-12 * straight.norm());
  } else {
    EXPECT_LE((forces - expected).norm(), 1e-5 * expected.norm());
  }
}

TEST_P(TangentStiffnessTest, BackendsSolveAndCountAlike) {
  TangentStiffness::Request request;
  request.matrix = true;
  ASSERT_TRUE(tangent_->Evaluate(request));
  Eigen::SparseMatrix<double> matrix = tangent_->matrix();
  const Eigen::VectorXd b = SeededUniform(tangent_->num_unknowns(), 1.0, 9);
  const Eigen::VectorXd expected = Matrix().ldlt().solve(b);
  const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Matrix()).eigenvalues();
  const int middle = static_cast<int>(eigenvalues.size()) / 2;
  const double shift = 0.5 * (eigenvalues[middle] + eigenvalues[middle + 1]);
  for (const SparseBackend backend : {SparseBackend::kSuiteSparse, SparseBackend::kEigen}) {
    const auto cholesky = SparseCholesky::Create(backend);
    cholesky->Analyze(matrix);
    ASSERT_TRUE(cholesky->Factorize(matrix));
    EXPECT_LE((cholesky->Solve(b) - expected).norm(), 1e-7 * expected.norm());
    EXPECT_EQ(cholesky->FactorizeIndefinite(matrix), 0);
    EXPECT_LE((cholesky->Solve(b) - expected).norm(), 1e-7 * expected.norm());
    Eigen::SparseMatrix<double> shifted = matrix;
    for (int i = 0; i < shifted.cols(); ++i) shifted.coeffRef(i, i) -= shift;
    EXPECT_FALSE(cholesky->Factorize(shifted));
    ASSERT_EQ(cholesky->FactorizeIndefinite(shifted), middle + 1);
    const Eigen::VectorXd x = cholesky->Solve(b);
    EXPECT_LE((shifted.selfadjointView<Eigen::Lower>() * x - b).norm(), 1e-8 * b.norm());
    ASSERT_TRUE(cholesky->Factorize(matrix));  // Serves on.
    EXPECT_LE((cholesky->Solve(b) - expected).norm(), 1e-7 * expected.norm());
  }
}

std::string With(const std::string& force) {
  std::string text = kPlate;
  return text.replace(text.find("FORCE"), 5, force);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    TangentStiffnessTest,
    ::testing::Values(
        Case{"LinearKoiter", kScene, false, Strains::kKoiter, BoundaryRule::kIndependent},
        Case{"Koiter", kScene, true, Strains::kKoiter, BoundaryRule::kIndependent},
        Case{"Seed", kScene, true, Strains::kSeed, BoundaryRule::kIndependent},
        Case{"SeedGhosts", kScene, true, Strains::kKoiter, BoundaryRule::kSeedGhosts},
        Case{"PlateNormalOnly",
             With("[0, 0, 1]"),
             false,
             Strains::kKoiter,
             BoundaryRule::kIndependent},
        Case{"PlateInPlaneOnly",
             With("[1, 0, 0]"),
             false,
             Strains::kKoiter,
             BoundaryRule::kIndependent}),
    [](const auto& info) { return info.param.name; });

// Threads share the work, not the answer.
TEST(TangentStiffnessThreadsTest, ThreadsAgree) {
  Scene scene = SceneFromText(kScene);
  scene.surface.divisions = {24, 24};
  std::string error;
  ShellProblem::Options options;
  options.nonlinear = true;
  const auto problem = ShellProblem::Create(scene, options, &error);
  ASSERT_NE(problem, nullptr) << error;
  TangentStiffness one(problem.get(), SparseBackend::kAuto, 1);
  TangentStiffness four(problem.get(), SparseBackend::kAuto, 4);
  problem->displacements() = one.Expand(SeededUniform(one.num_unknowns(), 0.01, 2));
  Eigen::VectorXd a, b;
  TangentStiffness::Request request;
  request.matrix = true;
  request.gradient = &a;
  ASSERT_TRUE(one.Evaluate(request));
  request.gradient = &b;
  ASSERT_TRUE(four.Evaluate(request));
  EXPECT_LE((a - b).norm(), 1e-13 * a.norm());
  EXPECT_LE((one.matrix() - four.matrix()).norm(), 1e-14 * one.matrix().norm());
}

}  // namespace
}  // namespace darboux
