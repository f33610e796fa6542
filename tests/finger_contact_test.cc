#include "costs/finger_contact.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "costs/load_work.h"
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

double ContactEnergy(const FingerContact& cost, const VectorXd& x) {
  double energy = 0.0;
  EXPECT_TRUE(cost.Energy(Blocks(cost, x).data(), &energy));
  return energy;
}

std::vector<ContactState> StatesAt(const FingerContact& cost, const VectorXd& x) {
  std::vector<ContactState> states;
  EXPECT_TRUE(cost.States(Blocks(cost, x).data(), &states));
  return states;
}

TravelDerivatives ByTravel(const FingerContact& cost, const VectorXd& x) {
  TravelDerivatives by_travel;
  EXPECT_TRUE(cost.LineariseTravel(Blocks(cost, x).data(), &by_travel));
  return by_travel;
}

VectorXd ForceAt(const FingerContact& cost, const VectorXd& x, MatrixXd* stiffness = nullptr) {
  Matrix3Xd force;
  EXPECT_TRUE(cost.Linearise(Blocks(cost, x).data(), &force, stiffness));
  return Eigen::Map<const VectorXd>(force.data(), force.size());
}

VectorXd WithTravel(const VectorXd& x, double travel) {
  VectorXd result(x.size() + 1);
  result << x, travel;
  return result;
}

// A fourth-order difference by `step` of a vector function of a number.
VectorXd Difference(const std::function<VectorXd(double)>& f, double step) {
  return (8.0 * (f(step) - f(-step)) - f(2.0 * step) + f(-2.0 * step)) / (12.0 * step);
}

// An element of a torus with six points, and a finger of each kind pressed into its outside.
class FingerContactTest : public ::testing::TestWithParam<NamedShape> {
 protected:
  FingerContactTest() {
    finger_.shape = GetParam().shape;
    finger_.offset = 0.3;  // thick, so that pins touch more than one point
    finger_.stiffness = 500.0;
    const ContactPoints& points = *points_;
    const StrainPoint& middle = (*strain_points_)[0];
    finger_.direction = -middle.n;
    const bool plane = GetParam().name == "plane";
    const Vector3d up = plane ? finger_.direction : middle.n;
    finger_.pose.rotation =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up).toRotationMatrix() *
        SkewRotation(plane ? 0.05 : 0.4);
    finger_.pose.position = middle.position + 3.0 * middle.n;
    std::vector<Vector3d> positions;
    for (int q = 0; q < points.size(); ++q) positions.push_back(points.positions.col(q));
    const Ball ball = finger_.shape->Bounds();
    if (std::isfinite(ball.radius)) {
      finger_.pose.position -= finger_.pose.rotation * ball.center;
    }
    double low = 0.0, high = 3.5;  // until four points of six overlap
    for (int i = 0; i < 60; ++i) {
      const double shift = 0.5 * (low + high);
      int inside = 0;
      for (const Vector3d& x : positions) {
        Distance d;
        finger_.PoseAt(shift).Evaluate(*finger_.shape, x, &d);
        if (d.value < finger_.offset) ++inside;
      }
      (inside >= 4 ? high : low) = shift;
    }
    pressed_ = high + 0.01;
    finger_.translation = pressed_ * finger_.direction;
    for (const bool with_travel : {false, true}) {
      costs_.push_back(
          std::make_unique<FingerContact>(points_, &finger_, multipliers_.data(), with_travel));
    }
  }

  const LoopPatch patch_ = MakeLoopPatch(TorusPatch());
  const StrainPoints strain_points_ = patch_.Points(0, 6);
  const std::shared_ptr<const ContactPoints> points_ =
      std::make_shared<const ContactPoints>(ContactPoints::From(*strain_points_));
  const std::vector<double> multipliers_ = {0.0, 3.0, 0.0, 0.5, 8.0, 0.0};
  ContactFinger finger_;
  double pressed_ = 0.0;
  std::vector<std::unique_ptr<FingerContact>> costs_;  // prescribed, driven by a force
  const VectorXd rest_ = VectorXd::Zero(36);
};

