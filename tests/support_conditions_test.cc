#include "solver/support_conditions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene_util.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

using Kind = SupportSpec::Kind;

SupportSpec Support(Region::Kind on, Kind kind) {
  SupportSpec support;
  support.on.kind = on;
  support.kind = kind;
  support.location = {"scene.yaml", 17, "supports[0].symmetry"};
  return support;
}

SupportSpec Fix(Region::Kind on, std::array<bool, 3> fix) {
  SupportSpec support = Support(on, Kind::kFix);
  support.fix = fix;
  return support;
}

SupportSpec Symmetry(Region::Kind on, const Eigen::Vector3d& normal) {
  SupportSpec support = Support(on, Kind::kSymmetry);
  support.normal = {normal.x(), normal.y(), normal.z()};
  return support;
}

SupportSpec Near(SupportSpec support, const Eigen::Vector3d& center, double radius) {
  support.on.kind = Region::Kind::kNear;
  support.on.center = {center.x(), center.y(), center.z()};
  support.on.radius = radius;
  return support;
}

constexpr int kM = 5, kN = 4;

std::unique_ptr<ShellSurface> Plate(
    ShellSurface::Ghosts ghosts = ShellSurface::Ghosts::kIndependent) {
  return MakePlate({kM, kN}, ghosts);
}

std::unique_ptr<ShellSurface> QuarterCylinder() {
  return MakeQuarterCylinder({kM, kN}, {0.4, -0.6});
}

std::unique_ptr<ShellSurface> Tube(int divisions_u = kM) {
  ParameterDomain::Options options = Domain({0.0, 2.0}, {0.0, 2.0 * M_PI}, {divisions_u, 8});
  options.periodic = {false, true};
  return std::make_unique<ShellSurface>(MakeCylinder(0.7), options);
}

Material SampleMaterial() {
  Material material;
  material.thickness = 0.02;
  material.young_modulus = 2e6;
  material.poisson_ratio = 0.3;
  return material;
}

SupportConditions Make(const std::vector<SupportSpec>& supports,
                       const ShellSurface& surface,
                       BoundaryRule rule = BoundaryRule::kIndependent) {
  Scene scene;
  scene.supports = supports;
  scene.model.boundary_rule = rule;
  SupportConditions result;
  std::string error;
  EXPECT_TRUE(MakeSupportConditions(scene, surface, SampleMaterial(), Frame(), &result, &error))
      << error;
  return result;
}

std::string ErrorOf(const SupportSpec& support, const ShellSurface& surface) {
  Scene scene;
  scene.supports = {support};
  SupportConditions result;
  std::string error;
  EXPECT_FALSE(MakeSupportConditions(scene, surface, SampleMaterial(), Frame(), &result, &error));
  return error;
}

std::vector<std::string> FreeMotionsOf(const SupportConditions& supports) {
  Eigen::MatrixXd rows(supports.conditions.size(), 6);
  for (size_t i = 0; i < supports.conditions.size(); ++i) {
    rows.row(i) = supports.conditions[i].rigid_row;
  }
  return NameMotions(FreeMotions(rows, Eigen::MatrixXd::Identity(6, 6)), Frame());
}

// sum a_i . u_i
double Evaluate(const PlacedCondition& condition, const Eigen::Matrix3Xd& control) {
  EXPECT_EQ(static_cast<size_t>(condition.coefficients.cols()), condition.vertices.size());
  double sum = 0.0;
  for (size_t i = 0; i < condition.vertices.size(); ++i) {
    sum += condition.coefficients.col(i).dot(control.col(condition.vertices[i]));
  }
  return sum;
}

// Displacement components on a side: means at its lattice vertices, values at its two ends.
size_t SideCount(int edges, int displacements, int rotations) {
  return (edges + 1) * (displacements + rotations) + 2 * displacements;
}

