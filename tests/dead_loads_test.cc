#include "solver/dead_loads.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/scene_util.h"

namespace darboux {
namespace {

LoadSpec Load(LoadSpec::Kind kind) {
  LoadSpec load;
  load.kind = kind;
  return load;
}

LoadSpec Pressure(const std::string& value, bool follower = true) {
  LoadSpec load = Load(LoadSpec::Kind::kPressure);
  load.value = Value(value);
  load.follower = follower;
  return load;
}

LoadSpec NormalTraction(const std::string& value) {
  LoadSpec load = Load(LoadSpec::Kind::kNormalTraction);
  load.value = Value(value);
  return load;
}

LoadSpec Traction(const SceneVector& force) {
  LoadSpec load = Load(LoadSpec::Kind::kTraction);
  load.force = force;
  return load;
}

LoadSpec Edge(Region::Kind on, const SceneVector& force, const SceneVector& moment = {}) {
  LoadSpec load = Load(LoadSpec::Kind::kEdge);
  load.on.kind = on;
  load.force = force;
  load.moment = moment;
  return load;
}

LoadSpec Line(int parameter, double value, const SceneVector& force) {
  LoadSpec load = Load(LoadSpec::Kind::kLine);
  load.line_parameter = parameter;
  load.line_value = value;
  load.force = force;
  return load;
}

// Of the quarter cylinder.
constexpr double kLength = 2.0, kRadius = 0.7, kHalfPi = 0.5 * M_PI;

std::unique_ptr<ShellSurface> Plate(
    ShellSurface::Ghosts ghosts = ShellSurface::Ghosts::kIndependent) {
  return MakePlate({6, 4}, ghosts);
}

DeadLoads Assemble(const std::vector<LoadSpec>& loads,
                   const ShellSurface& surface,
                   bool nonlinear = false,
                   const RigidFrame& frame = Frame()) {
  Scene scene;
  scene.shell.thickness = 0.02;
  scene.shell.density = 1200.0;
  scene.loads = loads;
  return AssembleDeadLoads(scene, surface, nonlinear, frame);
}

Eigen::Vector3d Sum(const DeadLoads& loads) { return loads.force.rowwise().sum(); }

// rigid_work as a force and a moment about the frame's centre.
Eigen::Vector3d Force(const DeadLoads& loads) { return loads.rigid_work.head<3>(); }
Eigen::Vector3d Moment(const DeadLoads& loads, const RigidFrame& frame = Frame()) {
  return loads.rigid_work.tail<3>() * frame.length;
}

void ExpectNear(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected, double tolerance) {
  EXPECT_LT((actual - expected).norm(), tolerance)
      << actual.transpose() << " is not " << expected.transpose();
}

TEST(DeadLoadsTest, NoLoadsNoForce) {
  const DeadLoads loads = Assemble({}, *Plate());
  EXPECT_EQ(loads.force.cols(), Plate()->mesh().num_vertices);
  EXPECT_TRUE(loads.force.isZero(0.0));
  EXPECT_TRUE(loads.rigid_work.isZero(0.0));
  EXPECT_EQ(loads.rigid_scale, 0.0);
}

TEST(DeadLoadsTest, PressureOnAQuarterCylinderHasTheResultantOfItsProjections) {
  constexpr double kPressure = 3.0;
  const auto shell = MakeQuarterCylinder({8, 8}, {0.4, -0.6});
  const DeadLoads loads = Assemble({Pressure("3")}, *shell);
  const Eigen::Vector3d force = kPressure * kLength * kRadius * Eigen::Vector3d(0.0, 1.0, 1.0);
  ExpectNear(Force(loads), force, 1e-7);
  ExpectNear(Sum(loads), force, 1e-7);
  // Every element of force goes through the axis: the resultant through its middle.
  ExpectNear(
      Moment(loads), (Eigen::Vector3d(0.5 * kLength, 0, 0) - Frame().center).cross(force), 1e-7);
}

TEST(DeadLoadsTest, PressureOnAClosedTorusHasNoResultant) {
  ParameterDomain::Options options = Domain({0.0, 2.0 * M_PI}, {0.0, 2.0 * M_PI}, {16, 10});
  options.periodic = {true, true};
  const ShellSurface torus(MakeTorus(2.0, 0.6), options);
  const DeadLoads loads = Assemble({Pressure("3")}, torus);
  EXPECT_GT(loads.rigid_scale, 100.0);  // 3 * 47 of area
  EXPECT_LT(loads.rigid_work.norm(), 1e-12 * loads.rigid_scale);
  EXPECT_LT(Sum(loads).norm(), 1e-12 * loads.rigid_scale);
}

TEST(DeadLoadsTest, TractionAndGravityActOnTheArea) {
  const auto shell = MakeQuarterCylinder({6, 6}, {0.4, -0.6});
  const double area = kLength * kRadius * kHalfPi;
  const Eigen::Vector3d traction(1.0, -2.0, 0.5), acceleration(0.0, 3.0, -9.81);
  // Centre of the arc.
  const double middle = kRadius * 2.0 / M_PI;
  const Eigen::Vector3d arm = Eigen::Vector3d(0.5 * kLength, middle, middle) - Frame().center;
  const DeadLoads by_traction = Assemble({Traction(Vector("1", "-2", "0.5"))}, *shell);
  ExpectNear(Force(by_traction), area * traction, 1e-10);
  ExpectNear(Sum(by_traction), area * traction, 1e-10);
  ExpectNear(Moment(by_traction), area * arm.cross(traction), 1e-7);
  LoadSpec gravity = Load(LoadSpec::Kind::kGravity);
  gravity.acceleration = {0.0, 3.0, -9.81};
  const DeadLoads by_gravity = Assemble({gravity}, *shell);
  const Eigen::Vector3d weight = 1200.0 * 0.02 * area * acceleration;
  ExpectNear(Sum(by_gravity), weight, 1e-8);
  ExpectNear(Force(by_gravity), weight, 1e-8);
  ExpectNear(Moment(by_gravity), arm.cross(weight), 1e-5);
}

TEST(DeadLoadsTest, EdgeForcesActOnTheLengthOfTheirSide) {
  const auto shell = MakeQuarterCylinder({6, 6}, {0.4, -0.6});
  const double arc = kRadius * kHalfPi;
  const struct {
    Region::Kind on;
    double length;
    Eigen::Vector3d middle;
  } cases[] = {
      {Region::Kind::kUMin, arc, {0.0, kRadius * 2.0 / M_PI, kRadius * 2.0 / M_PI}},
      {Region::Kind::kUMax, arc, {kLength, kRadius * 2.0 / M_PI, kRadius * 2.0 / M_PI}},
      {Region::Kind::kVMin, kLength, {0.5 * kLength, 0.0, kRadius}},
      {Region::Kind::kVMax, kLength, {0.5 * kLength, kRadius, 0.0}},
  };
  const Eigen::Vector3d force(1.0, 2.0, -3.0);
  for (const auto& c : cases) {
    const DeadLoads loads = Assemble({Edge(c.on, Vector("1", "2", "-3"))}, *shell);
    ExpectNear(Sum(loads), c.length * force, 1e-12);
    ExpectNear(Force(loads), c.length * force, 1e-12);
    ExpectNear(Moment(loads), c.length * (c.middle - Frame().center).cross(force), 1e-7);
  }
  const DeadLoads rim = Assemble({Edge(Region::Kind::kRim, Vector("1", "2", "-3"))}, *shell);
  ExpectNear(Sum(rim), (2.0 * arc + 2.0 * kLength) * force, 1e-12);
}

TEST(DeadLoadsTest, LineForcesActOnTheLengthOfTheirLine) {
  const auto shell = MakeQuarterCylinder({6, 6}, {0.4, -0.6});
  const Eigen::Vector3d force(1.0, 2.0, -3.0);
  for (const double f : {0.0, 0.21, 0.5, 1.0}) {
    const double v = f * kHalfPi;
    const DeadLoads along_u = Assemble({Line(1, v, Vector("1", "2", "-3"))}, *shell);
    ExpectNear(Sum(along_u), kLength * force, 1e-12);
    const Eigen::Vector3d middle(0.5 * kLength, kRadius * std::sin(v), kRadius * std::cos(v));
    ExpectNear(Moment(along_u), kLength * (middle - Frame().center).cross(force), 1e-11);
    const DeadLoads along_v = Assemble({Line(0, f * kLength, Vector("1", "2", "-3"))}, *shell);
    ExpectNear(Sum(along_v), kRadius * kHalfPi * force, 1e-12);
    ExpectNear(Force(along_v), kRadius * kHalfPi * force, 1e-12);
  }
}

TEST(DeadLoadsTest, PointForcesActAtTheirPoint) {
  const auto shell = MakeQuarterCylinder({4, 4});
  const Eigen::Vector3d force(1.0, 2.0, -3.0);
  LoadSpec load = Load(LoadSpec::Kind::kPoint);
  load.force = Vector("1", "2", "-3");
  load.at.kind = SurfacePoint::Kind::kUv;
  load.at.uv = {0.4, 1.0};
  const Eigen::Vector3d at(0.4, kRadius * std::sin(1.0), kRadius * std::cos(1.0));
  const DeadLoads by_uv = Assemble({load}, *shell);
  ExpectNear(Sum(by_uv), force, 1e-14);
  ExpectNear(Moment(by_uv), (at - Frame().center).cross(force), 1e-13);
  // Twelve control vertices carry it.
  EXPECT_EQ((by_uv.force.colwise().norm().array() > 0.0).count(), 12);
  // A point over the shell means the point below it.
  load.at.kind = SurfacePoint::Kind::kNearest;
  load.at.nearest = {0.4, 3.0 * std::sin(1.0), 3.0 * std::cos(1.0)};
  const DeadLoads by_nearest = Assemble({load}, *shell);
  EXPECT_LT((by_nearest.force - by_uv.force).norm(), 1e-6);
  // At a corner of the domain.
  load.at.kind = SurfacePoint::Kind::kUv;
  load.at.uv = {kLength, kHalfPi};
  ExpectNear(Sum(Assemble({load}, *shell)), force, 1e-14);
}

TEST(DeadLoadsTest, LoadsAddUp) {
  const auto shell = MakeQuarterCylinder({4, 4});
  const std::vector<LoadSpec> loads = {Pressure("1+u"),
                                       Traction(Vector("v", "0", "1")),
                                       Edge(Region::Kind::kUMax, Vector("0", "1", "0")),
                                       Line(1, 0.3, Vector("0", "0", "u"))};
  const DeadLoads all = Assemble(loads, *shell);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, all.force.cols());
  Eigen::Matrix<double, 6, 1> rigid = Eigen::Matrix<double, 6, 1>::Zero();
  for (const LoadSpec& load : loads) {
    const DeadLoads one = Assemble({load}, *shell);
    sum += one.force;
    rigid += one.rigid_work;
  }
  EXPECT_LT((all.force - sum).norm(), 1e-13);
  EXPECT_LT((all.rigid_work - rigid).norm(), 1e-13);
}

// cos(2v) sin(pi u/L) n: the load of the harmonic benchmark, on a mesh of its size. The integrals
// over the quarter are 2L/pi and -1/3, 1/3.
TEST(DeadLoadsTest, ExpressionLoadsAreIntegratedAccurately) {
  const Eigen::Vector3d exact = kRadius * 2.0 * kLength / M_PI / 3.0 * Eigen::Vector3d(0, -1, 1);
  double last = 0.0;
  for (const int divisions : {4, 8, 16, 32}) {
    const auto shell = MakeQuarterCylinder({divisions, divisions});
    const DeadLoads loads = Assemble({NormalTraction("cos(2*v)*sin(pi*u/2)")}, *shell);
    const double error = (Sum(loads) - exact).norm() / exact.norm();
    if (last > 0.0) {
      EXPECT_LT(error, last / 40.0) << divisions;  // sixth order: 64
    }
    last = error;
  }
  EXPECT_LT(last, 1e-10);
}

TEST(DeadLoadsTest, ExpressionsKnowTheRestPosition) {
  // Hydrostatic: 5 (1 - z) on the quarter cylinder, only the projection on z.
  const auto shell = MakeQuarterCylinder({16, 16});
  const DeadLoads loads = Assemble({NormalTraction("5*(1-z)")}, *shell);
  // Integral of (1 - R cos v) cos v over the quarter: 1 - R pi/4.
  EXPECT_NEAR(Sum(loads).z(), 5.0 * kLength * kRadius * (1.0 - 0.25 * M_PI * kRadius), 1e-9);
}

TEST(DeadLoadsTest, FollowerPressureIsDeadInTheLinearTheoryOnly) {
  const auto shell = MakeQuarterCylinder({4, 4});
  const DeadLoads linear = Assemble({Pressure("3")}, *shell, false);
  const DeadLoads nonlinear = Assemble({Pressure("3")}, *shell, true);
  const DeadLoads dead = Assemble({Pressure("3", false)}, *shell, true);
  const DeadLoads traction = Assemble({NormalTraction("3")}, *shell, true);
  EXPECT_TRUE(nonlinear.force.isZero(0.0));
  EXPECT_EQ(dead.force, linear.force);
  EXPECT_EQ(traction.force, linear.force);
  // What a rigid motion meets at rest is the same for all.
  EXPECT_LT((nonlinear.rigid_work - linear.rigid_work).norm(), 1e-13);
  EXPECT_NEAR(nonlinear.rigid_scale, linear.rigid_scale, 1e-12);
}

TEST(DeadLoadsTest, EdgeMomentsAreLeftToTheirBlocksInTheNonlinearTheory) {
  const auto plate = Plate();
  const auto load = Edge(Region::Kind::kUMax, Vector("0", "0", "1"), Vector("0", "2", "0"));
  const DeadLoads linear = Assemble({load}, *plate, false);
  const DeadLoads nonlinear = Assemble({load}, *plate, true);
  const DeadLoads force_only =
      Assemble({Edge(Region::Kind::kUMax, Vector("0", "0", "1"))}, *plate, true);
  EXPECT_EQ(nonlinear.force, force_only.force);
  EXPECT_GT((linear.force - nonlinear.force).norm(), 1.0);
  EXPECT_EQ(nonlinear.rigid_work, linear.rigid_work);
}

// A moment is a couple: no net force, its own moment on a rotation about any axis.
TEST(DeadLoadsTest, EdgeMomentsAreCouples) {
  const auto plate = Plate();
  const Eigen::Vector3d moment(1.0, -2.0, 0.5);
  const DeadLoads loads = Assemble(
      {Edge(Region::Kind::kUMax, Vector("0", "0", "0"), Vector("1", "-2", "0.5"))}, *plate);
  ExpectNear(Sum(loads), Eigen::Vector3d::Zero(), 1e-12);
  ExpectNear(Force(loads), Eigen::Vector3d::Zero(), 1e-300);
  ExpectNear(Moment(loads), 2.0 * moment, 1e-12);  // side u_max is 2 long
}

// The forces on the control vertices do the same work as the loads they stand for.
TEST(DeadLoadsTest, ControlForcesHaveTheMomentOfTheLoads) {
  for (const auto ghosts : {ShellSurface::Ghosts::kIndependent, ShellSurface::Ghosts::kFolded}) {
    const auto plate = Plate(ghosts);
    LoadSpec point = Load(LoadSpec::Kind::kPoint);
    point.force = Vector("1", "1", "1");
    point.at.uv = {0.7, 1.9};
    const std::vector<std::vector<LoadSpec>> cases = {
        {Pressure("1+u*v")},
        {Traction(Vector("v", "u^2", "1"))},
        {Edge(Region::Kind::kRim, Vector("v", "-u", "1"))},
        {Edge(Region::Kind::kVMin, Vector("0", "0", "0"), Vector("1", "-2", "0.5"))},
        {Line(0, 1.1, Vector("0", "v", "1"))},
        {point}};
    for (const auto& loads : cases) {
      const DeadLoads assembled = Assemble(loads, *plate);
      for (int axis = 0; axis < 3; ++axis) {
        // Linear in the plate's coordinates: exactly a rigid rotation.
        const Eigen::Vector3d rotation = Eigen::Vector3d::Unit(axis);
        const Eigen::Matrix3Xd control = PlateField(*plate, [&](double x, double y) {
          return rotation.cross(Eigen::Vector3d(x, y, 0.0) - Frame().center).eval();
        });
        EXPECT_NEAR(assembled.force.cwiseProduct(control).sum(), Moment(assembled)[axis], 1e-12);
      }
      for (int i = 0; i < assembled.force.cols(); ++i) {
        EXPECT_TRUE(plate->IsActive(i) || assembled.force.col(i).isZero(0.0));
      }
    }
  }
}

// Opposite moments on opposite sides do work on the curvature alone: M kappa times the area.
TEST(DeadLoadsTest, MomentsWorkOnBending) {
  const auto plate = Plate();
  const DeadLoads loads =
      Assemble({Edge(Region::Kind::kUMin, Vector("0", "0", "0"), Vector("0", "4", "0")),
                Edge(Region::Kind::kUMax, Vector("0", "0", "0"), Vector("0", "-4", "0"))},
               *plate);
  EXPECT_LT(loads.rigid_work.norm(), 1e-13);
  EXPECT_NEAR(loads.rigid_scale, 2.0 * 4.0 * 2.0 / Frame().length, 1e-12);
  constexpr double kCurvature = 0.3;
  const Eigen::Matrix3Xd bend = PlateField(*plate, [&](double x, double) {
    return Eigen::Vector3d(0.0, 0.0, 0.5 * kCurvature * x * x);
  });
  EXPECT_NEAR(loads.force.cwiseProduct(bend).sum(), 4.0 * kCurvature * 3.0 * 2.0, 1e-11);
}

// rigid_scale never falls below what the loads do together, in any frame.
TEST(DeadLoadsTest, RigidScaleBoundsRigidWork) {
  const auto shell = MakeQuarterCylinder({4, 4});
  for (const auto& load : {Pressure("sin(5*u)"), Traction(Vector("u-1", "v", "0"))}) {
    const DeadLoads loads = Assemble({load}, *shell);
    EXPECT_GE(loads.rigid_scale, loads.rigid_work.norm());
    EXPECT_GT(loads.rigid_scale, 0.0);
  }
}

}  // namespace
}  // namespace darboux