TEST_P(FingerContactTest, TouchesSomePointsOnly) {  // or the other tests show little
  int touching = 0;
  for (const ContactState& state : StatesAt(*costs_[0], rest_)) {
    if (state.pressure > 0.0) ++touching;
  }
  EXPECT_GE(touching, 3);
}

TEST_P(FingerContactTest, IsZeroWhenApart) {
  finger_.translation.setZero();
  finger_.pose.position -= 40.0 * finger_.direction;
  for (const double multiplier : {0.0, 5.0}) {
    const std::vector<double> multipliers(6, multiplier);
    const FingerContact cost(points_, &finger_, multipliers.data(), false);
    const Evaluation e = EvaluateAt(cost, rest_);
    EXPECT_EQ(e.residuals.norm(), 0.0);
    EXPECT_EQ(e.jacobian.norm(), 0.0);
    MatrixXd stiffness;
    EXPECT_EQ(ForceAt(cost, rest_, &stiffness).norm(), 0.0);
    EXPECT_EQ(stiffness.norm(), 0.0);
    for (const ContactState& state : StatesAt(cost, rest_)) {
      EXPECT_GT(state.gap, 0.0);
      EXPECT_EQ(state.pressure, 0.0);
      EXPECT_EQ(state.force_on_finger, Vector3d::Zero());
    }
  }
}

TEST_P(FingerContactTest, EnergyIsThatOfTheAugmentedLagrangian) {
  const VectorXd x = SeededUniform(36, 0.02);
  double expected = 0.0;
  for (int q = 0; q < 6; ++q) {
    Vector3d at = points_->positions.col(q);
    for (int i = 0; i < 12; ++i) at += points_->weights(q, i) * x.segment<3>(3 * i);
    Distance d;
    ASSERT_TRUE(finger_.PoseAt(0.0).Evaluate(*finger_.shape, at, &d));
    const double g = d.value - finger_.offset, lambda = multipliers_[q], k = finger_.stiffness;
    // Written in its usual form: -lambda g + k g^2 / 2 in contact, -lambda^2 / (2 k) apart.
    expected += points_->areas[q] * (lambda - k * g > 0.0 ? -lambda * g + 0.5 * k * g * g
                                                          : -lambda * lambda / (2.0 * k));
  }
  EXPECT_NEAR(ContactEnergy(*costs_[0], x), expected, 1e-12 * std::abs(expected));
  double constant = 0.0;
  for (int q = 0; q < 6; ++q) {
    constant += points_->areas[q] * multipliers_[q] * multipliers_[q] / (2.0 * finger_.stiffness);
  }
  EXPECT_NEAR(Energy(*costs_[0], x), expected + constant, 1e-12 * std::abs(expected));
}

TEST_P(FingerContactTest, ForceIsMinusCeresGradient) {
  for (const double size : {0.0, 1e-8, 1e-2, 0.3}) {
    const VectorXd x = SeededUniform(36, size, 5);
    const VectorXd gradient = Gradient(*costs_[0], x);
    EXPECT_LE((ForceAt(*costs_[0], x) + gradient).norm(), 1e-13 * gradient.norm());
    const VectorXd with_travel = Gradient(*costs_[1], WithTravel(x, 0.0));
    EXPECT_LE((with_travel.head(36) - gradient).norm(), 1e-13 * gradient.norm());
    EXPECT_NEAR(with_travel[36], ByTravel(*costs_[0], x).energy, 1e-13 * (1.0 + gradient.norm()));
  }
}

// Force, moment and the finger's reaction are one wrench.
TEST_P(FingerContactTest, FingerFeelsTheReaction) {
  const VectorXd x = SeededUniform(36, 0.02);
  const Eigen::Map<const Matrix3Xd> u(x.data(), 3, 12);
  const VectorXd f = ForceAt(*costs_[0], x);
  const Matrix3Xd force = Eigen::Map<const Matrix3Xd>(f.data(), 3, 12);
  Vector3d on_finger = Vector3d::Zero();
  double push = 0.0;
  for (const ContactState& state : StatesAt(*costs_[0], x)) {
    on_finger += state.force_on_finger;
    if (state.pressure > 0.0) {
      EXPECT_LT(state.force_on_finger.dot(state.normal), 0.0);
    }
    push += state.force_on_finger.dot(finger_.direction);
  }
  EXPECT_LE((force.rowwise().sum() + on_finger).norm(), 1e-13 * on_finger.norm());
  EXPECT_NEAR(ByTravel(*costs_[0], x).energy, -push, 1e-12 * std::abs(push));
  EXPECT_LT(push, 0.0);  // It is held back.
}