TEST(SupportConditionsTest, OpenSidesHoldOneMeanPerVertexAndTheirEnds) {
  const auto plate = Plate();
  const auto count = [&](const SupportSpec& s) { return Make({s}, *plate).conditions.size(); };
  EXPECT_EQ(count(Fix(Region::Kind::kUMin, {false, true, false})), SideCount(kN, 1, 0));
  EXPECT_EQ(count(Fix(Region::Kind::kVMax, {true, false, true})), SideCount(kM, 2, 0));
  EXPECT_EQ(count(Support(Region::Kind::kUMax, Kind::kSimplySupported)), SideCount(kN, 3, 0));
  EXPECT_EQ(count(Support(Region::Kind::kVMin, Kind::kClamped)), SideCount(kM, 3, 1));
  EXPECT_EQ(count(Symmetry(Region::Kind::kUMin, {1, 0, 0})), SideCount(kN, 1, 2));
  EXPECT_EQ(count(Support(Region::Kind::kRim, Kind::kClamped)),
            2 * SideCount(kN, 3, 1) + 2 * SideCount(kM, 3, 1));
  EXPECT_THAT(Make({}, *plate).conditions, IsEmpty());
  EXPECT_THAT(Make({Support(Region::Kind::kRim, Kind::kClamped)}, *plate).fixed_vertices,
              IsEmpty());
}

TEST(SupportConditionsTest, ClosedSidesHaveNoEnds) {
  const auto tube = Tube();
  EXPECT_EQ(Make({Support(Region::Kind::kUMin, Kind::kClamped)}, *tube).conditions.size(), 8u * 4);
  // The rim of a tube is its two circles; of a torus, nothing.
  EXPECT_EQ(Make({Fix(Region::Kind::kRim, {false, true, true})}, *tube).conditions.size(),
            2u * 8 * 2);
  EXPECT_THAT(SidesOf(Fix(Region::Kind::kRim, {}).on, *tube),
              ElementsAre(Side::kUMin, Side::kUMax));
  EXPECT_THAT(SidesOf(Fix(Region::Kind::kVMin, {}).on, *tube), IsEmpty());
  EXPECT_THAT(SidesOf(Near(Fix(Region::Kind::kRim, {}), {0, 0, 0}, 1.0).on, *tube), IsEmpty());
  EXPECT_THAT(SidesOf(Fix(Region::Kind::kVMax, {}).on, *Plate()), ElementsAre(Side::kVMax));
}

// The mean of a linear field over a hat is its value at the hat's centroid.
TEST(SupportConditionsTest, ConditionsMeasureTheDisplacementOfTheSide) {
  const auto plate = Plate();
  const Eigen::Vector3d a(0.3, -0.2, 0.7);
  Eigen::Matrix3d gradient;
  gradient << 1, 2, 0, -3, 4, 0, 5, -6, 0;
  const auto field = [&](double x, double y) -> Eigen::Vector3d {
    return a + gradient * Eigen::Vector3d(x, y, 0.0);
  };
  const Eigen::Matrix3Xd control = PlateField(*plate, field);
  const auto result = Make({Support(Region::Kind::kUMax, Kind::kClamped)}, *plate);
  const double h = 2.0 / kN;
  ASSERT_EQ(result.conditions.size(), SideCount(kN, 3, 1));
  for (int k = 0; k <= kN; ++k) {
    // Centroid of the hat: a third of the edge from the ends of the side.
    const double y = k == 0 ? h / 3.0 : k == kN ? 2.0 - h / 3.0 : k * h;
    for (int c = 0; c < 3; ++c) {
      const PlacedCondition& condition = result.conditions[4 * k + c];
      EXPECT_NEAR(Evaluate(condition, control), field(3.0, y)[c], 1e-13);
      EXPECT_LT((condition.direction - Eigen::Vector3d::Unit(c)).norm(), 1e-14);
      EXPECT_GT(condition.stiffness, 0.0);
      EXPECT_EQ(condition.target, 0.0);
    }
    // The slope across the side, n . d(delta)/dx.
    const PlacedCondition& rotation = result.conditions[4 * k + 3];
    EXPECT_NEAR(Evaluate(rotation, control), 5.0, 1e-12);
    EXPECT_TRUE(rotation.direction.isZero(0.0));
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(Evaluate(result.conditions[4 * (kN + 1) + c], control), field(3.0, 0.0)[c], 1e-13);
    EXPECT_NEAR(
        Evaluate(result.conditions[4 * (kN + 1) + 3 + c], control), field(3.0, 2.0)[c], 1e-13);
  }
}

