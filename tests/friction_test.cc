#include "costs/friction.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "costs/support.h"
#include "tests/finger_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd ForceAt(const Friction& cost, const VectorXd& x, MatrixXd* stiffness = nullptr) {
  Matrix3Xd force;
  EXPECT_TRUE(cost.Linearise(Blocks(cost, x).data(), &force, stiffness));
  return Eigen::Map<const VectorXd>(force.data(), force.size());
}

std::vector<FrictionState> StatesAt(const Friction& cost, const VectorXd& x) {
  return cost.States(Blocks(cost, x).data());
}

double SmoothedLength(double s, double e) {
  return s < e ? s * s / e - s * s * s / (3.0 * e * e) : s - e / 3.0;
}

VectorXd Difference(const std::function<VectorXd(double)>& f, double step) {
  return (8.0 * (f(step) - f(-step)) - f(2.0 * step) + f(-2.0 * step)) / (12.0 * step);
}

// An element with six points, each with its own normal, normal force and anchor; one is out of
// contact. Parameter: the size of the displacements over the stick length 1e-2 m.
class FrictionTest : public ::testing::TestWithParam<double> {
 protected:
  FrictionTest() {
    finger_.shape = MakeSphereFinger(1.0);
    finger_.pose = SkewPose();
    finger_.direction = Vector3d(2.0, -1.0, 2.0) / 3.0;
    finger_.friction = 0.6;
    finger_.stick_length = 1e-2;
    for (int q = 0; q < 6; ++q) {
      FrictionPoint& point = state_[q];
      point.normal_force = q == 3 ? 0.0 : 1.0 + q;
      point.normal = SeededUniform(3, 1.0, 70 + q).normalized();
      point.anchor = points_->positions.col(q) - finger_.pose.position;
    }
  }
  VectorXd X(int n, unsigned seed) const {
    return SeededUniform(n, GetParam() * finger_.stick_length, seed);
  }
  Vector3d PointDisplacement(int q, const VectorXd& x) const {
    Vector3d u = Vector3d::Zero();
    for (int i = 0; i < 12; ++i) u += points_->weights(q, i) * x.segment<3>(3 * i);
    return u;
  }

  const LoopPatch patch_ = MakeLoopPatch(TorusPatch());
  const std::shared_ptr<const ContactPoints> points_ =
      std::make_shared<const ContactPoints>(ContactPoints::From(*patch_.Points(0, 6)));
  ContactFinger finger_;
  std::vector<FrictionPoint> state_ = std::vector<FrictionPoint>(6);
  const std::unique_ptr<Friction> cost_ =
      std::make_unique<Friction>(points_, &finger_, state_.data(), false);
  const std::unique_ptr<Friction> driven_ =
      std::make_unique<Friction>(points_, &finger_, state_.data(), true);
};

TEST_P(FrictionTest, EnergyIsThatOfTheSmoothedSlip) {
  const VectorXd x = X(36, 1);
  double expected = 0.0;
  for (int q = 0; q < 6; ++q) {
    const Vector3d u = PointDisplacement(q, x), n = state_[q].normal;
    expected += finger_.friction * state_[q].normal_force *
                SmoothedLength((u - n.dot(u) * n).norm(), finger_.stick_length);
  }
  EXPECT_NEAR(Energy(*cost_, x), expected, 3e-8 * expected);  // x - anchor cancels
}

TEST_P(FrictionTest, ForceIsMinusCeresGradient) {
  const VectorXd x = X(36, 2);
  const VectorXd gradient = Gradient(*cost_, x);
  EXPECT_LE((ForceAt(*cost_, x) + gradient).norm(), 1e-12 * gradient.norm());
}