TEST_P(FingerContactTest, JacobianMatchesRiddersDifferences) {
  // Differences of a point at the verge of contact cannot tell; these are not there.
  for (const double size : {0.0, 1e-8, 1e-3, 1e-2}) {
    EXPECT_THAT(costs_[0], HasCorrectJacobianAt(SeededUniform(36, size, 2), 1e-6)) << size;
    EXPECT_THAT(costs_[1], HasCorrectJacobianAt(SeededUniform(37, size, 2), 1e-6)) << size;
  }
}

TEST_P(FingerContactTest, HugeDisplacementsAreFinite) {
  for (const double size : {1.0, 1e2, 1e8}) {
    const VectorXd x = SeededUniform(37, size, 3);
    const Evaluation e = EvaluateAt(*costs_[1], x);
    ASSERT_TRUE(e.ok);
    EXPECT_TRUE(e.residuals.allFinite());
    EXPECT_TRUE(e.jacobian.allFinite());
  }
}

TEST_P(FingerContactTest, StiffnessIsTheDerivativeOfTheForce) {
  for (const double size : {0.0, 1e-8, 1e-2}) {
    const VectorXd x = SeededUniform(36, size, 2);
    MatrixXd stiffness, expected(36, 36);
    ForceAt(*costs_[0], x, &stiffness);
    for (int j = 0; j < 36; ++j) {
      expected.col(j) = -Difference(
          [&](double s) -> VectorXd { return ForceAt(*costs_[0], x + s * VectorXd::Unit(36, j)); },
          1e-4);
    }
    EXPECT_LE((stiffness - expected).norm(), 1e-7 * expected.norm()) << size;
    EXPECT_LE((stiffness - stiffness.transpose()).norm(), 1e-14 * stiffness.norm());
  }
}

// Gauss-Newton's matrix is the stiffness but for the finger's curvature under pressure.
TEST_P(FingerContactTest, GaussNewtonLacksTheCurvatureOnly) {
  MatrixXd stiffness;
  const VectorXd x = SeededUniform(36, 1e-2, 2);
  ForceAt(*costs_[0], x, &stiffness);
  const MatrixXd j = EvaluateAt(*costs_[0], x).jacobian;
  const std::vector<ContactState> states = StatesAt(*costs_[0], x);
  MatrixXd lacking = MatrixXd::Zero(36, 36);
  for (int q = 0; q < 6; ++q) {
    Distance d;
    ASSERT_TRUE(finger_.PoseAt(0.0).Evaluate(*finger_.shape, states[q].position, &d));
    for (int a = 0; a < 12; ++a) {
      for (int b = 0; b < 12; ++b) {
        lacking.block<3, 3>(3 * a, 3 * b) += states[q].pressure * points_->areas[q] *
                                             points_->weights(q, a) * points_->weights(q, b) *
                                             d.hessian;
      }
    }
  }
  EXPECT_LE((stiffness - (j.transpose() * j - lacking)).norm(), 1e-12 * stiffness.norm());
}

TEST_P(FingerContactTest, DerivativesByTheTravel) {
  const VectorXd x = SeededUniform(36, 1e-2, 2);
  const TravelDerivatives by_travel = ByTravel(*costs_[1], WithTravel(x, 0.01));
  const auto energy = [&](double s) -> VectorXd {
    return VectorXd::Constant(1, ContactEnergy(*costs_[1], WithTravel(x, 0.01 + s)));
  };
  const auto slope = [&](double s) -> VectorXd {
    return VectorXd::Constant(1, ByTravel(*costs_[1], WithTravel(x, 0.01 + s)).energy);
  };
  const auto force = [&](double s) -> VectorXd {
    return ForceAt(*costs_[1], WithTravel(x, 0.01 + s));
  };
  EXPECT_NEAR(by_travel.energy, Difference(energy, 1e-4)[0], 1e-8 * by_travel.energy);
  EXPECT_NEAR(
      by_travel.stiffness, Difference(slope, 1e-4)[0], 1e-7 * std::abs(by_travel.stiffness));
  const VectorXd by_t = Eigen::Map<const VectorXd>(by_travel.force.data(), 36);
  EXPECT_LE((by_t - Difference(force, 1e-4)).norm(), 1e-7 * by_t.norm());
}