TEST(SupportConditionsTest, ConditionsOnASideDoNotNameAVertexTwice) {
  for (const auto& surface : {Plate(), QuarterCylinder(), Tube(4), Tube(1)}) {
    for (const auto on : {Region::Kind::kUMin, Region::Kind::kUMax}) {
      for (const auto& c : Make({Support(on, Kind::kClamped)}, *surface).conditions) {
        EXPECT_EQ(std::set<int>(c.vertices.begin(), c.vertices.end()).size(), c.vertices.size());
        EXPECT_TRUE(c.coefficients.allFinite());
        EXPECT_GT(c.coefficients.norm(), 0.0);
      }
    }
  }
}

// On a plate rigid motions are in the space: what the coefficients say is what rigid_row says.
TEST(SupportConditionsTest, RigidRowsAreTheConditionsOnARigidMotion) {
  const auto plate = Plate();
  std::mt19937 gen(56001);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::Matrix<double, 6, 1> motion;
  for (int i = 0; i < 6; ++i) motion[i] = uniform(gen);
  const RigidFrame frame = Frame();
  const Eigen::Vector3d translation = motion.head<3>();
  const Eigen::Vector3d rotation = motion.tail<3>() / frame.length;
  const Eigen::Matrix3Xd control = PlateField(*plate, [&](double x, double y) {
    return (translation + rotation.cross(Eigen::Vector3d(x, y, 0.0) - frame.center)).eval();
  });
  const std::vector<SupportSpec> supports = {
      Support(Region::Kind::kUMax, Kind::kClamped),
      Symmetry(Region::Kind::kVMin, {0, 1, 0}),
      Near(Support(Region::Kind::kRim, Kind::kClamped), {1, 1, 3}, 0.0),
      Near(Symmetry(Region::Kind::kRim, {1, 0, 0}), {1.5, 1, 0}, 0.6),
      Near(Support(Region::Kind::kRim, Kind::kSimplySupported), {2, 2, 0}, 0.9)};
  for (const PlacedCondition& c : Make(supports, *plate).conditions) {
    // Rotations: rigid_row counts the derivative times the frame's length.
    const bool is_rotation = c.direction.isZero(0.0);
    const double expected = Evaluate(c, control) * (is_rotation ? frame.length : 1.0);
    EXPECT_NEAR(c.rigid_row * motion, expected, 1e-12);
  }
  const ElementPoint at{7, 0.2, 0.5};
  const PlacedCondition point =
      PointCondition(*plate, at, {0.6, 0.0, 0.8}, SampleMaterial(), frame);
  EXPECT_NEAR(point.rigid_row * motion, Evaluate(point, control), 1e-13);
  EXPECT_EQ(point.target, 0.0);
  EXPECT_GT(point.stiffness, 0.0);
}

TEST(SupportConditionsTest, TargetsFollowTheExpressions) {
  const auto shell = QuarterCylinder();
  SupportSpec support = Fix(Region::Kind::kUMax, {true, false, true});
  support.displacement = Vector("0.1", "99", "2*z+u");
  const auto result = Make({support}, *shell);
  ASSERT_EQ(result.conditions.size(), SideCount(kN, 2, 0));
  for (const PlacedCondition& c : result.conditions) {
    if (c.direction.x() > 0.5) {
      EXPECT_NEAR(c.target, 0.1, 1e-15);
    } else {
      EXPECT_GE(c.target, 2.0);
      EXPECT_LE(c.target, 2.0 + 1.4);
    }
  }
  // The values at the two ends; z = 0.7 and 0.
  const size_t first = 2 * (kN + 1);
  EXPECT_NEAR(result.conditions[first + 1].target, 2.0 + 1.4, 1e-14);
  EXPECT_NEAR(result.conditions[first + 3].target, 2.0, 1e-14);
  // Means of what a linear field has there are met by the field.
  const auto plate = Plate();
  support = Support(Region::Kind::kVMax, Kind::kSimplySupported);
  support.displacement = Vector("1+u", "2*u-v", "0.5");
  const Eigen::Matrix3Xd control = PlateField(
      *plate, [](double x, double y) { return Eigen::Vector3d(1.0 + x, 2.0 * x - y, 0.5); });
  for (const PlacedCondition& c : Make({support}, *plate).conditions) {
    EXPECT_NEAR(Evaluate(c, control), c.target, 1e-13);
  }
}