TEST_P(FrictionTest, JacobianMatchesRiddersDifferences) {
  // r has kinks in its second derivatives, at no slip and where sliding begins: differences are
  // less sure there.
  const double tolerance = GetParam() < 0.1 ? 5e-3 : 1e-4;
  EXPECT_THAT(cost_, HasCorrectJacobianAt(X(36, 2), tolerance));
  EXPECT_THAT(driven_, HasCorrectJacobianAt(X(37, 2), tolerance));
}

TEST_P(FrictionTest, StiffnessIsTheDerivativeOfTheForce) {
  const VectorXd x = X(36, 2);
  MatrixXd stiffness, expected(36, 36);
  ForceAt(*cost_, x, &stiffness);
  for (int j = 0; j < 36; ++j) {
    expected.col(j) = -Difference(
        [&](double s) -> VectorXd { return ForceAt(*cost_, x + s * VectorXd::Unit(36, j)); },
        1e-8 * (1.0 + GetParam()));
  }
  EXPECT_LE((stiffness - expected).norm(), 1e-4 * expected.norm());
  EXPECT_LE((stiffness - stiffness.transpose()).norm(), 1e-14 * stiffness.norm());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(stiffness);
  EXPECT_GE(modes.eigenvalues().minCoeff(), -1e-14 * modes.eigenvalues().maxCoeff());
}

TEST_P(FrictionTest, DerivativesByTheTravel) {
  const double t = 0.3 * GetParam() * finger_.stick_length;
  VectorXd x(37);
  x << X(36, 2), t;
  TravelDerivatives by_travel;
  ASSERT_TRUE(driven_->LineariseTravel(Blocks(*driven_, x).data(), &by_travel));
  const VectorXd gradient = Gradient(*driven_, x);
  EXPECT_NEAR(by_travel.energy, gradient[36], 1e-11 * gradient.norm());
  const double step = 1e-8 * (1.0 + GetParam());
  const VectorXd by_t = Difference(
      [&](double s) -> VectorXd { return ForceAt(*driven_, x + s * VectorXd::Unit(37, 36)); },
      step);
  EXPECT_LE((Eigen::Map<const VectorXd>(by_travel.force.data(), 36) - by_t).norm(),
            1e-4 * by_t.norm());
  const VectorXd second = Difference(
      [&](double s) -> VectorXd {
        return Gradient(*driven_, x + s * VectorXd::Unit(37, 36)).tail<1>();
      },
      step);
  EXPECT_NEAR(by_travel.stiffness, second[0], 1e-4 * std::abs(second[0]));
}

TEST_P(FrictionTest, ForceOpposesSlipAndStaysInTheCone) {
  const VectorXd x = X(36, 3);
  const std::vector<FrictionState> states = StatesAt(*cost_, x);
  Vector3d on_finger = Vector3d::Zero();
  for (int q = 0; q < 6; ++q) {
    const double limit = finger_.friction * state_[q].normal_force;
    const Vector3d on_shell = -states[q].force_on_finger;
    on_finger += states[q].force_on_finger;
    EXPECT_LE(on_shell.norm(), limit * (1.0 + 1e-14));
    EXPECT_NEAR(on_shell.dot(state_[q].normal), 0.0, 1e-14 * limit);
    EXPECT_NEAR(on_shell.dot(states[q].slip),
                -on_shell.norm() * states[q].slip.norm(),
                1e-14 * limit * states[q].slip.norm());
    EXPECT_EQ(states[q].sticks, states[q].slip.norm() < finger_.stick_length);
    if (!states[q].sticks) {
      EXPECT_NEAR(on_shell.norm(), limit, 1e-14 * limit);
    }
  }
  const VectorXd force = ForceAt(*cost_, x);
  const Vector3d sum = Eigen::Map<const Matrix3Xd>(force.data(), 3, 12).rowwise().sum();
  EXPECT_LE((sum + on_finger).norm(), 1e-13 * on_finger.norm());
}

