#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "solver/sparse_cholesky.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

constexpr int kSize = 30;

// A band matrix with a few entries far from the diagonal and eigenvalues around `shift`, about
// within 4 of it; always the same pattern.
Eigen::MatrixXd Base(double shift, unsigned seed) {
  const Eigen::VectorXd x = SeededUniform(4 * kSize, 1.0, seed);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(kSize, kSize);
  for (int i = 0; i < kSize; ++i) {
    a(i, i) = shift + x[i];
    if (i + 1 < kSize) a(i + 1, i) = a(i, i + 1) = x[kSize + i];
    if (i + 2 < kSize) a(i + 2, i) = a(i, i + 2) = 0.5 * x[2 * kSize + i];
    if (i % 7 == 0 && i + 11 < kSize) a(i + 11, i) = a(i, i + 11) = 0.5 * x[3 * kSize + i];
  }
  return a;
}

Eigen::SparseMatrix<double> Lower(const Eigen::MatrixXd& a) {
  Eigen::SparseMatrix<double> lower =
      Eigen::MatrixXd(a.triangularView<Eigen::Lower>()).sparseView();
  lower.makeCompressed();
  return lower;
}

Eigen::MatrixXd Vectors(int count, unsigned seed) {
  return Eigen::Map<const Eigen::MatrixXd>(
      SeededUniform(kSize * count, 1.0, seed).data(), kSize, count);
}

Eigen::MatrixXd Sum(const Eigen::MatrixXd& a, const Eigen::MatrixXd& u, const Eigen::VectorXd& d) {
  return a + u * d.asDiagonal() * u.transpose();
}

int NegativeEigenvalues(const Eigen::MatrixXd& a) {
  return static_cast<int>(
      (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a).eigenvalues().array() < 0.0).count());
}

class UpdatedCholeskyTest : public ::testing::TestWithParam<SparseBackend> {
 protected:
  UpdatedCholeskyTest() : updated_(SparseCholesky::Create(GetParam())) {
    updated_.Analyze(Lower(Base(1.0, 1)));
  }

  // Whether both kinds of solves with the last factor are those of dense algebra.
  void ExpectSolves(const Eigen::MatrixXd& sum) {
    const Eigen::MatrixXd b = Vectors(3, 900);
    const Eigen::MatrixXd expected = sum.fullPivLu().solve(b);
    EXPECT_LT((updated_.SolveMany(b) - expected).norm(), 1e-10 * expected.norm());
    EXPECT_LT((updated_.Solve(b.col(0)) - expected.col(0)).norm(), 1e-10 * expected.col(0).norm());
  }

  UpdatedCholesky updated_;
};

TEST_P(UpdatedCholeskyTest, WithoutAnUpdateIsItsBase) {
  const auto base = SparseCholesky::Create(GetParam());
  const Eigen::SparseMatrix<double> definite = Lower(Base(8.0, 2)), indefinite = Lower(Base(0, 3));
  base->Analyze(definite);
  const Eigen::MatrixXd b = Vectors(2, 901);
  for (const bool set : {false, true}) {
    if (set) updated_.SetUpdate(Eigen::MatrixXd(kSize, 0), Eigen::VectorXd(0));
    EXPECT_TRUE(base->Factorize(definite));
    EXPECT_TRUE(updated_.Factorize(definite));
    EXPECT_EQ(updated_.SolveMany(b), base->SolveMany(b));
    EXPECT_FALSE(updated_.Factorize(indefinite));
    EXPECT_EQ(updated_.FactorizeIndefinite(indefinite), base->FactorizeIndefinite(indefinite));
    EXPECT_EQ(updated_.SolveMany(b), base->SolveMany(b));
  }
}