TEST(SupportConditionsTest, RadiusZeroHoldsTheNearestPoint) {
  const auto shell = QuarterCylinder();
  const Eigen::Vector3d on_shell(1.1, 0.7 * std::sin(0.8), 0.7 * std::cos(0.8));
  const Eigen::Vector3d near = on_shell + 0.5 * Eigen::Vector3d(0, std::sin(0.8), std::cos(0.8));
  const auto held = Make({Near(Fix(Region::Kind::kRim, {true, false, true}), near, 0.0)}, *shell);
  ASSERT_EQ(held.conditions.size(), 2u);
  const auto expected = Frame().DisplacementRow(on_shell, Eigen::Vector3d::UnitZ());
  EXPECT_LT((held.conditions[1].rigid_row - expected).norm(), 1e-7);
  // Clamped: three displacements, two slopes and the spin about the normal.
  const auto clamped = Make({Near(Support(Region::Kind::kRim, Kind::kClamped), near, 0.0)}, *shell);
  EXPECT_EQ(clamped.conditions.size(), 6u);
  EXPECT_THAT(FreeMotionsOf(clamped), IsEmpty());
  // A pin leaves three rotations, a symmetry plane its own motions.
  const auto pinned =
      Make({Near(Support(Region::Kind::kRim, Kind::kSimplySupported), near, 0.0)}, *shell);
  EXPECT_EQ(FreeMotionsOf(pinned).size(), 3u);
  for (const auto& name : FreeMotionsOf(pinned)) EXPECT_THAT(name, StartsWith("rotation"));
  EXPECT_EQ(
      Make({Near(Symmetry(Region::Kind::kRim, {1, 0, 0}), near, 0.0)}, *shell).conditions.size(),
      3u);
}

TEST(SupportConditionsTest, ARadiusHoldsTheLatticePointsWithin) {
  const auto plate = Plate();
  const Eigen::Vector3d center(1.5, 1.0, 0.2);
  for (const double radius : {1.1, 1.5, 10.0}) {
    std::set<std::pair<int, int>> within;
    for (int j = 0; j <= kN; ++j) {
      for (int i = 0; i <= kM; ++i) {
        const Eigen::Vector3d x(3.0 * i / kM, 2.0 * j / kN, 0.0);
        if ((x - center).norm() <= radius) within.insert({i, j});
      }
    }
    ASSERT_GE(within.size(), 7u);
    const auto fixed = Near(Fix(Region::Kind::kRim, {false, true, true}), center, radius);
    EXPECT_EQ(Make({fixed}, *plate).conditions.size(), 2 * within.size()) << radius;
    const auto clamped = Near(Support(Region::Kind::kRim, Kind::kClamped), center, radius);
    EXPECT_EQ(Make({clamped}, *plate).conditions.size(), 5 * within.size()) << radius;
    EXPECT_THAT(FreeMotionsOf(Make({clamped}, *plate)), IsEmpty());
  }
  // Of a few vertices or none: a finer lattice, which stops the area's rotation as well.
  for (const double radius : {0.1, 0.2, 0.45, 0.8}) {
    const auto held =
        Make({Near(Fix(Region::Kind::kRim, {true, true, true}), {1.35, 1.1, 0}, radius)}, *plate);
    EXPECT_GE(held.conditions.size(), 3u * 7u) << radius;
    EXPECT_THAT(FreeMotionsOf(held), IsEmpty()) << radius;
  }
  // Too small for the finest lattice: the nearest point.
  const auto small = Near(Fix(Region::Kind::kRim, {true, true, true}), {1.35, 1.1, 0.0}, 1e-4);
  const auto result = Make({small}, *plate);
  ASSERT_EQ(result.conditions.size(), 3u);
  EXPECT_LT((result.conditions[0].rigid_row -
             Frame().DisplacementRow({1.35, 1.1, 0.0}, Eigen::Vector3d::UnitX()))
                .norm(),
            1e-7);
  // The seam of a tube is not counted twice.
  const auto all = Near(Fix(Region::Kind::kRim, {true, true, true}), {1, 0, 0}, 10.0);
  EXPECT_EQ(Make({all}, *Tube()).conditions.size(), 3u * (kM + 1) * 8);
}