TEST_P(FingerContactTest, TravelIsTranslation) {
  const VectorXd x = SeededUniform(36, 1e-2, 2);
  const double driven = ContactEnergy(*costs_[1], WithTravel(x, 0.03));
  EXPECT_GT(std::abs(driven - ContactEnergy(*costs_[0], x)), 1e-3 * std::abs(driven));
  finger_.translation += 0.03 * finger_.direction;  // Read at every evaluation.
  EXPECT_NEAR(ContactEnergy(*costs_[0], x), driven, 1e-12 * std::abs(driven));
}

// Finger and shell move together: nothing changes but the frame.
TEST_P(FingerContactTest, RigidMotionOfBothChangesNothing) {
  const Eigen::Map<const Matrix3Xd> rest(patch_.positions.data(), 3, patch_.positions.cols());
  const Matrix3Xd bent = patch_.RandomField(1e-2);
  const VectorXd x = patch_.Parameters(0, bent);
  const std::vector<ContactState> before = StatesAt(*costs_[0], x);
  const double energy = ContactEnergy(*costs_[0], x);
  const Matrix3d r = SkewRotation(1.1);
  const Vector3d c(0.4, -0.7, 2.0);
  const Matrix3Xd moved = ((r * (rest + bent)).colwise() + c) - rest;
  finger_.pose.position = r * finger_.PoseAt(0.0).position + c;
  finger_.pose.rotation = r * finger_.pose.rotation;
  finger_.translation.setZero();
  const VectorXd y = patch_.Parameters(0, moved);
  EXPECT_NEAR(ContactEnergy(*costs_[0], y), energy, 1e-11 * std::abs(energy));
  const std::vector<ContactState> after = StatesAt(*costs_[0], y);
  for (int q = 0; q < 6; ++q) {
    EXPECT_NEAR(after[q].pressure, before[q].pressure, 1e-10 * finger_.stiffness);
    EXPECT_LE((after[q].force_on_finger - r * before[q].force_on_finger).norm(),
              1e-10 * (1.0 + before[q].force_on_finger.norm()));
  }
}

TEST_P(FingerContactTest, TranslationOfBothChangesNothing) {
  const double energy = ContactEnergy(*costs_[0], rest_);
  const Vector3d c(0.4, -0.7, 2.0);
  finger_.translation += c;
  EXPECT_NEAR(ContactEnergy(*costs_[0], patch_.Parameters(0, patch_.Affine(Matrix3d::Zero(), c))),
              energy,
              1e-12 * std::abs(energy));
}