TEST_P(FrictionTest, FingerAndShellTogetherDoNotSlip) {
  const VectorXd x = X(36, 4);
  const double energy = Energy(*cost_, x);
  const Vector3d c = SeededUniform(3, 3.0, 9);
  finger_.translation = c;
  VectorXd moved = x;
  for (int i = 0; i < 12; ++i) moved.segment<3>(3 * i) += c;
  EXPECT_NEAR(Energy(*cost_, moved), energy, 1e-7 * energy);
  // And the finger alone slips.
  if (GetParam() < 10.0) {
    EXPECT_GT(Energy(*cost_, x), energy);
  }
}

INSTANTIATE_TEST_SUITE_P(SizeOverStickLength,
                         FrictionTest,
                         ::testing::Values(1e-5, 0.2, 1.0, 5.0, 1e2, 1e4));

// ---------------------------------------------------------------------------------------------

// One point that is its own control vertex, at the origin, on a finger with normal z.
class FrictionOfAPointTest : public ::testing::Test {
 protected:
  static std::shared_ptr<const ContactPoints> Point() {
    ContactPoints points;
    points.positions = Vector3d::Zero();
    points.areas = VectorXd::Ones(1);
    points.weights = MatrixXd::Ones(1, 1);
    return std::make_shared<const ContactPoints>(points);
  }
  FrictionOfAPointTest() {
    finger_.friction = 0.5;
    finger_.stick_length = 0.01;
    finger_.direction = Vector3d::UnitX();
    state_.normal_force = 4.0;
  }
  Vector3d Force(const Vector3d& u) const { return ForceAt(cost_, u); }

  ContactFinger finger_;
  FrictionPoint state_;
  const Friction cost_{Point(), &finger_, &state_, false};
};

TEST_F(FrictionOfAPointTest, NoSlipNoForceNoEnergy) {
  EXPECT_EQ(Energy(cost_, Vector3d::Zero()), 0.0);
  EXPECT_EQ(Energy(cost_, Vector3d(0.0, 0.0, 7.0)), 0.0);  // It leaves or sinks in: not friction.
  EXPECT_EQ(Force(Vector3d::Zero()).norm(), 0.0);
  MatrixXd stiffness;
  ForceAt(cost_, Vector3d::Zero(), &stiffness);
  const Matrix3d expected = 2.0 * 2.0 / 0.01 * Vector3d(1.0, 1.0, 0.0).asDiagonal();
  EXPECT_LE((stiffness - expected).norm(), 1e-12 * expected.norm());
}