TEST(SupportConditionsTest, SupportsLeaveTheMotionsTheyShould) {
  const auto plate = Plate();
  EXPECT_THAT(FreeMotionsOf(Make({Support(Region::Kind::kUMin, Kind::kClamped)}, *plate)),
              IsEmpty());
  EXPECT_THAT(FreeMotionsOf(Make({Support(Region::Kind::kUMin, Kind::kSimplySupported)}, *plate)),
              ElementsAre(HasSubstr("rotation about the axis through (0, -0.4, 0) along y")));
  EXPECT_THAT(FreeMotionsOf(Make({Symmetry(Region::Kind::kUMin, {1, 0, 0})}, *plate)),
              ElementsAre("translation along y",
                          "translation along z",
                          "rotation about the axis through (0.3, -0.4, 0.5) along x"));
  EXPECT_THAT(FreeMotionsOf(Make({Symmetry(Region::Kind::kUMin, {1, 0, 0}),
                                  Symmetry(Region::Kind::kVMin, {0, 1, 0})},
                                 *plate)),
              ElementsAre("translation along z"));
  // A tube between two diaphragms slides along its axis; one pinned circle holds it all.
  EXPECT_THAT(FreeMotionsOf(Make({Fix(Region::Kind::kRim, {false, true, true})}, *Tube())),
              ElementsAre("translation along x"));
  EXPECT_THAT(FreeMotionsOf(Make({Support(Region::Kind::kUMax, Kind::kSimplySupported)}, *Tube())),
              IsEmpty());
}

TEST(SupportConditionsTest, MirrorPlanesMustFitTheSide) {
  const auto cylinder = QuarterCylinder();
  // v_min is the line y = 0 at the top: its plane y = 0 is one of symmetry, z = 0 is not.
  EXPECT_EQ(Make({Symmetry(Region::Kind::kVMin, {0, 1, 0})}, *cylinder).conditions.size(),
            SideCount(kM, 1, 2));
  EXPECT_EQ(Make({Symmetry(Region::Kind::kUMin, {1, 0, 0})}, *cylinder).conditions.size(),
            SideCount(kN, 1, 2));
  // In the plane z = 0.7, but tangent to it.
  const std::string tangent = ErrorOf(Symmetry(Region::Kind::kVMin, {0, 0, 1}), *cylinder);
  EXPECT_THAT(tangent, StartsWith("scene.yaml:17: supports[0].symmetry: found a side that does"));
  EXPECT_THAT(tangent, HasSubstr("allowed is a plane of mirror symmetry"));
  // Not in one plane.
  EXPECT_THAT(ErrorOf(Symmetry(Region::Kind::kUMin, {0, 1, 0}), *cylinder),
              HasSubstr("does not lie in one plane"));
  // One of several sides is enough to be wrong.
  EXPECT_THAT(ErrorOf(Symmetry(Region::Kind::kRim, {1, 0, 0}), *cylinder),
              HasSubstr("does not lie in one plane"));
}

// ------------------------------------------------------------------------------------------------
// boundary_rule: seed_ghosts

TEST(SeedGhostsTest, SupportsFixRingsOfControlVertices) {
  const auto plate = Plate(ShellSurface::Ghosts::kFolded);
  const auto ring = [&](int inset) {
    std::vector<int> vertices;
    for (int j = 0; j <= kN; ++j) {
      for (int i = 0; i <= kM; ++i) {
        if (std::min({i, kM - i, j, kN - j}) <= inset) {
          vertices.push_back(plate->domain().VertexIndex(i, j));
        }
      }
    }
    std::sort(vertices.begin(), vertices.end());
    return vertices;
  };
  const auto simple = Make(
      {Support(Region::Kind::kRim, Kind::kSimplySupported)}, *plate, BoundaryRule::kSeedGhosts);
  EXPECT_EQ(simple.fixed_vertices, ring(0));
  const auto clamped =
      Make({Support(Region::Kind::kRim, Kind::kClamped)}, *plate, BoundaryRule::kSeedGhosts);
  EXPECT_EQ(clamped.fixed_vertices, ring(1));
  // No spring doubles what is fixed.
  for (const auto& c : simple.conditions) EXPECT_EQ(c.stiffness, 0.0);
  for (const auto& c : clamped.conditions) EXPECT_EQ(c.stiffness, 0.0);
  // One side alone.
  const auto side = Make(
      {Support(Region::Kind::kVMax, Kind::kSimplySupported)}, *plate, BoundaryRule::kSeedGhosts);
  EXPECT_EQ(side.fixed_vertices.size(), static_cast<size_t>(kM + 1));
  for (int i = 0; i <= kM; ++i) {
    EXPECT_THAT(side.fixed_vertices, ::testing::Contains(plate->domain().VertexIndex(i, kN)));
  }
}