TEST_P(UpdatedCholeskyTest, SolvesWithTheSum) {
  const Eigen::MatrixXd a = Base(8.0, 4), u = Vectors(3, 5);
  // The last: vectors of length about 3 lower eigenvalues of about 8 to about 7.
  for (const Eigen::Vector3d& d : {Eigen::Vector3d(1.0, 0.2, 50.0),
                                   Eigen::Vector3d(1e6, 1e-6, 1.0),
                                   Eigen::Vector3d(3.0, -0.1, 0.5),
                                   Eigen::Vector3d(-0.1, -0.1, -0.1)}) {
    updated_.SetUpdate(u, d);
    const Eigen::MatrixXd sum = Sum(a, u, d);
    ASSERT_EQ(NegativeEigenvalues(sum), 0) << d.transpose();
    ASSERT_TRUE(updated_.Factorize(Lower(a))) << d.transpose();
    ExpectSolves(sum);
    ASSERT_EQ(updated_.FactorizeIndefinite(Lower(a)), 0) << d.transpose();
    ExpectSolves(sum);
  }
}

TEST_P(UpdatedCholeskyTest, CountsNegativeEigenvaluesOfTheSum) {
  std::mt19937 gen(38402);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  int seen[2] = {};
  for (unsigned seed = 10; seed < 60; ++seed) {
    const Eigen::MatrixXd a = Base(2.0 * uniform(gen), seed), u = Vectors(4, seed + 500);
    const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(4, [&] { return uniform(gen); });
    updated_.SetUpdate(u, d);
    const Eigen::MatrixXd sum = Sum(a, u, d);
    const int expected = NegativeEigenvalues(sum);
    ASSERT_EQ(updated_.FactorizeIndefinite(Lower(a)), expected) << "seed " << seed;
    ExpectSolves(sum);
    const int change = expected - NegativeEigenvalues(a);
    if (change < 0) ++seen[0];
    if (change > 0) ++seen[1];
  }
  EXPECT_GE(seen[0], 10);  // Updates that add stiffness where there was none,
  EXPECT_GE(seen[1], 10);  // and those that take it away.
}

TEST_P(UpdatedCholeskyTest, FactorizeWantsBothDefinite) {
  const Eigen::MatrixXd a = Base(8.0, 6), u = Vectors(2, 7);
  updated_.SetUpdate(u, Eigen::Vector2d(1.0, -5.0));
  ASSERT_EQ(NegativeEigenvalues(Sum(a, u, Eigen::Vector2d(1.0, -5.0))), 1);
  EXPECT_FALSE(updated_.Factorize(Lower(a)));
  EXPECT_EQ(updated_.FactorizeIndefinite(Lower(a)), 1);
  ExpectSolves(Sum(a, u, Eigen::Vector2d(1.0, -5.0)));

  // The base with one negative eigenvalue, which the update lifts along its eigenvector.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(a);
  const Eigen::MatrixXd below = a - 0.5 * (eigen.eigenvalues()[0] + eigen.eigenvalues()[1]) *
                                        Eigen::MatrixXd::Identity(kSize, kSize);
  const Eigen::VectorXd lift = Eigen::VectorXd::Constant(1, 10.0);
  ASSERT_EQ(NegativeEigenvalues(below), 1);
  updated_.SetUpdate(eigen.eigenvectors().leftCols(1), lift);
  EXPECT_FALSE(updated_.Factorize(Lower(below)));
  EXPECT_EQ(updated_.FactorizeIndefinite(Lower(below)), 0);
  ExpectSolves(Sum(below, eigen.eigenvectors().leftCols(1), lift));
}