TEST_F(FrictionOfAPointTest, NoNormalForceNoFriction) {
  state_.normal_force = 0.0;
  const Evaluation e = EvaluateAt(cost_, Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(e.residuals.norm(), 0.0);
  EXPECT_EQ(e.jacobian.norm(), 0.0);
  EXPECT_EQ(Force(Vector3d(1.0, 2.0, 3.0)).norm(), 0.0);
}

TEST_F(FrictionOfAPointTest, SlidingForceIsCoulombs) {
  EXPECT_LE((Force({3.0, -4.0, 1.0}) - Vector3d(-1.2, 1.6, 0.0)).norm(), 1e-14);
  EXPECT_NEAR(Energy(cost_, Vector3d(3.0, -4.0, 1.0)), 2.0 * (5.0 - 0.01 / 3.0), 1e-13);
  // Half way to the stick length it carries three quarters: f' = 2/2 - 1/4.
  EXPECT_LE((Force({0.0, 0.005, 0.0}) - Vector3d(0.0, -1.5, 0.0)).norm(), 1e-14);
}

TEST_F(FrictionOfAPointTest, EnergyIsC2WhereItBeginsToSlide) {
  const double e = finger_.stick_length, step = 1e-9 * e;
  const auto at = [&](double s) -> Vector3d { return {0.6 * s, 0.8 * s, 0.0}; };
  EXPECT_NEAR(Energy(cost_, at(e - step)), Energy(cost_, at(e + step)), 1e-8 * e);
  EXPECT_LE((Force(at(e - step)) - Force(at(e + step))).norm(), 1e-8);
  MatrixXd before, after;
  ForceAt(cost_, at(e - step), &before);
  ForceAt(cost_, at(e + step), &after);
  EXPECT_LE((before - after).norm(), 1e-7 * before.norm());
  const MatrixXd j = EvaluateAt(cost_, at(e - step)).jacobian;
  EXPECT_LE((j - EvaluateAt(cost_, at(e + step)).jacobian).norm(), 1e-7 * j.norm());
}

// The same energy as a robust loss on slip: Ceres' corrector leaves rho'' < 0 out of the Jacobian,
// and cost and gradient remain exact.
class SlipLoss : public ceres::LossFunction {
 public:
  SlipLoss(double limit, double e) : limit_(limit), e_(e) {}
  void Evaluate(double z, double rho[3]) const override {
    const double s = std::sqrt(z);
    rho[0] = 2.0 * limit_ * SmoothedLength(s, e_);
    rho[1] = s < e_ ? limit_ * (2.0 - s / e_) / e_ : limit_ / s;
    rho[2] = s < e_ ? -limit_ / (2.0 * s * e_ * e_) : -0.5 * limit_ / (s * z);
  }

 private:
  double limit_, e_;
};

TEST_F(FrictionOfAPointTest, IsARobustLossOnSlip) {
  for (const Vector3d& at : {Vector3d(1e-4, 2e-4, 0.0),
                             Vector3d(-4e-3, 3e-3, 0.2),
                             Vector3d(0.02, 0.01, 0.0),
                             Vector3d(3.0, -4.0, 1.0)}) {
    Vector3d u = at;
    double cost[2];
    std::vector<double> gradient[2];
    for (const bool as_loss : {false, true}) {
      ceres::Problem problem;
      if (as_loss) {
        std::vector<Support::Condition> slip(2);
        for (int i = 0; i < 2; ++i) {
          slip[i].coefficients = Vector3d::Unit(i);
          slip[i].stiffness = 1.0;
        }
        problem.AddResidualBlock(new Support(slip), new SlipLoss(2.0, 0.01), u.data());
      } else {
        problem.AddResidualBlock(
            new Friction(Point(), &finger_, &state_, false), nullptr, u.data());
      }
      ASSERT_TRUE(problem.Evaluate({}, &cost[as_loss], nullptr, &gradient[as_loss], nullptr));
    }
    EXPECT_NEAR(cost[1], cost[0], 1e-14 * cost[0]);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(gradient[1][i], gradient[0][i], 1e-13);
    const Vector3d force = Force(u);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(gradient[1][i], -force[i], 1e-13);
  }
}

TEST_F(FrictionOfAPointTest, WorkOfASlipIsLost) {
  // Around a closed loop of 2 pi, the anchor dragged along: friction takes mu N times the way.
  state_.anchor = Vector3d::Zero();
  double work = 0.0;
  Vector3d last = Vector3d::Zero();
  constexpr int kSteps = 2000;
  for (int step = 0; step <= kSteps; ++step) {
    const double angle = 2.0 * M_PI * step / kSteps;
    const Vector3d u(1.0 - std::cos(angle), std::sin(angle), 0.0);
    const Vector3d force = Force(u);
    work -= force.dot(u - last);
    EXPECT_GE(-force.dot(u - last), -1e-12);
    last = u;
    cost_.AdvanceAnchors(Blocks(cost_, u).data(), &state_);
  }
  EXPECT_NEAR(work, 2.0 * 2.0 * M_PI, 0.1);
}

TEST_F(FrictionOfAPointTest, AnchorsRememberStickAndFollowSlip) {
  const auto advance = [&](const Vector3d& u) {
    cost_.AdvanceAnchors(Blocks(cost_, u).data(), &state_);
  };
  // Sticking: the force is the same at the beginning of the next step.
  const Vector3d stick(0.003, -0.002, 0.1);
  const Vector3d force = Force(stick);
  advance(stick);
  EXPECT_LE((Force(stick) - force).norm(), 1e-13);
  // Sliding: so it is here, and the way back begins by sticking.
  const Vector3d slide(5.0, 0.0, 0.1);
  EXPECT_NEAR(Force(slide).norm(), 2.0, 1e-14);
  advance(slide);
  EXPECT_NEAR(Force(slide).x(), -2.0, 1e-9);
  EXPECT_FALSE(StatesAt(cost_, slide + Vector3d(0.1, 0, 0))[0].sticks);
  EXPECT_TRUE(StatesAt(cost_, slide - Vector3d(0.01, 0, 0))[0].sticks);
  EXPECT_NEAR(Force(slide - Vector3d(0.01, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(Force(slide - Vector3d(0.02, 0, 0)).x(), 2.0, 1e-9);
  // Out of contact it forgets.
  state_.normal_force = 0.0;
  advance(Vector3d(1.0, 2.0, 3.0));
  state_.normal_force = 4.0;
  EXPECT_EQ(Force({1.0, 2.0, 3.0}).norm(), 0.0);
}

TEST_F(FrictionOfAPointTest, TakesNormalForceAndNormalFromContact) {
  std::vector<ContactState> contact(1);
  contact[0].normal = Vector3d(0.6, 0.0, 0.8);
  contact[0].force_on_finger = -3.0 * contact[0].normal;
  LagFriction(contact, &state_);
  EXPECT_NEAR(state_.normal_force, 3.0, 1e-15);
  EXPECT_EQ(state_.normal, contact[0].normal);
  LagFriction({ContactState()}, &state_);
  EXPECT_EQ(state_.normal_force, 0.0);
  EXPECT_EQ(state_.normal, contact[0].normal);
}

// A block pulled by a spring K over a finger: it sticks until the spring carries mu N, then slides
// at mu N. Ceres alone minimises it.
TEST_F(FrictionOfAPointTest, SpringPullsABlockThatSticksAndThenSlides) {
  const double spring = 10.0, limit = 2.0;
  Vector3d u = Vector3d::Zero();
  double pull = 0.0;
  ceres::Problem problem;
  problem.AddResidualBlock(new Friction(Point(), &finger_, &state_, false), nullptr, u.data());
  std::vector<Support::Condition> springs(3);
  for (int i = 0; i < 3; ++i) {
    springs[i].coefficients = Vector3d::Unit(i);
    springs[i].stiffness = spring;
  }
  springs[0].target = &pull;
  problem.AddResidualBlock(new Support(springs), nullptr, u.data());
  ceres::Solver::Options options;
  options.function_tolerance = options.parameter_tolerance = 0.0;
  options.gradient_tolerance = 1e-11;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 500;
  options.logging_type = ceres::SILENT;
  for (const double end : {0.05, 0.1, 0.15, 0.19, 0.25, 0.5, 3.0}) {
    pull = end;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    ASSERT_EQ(summary.termination_type, ceres::CONVERGENCE) << summary.FullReport();
    const double force = spring * (pull - u.x());
    EXPECT_NEAR(-Force(u).x(), force, 1e-6);  // Ceres stops when the cost does.
    if (spring * (pull - finger_.stick_length) < limit) {
      EXPECT_TRUE(StatesAt(cost_, u)[0].sticks);
      EXPECT_LT(u.x(), finger_.stick_length);
      EXPECT_LT(force, limit);
    } else {
      EXPECT_FALSE(StatesAt(cost_, u)[0].sticks);
      EXPECT_NEAR(force, limit, 1e-6);
    }
    EXPECT_NEAR(u.tail<2>().norm(), 0.0, 1e-14);
    cost_.AdvanceAnchors(Blocks(cost_, u).data(), &state_);
    u.x() += 1e-4;  // Wherever the next solve begins, the anchor knows.
  }
}

}  // namespace
}  // namespace darboux