TEST(SeedGhostsTest, WhatRingsCannotSayIsHeldBySprings) {
  const auto plate = Plate(ShellSurface::Ghosts::kFolded);
  const auto fixed =
      Make({Fix(Region::Kind::kUMin, {false, true, true})}, *plate, BoundaryRule::kSeedGhosts);
  EXPECT_THAT(fixed.fixed_vertices, IsEmpty());
  EXPECT_EQ(fixed.conditions.size(), SideCount(kN, 2, 0));
  SupportSpec moved = Support(Region::Kind::kUMin, Kind::kClamped);
  moved.displacement = Vector("0", "0", "0.1");
  const auto springs = Make({moved}, *plate, BoundaryRule::kSeedGhosts);
  EXPECT_THAT(springs.fixed_vertices, IsEmpty());
  EXPECT_EQ(springs.conditions.size(), SideCount(kN, 3, 1));
  for (const auto& c : springs.conditions) EXPECT_GT(c.stiffness, 0.0);
}

// Rings hold the shell like the supports they stand for: a clamped straight side leaves nothing.
TEST(SeedGhostsTest, RingsHoldTheSameRigidMotionsAsSprings) {
  const auto folded = Plate(ShellSurface::Ghosts::kFolded), full = Plate();
  for (const Kind kind : {Kind::kClamped, Kind::kSimplySupported}) {
    for (const auto on : {Region::Kind::kUMin, Region::Kind::kVMax, Region::Kind::kRim}) {
      EXPECT_EQ(FreeMotionsOf(Make({Support(on, kind)}, *folded, BoundaryRule::kSeedGhosts)),
                FreeMotionsOf(Make({Support(on, kind)}, *full)));
    }
  }
}

// ------------------------------------------------------------------------------------------------
// What conditions do to a solution: the square plate of side 1 under uniform pressure, w D / p in
// the centre. Clamped: Taylor & Govindjee (2004). Simply supported: Navier's series.

enum class Conditions { kMeans, kOnePoint, kTwoPoints, kThreePoints };