// Energy and force go on through first touch; the stiffness jumps.
TEST_P(FingerContactTest, EnergyIsC1AcrossTouch) {
  const FingerContact cost(points_, &finger_, nullptr, false);
  std::vector<ContactState> states = StatesAt(cost, rest_);
  int q = 0;
  for (int i = 0; i < 6; ++i) {
    if (states[i].gap < states[q].gap) q = i;
  }
  // Alone, that point is at the verge of touching.
  auto alone = std::make_shared<ContactPoints>();
  alone->positions = points_->positions.col(q);
  alone->areas = points_->areas.segment(q, 1);
  alone->weights = points_->weights.row(q);
  const FingerContact single(alone, &finger_, nullptr, false);
  finger_.offset += states[q].gap;
  double last_energy = 1.0, last_force = 1.0;
  for (const double depth : {1e-2, 1e-3, 1e-4, 1e-5}) {
    VectorXd x(36);
    for (int i = 0; i < 12; ++i) x.segment<3>(3 * i) = -depth * states[q].normal;  // inwards
    const double energy = ContactEnergy(single, x), force = ForceAt(single, x).norm();
    const double expected = 0.5 * finger_.stiffness * alone->areas[0] * depth * depth;
    EXPECT_NEAR(energy, expected, 1e-8 * expected);
    EXPECT_LT(energy, 1.1e-2 * last_energy);
    EXPECT_LT(force, 0.11 * last_force);
    EXPECT_EQ(ContactEnergy(single, -x), 0.0);
    EXPECT_EQ(ForceAt(single, -x).norm(), 0.0);
    last_energy = energy * 1.0000001;
    last_force = force * 1.0000001;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, FingerContactTest, ::testing::ValuesIn(SampleShapes()), ShapeName);

// ---------------------------------------------------------------------------------------------

// One point that is its own control vertex, standing for the area A.
std::shared_ptr<const ContactPoints> SinglePoint(const Vector3d& position, double area) {
  ContactPoints points;
  points.positions = position;
  points.areas = VectorXd::Constant(1, area);
  points.weights = MatrixXd::Ones(1, 1);
  return std::make_shared<const ContactPoints>(points);
}

ContactFinger SphereAbove(double radius, double height, double offset, double stiffness) {
  ContactFinger finger;
  finger.shape = MakeSphereFinger(radius);
  finger.pose.position = Vector3d(0.0, 0.0, height);
  finger.offset = offset;
  finger.stiffness = stiffness;
  return finger;
}

void Solve(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.function_tolerance = options.parameter_tolerance = 0.0;
  options.gradient_tolerance = 1e-13;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.initial_trust_region_radius = 1e16;  // Undamped: small energies stall damped steps.
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
}

TEST(FingerContactClosedFormTest, PressureIsStiffnessTimesPenetration) {
  // The face, h/2 = 0.1 above the point, is 0.05 inside the sphere.
  const ContactFinger finger = SphereAbove(2.0, 2.05, 0.1, 40.0);
  const FingerContact cost(SinglePoint(Vector3d::Zero(), 3.0), &finger, nullptr, false);
  const ContactState state = StatesAt(cost, Vector3d::Zero())[0];
  EXPECT_NEAR(state.gap, -0.05, 1e-15);
  EXPECT_NEAR(state.pressure, 2.0, 1e-13);
  EXPECT_LE((state.force_on_finger - Vector3d(0, 0, 6.0)).norm(), 1e-12);
  EXPECT_NEAR(Energy(cost, Vector3d::Zero()), 0.5 * 40.0 * 3.0 * 0.05 * 0.05, 1e-13);
  // At the finger's other side and at its centre.
  EXPECT_GT(StatesAt(cost, Vector3d(0, 0, 4.0))[0].normal.z(), 0.999);
  EXPECT_FALSE(EvaluateAt(cost, Vector3d(0, 0, 2.05)).ok);
}

// A spring K against a finger: penetration falls by the factor K / (K + k A) with every update of
// the multiplier, to nothing, and the pressure becomes what the spring holds.
TEST(FingerContactClosedFormTest, MultiplierDrivesPenetrationToZero) {
  const double spring = 7.0, area = 2.0, depth = 0.03;
  for (const double k : {3.0, 30.0, 3e4}) {
    const ContactFinger finger = SphereAbove(1.0, 1.1 - depth, 0.1, k);
    double multiplier = 0.0;
    Vector3d u = Vector3d::Zero();
    auto* contact =
        new FingerContact(SinglePoint(Vector3d::Zero(), area), &finger, &multiplier, false);
    ceres::Problem problem;
    problem.AddResidualBlock(contact, nullptr, u.data());
    std::vector<Support::Condition> springs(3);
    for (int i = 0; i < 3; ++i) {
      springs[i].coefficients = Vector3d::Unit(i);
      springs[i].stiffness = spring;
    }
    problem.AddResidualBlock(new Support(springs), nullptr, u.data());
    double penetration = depth;
    for (int update = 0; update < 60; ++update) {
      Solve(&problem);
      const double* parameters[] = {u.data()};
      std::vector<ContactState> states;
      ASSERT_TRUE(contact->States(parameters, &states));
      const double expected = penetration * spring / (spring + k * area);
      ASSERT_NEAR(-states[0].gap, expected, 1e-8);  // Ceres stops when the cost does.
      penetration = expected;
      multiplier = states[0].pressure;
    }
    EXPECT_NEAR(u.z(), -depth, 1e-8);
    EXPECT_NEAR(multiplier * area, spring * depth, 1e-7);
    EXPECT_EQ(u.head<2>().norm(), 0.0);
  }
}

// And it lets go: a multiplier left over from a contact that is gone vanishes at once.
TEST(FingerContactClosedFormTest, MultiplierOfAnOpenGapVanishes) {
  const ContactFinger finger = SphereAbove(1.0, 1.5, 0.1, 100.0);
  double multiplier = 5.0;
  const FingerContact cost(SinglePoint(Vector3d::Zero(), 1.0), &finger, &multiplier, false);
  const ContactState state = StatesAt(cost, Vector3d::Zero())[0];
  EXPECT_EQ(state.pressure, 0.0);
  EXPECT_GT(state.gap, 0.0);
}

// Driven by a force the finger settles where the spring carries it.
TEST(FingerContactClosedFormTest, ForceDrivenFingerFindsItsTravel) {
  const double spring = 7.0, area = 2.0, k = 50.0, force = 0.9;
  const ContactFinger finger = SphereAbove(1.0, 1.1, 0.1, k);
  Vector3d u = Vector3d::Zero();
  double travel = 0.01;
  auto* contact = new FingerContact(SinglePoint(Vector3d::Zero(), area), &finger, nullptr, true);
  ceres::Problem problem;
  problem.AddResidualBlock(contact, nullptr, u.data(), &travel);
  FingerForce::AddTo(&problem, new FingerForce(&force, 1e6), {&travel});
  std::vector<Support::Condition> springs(3);
  for (int i = 0; i < 3; ++i) {
    springs[i].coefficients = Vector3d::Unit(i);
    springs[i].stiffness = spring;
  }
  problem.AddResidualBlock(new Support(springs), nullptr, u.data());
  Solve(&problem);
  EXPECT_NEAR(u.z(), -force / spring, 1e-9);
  EXPECT_NEAR(travel, force / spring + force / (k * area), 1e-9);
  const double* parameters[] = {u.data(), &travel};
  std::vector<ContactState> states;
  ASSERT_TRUE(contact->States(parameters, &states));
  EXPECT_NEAR(states[0].force_on_finger.z(), force, 1e-9);
}

TEST(FingerContactClosedFormTest, SkipsTheJacobiansThatNobodyAsksFor) {
  const ContactFinger finger = SphereAbove(1.0, 1.0, 0.1, 4.0);
  const FingerContact cost(SinglePoint(Vector3d::Zero(), 1.0), &finger, nullptr, true);
  const Vector3d u = Vector3d::Zero();
  const double travel = 0.0;
  const double* parameters[] = {u.data(), &travel};
  double residual, by_travel;
  double* jacobians[] = {nullptr, &by_travel};
  ASSERT_TRUE(cost.Evaluate(parameters, &residual, jacobians));
  EXPECT_NEAR(residual, 0.2, 1e-15);
  EXPECT_NEAR(by_travel, 2.0, 1e-15);
  jacobians[1] = nullptr;
  ASSERT_TRUE(cost.Evaluate(parameters, &residual, jacobians));
}

// Other units of length and force: other numbers, the same state.
TEST(FingerContactClosedFormTest, UnitsDoNotMatter) {
  const double metre = 1e3, newton = 1e-6;
  const ContactFinger si = SphereAbove(2.0, 2.05, 0.1, 40.0);
  const ContactFinger other =
      SphereAbove(2.0 * metre, 2.05 * metre, 0.1 * metre, 40.0 * newton / std::pow(metre, 3));
  const FingerContact a(SinglePoint(Vector3d::Zero(), 3.0), &si, nullptr, false);
  const FingerContact b(SinglePoint(Vector3d::Zero(), 3.0 * metre * metre), &other, nullptr, false);
  const Vector3d u(0.2, -0.1, 0.01);
  EXPECT_NEAR(Energy(b, metre * u) / (metre * newton), Energy(a, u), 1e-13 * Energy(a, u));
}

}  // namespace
}  // namespace darboux