// What pins are for: a matrix that is singular as it stands, held by springs that the update takes
// away, and held on the average instead.
TEST_P(UpdatedCholeskyTest, SpringsThatAreTakenAwayAgainLeaveNoTrace) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kSize);
  // A chain of springs: its null vector is `ones`.
  Eigen::MatrixXd chain = 0.0 * Base(1.0, 1);
  for (int i = 0; i + 1 < kSize; ++i) {
    chain(i, i) += 1.0;
    chain(i + 1, i + 1) += 1.0;
    chain(i + 1, i) = chain(i, i + 1) = -1.0;
  }
  Eigen::MatrixXd pinned = chain;
  constexpr int kPin = 3;
  constexpr double kStiffness = 5.0;
  pinned(kPin, kPin) += kStiffness;
  updated_.Analyze(Lower(pinned));
  Eigen::MatrixXd u(kSize, 2);
  u << Eigen::VectorXd::Unit(kSize, kPin), ones / kSize;
  const Eigen::Vector2d d(-kStiffness, 100.0);
  updated_.SetUpdate(u, d);
  ASSERT_TRUE(updated_.Factorize(Lower(pinned)));
  // A load in balance: the mean vanishes and nothing but the chain bears it.
  Eigen::VectorXd load = SeededUniform(kSize, 1.0, 8);
  load.array() -= load.mean();
  const Eigen::VectorXd x = updated_.Solve(load);
  EXPECT_NEAR(x.mean(), 0.0, 1e-12 * x.norm());
  EXPECT_LT((chain * x - load).norm(), 1e-11 * load.norm());

  // Without the mean nothing holds it.
  updated_.SetUpdate(u.leftCols(1), d.head(1));
  EXPECT_FALSE(updated_.Factorize(Lower(pinned)));
  EXPECT_EQ(updated_.FactorizeIndefinite(Lower(pinned)), -1);
}

// d = -1 / (u^T A^-1 u) makes A + d u u^T singular, alone and beside updates of any size.
TEST_P(UpdatedCholeskyTest, ReportsSingularSums) {
  for (unsigned seed = 20; seed < 30; ++seed) {
    const Eigen::MatrixXd a = Base(8.0, seed), u = Vectors(2, seed + 100);
    const Eigen::Matrix2d g = u.transpose() * a.llt().solve(u);
    for (const double other : {0.0, 1e-6, 1.0, 1e6}) {
      const double critical =
          -1.0 / (other == 0.0 ? g(0, 0) : g(0, 0) - g(0, 1) * g(0, 1) / (1.0 / other + g(1, 1)));
      const int count = other == 0.0 ? 1 : 2;
      updated_.SetUpdate(u.leftCols(count), Eigen::Vector2d(critical, other).head(count));
      EXPECT_EQ(updated_.FactorizeIndefinite(Lower(a)), -1) << seed << ", beside " << other;
      EXPECT_FALSE(updated_.Factorize(Lower(a))) << seed << ", beside " << other;
      // A little beside it on either side.
      for (const double factor : {1.0 - 1e-6, 1.0 + 1e-6}) {
        updated_.SetUpdate(u.leftCols(count),
                           Eigen::Vector2d(factor * critical, other).head(count));
        EXPECT_EQ(updated_.FactorizeIndefinite(Lower(a)), factor > 1.0 ? 1 : 0)
            << seed << ", beside " << other;
      }
    }
  }
}

// One symbolic analysis for all values, and any update after any other.
TEST_P(UpdatedCholeskyTest, FactorisationsFollowOneAnother) {
  for (unsigned seed = 40; seed < 46; ++seed) {
    const int count = seed % 3;
    const Eigen::MatrixXd a = Base(9.0, seed), u = Vectors(count, seed);
    const Eigen::VectorXd d = Eigen::VectorXd::Constant(count, seed % 2 == 0 ? 2.0 : -0.02);
    updated_.SetUpdate(u, d);
    ASSERT_TRUE(updated_.Factorize(Lower(a)));
    ExpectSolves(Sum(a, u, d));
    ASSERT_EQ(updated_.FactorizeIndefinite(Lower(a - 9.0 * Eigen::MatrixXd::Identity(30, 30))),
              NegativeEigenvalues(Sum(a - 9.0 * Eigen::MatrixXd::Identity(30, 30), u, d)));
    ExpectSolves(Sum(a - 9.0 * Eigen::MatrixXd::Identity(30, 30), u, d));
  }
}

INSTANTIATE_TEST_SUITE_P(Backends,
                         UpdatedCholeskyTest,
                         ::testing::Values(SparseBackend::kEigen, SparseBackend::kSuiteSparse),
                         [](const auto& info) {
                           return std::string(info.param == SparseBackend::kEigen ? "Eigen"
                                                                                  : "SuiteSparse");
                         });

}  // namespace
}  // namespace darboux