// Relative error. The springs' stiffness is multiplied by `factor`. Other than kMeans: values (and
// slopes) at that many Gauss points per edge, with springs of the same stiffness per length.
double PlateError(Kind kind, int divisions, double factor, Conditions conditions) {
  ParameterDomain::Options options;
  options.divisions = {divisions, divisions};
  const ShellSurface plate(MakePlane(), options);
  const Material material = SampleMaterial();
  const int n = plate.mesh().num_vertices;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(n);
  const auto add = [&](const std::vector<int>& vertices, const Eigen::RowVectorXd& row, double k) {
    for (size_t i = 0; i < vertices.size(); ++i) {
      for (size_t j = 0; j < vertices.size(); ++j) {
        entries.push_back({vertices[i], vertices[j], k * row[i] * row[j]});
      }
    }
  };
  const double bending = material.BendingStiffness(), nu = material.poisson_ratio;
  for (int e = 0; e < plate.num_elements(); ++e) {
    const auto& vertices = plate.control_vertices(e);
    for (const StrainPoint& p : plate.QuadraturePoints(e, 6)) {
      // (h11 + nu h22)^2 + (1 - nu^2) h22^2 + 2 (1 - nu) h12^2
      add(vertices, p.weights.row(kRowH11) + nu * p.weights.row(kRowH22), bending * p.area);
      add(vertices, p.weights.row(kRowH22), bending * (1.0 - nu * nu) * p.area);
      add(vertices, p.weights.row(kRowH12), 2.0 * (1.0 - nu) * bending * p.area);
      for (size_t i = 0; i < vertices.size(); ++i) {
        force[vertices[i]] += bending * p.area * p.weights(kRowValue, i);
      }
    }
  }
  if (conditions == Conditions::kMeans) {
    for (const PlacedCondition& c : Make({Support(Region::Kind::kRim, kind)}, plate).conditions) {
      // As if multipliers held them: springs alone, of 1e5 times the membrane.
      add(c.vertices, c.coefficients.row(2), factor * (1e5 / 3e3) * c.stiffness);
    }
  } else {
    const double height = 1.0 / divisions;
    for (const Side side : {Side::kUMin, Side::kUMax, Side::kVMin, Side::kVMax}) {
      for (const auto& p : plate.SidePoints(side, static_cast<int>(conditions))) {
        const auto& vertices = plate.control_vertices(p.at.element);
        const double stiffness = factor * 1e5 * material.MembraneStiffness() * p.point.area;
        add(vertices, p.point.weights.row(kRowValue), stiffness / height);
        if (kind != Kind::kClamped) continue;
        add(vertices,
            p.conormal.x() * p.point.weights.row(kRowD1) +
                p.conormal.y() * p.point.weights.row(kRowD2),
            stiffness * height);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd w = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(force);
  const ElementPoint centre = plate.domain().Locate(0.5, 0.5);
  const StrainPoint point = plate.MakePoint(centre);
  double deflection = 0.0;
  for (int i = 0; i < point.weights.cols(); ++i) {
    deflection += point.weights(kRowValue, i) * w[plate.control_vertices(centre.element)[i]];
  }
  return deflection / (kind == Kind::kClamped ? 0.00126531908 : 0.00406235266) - 1.0;
}

class PlateSupportTest : public ::testing::TestWithParam<Kind> {};

TEST_P(PlateSupportTest, ResultIsFlatOverTwoDecadesOfStiffnessToEitherSide) {
  const double error = PlateError(GetParam(), 16, 1.0, Conditions::kMeans);
  for (const double factor : {1e-2, 1e-1, 10.0, 100.0}) {
    EXPECT_NEAR(PlateError(GetParam(), 16, factor, Conditions::kMeans), error, 1e-5) << factor;
  }
}

TEST_P(PlateSupportTest, MeansConvergeLikeTheFourthPowerOfTheElementSize) {
  const double coarse = PlateError(GetParam(), 8, 1.0, Conditions::kMeans);
  const double middle = PlateError(GetParam(), 16, 1.0, Conditions::kMeans);
  const double fine = PlateError(GetParam(), 32, 1.0, Conditions::kMeans);
  EXPECT_LT(std::abs(middle), 1e-4);
  EXPECT_LT(std::abs(middle), std::abs(coarse) / 14.0);
  EXPECT_LT(std::abs(fine), std::abs(middle) / 13.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         PlateSupportTest,
                         ::testing::Values(Kind::kClamped, Kind::kSimplySupported),
                         [](const auto& info) {
                           return info.param == Kind::kClamped ? "clamped" : "simply_supported";
                         });

// Why sides are held by means: one value per edge cannot carry the reaction between the points, two
// or three are more than the control rows next to the side can follow.
TEST(SinglePointSupportTest, OneValuePerEdgeConvergesAtFirstOrderInTheUnknowns) {
  const double coarse = PlateError(Kind::kSimplySupported, 16, 1.0, Conditions::kOnePoint);
  const double fine = PlateError(Kind::kSimplySupported, 32, 1.0, Conditions::kOnePoint);
  EXPECT_GT(coarse, 1e-3);
  EXPECT_GT(fine, coarse / 5.0);
}

TEST(SinglePointSupportTest, MoreValuesPerEdgeLockAClampedSide) {
  for (const auto conditions : {Conditions::kTwoPoints, Conditions::kThreePoints}) {
    EXPECT_LT(PlateError(Kind::kClamped, 16, 1.0, conditions), -0.1);  // ten per cent too stiff
  }
}

}  // namespace
}  // namespace darboux
